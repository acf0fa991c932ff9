"""Hold-outs that know more or less than what was fitted, or state another noise; blocks of long records."""

from pathlib import Path

import numpy as np
import pytest
from coils import write_sweep

import modelgen as mg
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.noise.thin import thin
from modelgen.models import kelvin_voigt
from modelgen.recordings import Case, Noise, Recording

MASSES = {"a": 0.013, "b": 0.026, "held": 0.019}
NOISE = {"a": 1e-3, "b": 1e-3, "held": 1e-2}


def held(folder: Path, told: dict[str, bool], noise: bool = False) -> Verdict:
    """A coil with three masses, of which those in `told` are said; the hold-out is ten times as noisy where
    `noise` is said."""
    f, rng = np.geomspace(10.0, 400.0, 150), np.random.default_rng(5)
    s, text = 2j * np.pi * f, 'model = "electrodynamic_transducer"\n[noise]\nZ_relative = 1e-3\n'
    for name, mass in MASSES.items():
        Z = 6 + 3e-4 * s + 36 / (1 + s * mass + 2e3 / s)
        error = rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)
        write_sweep(folder / f"{name}.csv", f, Z * (1 + (NOISE[name] if noise else 1e-3) * error))
        text += f'[[recording]]\nfile = "{name}.csv"\nrole = "{"holdout" if name == "held" else "fit"}"\n'
        text += f"constants = {{ M_m = {mass} }}\n" * told[name]
        text += f"noise = {{ Z_relative = {NOISE[name]} }}\n" * (noise and name == "held")
    (folder / "case.toml").write_text(text)
    model, case = mg.open_case(folder / "case.toml")
    return diagnose(case, model)


def test_a_hold_out_may_know_what_a_fitted_recording_does_not(tmp_path: Path) -> None:
    v = held(tmp_path, {"a": True, "b": False, "held": True})
    assert v.adequate and v.before.holdout_over_noise == pytest.approx(1.0, abs=0.15)


def test_a_hold_out_lacks_a_constant_that_all_others_have(tmp_path: Path) -> None:
    with pytest.raises(mg.InputError, match="recording 'held': 'M_m' is a constant of every other"):
        held(tmp_path, {"a": True, "b": True, "held": False})


def test_a_hold_out_has_the_noise_that_it_states(tmp_path: Path) -> None:
    v = held(tmp_path, dict.fromkeys(MASSES, True), noise=True)
    assert v.adequate and v.before.holdout_over_noise == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("told", [Noise(sigma={"F": 0.2}), Noise(relative={"F": 0.02})])
def test_a_record_too_short_for_blocks_keeps_its_noise(told: Noise) -> None:
    """What is averaged has less of it, be it stated in newtons or as a share."""

    def record(name: str, n: int) -> Recording:
        t = np.arange(n) / 1000.0
        return Recording(name, None, "fit", {"t": t, "z": np.sin(t)}, {"F": np.sin(t)})

    case = Case(None, "kelvin_voigt", (record("long", 240_000), record("short", 30)), noise=told)
    found = thin(kelvin_voigt, case)
    short = next(r for r in found.case.recordings if r.name == "short")
    long = next(r for r in found.case.recordings if r.name == "long")
    assert short.n == 30 and long.n < 60_000
    assert found.case.noise_of(short) == told
    less = found.case.noise_of(long)
    for now, then in ((less.sigma, told.sigma), (less.relative, told.relative)):
        assert {n: x * np.sqrt(240_000 / long.n) for n, x in now.items()} == pytest.approx(
            dict(then), rel=1e-3
        )
