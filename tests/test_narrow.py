"""Resonances so narrow that a sweep has them in single samples, as it has glitches."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from coils import HEAD, verdict, write_sweep
from scipy.optimize import brentq

import modelgen as mg
from modelgen.diagnose import diagnose
from modelgen.diagnose.diagnosis import set_up
from modelgen.diagnose.gate.narrow import glitch
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.setting import Outcome
from modelgen.diagnose.noise.glitches import by_chance
from modelgen.effects import CATALOGUE

SHARE, MASS = 0.3, 0.013
"""Of the moving mass, that is a rod with waves in it; and all of it [kg]."""


@pytest.mark.slow
def test_a_narrow_resonance_that_a_law_explains_is_no_outlier(tmp_path: Path) -> None:
    """A rod with a free end, whose mass m tan(kl)/kl cancels the rest of the mass at one sample."""
    f = np.geomspace(20, 20e3, 401)
    lone = brentq(lambda x: 1 - SHARE + SHARE * np.tan(x) / x, np.pi / 2 + 1e-9, np.pi - 1e-9)
    s, kl = 2j * np.pi * f, lone * f / f[391] / 1.0005
    mass = MASS * (1 - SHARE + SHARE * np.tan(kl) / kl)
    Z = 6 + 3e-4 * s + 36 / (1 + mass * s + 2e3 / s)
    found = verdict(tmp_path, f, Z, HEAD.replace("[noise]", f"[constants]\nM_m = {MASS}\n[noise]"))
    assert [e.id for e in found.effects] == ["distributed_rod"]
    assert not found.effects[0].equivalents
    assert not any("outlier" in n for n in found.notes)


def test_what_stands_at_one_frequency_in_every_sweep_is_no_glitch() -> None:
    f = [np.geomspace(1.0, 10.0, 50), np.geomspace(1.0, 10.0, 50), np.geomspace(1.1, 11.0, 70)]
    marks = [np.zeros(len(x), dtype=bool) for x in f]
    for x, m in zip(f, marks, strict=True):
        m[np.abs(np.log(x / 5.0)) < 0.04] = True  # a narrow resonance
    marks[0][[3, 40]] = marks[1][40] = True  # glitches, two of them at the same frequency
    kept = by_chance(f, marks)
    assert [np.flatnonzero(m).tolist() for m in kept] == [[3, 40], [40], []]
    assert [m.tolist() for m in by_chance(f[:2], marks[:2])] == [m.tolist() for m in marks[:2]]


TWO = """
model = "electrodynamic_transducer"
[noise]
Z_relative = 1e-3
[[recording]]
file = "light.csv"
constants = { M_m = 0.0121 }
[[recording]]
file = "heavy.csv"
constants = { M_m = 0.0181 }
"""


@pytest.mark.slow
def test_glitches_side_by_side_in_one_of_two_sweeps_are_no_physics(tmp_path: Path) -> None:
    """They are as large as what effects at a steep flank would make, which the other sweep shows nothing
    of."""
    rng = np.random.default_rng(7)
    f = np.geomspace(20, 5e3, 201)
    for file, mass in (("light.csv", 0.0121), ("heavy.csv", 0.0181)):
        s = 2j * np.pi * f
        Z = 6 + 3e-4 * s + 36 / (0.4 + mass * s + 2.5e3 / s)
        Z *= 1 + 1e-3 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
        if file == "light.csv":
            at = np.argmin(np.abs(f - 78.0))
            Z[at : at + 2] *= 1.02
        write_sweep(tmp_path / file, f, Z)
    (tmp_path / "case.toml").write_text(TWO)
    model, case = mg.open_case(tmp_path / "case.toml")
    found = diagnose(case, model)
    assert found.adequate
    assert any("outlier" in n for n in found.notes)


def test_a_resonance_beside_another_effect_that_stands_on_one_sample_is_a_glitch(tmp_path: Path) -> None:
    """In the only sweep, whose spring loses a share of its energy in each cycle; one sample is wrong."""
    rng = np.random.default_rng(7)
    f, wrong = np.geomspace(20, 5e3, 201), 60
    s = 2j * np.pi * f
    Z = 6 + 3e-4 * s + 36 / (0.4 + 0.0121 * s + 2.5e3 * (1 + 0.1j) / s)
    Z *= 1 + 1e-3 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    Z[wrong] *= 1.05
    write_sweep(tmp_path / "z.csv", f, Z)
    (tmp_path / "case.toml").write_text(TWO.partition("[[recording]]")[0] + '[[recording]]\nfile = "z.csv"\n')
    model, case = mg.open_case(tmp_path / "case.toml")
    ground = prepare(model, case, 0, [np.zeros(f.size, dtype=bool)])
    setting = set_up(model, case, ground, CATALOGUE)
    by_name = {a.shared[0]: a for a in setting.additions}
    loss, mode = by_name["structural_damping_H"], by_name["second_mode_M_2"]
    pair, one = make_hypotheses(model, case, setting.series, [(loss, mode), (loss,)])
    base = ground.base
    less = ground.judge.fit(one, [one.place(base.hypothesis, base.theta, {})])
    start = {"second_mode_M_2": 1e-4, "second_mode_omega_2": 2 * np.pi * f[wrong], "second_mode_Q": 300.0}
    more = ground.judge.fit(pair, [pair.place(one, less.theta, start)])
    assert more.chi2 < less.chi2 - 1000
    found = glitch(Outcome(ground.judge, base, more, (less, more), ()))
    assert found is not None
    assert np.flatnonzero(found[0]).tolist() == [wrong]
    assert glitch(Outcome(ground.judge, base, less, (less,), ())) is None
