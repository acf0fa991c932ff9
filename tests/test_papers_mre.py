"""The MRE paper's numbers, its four stages, and what is said of them."""

from dataclasses import replace

import numpy as np
import pytest

from modelgen.cli.methods import read_method
from modelgen.errors import InputError
from modelgen.fit import GaussNewton, Method
from modelgen.fit.random import RandomChanges, RandomSets
from modelgen.papers.mre.estimators import between_published, stage_2
from modelgen.papers.mre.material import exact, loops, six_jointly, table_3_jointly, truth
from modelgen.papers.mre.paper import PAPER
from modelgen.papers.mre.stages import FOUR, RANGES, estimate, first_stage, fitted_to
from modelgen.papers.mre.sweep import SETS, fit_sweep, spring_and_springpot, springpot, sweep, swept
from modelgen.papers.mre.tables import ESTIMATES, steady
from modelgen.papers.mre.truth import SHIFT, STAGE_4, direct, record
from modelgen.papers.number import Verdict, judge


def verdicts(name: str) -> dict[tuple[str, str], Verdict]:
    (table,) = (t for t in PAPER.tables if t.name == name)
    return {(r.number.row, r.number.quantity): r.verdict for r in map(judge, table.numbers)}


def test_every_table_of_the_paper_is_there_in_full() -> None:
    sizes = {t.name: len(t.numbers) for t in PAPER.tables}
    # 1: 5 × 4 by FEMM, 5 by gaussmeter, one of the text; 2: 4 × 7; 3: 5 × 6; 4: 2 × (4 + 3 × 6) + 2 of text
    assert sizes == {
        "Table 1": 26, "Sec. 3.3, 3.4": 3, "Table 2": 28, "Table 3": 30, "Table 4": 46, "Table 5": 16,
    }  # fmt: skip
    places = [(t.name, n.row, n.quantity) for t in PAPER.tables for n in t.numbers]
    assert len(places) == len(set(places))


def test_verdicts_of_table_2_and_3() -> None:
    said = verdicts("Table 2")
    assert all(said[s, "k_s"] is Verdict.REPRODUCED for s in SETS)
    assert [said[s, "c_s"] is Verdict.WRONG for s in SETS] == [False, True, True, True]
    assert said["S1 M0", "h_s"] is Verdict.REPRODUCED and said["S1 M1", "h_s"] is Verdict.NOT_REPRODUCIBLE
    sweep_said = verdicts("Table 3")
    assert all((v is Verdict.REPRODUCED) == (q == "k_d") for (_, q), v in sweep_said.items())
    assert verdicts("Table 1")["text, points 2 and 3", "worst |gaussmeter − FEMM|"] is Verdict.WRONG


@pytest.mark.parametrize(
    ("case", "A", "f", "k_s", "h_s"),
    [
        ("M0", 3.01, 0.099, 0.39929809233874111, 0.20518482603477049),
        ("M1", 2.99, 0.1, 0.76235564287613545, 0.4827997536),
    ],
)
def test_steady_cycle(case: str, A: float, f: float, k_s: float, h_s: float) -> None:
    assert steady(case, "k_s", A, f) == pytest.approx(k_s, rel=1e-9)
    assert steady(case, "h_s", A, f) == pytest.approx(h_s, rel=1e-6)


@pytest.mark.parametrize(
    ("case", "J"),
    [("M0", (0.107851285, 0.098897463, 0.102938513)), ("M1", (0.017035987, 0.015185543, 0.016047960))],
)
def test_quality_factors_between_the_published_sets(case: str, J: tuple[float, float, float]) -> None:
    assert between_published(case, 1000) == pytest.approx(J, rel=1e-6)


@pytest.mark.parametrize("case", ["M0", "M1"])
def test_first_stage_finds_motion_and_offset(case: str) -> None:
    cycle = first_stage(*record(case))
    assert abs(cycle.A - 3.0) < 1e-3
    assert cycle.f == pytest.approx(0.1, rel=2e-4)
    assert cycle.shift == pytest.approx(SHIFT[case], abs=5e-3)


def test_first_stage_says_what_it_wants() -> None:
    t, z, F = (x[::100] for x in record("M0"))
    with pytest.raises(InputError, match="less than two cycles"):
        first_stage(t[:700], z[:700], F[:700])
    with pytest.raises(InputError, match="equal steps"):
        first_stage(t**1.1, z, F)
    with pytest.raises(InputError, match="at least 40"):
        first_stage(t[:30], z[:30], F[:30])
    assert first_stage(t[:900], z[:900], F[:900]).f == pytest.approx(0.1, rel=0.01)


def test_stages_get_better_one_after_the_other_and_the_direct_fit_is_best() -> None:
    found = estimate(*record("M0"), seed=3, samples=200, changes=2000)
    J = [s.J_es for s in found.stages]
    assert J[0] > J[1] > J[2]
    last = found.stages[2].values
    for n in FOUR:
        true, ours = STAGE_4["M0"][n], direct("M0")
        assert last[n] == pytest.approx(true, rel=0.02)
        assert ours.values[n] == pytest.approx(true, abs=4 * ours.std[n])
        assert abs(ours.values[n] - true) < abs(last[n] - true)


def test_random_methods_keep_the_box_and_never_get_worse() -> None:
    ex = fitted_to(first_stage(*record("M0"), 50))
    problem = ex.problem()
    start = np.array([0.5, 0.1, 0.2, 1.0])
    changed = RandomChanges(500).run(problem, start, seed=1)
    assert changed.value < problem.value(start) and changed.evaluations >= 500
    assert np.all((changed.theta >= problem.lower) & (changed.theta <= problem.upper))
    assert RandomSets(50).run(problem, start, seed=1).evaluations == 50
    again = RandomChanges(500).run(problem, start, seed=1)
    assert np.array_equal(again.theta, changed.theta)


def test_the_stages_are_a_method_by_name() -> None:
    method = read_method("mre-stages(300)")
    assert isinstance(method, Method)
    assert method.text.startswith("best of 100 random sets, then 300 random changes, then Gauss–Newton")
    ex = fitted_to(first_stage(*record("M0"), 100))
    low, high = (np.array([RANGES[n][k] for n in ex.layout.names]) for k in (0, 1))
    problem = replace(ex.problem(), lower=low, upper=high, start=(low + high) / 2)
    assert method.run(problem, seed=0).value < 1.001 * GaussNewton().run(problem).value


def test_only_the_scale_inside_the_square_gives_the_printed_ratio() -> None:
    J_e, J_es = (float(x) for x in ESTIMATES["M1"][1][4:])
    off = {
        r: abs(J_es / J_e - stage_2("M1", r)[0].mean()) / stage_2("M1", r)[0].std()
        for r in ("inside", "outside")
    }
    assert off["inside"] < 2 and off["outside"] > 4


@pytest.mark.parametrize("case", ["M0", "M1"])
def test_loops_of_the_recording_against_the_truth(case: str) -> None:
    mean = loops(case).mean()
    for name, true in exact(case).items():
        value, std = mean[name]
        assert value == pytest.approx(true, abs=4 * std), name
        assert std < 2e-4 * true


@pytest.mark.parametrize(
    ("name", "alpha", "C"), [("S1 M0", 0.16902793, 0.43703821), ("S2 M1", 0.14449862, 1.15035572)]
)
def test_springpot_of_table_3(name: str, alpha: float, C: float) -> None:
    found = fit_sweep(spring_and_springpot(), name, {"k_0": 0.0})
    assert found["alpha"].value == pytest.approx(alpha, rel=0.02)  # there: least squares of the logarithms
    assert found["C"].value == pytest.approx(C, rel=0.01)
    assert found.rms["N/mm"]["fit"] < 0.007 * sweep(name)[1].mean()


def test_a_sweep_gives_the_springpot_back() -> None:
    found, true = swept(), springpot("S1 M0")
    f, k_s = found.values["f"], found.values["k_s"]
    assert f.min() < 0.4 and f.max() > 9.5
    assert k_s == pytest.approx(true["C"] * (2 * np.pi * f) ** true["alpha"], rel=0.02)
    assert found.values["loss_angle"].mean() == pytest.approx(90 * true["alpha"], abs=0.05)


def test_conditions_are_found_jointly() -> None:
    found = six_jointly()
    for name, true in truth().items():
        assert found[name].value == pytest.approx(true, abs=4 * found[name].std), name
    assert 0.8 < found.rms_over_noise["holdout"] < 1.2
    assert (
        table_3_jointly()["C_M"].value > 2.5 * table_3_jointly()["C_P"].value
    )  # the field does more than the iron
