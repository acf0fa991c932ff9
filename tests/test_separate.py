"""The recording that is proposed to tell rivals apart does so: with noise, all parameters fitted again."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

import modelgen.models as models
from modelgen.codegen import build
from modelgen.diagnose.diagnosis import prepare, set_up
from modelgen.diagnose.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.menu import Plan, plans
from modelgen.diagnose.refit import Fit, Judge
from modelgen.diagnose.search import white_judge
from modelgen.diagnose.separate import propose, separate
from modelgen.diagnose.setting import Outcome, Setting
from modelgen.effects import CATALOGUE, Effect
from modelgen.fit.series import make_series
from modelgen.language import Model
from modelgen.recordings import Case, Noise, Recording

SPEAKER = models.electrodynamic_transducer
TRUTH = {"R_e": 6.0, "L_e": 5e-4, "Bl": 6.0, "M_m": 0.015, "K_m": 2e3, "R_m": 1.0}
RELATIVE = 1e-3


def effect(model: Model, id: str) -> Effect:
    return next(e for e in CATALOGUE if e.id == id and e.fits(model))


def extended(model: Model, id: str) -> Model:
    e = effect(model, id)
    return e.extend(model, e.fits(model)[0])


def sweep(
    model: Model, f: np.ndarray, values: dict[str, float], quiet: float = 1.0, seed: int = 1
) -> Recording:
    Z = build(model)(f=f, **values)
    Z = np.asarray(Z[0] if isinstance(Z, tuple) else Z)
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=f.size) + 1j * rng.normal(size=f.size)
    return Recording("sweep", None, "fit", {"f": f}, {"Z": Z * (1 + quiet * RELATIVE * noise)})


def fitted(setting: Setting, judge: Judge, base: Fit, hypotheses: list[Hypothesis]) -> list[Fit]:
    """Every hypothesis from a grid of starts, best first."""
    fits = []
    for h in hypotheses:
        strength = h.added[0].strengths[0]
        starts = [
            h.place(base.hypothesis, base.theta, {**g, strength: s})
            for g in h.added[0].grid()
            for s in (1e-3, 1e-1, 10.0)
        ]
        fits.append(judge.fit(h, starts))
    return sorted(fits, key=lambda f: f.bic)


def rivals_for(case: Case, model: Model, ids: tuple[str, ...]) -> tuple[Setting, Judge, list[Fit]]:
    ground = prepare(model, case, 0)
    setting = set_up(model, case, ground, [effect(model, i) for i in ids])
    hypotheses = make_hypotheses(model, case, ground.series, [(a,) for a in setting.additions])
    return setting, ground.judge, fitted(setting, ground.judge, ground.base, hypotheses)


def outcome(judge: Judge, fits: list[Fit]) -> Outcome:
    return Outcome(judge, fits[0], fits[0], tuple(fits), ())


@pytest.fixture(scope="module")
def narrow() -> tuple[Setting, Judge, list[Fit]]:
    """A shunted inductance seen in a band too narrow to tell it from a semi-inductance."""
    f = np.geomspace(20, 400, 81)
    truth = sweep(extended(SPEAKER, "eddy_shunt"), f, {**TRUTH, "eddy_shunt_G": 5e-3})
    case = Case(None, SPEAKER.id, (truth,), constants={"M_m": 0.015}, noise=Noise(relative={"Z": RELATIVE}))
    return rivals_for(case, SPEAKER, ("semi_inductance", "eddy_shunt"))


def test_a_narrow_band_and_the_recording_that_settles_it(narrow: tuple[Setting, Judge, list[Fit]]) -> None:
    setting, judge, fits = narrow
    by_id = {f.ids[0]: f for f in fits}
    best, rival = by_id["eddy_shunt"], by_id["semi_inductance"]
    assert abs(best.bic - rival.bic) < 10  # the data can't tell
    says = separate(setting, outcome(judge, [best, rival]), best, [rival])
    found = propose(setting, judge, best, [rival], time.perf_counter() + 5)
    assert found is not None and found.separation > 30
    assert says is not None and says.startswith(found.plan.says)
    assert "would separate eddy_shunt from semi_inductance by" in says and says.endswith("(chi-square)")
    after = settled(setting, found.plan, best)
    assert after["eddy_shunt"] == pytest.approx(2 * 81 + 2 * len(found.plan.inputs["f"]), rel=0.3)
    gap = after["semi_inductance"] - after["eddy_shunt"]
    assert 0.4 * found.separation < gap < 2.5 * found.separation


def settled(setting: Setting, plan: Plan, best: Fit) -> dict[str, float]:
    """χ² of both rivals after the planned recording has been made (of the truth, with noise)."""
    values = {**TRUTH, "eddy_shunt_G": 5e-3, **plan.constants}
    new = sweep(extended(SPEAKER, "eddy_shunt"), plan.inputs["f"], values, plan.quiet, seed=7)
    new = replace(new, name="new", constants=plan.constants)
    series = [*setting.series, make_series(SPEAKER, setting.case, new)]
    quieter = replace(series[1], whitener=series[1].whitener.scaled(plan.quiet))
    case = replace(setting.case, recordings=(*setting.case.recordings, new))
    hypotheses = make_hypotheses(SPEAKER, case, [series[0], quieter], [(a,) for a in setting.additions])
    judge = white_judge((series[0], quieter))
    fits = fitted(setting, judge, best, hypotheses)
    return {f.ids[0]: f.chi2 for f in fits}


def test_without_rivals_and_with_one_that_is_the_same(narrow: tuple[Setting, Judge, list[Fit]]) -> None:
    setting, judge, fits = narrow
    assert separate(setting, outcome(judge, fits), fits[0], []) is None
    same = separate(setting, outcome(judge, fits), fits[0], [fits[0]])
    assert same is not None and same.startswith("no recording of this menu would tell them apart")


def test_the_menu_of_a_sweep(narrow: tuple[Setting, Judge, list[Fit]]) -> None:
    """A load is offered where the mass is known, a blocked coil where there is an electrical port."""
    setting, _, _ = narrow
    known = {**TRUTH}
    series = [replace(setting.series[0], constants={"M_m": 0.015})]
    menu = {p.says: p for p in plans(SPEAKER, series, 0, known)}
    assert "a sweep from 20 Hz to 2 kHz" in menu and "a sweep from 4 Hz to 400 Hz" in menu
    assert menu["a second sweep with 50% more mass (M_m = 0.0225 kg)"].constants == {
        "M_m": pytest.approx(0.0225)
    }
    blocked = menu["the same sweep with the moving side blocked"]
    Z = np.asarray(build(SPEAKER)(f=blocked.inputs["f"], **{**TRUTH, **blocked.constants}))
    alone = TRUTH["R_e"] + 2j * np.pi * blocked.inputs["f"] * TRUTH["L_e"]
    np.testing.assert_allclose(Z, alone, rtol=1e-5)
    unknown = [replace(setting.series[0], constants={})]
    assert not any("more mass" in p.says for p in plans(SPEAKER, unknown, 0, known))


def test_motions_in_time() -> None:
    """Rate and amplitude tell a relaxation from a power law; each plan is a record that can be made."""
    dahl = models.modified_dahl
    t = np.arange(0, 20, 0.01)
    z = 2.0 * np.sin(2 * np.pi * 0.2 * t)
    law = extended(dahl, "maxwell_branch")
    values = {"k_D": 0.4, "c_D": 0.05, "h_D": 0.03, "rho": 1.5, "F_0": 1.0, "r_0": 0.0}
    names = [
        p.name
        for p in law.scalar_parameters
        if p.name.startswith("maxwell_branch") and p.default in (None, 0.0)
    ]
    values |= dict.fromkeys(names, 0.1)
    F = np.asarray(build(law)(t=t, z=z, **values)) + 2e-3 * np.random.default_rng(3).normal(size=t.size)
    record = Recording("sine", None, "fit", {"t": t, "z": z}, {"F": F})
    case = Case(None, dahl.id, (record,), noise=Noise(sigma={"F": 2e-3, "z": 0.0}))
    setting, judge, fits = rivals_for(case, dahl, ("maxwell_branch", "power_law_viscoelasticity"))
    says = separate(setting, outcome(judge, fits), fits[0], fits[1:])
    assert says is not None and "chi-square" in says
    for plan in plans(dahl, setting.series, 0, values):
        assert (np.diff(plan.inputs["t"]) > 0).all() and np.abs(np.diff(plan.inputs["z"])).max() < 1.0
        assert np.abs(plan.inputs["z"]).max() <= 4.0 + 1e-9
