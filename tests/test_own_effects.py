"""Effects of the user's own that a diagnosis can't use: it says which, and what is lacking."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modelgen.diagnose import diagnose
from modelgen.diagnose.own_effects import check_effects, unused
from modelgen.effects import Effect, Shape, Strength
from modelgen.effects.effect import add, change
from modelgen.errors import InputError
from modelgen.language import Model
from modelgen.models import load
from modelgen.recordings import Case, Recording

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


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"strengths": Strength("R", "{port}")}, r"strengths is of type Strength, .* \(Strength\(…\),\)"),
        ({"shapes": Shape("tau", "s", "time", 1, 2)}, r"shapes is of type Shape, .* \(Shape\(…\),\)"),
        ({"needs": "z_prev"}, r"needs is text, wanted a tuple of them: \('z_prev',\)"),
    ],
)
def test_a_comma_that_was_forgotten_is_told(model: Model, wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=f"effect 'rub': {says}"):
        check_effects([replace(rub, **wrong)], model, {"spring"})


def test_an_effect_that_changes_the_model_without_strength_is_refused() -> None:
    f = np.geomspace(20, 2000, 80)
    coil = load("electrodynamic_transducer")
    known = {"R_e": 6.0, "L_e": 3e-4, "Bl": 6.0, "M_m": 0.02, "K_m": 2000.0, "R_m": 1.0}
    Z = complex_impedance(f, known)
    case = Case(None, coil.id, (Recording("a", None, "fit", {"f": f}, {"Z": Z}),), constants={"M_m": 0.02})
    twice = replace(
        rub, kinds=("electrical_impedance",), apply=change(lambda Z, at, p: 2 * Z + p["R"]),
        strengths=(Strength("R", "{port}"),),
    )  # fmt: skip
    with pytest.raises(InputError, match="with rub_R = 0 the model has to be as it was, and differs by"):
        diagnose(case, coil, effects=[twice])


def complex_impedance(f: np.ndarray, p: dict[str, float]) -> np.ndarray:
    """Of a moving coil: R_e + jωL_e + Bl²/(R_m + jωM_m + K_m/jω), with noise of a thousandth."""
    s = 2j * np.pi * f
    Z = p["R_e"] + s * p["L_e"] + p["Bl"] ** 2 / (p["R_m"] + s * p["M_m"] + p["K_m"] / s)
    noise = np.random.default_rng(5).standard_normal((2, f.size))
    return np.asarray(Z * (1 + 1e-3 * (noise[0] + 1j * noise[1])))
