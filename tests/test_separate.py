"""The recording that is proposed to tell rivals apart does so: with noise, all parameters fitted again."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import modelgen.models as models
from modelgen.codegen import build
from modelgen.diagnose.diagnosis import set_up
from modelgen.diagnose.experiment.foresee import chance, excluded
from modelgen.diagnose.experiment.menu import Plan, often, plans
from modelgen.diagnose.experiment.rivals import Rivals, same
from modelgen.diagnose.experiment.separate import Proposal, propose, separate
from modelgen.diagnose.experiment.simulate import simulated
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.hypotheses.hypothesis import Hypothesis, make_hypotheses
from modelgen.diagnose.hypotheses.ranking import as_ranked
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.setting import CLOSE, Outcome, Setting
from modelgen.diagnose.search.search import white_judge
from modelgen.effects import CATALOGUE, Effect
from modelgen.fit.series import make_series, signature_of
from modelgen.language import Model
from modelgen.recordings import Case, Noise, Recording, load_case, read_case_file
from modelgen.truths import draw, write_case
from modelgen.truths.drawing import scene_of
from modelgen.truths.drive import Motion
from modelgen.truths.further import further

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
            h.place(base.hypothesis, base.theta, {strength: s, **g})
            for g in h.added[0].grid
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
    found = propose(setting, judge, best, [rival])
    assert found is not None and found.separation > 15 and found.worth > 0.8
    assert says is not None and says.startswith(found.plan.says)
    assert "would separate eddy_shunt from semi_inductance by" in says and says.endswith("(chi-square)")
    after = {f.ids[0]: f.chi2 for f in settled(setting, found.plan, fits, {"eddy_shunt_G": 5e-3})}
    assert after["eddy_shunt"] == pytest.approx(2 * 81 + 2 * len(found.plan.inputs["f"]), rel=0.3)
    gap = after["semi_inductance"] - after["eddy_shunt"]
    foreseen = excluded(Rivals(setting, judge, (best, rival), (), 0, 1.0), found.plan, 0)
    assert found.separation <= foreseen.behind and 0.4 * foreseen.behind < gap < 2.5 * foreseen.behind


def settled(setting: Setting, plan: Plan, before: list[Fit], law: dict[str, float]) -> list[Fit]:
    """The rivals, best first, after the planned recording has been made (of the truth, with noise)."""
    (id,) = {n.rpartition("_")[0] for n in law}
    values = {**TRUTH, **law, **plan.constants}
    new = sweep(extended(SPEAKER, id), plan.inputs["f"], values, plan.quiet, seed=7)
    new = replace(new, name="new", constants=plan.constants)
    series = [*setting.series, make_series(SPEAKER, setting.case, new)]
    quieter = replace(series[1], whitener=series[1].whitener.scaled(plan.quiet))
    case = replace(setting.case, recordings=(*setting.case.recordings, new))
    hypotheses = make_hypotheses(SPEAKER, case, [series[0], quieter], [(a,) for a in setting.additions])
    judge = white_judge((series[0], quieter))
    fits = fitted(setting, judge, before[0], hypotheses)
    known = {f.ids: f.theta for f in before}
    return sorted((judge.fit(f.hypothesis, [f.theta, known[f.ids]]) for f in fits), key=lambda f: f.bic)


KNOWN = {"M_m": 0.015, "Bl": 6.0}
"""With Bl free, more mass is less Bl with less of everything else."""
LIMITS = [({"inertia_M": 4e-4}, "distributed_rod"), ({"distributed_rod_tau2": 6e-7}, "inertia")]


@pytest.mark.parametrize(("law", "other"), LIMITS)
def test_a_mass_or_the_limit_of_a_rod(law: dict[str, float], other: str) -> None:
    """A rod whose waves are far above the band is a third of its mass; a wider band excludes the wrong one,
    whichever it is, although only one of them holds the other's resonances."""
    id = next(iter(law)).rpartition("_")[0]
    f = np.geomspace(20, 100, 81)
    truth = sweep(extended(SPEAKER, id), f, {**TRUTH, **law})
    case = Case(None, SPEAKER.id, (truth,), constants=KNOWN, noise=Noise(relative={"Z": RELATIVE}))
    setting, judge, fits = rivals_for(case, SPEAKER, (id, other))
    assert {f.ids[0] for f in fits if f.bic < fits[0].bic + CLOSE} == {id, other}
    found = propose(setting, judge, fits[0], fits[1:])
    assert found is not None and found.worth > 0.8 and found.separation > 6
    assert found.plan.inputs["f"].max() > 100
    after = settled(setting, found.plan, fits, law)
    assert after[0].ids == (id,)
    assert all(f.bic > after[0].bic + CLOSE for f in after if f.ids != (id,))


def test_what_helps_only_if_one_of_them_is_true_is_said_so(
    narrow: tuple[Setting, Judge, list[Fit]], monkeypatch: pytest.MonkeyPatch
) -> None:
    setting, judge, fits = narrow
    by_id = {f.ids[0]: f for f in fits}
    best, rival = by_id["eddy_shunt"], by_id["semi_inductance"]
    whole = propose(setting, judge, best, [rival])
    assert whole is not None and whole.tells == (best, rival)
    half = replace(whole, tells=(rival,), separation=1.0, lead=14.2)
    monkeypatch.setattr("modelgen.diagnose.experiment.separate.propose", lambda *_: half)
    says = separate(setting, outcome(judge, [best, rival]), best, [rival])
    assert says is not None and says.endswith("if semi_inductance is what is there")
    assert "would separate eddy_shunt from semi_inductance by 14 (BIC" in says


def test_a_shape_on_its_bound_has_its_price() -> None:
    """A resonance at the far end of its range is a mass: it fits as well, and pays for what it doesn't need;
    a base parameter that is driven to nothing costs nothing."""
    f = np.geomspace(20, 400, 81)
    truth = sweep(extended(SPEAKER, "inertia"), f, {**TRUTH, "inertia_M": 2e-3})
    case = Case(None, SPEAKER.id, (truth,), constants=KNOWN, noise=Noise(relative={"Z": RELATIVE}))
    _, judge, fits = rivals_for(case, SPEAKER, ("inertia", "second_mode"))
    by_id = {f.ids[0]: f for f in fits}
    mass, mode = by_id["inertia"], by_id["second_mode"]
    names = mode.hypothesis.names
    high = mode.hypothesis.experiment.layout.parameters[names.index("second_mode_omega_2")].bounds[1]
    theta = mode.theta.copy()
    theta[names.index("second_mode_omega_2")] = high
    assert judge.look(mode.hypothesis, theta).parameters == len(names) == mass.parameters + 2
    theta[names.index("R_m")] = 0.0
    assert judge.look(mode.hypothesis, theta).parameters == len(names) - 1
    assert mode.bic - mass.bic > CLOSE and mode.chi2 < mass.chi2 + 1


@pytest.mark.parametrize("domain", ["impedance", "gmm", "force", "stiffness"])
def test_every_plan_of_the_menu_can_be_made(domain: str, tmp_path: Path) -> None:
    """The sentence alone tells what to record: the independent simulator makes what was planned."""
    secret = draw(4, "single", domain, "temperature_drift")
    case_file = read_case_file(write_case(secret, tmp_path))
    model = getattr(models, case_file.model)
    case = load_case(case_file, signature_of(model))
    series = [make_series(model, case, r) for r in case.fit]
    k = int(np.argmax([s.n for s in series]))
    known = {p.name: p.default or 1.0 for p in model.scalar_parameters} | case.constants | series[k].constants
    reference = replace(series[k], constants={**case.constants, **series[k].constants})
    menu = plans(model, [reference if i == k else s for i, s in enumerate(series)], k, known)
    assert len({p.says for p in menu}) == len(menu) > 15
    assert [p.cost for p in menu] == sorted(p.cost for p in menu)
    for plan in (p for once in menu for p in often(once)):
        made = further(secret, f"{plan.says} would separate a from b by 9 (chi-square)")
        assert made is not None, plan.says
        entry = made.setup["further"][0]
        assert entry.get("averaged", 1) == plan.averaged
        axis = plan.inputs[model.axis]
        if model.is_time_model:
            amplitude = 0.5 * np.ptp(plan.inputs["z"])
            z = Motion(entry["motion"], entry["rate"], entry["seconds"], entry["pre"]).zva[0]
            assert 0.5 * np.ptp(z) == pytest.approx(amplitude, rel=0.25), plan.says
        else:
            assert entry.get("down", False) == bool(axis[0] > axis[-1]), plan.says
            assert (entry["lo"], entry["hi"]) == pytest.approx((axis.min(), axis.max()), rel=1e-2)
            assert {n: entry["known"][n] for n in plan.constants} == pytest.approx(plan.constants, rel=1e-2)


def test_an_averaged_recording_is_as_quiet_as_it_says(tmp_path: Path) -> None:
    """Sixteen readings leave a quarter of the noise; the case says so for that recording alone."""
    secret = next(s for i in range(20) if (s := draw(i, "none", "impedance", noise="white")).levels["stated"])
    made = further(secret, "the same sweep averaged 16 times would separate a from b by 9 (chi-square)")
    assert made is not None
    case = load_case(read_case_file(write_case(made, tmp_path)), signature_of(SPEAKER))
    once, often = case.fit[0], case.fit[-1]
    stated = case.noise.relative["Z"]
    assert case.noise_of(once).relative["Z"] == stated
    assert case.noise_of(often).relative["Z"] == pytest.approx(stated / 4, rel=1e-3)
    weights = [np.median(np.abs(make_series(SPEAKER, case, r).whitener.weight)) for r in (once, often)]
    assert weights[1] / weights[0] == pytest.approx(4, rel=0.1)
    clean = scene_of(made).simulate(made.strength)
    errors = [np.std(r.outputs["Z"] / z - 1) for r, z in ((once, clean[0]), (often, clean[-1]))]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.3)


def test_without_rivals_and_with_one_that_is_the_same(narrow: tuple[Setting, Judge, list[Fit]]) -> None:
    setting, judge, fits = narrow
    assert separate(setting, outcome(judge, fits), fits[0], []) is None
    same = separate(setting, outcome(judge, fits), fits[0], [fits[0]])
    assert same is not None and same.startswith("no recording of this menu would tell them apart")


def test_one_law_under_two_names_is_told_from_a_third() -> None:
    """The logarithmic law is a constant loss angle and the limit of a power law; a relaxation is neither."""
    f = np.geomspace(20, 80, 81)
    laws = [e for e in CATALOGUE if e.fits(SPEAKER) and e.id in ("structural_damping", "maxwell_branch")]
    laws += [e for e in CATALOGUE if e.fits(SPEAKER) and e.id == "power_law_viscoelasticity"]
    laws = [e for e in laws if e.id == "maxwell_branch" or [q.name for q in e.strengths] == ["C_ln"]]
    model = laws[0].extend(SPEAKER, laws[0].fits(SPEAKER)[0])
    truth = sweep(model, f, {**TRUTH, f"{laws[0].id}_C_ln": 20.0})
    case = Case(None, SPEAKER.id, (truth,), constants={"M_m": 0.015}, noise=Noise(relative={"Z": RELATIVE}))
    ground = prepare(SPEAKER, case, 0)
    setting = set_up(SPEAKER, case, ground, laws)
    hypotheses = make_hypotheses(SPEAKER, case, ground.series, [(a,) for a in setting.additions])
    fits = fitted(setting, ground.judge, ground.base, hypotheses)
    first, twin, other = fits
    assert same(first, twin) and not same(first, other) and other.ids == ("maxwell_branch",)
    says = separate(setting, outcome(ground.judge, fits), first, [twin, other])
    ours = f"{first.ids[0]} or {twin.ids[0]}"
    assert says is not None and f"would separate {ours} (one and the same so far) from maxwell_branch" in says
    alone = separate(setting, outcome(ground.judge, fits), first, [twin])
    assert alone is not None and alone.endswith("say the same")


def test_a_rival_that_would_run_away_is_excluded() -> None:
    """Its square has no floating-point number; what is known of it is half of it, two standard deviations."""
    assert chance(1e200, 1e200) == pytest.approx(0.977, abs=1e-3)


@pytest.mark.parametrize(
    ("separation", "lead", "parts"), [(9.0, -2.0, True), (2.0, 8.0, True), (2.0, -54.0, False)]
)
def test_what_leaves_a_rival_ahead_is_no_proposal(
    narrow: tuple[Setting, Judge, list[Fit]],
    monkeypatch: pytest.MonkeyPatch,
    separation: float,
    lead: float,
    parts: bool,
) -> None:
    setting, judge, fits = narrow
    plan = next(iter(plans(SPEAKER, setting.series, 0, TRUTH)))
    made = Proposal(plan, separation, lead, 0.9, (fits[0],))
    monkeypatch.setattr("modelgen.diagnose.experiment.separate._foreseen", lambda *_: made)
    assert (propose(setting, judge, fits[0], [fits[1]]) is not None) == parts


def test_a_rival_that_coloured_noise_alone_has_put_ahead_hides_no_plan(
    narrow: tuple[Setting, Judge, list[Fit]],
) -> None:
    """It counts as good as the best; taken as far better, it would be the only one to make a plan for."""
    setting, judge, fits = narrow
    best, rival = ({f.ids[0]: f for f in fits}[i] for i in ("eddy_shunt", "semi_inductance"))
    ahead = replace(rival, bic=best.bic - 900)
    counted = as_ranked(outcome(judge, [best, ahead]), ahead)
    assert counted.bic == best.bic
    taken, found = (propose(setting, judge, best, [f]) for f in (ahead, counted))
    assert taken is not None and best not in taken.tells
    assert found is not None and best in found.tells and found.separation > 15


def test_averaging_is_no_help_far_from_the_data(narrow: tuple[Setting, Judge, list[Fit]]) -> None:
    """Where the best hypothesis leaves far more than noise, a quieter recording tells nothing more."""
    setting, judge, fits = narrow
    best, rival = (replace(f, white=tuple(10 * e for e in f.white)) for f in fits[:2])
    found = propose(setting, judge, best, [rival])
    assert found is None or found.plan.averaged == 1


def test_a_law_that_is_not_quite_right_is_no_evidence(narrow: tuple[Setting, Judge, list[Fit]]) -> None:
    """However often a recording is averaged, misfits of less than a law's own error count little."""
    setting, judge, fits = narrow
    group = Rivals(setting, judge, tuple(fits[:2]), (), 0, 1.0)
    plan = next(p for p in plans(SPEAKER, setting.series, 0, TRUTH) if "to 2 kHz" in p.says)
    made = simulated(group, fits[0], plan)
    assert made is not None
    once, often = (np.abs(made.whitener(n).weight) for n in (1, 10**16))
    assert (once < often).all()
    np.testing.assert_allclose(often, 1 / made.inexact, rtol=1e-3)


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
    assert says is not None and re.search(r"by at least \d+ \((chi-square|BIC)", says)
    for plan in plans(dahl, setting.series, 0, values):
        assert (np.diff(plan.inputs["t"]) > 0).all() and np.abs(np.diff(plan.inputs["z"])).max() < 1.0
        assert np.abs(plan.inputs["z"]).max() <= 4.0 + 1e-9
