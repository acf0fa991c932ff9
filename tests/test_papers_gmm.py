"""The GMM paper's numbers: what is computed, against independent values, and what is said of them."""

from math import pi

import numpy as np
import pytest

from modelgen.codegen import build
from modelgen.models.contact_damping import contact_damping
from modelgen.papers.gmm.agreement import compared, published_sets, table_7, variances
from modelgen.papers.gmm.contact import CONTACT, PRINTED, damping, widely
from modelgen.papers.gmm.damping import STATED, STRUCTURAL
from modelgen.papers.gmm.equations import SERIES, coefficients
from modelgen.papers.gmm.fractal import FRACTAL, contact, contact_std, dimension, roughness
from modelgen.papers.gmm.misprints import misprints
from modelgen.papers.gmm.paper import PAPER
from modelgen.papers.gmm.roughness import SURFACES
from modelgen.papers.gmm.runs import MEANS, runs
from modelgen.papers.gmm.sensitivity import width
from modelgen.papers.gmm.truth import FREQUENCIES, RANGE, impedance
from modelgen.papers.gmm.uncertainty import SPREADS, damping_known_or_not, linear, refitted, relative, ways
from modelgen.papers.number import Verdict, judge
from modelgen.papers.paper import Table


def verdicts(table: Table) -> dict[tuple[str, str], Verdict]:
    return {(r.number.row, r.number.quantity): r.verdict for r in map(judge, table.numbers)}


def test_every_table_of_the_paper_is_there_in_full() -> None:
    sizes = {t.name: len(t.numbers) for t in PAPER.tables}
    # 1: 3 × 8; 2: 3 × 2; 3: 3 × 6 and the sum; 5: 3 × 3; 6: 3 × 4; 7: 6 ranges, 12 + 6 + 6; 8: 6 × 2 and K
    wanted = {
        "Table 1": 24,
        "Table 2": 6,
        "Table 3": 20,
        "Table 5": 9,
        "Table 6": 12,
        "Table 7": 36,
        "Table 8": 13,
    }
    assert {name: sizes[name] for name in wanted} == wanted
    assert {"Eq. 5", "Sec. 3.1", "Table 4"} < set(sizes)
    places = [(t.name, n.row, n.quantity) for t in PAPER.tables for n in t.numbers]
    assert len(places) == len(set(places))


def test_series_of_the_eddy_current_factor() -> None:
    assert [str(c) for c in coefficients()] == ["1", "1/8", "1/48", "11/3072", "19/30720", "473/4423680"]
    assert verdicts(SERIES)["χ_i", "denominator under 473 (f/f_c)^5"] is Verdict.WRONG
    assert sum(v is Verdict.REPRODUCED for v in verdicts(SERIES).values()) == 4


def test_fractal_numbers_against_the_compiled_model() -> None:
    found = build(contact_damping).all(R_q_1=0.661e-6, R_q_2=0.347e-6)
    for R_q, D, G in ((0.661, "D_1", "G_1"), (0.347, "D_2", "G_2")):
        assert dimension(R_q) == pytest.approx(float(found[D]), rel=1e-12)
        assert roughness(R_q, dimension(R_q)) == pytest.approx(float(found[G]), rel=1e-10)
    assert roughness(0.347, 2.6167) == pytest.approx(2.8175247135584104753e-10, rel=1e-12)
    assert contact("M-D") == pytest.approx((2.6214, 3.6495631131604041021e-10), rel=1e-12)
    said = verdicts(FRACTAL)
    assert said["rod", "D"] is said["rod", "G"] is Verdict.NOT_REPRODUCIBLE
    assert all(v is Verdict.REPRODUCED for (row, _), v in said.items() if row != "rod")


@pytest.mark.parametrize(("name", "R_n"), [("G-M", 20213.12), ("M-D", 29026.02), ("M-H", 25693.42)])
def test_corrected_contact_damping(name: str, R_n: float) -> None:
    assert damping(name) == pytest.approx(R_n, rel=2e-3)  # reference_values.txt D, G_eq as printed there


def test_no_usual_constants_give_table_3() -> None:
    for name, (printed, _) in PRINTED.items():
        assert np.all(np.isfinite(widely(name))) and widely(name).min() > 6 * float(printed)


def test_uncertainty_of_the_fractal_dimension_is_the_derivative() -> None:
    assert contact_std("G-M", 0) == pytest.approx(0.041 * 1.6167 * 0.011 / 0.347, rel=0.02)
    # D_eq = max(D, D) of two independent equals: std √(1 − 1/π) of one
    assert contact_std("M-H", 0) / contact_std("G-M", 0) == pytest.approx((1 - 1 / pi) ** 0.5, rel=0.03)


def test_misprints_are_found() -> None:
    without_draws = Table(
        "", "", tuple(n for n in CONTACT.numbers if not n.quantity.startswith("u(") or n.row == "sum")
    )
    said = verdicts(without_draws)
    wrong = {place for place, v in said.items() if v is Verdict.WRONG}
    assert wrong == {("M-D surface", "G_eq"), ("M-H surface", "G_eq"), ("sum", "u(contact damping)")}
    assert verdicts(STRUCTURAL)["steel bar and plunger", "R_d"] is Verdict.WRONG
    stated = verdicts(STATED)
    assert stated["phase", "expanded uncertainty, P = 99 %"] is Verdict.REPRODUCED
    assert stated["factors", "K at P = 99 %, uniform"] is Verdict.WRONG
    assert sum(v is Verdict.WRONG for v in verdicts(SURFACES).values()) == 3


def test_what_needs_the_recording_is_never_called_reproduced() -> None:
    for table in PAPER.tables:
        if table.name in ("Table 5", "Table 6"):
            assert all(n.lacks for n in table.numbers)
    assert all(n.lacks or n.given for n in MEANS.numbers)


@pytest.mark.slow  # 400 refits
def test_real_parts_of_table_8_are_the_optimisers_scatter() -> None:
    said = verdicts(SPREADS)
    assert said["μ'", "relative standard uncertainty"] is Verdict.REPRODUCED
    assert said["S'", "relative standard uncertainty"] is Verdict.REPRODUCED
    assert said["d''", "relative expanded uncertainty"] is Verdict.WRONG


@pytest.mark.slow
def test_refits_and_first_order_agree_with_the_damping_measured() -> None:
    assert refitted()["S33_im"].size == 400
    for name in RANGE:
        assert relative(name) == pytest.approx(linear()[name], rel=0.15), name
    assert linear()["S33_im"] == pytest.approx(100 * 2.08e-15 * np.hypot(3.0264, 0.439) / 2.178e-13, rel=0.05)


@pytest.mark.slow
def test_with_the_damping_unknown_the_profile_stops_at_passivity() -> None:
    rows = {str(r[0]): r for r in ways().rows}
    _, _, _, linear_std, low, high = rows["S'', R_f unknown"]
    assert float(linear_std) > 50  # per cent: ± two of them would reach materials that give out power
    assert float(low) > 0 > float(high) > -100


def test_the_recording_cannot_tell_what_is_believed_of_the_damping() -> None:
    rows = {str(r[0]): [float(x) for x in r[1:] if x != ""] for r in damping_known_or_not().rows}
    residuals = [r[3] for name, r in rows.items() if "printed" not in name and "second" not in name]
    assert max(residuals) < 1.05 * min(residuals)
    assert rows["none (R_d = R_f = 0)"][0] == pytest.approx(-9.566e-13, rel=1e-3)
    assert rows["R_f unknown"][1] > 100 * rows["R_f unknown, second sweep with M_t + 20 %"][1]
    assert abs(rows["R_f unknown, second sweep with M_t + 20 %"][2]) < 2  # per cent off


def test_method_2_of_table_7_is_no_passive_material() -> None:
    assert [row[2] for row in published_sets().rows] == ["yes", "no", "yes"]
    assert compared(impedance(FREQUENCIES), impedance(FREQUENCIES, table_7(3))) == (0.0, 0.0, 1.0, 1.0)


def test_what_the_misprints_would_do() -> None:
    shows = {where: text for where, _, _, text in misprints().rows}
    assert "80.40 in place of 81.72" in str(shows["(6), R_g1"])
    assert "1.8e-09 in place of 2.81e-10" in str(shows["(18)"])  # reference_values.txt, homogeneous
    assert "1.233e+08 N/m" in str(shows["(9), K_G*"]) and "−j 1.4e+10" in str(shows["(9), K_G*"])


def test_table_6_contradicts_itself() -> None:
    rows = variances().rows
    assert float(rows[0][2]) < float(rows[1][1])  # |Z|: the intervals of Methods 1 and 2 do not meet
    assert float(rows[2][3]) > 1.4 * float(rows[0][4])


def test_basins_at_the_papers_level_are_far_wider_than_printed() -> None:
    assert width(3, "mu33_im") > 20 * 0.049
    assert np.isnan(
        width(3, "mu33_im", level=0.01)
    )  # no basin below the optimum: as 1.5 under 1.6748 would be


def test_our_swarm_finds_the_resonance_every_time_and_the_papers_does_not() -> None:
    assert np.all(runs(1, papers=False).objectives[:, 0] < 1e-3)
    assert np.sum(runs(1, papers=True).objectives[:, 0] < 1.34) < 8
