"""Recordings that no model of ours accounts for: what is claimed of them, and what is not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from coils import coil, write_sweep

from modelgen.api import read_case
from modelgen.diagnose import diagnose
from modelgen.diagnose.base import soundest
from modelgen.diagnose.gate.vague import FAMILIES, SURELY, told
from modelgen.diagnose.hypotheses.addition import additions
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.ranking import Standing, standings
from modelgen.diagnose.hypotheses.refit import misfit
from modelgen.diagnose.hypotheses.scales import record_scales
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome, Setting, nearest
from modelgen.diagnose.search import search as searching
from modelgen.diagnose.search.claim import gains
from modelgen.diagnose.search.search import white_judge
from modelgen.effects import CATALOGUE
from modelgen.effects.resonance import MODES
from modelgen.fit.series import make_series
from modelgen.models import load
from modelgen.recordings import Case


def case_of(folder: Path, z: np.ndarray, force: np.ndarray, step: float, name: str = "r") -> Case:
    """A case of one record at even `step` [s]."""
    rows = np.column_stack([step * np.arange(len(z)), z, force])
    np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
    (folder / "case.toml").write_text(
        f'model = "modified_dahl"\n[[recording]]\nfile = "{name}.csv"\nrole = "fit"\n'
    )
    return read_case(folder / "case.toml")


def swings(cycles: float, count: int = 1500) -> np.ndarray:
    """(count,) displacements [mm], stretched from 0 to 6 and back."""
    return 3 * (1 - np.cos(2 * np.pi * cycles * np.arange(count) / count))


@pytest.mark.slow
def test_a_rubber_is_known_by_its_stretch(tmp_path: Path) -> None:
    """f = G A (λ − 1/λ²), λ = 1 + z/l (Treloar): as a magnet that repels would have it, and told so."""
    rng = np.random.default_rng(2)
    z, step = swings(6), 0.02
    stretch = 1 + z / 8.0
    force = 2.0 * (stretch - stretch**-2) + 0.01 * np.gradient(z, step) + 2e-3 * rng.standard_normal(len(z))
    first = diagnose(case_of(tmp_path, z, force, step), load("modified_dahl")).effects[0]
    assert first.id == "asymmetric_stiffness" and "magnetic_pull" in first.equivalents


@pytest.mark.parametrize(("cycles", "offered"), [(1, False), (8, True)])
def test_what_wanders_with_time_needs_a_motion_that_returns(
    tmp_path: Path, cycles: float, offered: bool
) -> None:
    """Waves in time describe any single loop, whatever its physics."""
    z = swings(cycles)
    case, model = case_of(tmp_path, z, z, 0.02), load("modified_dahl")
    scales = record_scales(model, [make_series(model, case, r) for r in case.fit])
    sizes = {p.equation: np.ones(1) for p in model.ports}
    found = [a.effect.says for a in additions(model, CATALOGUE, scales, sizes, {})]
    assert any("zero point of the force wanders" in s for s in found) == offered
    assert any("zero point of the force drifts" in s for s in found)


@pytest.fixture(scope="module")
def two_effects(tmp_path_factory: pytest.TempPathFactory) -> tuple[Setting, Outcome]:
    """A search that has found hardening and drag in the square of speed."""
    seen: list[tuple[Setting, Outcome]] = []

    def kept(s, base, judge, progress=None):  # type: ignore[no-untyped-def]
        seen.append((s, searching.search(s, base, judge, progress)))
        return seen[-1][1]

    rng = np.random.default_rng(3)
    z, step = 3 * np.sin(np.arange(2500) ** 1.1 / 40), 0.02
    v = np.gradient(z, step)
    force = z + 0.02 * v + 0.05 * z**3 + 0.002 * v * abs(v) + 5e-3 * rng.standard_normal(len(z))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("modelgen.diagnose.diagnosis.search", kept)
        diagnose(case_of(tmp_path_factory.mktemp("two"), z, force, step), load("modified_dahl"), out=None)
    return seen[-1]


@pytest.mark.slow
def test_a_further_effect_that_may_be_almost_anything_is_not_claimed(
    two_effects: tuple[Setting, Outcome],
) -> None:
    setting, outcome = two_effects
    assert set(outcome.best.ids) == {"cubic_stiffness", "quadratic_damping"}
    first, second = standings(outcome)

    def among(*ids: str, temper: float = 2.0) -> tuple[Outcome, tuple[Standing, ...], tuple[str, ...]]:
        rest = replace(outcome, judge=replace(outcome.judge, temper=temper))
        return told(setting, rest, (first, replace(second, equivalents=ids)))

    few = ("structural_damping", "maxwell_branch", "power_law_viscoelasticity", "backlash")
    same, both, none = among(*few)  # viscoelastic, play and drag: three families
    assert same.best is outcome.best and len(both) == 2 and not none
    many = (*few, "inertia", "sensor_delay", "cubic_stiffness")
    assert len(many) > FAMILIES
    less, one, notes = among(*many)
    assert less.best.ids == (first.addition.id,) and one == (first,)
    share = 1 - misfit(outcome.best) / misfit(less.best)
    assert len(notes) == 1 and f"{share:.0%}" in notes[0] and "inertia" in notes[0]
    assert share > SURELY  # and it leaves but noise: something is there, whatever it is
    assert [len(x) for x in among(*many, temper=1.0)[1:]] == [2, 0]


@pytest.mark.slow
def test_what_is_shown_as_before_is_the_base_nearest_to_the_recordings(
    two_effects: tuple[Setting, Outcome],
) -> None:
    setting, outcome = two_effects
    first = outcome.base
    led_away = outcome.judge.look(first.hypothesis, 1.2 * first.theta)
    assert misfit(led_away) > 1.5 * misfit(first)
    assert nearest(replace(setting, base=first), led_away) is first
    assert nearest(replace(setting, base=led_away), first) is first
    assert nearest(replace(setting, base=None), led_away) is led_away


@pytest.mark.slow
def test_over_time_a_second_effect_is_as_sure_as_its_part_of_the_evidence_is_large(
    two_effects: tuple[Setting, Outcome],
) -> None:
    """What it takes up may be what the first one's law is not quite right about."""
    _, outcome = two_effects
    whole = outcome.base.bic - outcome.best.bic
    rest = outcome.best.hypothesis.key - {standings(outcome)[1].addition.key}

    def if_it_brings(part: float) -> float:
        without = outcome.best.bic + part * whole
        tried = (replace(f, bic=without) if f.hypothesis.key == rest else f for f in outcome.tried)
        return standings(replace(outcome, tried=tuple(tried)))[1].probability

    little, some, much, most = map(if_it_brings, (0.01, 0.1, 0.3, 0.6))
    assert little < 0.5 < some < 0.7 < much == most < 0.9


@pytest.mark.slow
def test_far_from_the_data_the_best_account_needs_no_more_than_evidence(
    two_effects: tuple[Setting, Outcome],
) -> None:
    """That something is missing is beyond doubt where a rest far above noise is long correlated: a first
    effect is the likeliest, a second one has to earn its place."""
    setting, outcome = two_effects
    single = min((f for f in outcome.tried if len(f.ids) == 1), key=lambda f: f.bic)
    for temper in np.geomspace(10, 2000, 60):
        judge = replace(outcome.judge, temper=float(temper))
        base, one, two = (judge.look(f.hypothesis, f.theta) for f in (outcome.base, single, outcome.best))
        if 0 < base.bic - one.bic < ALARM:
            assert gains(setting, judge, base, base, one)
            assert one.bic - two.bic > ALARM or not gains(setting, judge, base, one, two)
            return
    raise AssertionError("no correlation length leaves evidence in doubt")


def coil_case(folder: Path) -> Case:
    """A sweep of a moving coil, its mass known [kg]."""
    write_sweep(folder / "sweep.csv", f := np.geomspace(20, 20e3, 60), coil(f))
    head = 'model = "electrodynamic_transducer"\n[constants]\nM_m = 0.013\n'
    (folder / "case.toml").write_text(f'{head}[[recording]]\nfile = "sweep.csv"\nrole = "fit"\n')
    return read_case(folder / "case.toml")


@pytest.mark.parametrize(("over", "inside"), [(20.0, True), (1.0, False)])
def test_a_base_that_is_all_wrong_is_not_fitted_by_switching_a_part_of_it_off(
    tmp_path: Path, over: float, inside: bool
) -> None:
    """So many times the noise `over`, an optimum at an end of the range yields to one within it, though that
    leaves more."""
    case, model = coil_case(tmp_path), load("electrodynamic_transducer")
    series = tuple(make_series(model, case, r) for r in case.fit)
    base = make_hypotheses(model, case, series, [()])[0]
    judge, at = white_judge(series), dict(R_e=6.0, L_e=3e-4, Bl=6.0, K_m=2e3, R_m=1.0)
    stiffest = next(p.bounds[1] for p in base.experiment.layout.parameters if p.name == "K_m")
    sound, clamped = (
        judge.look(base, np.array([{**at, "K_m": K}[n] for n in base.names])) for K in (2e3, stiffest)
    )
    noise = np.ones_like(sound.white[0])
    sound, clamped = replace(sound, white=(1.5 * over * noise,)), replace(clamped, white=(over * noise,))
    assert (soundest([clamped, sound]) is sound) == inside


def test_a_gap_may_take_up_most_of_the_stroke(tmp_path: Path) -> None:
    case, model = case_of(tmp_path, swings(6), swings(6), 0.02), load("modified_dahl")
    scales = record_scales(model, [make_series(model, case, r) for r in case.fit])
    sizes = {p.equation: np.ones(1) for p in model.ports}
    gaps = [a for a in additions(model, CATALOGUE, scales, sizes, {}) if a.id == "backlash"]
    most = [a.extend(model).parameter(n).bounds[1] for a in gaps for n in a.shared]
    assert most and min(most) == np.inf


def test_a_resonator_that_is_hung_on_does_not_take_the_place_of_a_mass_that_is_known(tmp_path: Path) -> None:
    case, model = coil_case(tmp_path), load("electrodynamic_transducer")
    series = [make_series(model, case, r) for r in case.fit]
    omega = 2 * np.pi * series[0].inputs["f"]
    sizes = {p.equation: 0.013 * omega for p in model.ports}
    modes = [a for a in additions(model, MODES, record_scales(model, series), sizes, {})]
    bounds = [a.extend(model).parameter(a.shared[0]).bounds for a in modes]
    assert len(bounds) == len(MODES)
    assert bounds == [(0.0, pytest.approx(10 * 0.013))] * len(MODES)


@pytest.mark.slow  # half a minute
def test_an_amplifier_that_saturates_softly_is_found_at_the_sensor(tmp_path: Path) -> None:
    """F/(1 + |F/F_s|⁹)^(1/9) for F > 0: no plateau, and no physics of the sample."""
    rng = np.random.default_rng(5)
    z, step = swings(9), 0.02
    true = 1.0 * z + 0.05 * np.gradient(z, step) - 2.0
    shown = np.where(true > 0, true / (1 + (np.maximum(true, 0) / 3.5) ** 9) ** (1 / 9), true)
    case = case_of(tmp_path, z, shown + 2e-3 * rng.standard_normal(len(z)), step)
    v = diagnose(case, load("modified_dahl"), out=tmp_path)
    assert v.effects[0].id == "unknown_sensor" and "force itself" in v.effects[0].says
    assert v.before.fit_over_noise > 5 and v.after.fit_over_noise == pytest.approx(1, abs=0.1)
    bend = next(e for e in v.effects[0].parameters if e.name == "bend")
    assert 1 / bend.value == pytest.approx(3.5, rel=0.02)


@pytest.mark.slow
def test_a_zero_point_that_drifts_otherwise_in_each_record(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    text = 'model = "modified_dahl"\nper_recording = ["F_0", "r_0"]\n'
    for name, drift in (("a", 0.05), ("b", -0.03)):
        z, t, r = swings(8), 0.02 * np.arange(1500), np.full(1500, -1.0)
        for n, dz in enumerate(np.diff(z)):
            r[n + 1] = np.sign(dz) - (np.sign(dz) - r[n]) * np.exp(-2 * abs(dz))
        force = 0.5 * z + 0.2 * r + 0.02 * np.gradient(z, 0.02) + drift * (1 - np.exp(-t / 12))
        rows = np.column_stack([t, z, force + 2e-3 * rng.standard_normal(len(z))])
        np.savetxt(tmp_path / f"{name}.csv", rows, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
        text += f'[[recording]]\nfile = "{name}.csv"\nrole = "fit"\n'
    (tmp_path / "case.toml").write_text(text)
    v = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"), out=tmp_path)
    assert [e.id for e in v.effects] == ["offset_drift"]
    assert v.after.fit_over_noise == pytest.approx(1, abs=0.1)
    rates = {e.name: e.value for e in v.effects[0].parameters}
    assert rates["d_own[a]"] > 0 > rates["d_own[b]"]
    assert "(per_recording) of offset_drift_d_own" in Path(str(v.extended_model)).read_text()
