"""How an input ran between its samples is no physics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import signal

import modelgen as mg
from modelgen.diagnose import diagnose
from modelgen.diagnose.noise.between import driving
from modelgen.models import load

OSCILLATOR = """
from modelgen.language import Equation, Input, Model, Output, Parameter, Port, State, Symbol, previous

t, u = Input("t", "s"), Input("u", "N")
m = Parameter("m", "kg", 1.0, (1e-6, 1e6))
c = Parameter("c", "N*s/m", 1.0, (0.0, 1e8))
k = Parameter("k", "N/m", 1000.0, (1e-3, 1e10))
X, V = Symbol("x", real=True), Symbol("v", real=True)
F_s = Equation("F_s", c * V + k * X, "N")
x = State("x", 0, rate=V, unit="m", substeps=2)
v = State("v", 0, rate=(u - F_s) / m, unit="m/s")
y = Equation("y", x, "m")
t_prev = previous(t)
at = (("t", t.symbol), ("t_prev", t_prev.symbol))
ports = Port("force", "force", "F_s", (("z", X), ("v", V), *at)), Port("sensor", "sensor", "y", at)
y_m = Output("y", measured_as=("x_m",))
oscillator = Model("oscillator", (t, u, t_prev), (m, c, k), (F_s, x, v, y), (y_m,), ports)
"""


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.slow
def test_inputs_between_samples_are_no_physics(straight: bool, tmp_path: Path) -> None:
    """A resonance at 60 Hz, driven at 14 samples a cycle; far stiffer than the model's defaults."""
    rng, rate, count = np.random.default_rng(3), 840.0, 1500
    m, k, c = 20.0, 20 * (2 * np.pi * 60) ** 2, 500.0
    n, fine = np.arange(count), np.arange(count * 8) / 8
    lines = np.sort(rng.uniform(5, 110, 40))
    waves = [np.sin(2 * np.pi * f * fine / rate + rng.uniform(0, 6)) for f in lines]
    u = np.interp(fine, n, sum(waves)[::8]) if straight else sum(waves)
    x = signal.lsim(([1.0], [m, c, k]), u, fine / rate)[1][::8]
    noisy = x + 2e-3 * np.std(x) * rng.standard_normal(count)
    table = np.column_stack([n / rate, u[::8], noisy * 1e6])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="t [s],u [N],x_m [um]", comments="")
    (tmp_path / "oscillator.py").write_text(OSCILLATOR)
    (tmp_path / "case.toml").write_text('model = "oscillator.py:oscillator"\n[[recording]]\nfile = "a.csv"\n')
    model = load(str(tmp_path / "oscillator.py") + ":oscillator")
    verdict = diagnose(mg.open_case(tmp_path / "case.toml")[1], model)
    assert verdict.adequate, verdict.summary
    assert any("smoothly" in note for note in verdict.notes) != straight


def test_an_input_that_is_held_runs_along_no_lines(tmp_path: Path) -> None:
    held = OSCILLATOR.replace('"N")\n', '"N")\nu_0 = previous(u)\n', 1).replace("(u - F_s)", "(u_0 - F_s)")
    (tmp_path / "held.py").write_text(held.replace("(t, u, t_prev)", "(t, u, t_prev, u_0)"))
    (tmp_path / "lines.py").write_text(OSCILLATOR)
    assert driving(load(str(tmp_path / "lines.py") + ":oscillator")) == {"u"}
    assert driving(load(str(tmp_path / "held.py") + ":oscillator")) == set()


@pytest.mark.slow
@pytest.mark.parametrize("straight", [False, True])
def test_motions_between_samples_are_no_physics(straight: bool, tmp_path: Path) -> None:
    """A springpot by Grünwald and Letnikov's sum, 32 steps a sample; ten samples a cycle at the fastest."""
    rng, count, often, alpha = np.random.default_rng(5), 900, 32, 0.3
    n, fine = np.arange(count), np.arange(count * often) / often
    lines = np.sort(rng.uniform(0.3, 6.0, 16))
    z = sum(np.sin(2 * np.pi * f * fine / 60 + rng.uniform(0, 6)) for f in lines) / 4
    z = z * np.clip(fine / 60, 0.0, 1.0) ** 2  # from rest
    z = np.interp(fine, n, z[::often]) if straight else z
    steps = np.arange(len(fine))
    g = np.cumprod(np.where(steps == 0, 1.0, (steps - 1 - alpha) / np.maximum(steps, 1)))
    force = 5 * z + 4 * (60 * often) ** alpha / (2 * np.pi) ** alpha * signal.fftconvolve(g, z)[: len(z)]
    noisy = force[::often] + 0.03 * rng.standard_normal(count)
    table = np.column_stack([n / 60, z[::often], noisy])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
    (tmp_path / "case.toml").write_text(
        'model = "fractional_kelvin_voigt"\n[noise]\nF_m = 0.03\n[[recording]]\nfile = "a.csv"\n'
    )
    model, case = mg.open_case(tmp_path / "case.toml")
    verdict = diagnose(case, model)
    assert verdict.adequate, verdict.summary
    assert any("smoothly" in note for note in verdict.notes) != straight
