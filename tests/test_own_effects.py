"""Effects of the user's own that a diagnosis can't use: it says which, and what is lacking."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from modelgen.diagnose.own_effects import check_effects, unused
from modelgen.effects import Effect, Shape, Strength
from modelgen.effects.effect import add
from modelgen.errors import InputError
from modelgen.language import Model
from modelgen.models import load

rub = Effect("rub", ("spring",), "", "", (Strength("R", "{port}"),), add(lambda at, p: p["R"]))


@pytest.fixture(scope="module")
def model() -> Model:
    return load("modified_dahl")


@pytest.mark.parametrize(
    ("effect", "why"),
    [
        (replace(rub, kinds=("mechanical_impedance",)), "is for 'mechanical_impedance', and mod"),
        (replace(rub, needs=("z_prv",)), r"needs 'z_prv' of port '\w+', which has .*did you mean 'z_prev'"),
        (replace(rub, also=("electrical",)), "needs a port 'electrical' too, and modified_dahl has none"),
        (replace(rub, unless=("spring",)), "is for models without a port 'spring'"),
        (replace(rub, lacks=("z_prev",)), "is for ports without 'z_prev'"),
        (replace(rub, units=("V",)), r"is for 'V', and port '\w+' is in 'N/mm'"),
        (replace(rub, each=True), "differs from sweep to sweep, and these recordings are no repeats"),
        (replace(rub, shapes=(Shape("tau", "s", "tme", 1, 2),)), r"no range to search in for tau \('tme'\)"),
    ],
)
def test_it_is_said_why_an_effect_was_not_tried(model: Model, effect: Effect, why: str) -> None:
    (note,) = unused([effect], model, [])
    assert note.startswith("effect 'rub' was not tried: ")
    assert re.search(why, note)


@pytest.mark.parametrize(
    ("unit", "says"),
    [
        ("1/{prt}", r"no '\{prt\}' for a unit, did you mean 'port'"),
        ("1/{port", "expected '}'"),
        ("{port}/mmm", "unknown unit"),
    ],
)
def test_a_unit_that_says_nothing_is_refused(model: Model, unit: str, says: str) -> None:
    wrong = replace(rub, strengths=(Strength("R", unit),))
    with pytest.raises(InputError, match=f"effect 'rub' at port .*{says}"):
        check_effects([wrong], model, {"spring"})


def test_a_turn_that_is_none_is_refused(model: Model) -> None:
    wrong = replace(rub, acts="last")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="effect 'rub': acts is 'last', wanted FIRST, BESIDE, AROUND"):
        check_effects([wrong], model, {"spring"})
