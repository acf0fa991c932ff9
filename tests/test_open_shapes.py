"""Shapes that recordings leave open, and ids that several laws speak for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from coils import coil, verdict

import modelgen as mg
from modelgen.diagnose import diagnose
from modelgen.diagnose.diagnosis import set_up
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.open_shapes import _likeliest, _of_range
from modelgen.diagnose.hypotheses.pasts import price
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.effects import CATALOGUE
from modelgen.recordings import Case, Noise, Recording

CASE = """
model = "magnetostrictive_transducer"
[constants]
N = 940
A = 3.14159e-4
l = 0.1
f_c = 3e4
K_spr = 3e6
R_d = 6.79
[noise]
Z_relative = 1e-3
[[recording]]
file = "1.25.csv"
constants = { M_t = 1.25 }
[[recording]]
file = "1.75.csv"
constants = { M_t = 1.75 }
"""


def test_a_number_costs_what_is_told_of_it() -> None:
    first, second = np.array([True, False]), np.array([False, True])
    widths = np.array([2.0, 1.0])
    told = np.diag([100.0, 9.0])
    assert price(told, first, second, widths, 1.0) == pytest.approx(np.log(401.0))
    assert price(told, first, second, widths, 4.0) == pytest.approx(np.log(101.0))
    same = np.array([[100.0, 30.0], [30.0, 9.0]])  # the other number does the same
    assert price(same, first, second, widths, 1.0) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
def test_a_small_radiator_is_a_mass_whatever_its_size(tmp_path: Path) -> None:
    """Two thousand samples don't exclude a law for having a number that they tell nothing of."""
    m = mg.models.magnetostrictive_transducer
    f, rng = np.linspace(1000.0, 2500.0, 500), np.random.default_rng(7)
    for known in (1.25, 1.75):
        Z = np.asarray(mg.build(m)(f=f, M_t=known + 0.02))
        Z = Z * (1 + 1e-3 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)))
        rows = np.column_stack([f, Z.real, Z.imag])
        header = "f [Hz],Re Z [ohm],Im Z [ohm]"
        np.savetxt(tmp_path / f"{known}.csv", rows, delimiter=",", header=header, comments="")
    (tmp_path / "case.toml").write_text(CASE)
    model, case = mg.open_case(tmp_path / "case.toml")
    (found,) = diagnose(case, model).effects
    assert found.id == "inertia"
    assert {"distributed_rod", "radiation_load"} <= set(found.equivalents)


def test_a_shorted_turn_is_a_permeability_that_relaxes(tmp_path: Path) -> None:
    f = np.geomspace(10, 20e3, 400)
    s = 2j * np.pi * f
    (found,) = verdict(tmp_path, f, coil(f, 2e-4 * s / (1 + s / 2e4))).effects
    assert {"eddy_shunt", "permeability_relaxation"} <= {found.id, *found.equivalents}
    assert "the same function" in (found.separating_experiment or "")


@dataclass(frozen=True)
class Law:
    """What `_likeliest` asks of a fit."""

    ids: tuple[str, ...]
    bic: float
    hypothesis: Any


def test_the_likeliest_id_is_named_not_the_best_law() -> None:
    laws = [("coil_ac_resistance", 0.0), ("semi_inductance", 1.0), ("semi_inductance", 1.5)]
    fits = [Law((i,), bic, SimpleNamespace(key=k)) for k, (i, bic) in enumerate(laws)]
    named = _likeliest(cast(list[Fit], fits))
    assert named.ids == ("semi_inductance",)
    assert named.hypothesis.key == 1  # its best law, …
    assert named.bic == 0.0  # … held to be as good as the best of all


@pytest.mark.parametrize(("k", "told"), [(25.0, True), (0.0, False)])
def test_a_shape_costs_by_the_share_of_its_range_that_is_left(k: float, told: bool) -> None:
    """A relaxation time that shows is known well: its cost is Laplace's. One of nothing may be anything."""
    speaker, rng = mg.models.electrodynamic_transducer, np.random.default_rng(3)
    truth = {"R_e": 6.0, "L_e": 5e-4, "Bl": 6.0, "M_m": 0.015, "K_m": 2e3, "R_m": 1.0}
    f = np.geomspace(5, 500, 121)
    effect = next(e for e in CATALOGUE if e.id == "maxwell_branch" and e.fits(speaker))
    law = effect.extend(speaker, effect.fits(speaker)[0])
    Z = np.asarray(mg.build(law)(f=f, **truth, maxwell_branch_k=k, maxwell_branch_tau=3e-3))
    Z = Z * (1 + 1e-3 * (rng.normal(size=f.size) + 1j * rng.normal(size=f.size)))
    record = Recording("sweep", None, "fit", {"f": f}, {"Z": Z})
    noise = Noise(relative={"Z": 1e-3})
    case = Case(None, speaker.id, (record,), constants={"M_m": 0.015}, noise=noise)
    ground = prepare(speaker, case, 0)
    setting = set_up(speaker, case, ground, [effect])
    (h,) = make_hypotheses(speaker, case, ground.series, [(a,) for a in setting.additions])
    base = ground.base
    fit = ground.judge.fit(
        h, [h.place(base.hypothesis, base.theta, {"maxwell_branch_k": k, **g}) for g in h.added[0].grid]
    )
    j = h.names.index("maxwell_branch_tau")
    low, high = h.experiment.layout.parameters[j].bounds
    cost = _of_range(ground.judge, fit, j, np.nan)
    if told:
        normal = h.experiment.normal(fit.theta, ground.judge.whiteners)[2]
        std = np.sqrt(np.linalg.pinv(normal)[j, j]) / fit.theta[j]
        laplace = 2 * np.log(np.log(high / low) / (np.sqrt(2 * np.pi) * std))
        assert cost == pytest.approx(laplace, abs=1.0) and cost > 4
    else:
        assert cost == pytest.approx(0.0, abs=1.0)
