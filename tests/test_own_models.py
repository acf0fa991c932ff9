"""What users write in models and cases of their own, and how they are told of slips."""

from __future__ import annotations

from sympy import Symbol

from modelgen.fit.series import signature_of
from modelgen.language import (
    Condition,
    Equation,
    Implicit,
    Input,
    Model,
    Parameter,
    Port,
    State,
    complex_parameter,
    exp,
    j,
)


def leaking(real: bool | None) -> Model:
    """A leaking tank whose quantities are all written as symbols, `real` or not."""
    t, q, k, h, left = (Symbol(n, real=real) for n in ("t", "q", "k", "h", "left"))
    root = Implicit("root", Symbol("root", real=real) ** 2 - h, (0, 2 * h**0.5), "cm**0.5")
    return Model(
        "leaking",
        (Input("t", "s"), Input("q", "cm/s")),
        (Parameter("k", "cm**0.5/s", 1.0, (0.1, 9.0)), Parameter("h_0", "cm", 2.0, (0.1, 9.0))),
        (
            State("h", Symbol("h_0", real=real), rate=q - k * h**0.5, unit="cm"),
            root,
            Equation("left", h, "cm"),
            Equation("twice", 2 * left, "cm"),
        ),
        ("twice",),
        (Port("out", "force", "left", (("z", h), ("t", t))),),
        conditions=(Condition("it leaks", k),),
    )


def test_a_plain_symbol_of_a_quantity_is_that_quantity() -> None:
    plain, real = leaking(None), leaking(True)
    assert plain == real and plain.hash == real.hash
    assert plain.ports[0]["z"] == plain["h"].symbol
    assert not signature_of(plain).outputs[0].complex


def test_what_is_complex_stays_complex() -> None:
    f, R = Input("f", "Hz"), Parameter("R", "ohm", 1.0)
    S = complex_parameter("S", "ohm", 1 + 2j)
    Y = Equation("Y", Symbol("S") * exp(j * Symbol("R") / Symbol("R")), "ohm")
    Z = Equation("Z", Symbol("Y") + Symbol("S_re"), "ohm")
    model = Model("z", (f,), (R, S), (Y, Z), ("Z",))
    assert model["Z"].complex
    assert model["Z"].expr == Y.symbol + S.re.symbol and Y.symbol.is_real is None
