"""The frame of `modelgen reproduce`: verdicts, what is written, and that every number says why."""

import json
import signal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelgen.cli import main
from modelgen.cli.reproducing import counted_interrupts
from modelgen.errors import InputError
from modelgen.papers import IDS, papers
from modelgen.papers.number import Published, Verdict, judge
from modelgen.papers.page import lowered, page
from modelgen.papers.paper import Figure, Found, Paper, Study, Table
from modelgen.papers.run import Reproduction, reproduce
from modelgen.papers.show import difference, ours, printed


def number(text: str, value: float, **more: object) -> Published:
    return Published("row", "quantity", text, "N", "some formula", lambda: value, **more)


@pytest.mark.parametrize(
    ("text", "rounding"),
    [("0.661", 5e-4), ("4.3788e-10", 5e-15), ("1600", 0.5), ("-2.178e-13", 5e-17), ("36.57", 5e-3)],
)
def test_the_last_printed_digit_is_the_rounding(text: str, rounding: float) -> None:
    assert number(text, 0.0).rounding == pytest.approx(rounding)


@given(st.floats(-9.9, 9.9), st.integers(-12, 12), st.integers(0, 8))
def test_a_value_printed_by_python_is_reproduced(mantissa: float, exponent: int, digits: int) -> None:
    value = mantissa * 10.0**exponent
    assert judge(number(f"{value:.{digits}e}", value)).verdict is Verdict.REPRODUCED


def test_verdicts() -> None:
    assert judge(number("1.00", 1.0049)).verdict is Verdict.REPRODUCED
    assert judge(number("1.00", 1.0051)).verdict is Verdict.NOT_REPRODUCIBLE
    assert judge(number("1.00", 1.08, within=0.1)).verdict is Verdict.REPRODUCED
    assert judge(number("1.00", 2.0, wrong="it is twice that")).verdict is Verdict.WRONG
    assert judge(number("1.00", 1.0, wrong="it is not")).verdict is Verdict.REPRODUCED
    assert judge(number("1.00", 1.0, lacks="the recording")).verdict is Verdict.NOT_REPRODUCIBLE
    assert judge(number("1.00", float("nan"))).verdict is Verdict.NOT_REPRODUCIBLE
    with pytest.raises(InputError, match="neither computed nor said why not"):
        Published("row", "quantity", "1", "N")


def test_numbers_are_shown_to_one_digit_more_than_printed() -> None:
    result = judge(number("4.3788e-10", 4.370071e-10))
    assert (printed(result), ours(result), difference(result)) == ("4.3788·10⁻¹⁰", "4.37007·10⁻¹⁰", "−0.20 %")
    assert difference(judge(number("0.012", 0.0638))) == "×5.32"


def test_page_and_json_hold_everything() -> None:
    table = Table("Table 9", "caption <b>", (number("1.0", 2.0, wrong="because"),))
    study = Study("A study", lambda: Found(("one sentence",), ("what", "value"), (("a", 0.5),)))
    figure = Figure("Fig. 1", "a line", "says", lambda canvas: canvas.subplots().plot([0, 1], [0, 1]))
    told: list[float] = []
    found = reproduce(
        [Paper("p", "A paper", (table,), (study,), (figure,))], lambda part, _: told.append(part)
    )
    assert told == [0.0, 0.5]
    whole = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert whole["papers"][0]["count"]["wrong in print"] == 1
    assert whole["papers"][0]["tables"][0]["numbers"][0]["ours"] == 2.0
    text = page(found)
    assert "Caption &lt;b&gt;" in text and "One sentence." in text and "<svg" in text and "Because." in text
    assert "http" not in text.replace("http-equiv", "").replace("http://www.w3.org", "")


def interrupted(times: list[int], after: int) -> Reproduction:
    """The reproduction of four numbers, stopped while the one after `after` is being computed."""
    done: list[int] = []

    def compute() -> float:
        done.append(1)
        if len(done) == after + 1:
            times[0] += times[1]
        return 1.0

    rows = tuple(Published(f"row {k}", "quantity", "1.0", "N", "some formula", compute) for k in range(4))
    study = Study("A study", lambda: Found(("said",)))
    paper = Paper("p", "A paper", (Table("Table 9", "caption", rows),), (study,))
    return reproduce([paper], stop=lambda: times[0])


def test_an_interrupt_keeps_what_is_done_and_a_second_one_drops_what_was_cut_short() -> None:
    once, twice = interrupted([0, 1], 1), interrupted([0, 2], 1)
    assert [len(r.papers[0].results) for r in (once, twice)] == [2, 1]
    assert [r.left_out for r in (once, twice)] == [3, 4]
    assert "3 numbers and studies were not reached" in page(once)
    assert interrupted([0, 2], 0).papers == ()


def test_ctrl_c_is_counted(capsys: pytest.CaptureFixture[str]) -> None:
    before = signal.getsignal(signal.SIGINT)
    with counted_interrupts() as stop:
        assert stop() == 0
        signal.raise_signal(signal.SIGINT)
        assert stop() == 1
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        assert stop() == 2
    assert signal.getsignal(signal.SIGINT) is before
    assert "Ctrl-C again" in capsys.readouterr().err


def test_indices_are_lowered_but_not_in_names_of_several_parts() -> None:
    assert str(lowered("R_f < D_eq, k_eff², k_D_M and loss_angle, J_1(x)^2")) == (
        "R<sub>f</sub> &lt; D<sub>eq</sub>, k<sub>eff</sub>², k_D_M and loss_angle, J_1(x)<sup>2</sup>"
    )


def test_unknown_paper_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "gmn"]) == 2
    assert "did you mean 'gmm'" in capsys.readouterr().err


def test_every_number_has_a_source_for_ours_or_a_reason() -> None:
    for paper in papers():
        assert paper.id in IDS
        for n in (n for t in paper.tables for n in t.numbers):
            assert n.row and n.quantity
            assert n.ours is None or n.how, f"{n.row}, {n.quantity}: how is ours computed?"
