"""Stress softening of a sample that has moved before its records: what no one recorded is free, and tells
what it can."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_effects_laws import find, force, record

from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.diagnosis import set_up
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.moderate import moderated
from modelgen.diagnose.hypotheses.pasts import is_past, price, widths_of
from modelgen.effects import CATALOGUE
from modelgen.fit.experiment import Layout
from modelgen.language import Parameter
from modelgen.models import load
from modelgen.truths import draw, write_case

t = np.arange(0, 4, 0.005)
SINE = record(t, lambda x: np.sin(2 * np.pi * x))


def test_what_is_left_when_the_record_begins_falls_on_with_the_path() -> None:
    F = force(find("stress_softening", "spring", "k_0_on"), SINE, k_0_on=1.0, s_c_on=3.0, left=0.6)
    assert F[650] / SINE["z"][650] == pytest.approx(0.6 * np.exp(-13 / 3), rel=1e-3)


@pytest.mark.parametrize(("left", "after"), [(1.0, np.exp(-2)), (0.6, np.exp(-2)), (0.05, 0.05)])
def test_a_peak_before_the_record_counts_until_it_is_passed(left: float, after: float) -> None:
    F = force(find("stress_softening", "spring", "k_p_on"), SINE, k_p_on=1.0, z_c_on=0.5, left=left)
    assert F[10] / SINE["z"][10] == pytest.approx(min(left, np.exp(-SINE["z"][10] / 0.5)), rel=1e-6)
    assert F[650] / SINE["z"][650] == pytest.approx(after, rel=1e-6)


def test_a_law_with_a_past_is_an_account_instead_of_paynes() -> None:
    free = [e for e in CATALOGUE if e.id == "stress_softening" and e.instead]
    assert {e.strengths[0].name for e in free} == {"k_0_on", "k_p_on"}
    assert all(e.instead == ("payne_softening",) for e in free)


def layout(*names: str) -> Layout:
    none = np.zeros((1, len(names)))
    p = tuple(Parameter(n.partition("[")[0], "1", 0.5, (0.0, 1.0)) for n in names)
    return Layout(names, names, p, none, none, ())


def test_a_past_costs_what_the_records_tell_of_it() -> None:
    """None at all where another parameter says the same, ln(1 + information × width²) where none does."""
    known = layout("k", "left[a]", "left[b]")
    past = is_past(known, {"left"})
    assert past.tolist() == [False, True, True]
    widths = widths_of(known, np.array([0.5, 0.5, 0.5]))
    J = np.zeros((90, 3))
    J[:30, 0] = 1.0  # k alone
    J[30:60, 1] = 10.0  # left of a, as well known as by 30 samples of a tenth
    cost = price(J.T @ J, past, ~past, widths, 1.0)
    assert cost == pytest.approx(np.log(1 + 3000 / 12))
    J[:30, 2] = 1.0  # what left of b does is what k does
    assert price(J.T @ J, past, ~past, widths, 1.0) == pytest.approx(cost, abs=1e-6)
    assert price(J.T @ J, past, ~past, widths, 4.0) == pytest.approx(np.log(1 + 3000 / 48), abs=1e-6)


def concealed(folder: Path, law: str, seed: int) -> Verdict:
    """Of a sample that had moved before its records."""
    secret = draw(seed, "variant" if law == "peak" else "single", "force", law, (30.0, 1e4), "white", 3.0)
    assert all(r["pre"] for r in secret.setup["records"])
    write_case(secret, folder)
    return diagnose(read_case(folder / "case.toml"), load("modified_dahl"))


@pytest.mark.slow
def test_a_sample_that_softens_on_in_mid_motion_is_told(tmp_path: Path) -> None:
    (found,) = concealed(tmp_path, "stress_softening", 73010).effects
    assert found.id == "stress_softening" and found.equivalents == ()


@pytest.mark.slow
def test_peaks_that_were_all_before_the_records_are_told_from_no_amplitude(tmp_path: Path) -> None:
    """Each record has one stiffness, its own: as of the peak that it reached before, as of its amplitude."""
    (found,) = concealed(tmp_path, "peak", 73010).effects
    assert {found.id, *found.equivalents} == {"payne_softening", "stress_softening"}
    assert found.separating_experiment


def test_where_softening_begins_is_taken_at_the_middle_of_what_is_left_open(tmp_path: Path) -> None:
    """At two amplitudes beyond it the rest of a power is all that is seen."""
    write_case(
        draw(203300367, "single", "force", "payne_softening", (30.0, 1e4), "displacement", 6.0), tmp_path
    )
    case, model = read_case(tmp_path / "case.toml"), load("modified_dahl")
    ground = prepare(model, case, 0)
    added = set_up(model, case, ground, CATALOGUE).additions
    law = next(a for a in added if a.id == "payne_softening" and a.effect.strengths[0].name == "k_0")
    h = make_hypotheses(model, case, ground.series, [(law,)])[0]
    low, high = law.ranges["A_c"]
    edge = {"payne_softening_A_c": low, "payne_softening_k_0": 0.5}
    fit = ground.judge.fit(h, [h.place(ground.base.hypothesis, ground.base.theta, edge)])
    at = h.names.index("payne_softening_A_c")
    assert fit.theta[at] < 1.2 * low
    found = moderated(ground.judge, fit)
    assert 2 * low < found.theta[at] < high / 2
    assert found.chi2 == pytest.approx(fit.chi2, abs=1.0)
