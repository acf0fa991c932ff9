"""What no catalogue holds, as effects that describe it: resonances of other places and orders, waves, losses
in a band, and errors of the recording chain that resonate or begin at a frequency."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from modelgen.diagnose.gate.describe import ANY, SOURCE
from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.effects import Effect, Shape, Strength
from modelgen.effects.effect import add
from modelgen.language import Model, Port, exp, j

RARE = 0.3
"""How common such physics is beside that of the catalogue; waves as much less beside a resonance or a row."""
MODES = 8
"""Members of a row of resonances."""
ONE, MANY = "a resonance", "a row of resonances, at multiples of the first,"
PEAK = "a loss in one band of frequencies"
CHAIN = "an error of the recording chain that resonates,"
STEP = "a gain of the recording chain that changes at one frequency, as where a range is switched,"
CLOSED = "waves between ends that are alike, with resonances at multiples of the first,"
OPEN = "waves between ends that are unlike, with resonances at odd multiples of the first,"
"""What is described. Waves on a line or in a pipe lose in proportion to frequency: −j cot kl, which is a
spring or a capacitor at low frequency, or j tan kl (L. E. Kinsler et al., Fundamentals of
Acoustics (2000), ch. 10). A peak of loss is Fuoss' and Kirkwood's (J. Am. Chem. Soc. 63 (1941) 385):
sech(Q ln u), which is Debye's for Q = 1.
"""
ROWS = (MANY, CLOSED, OPEN)
FACTORS = (CHAIN, STEP)
QUALITY = {PEAK: (0.5, 40.0), STEP: (8.0, 40.0)}
"""Ranges of Q beside those of resonances; a step that is not sharp is a smooth error of the instrument."""
PARTS = {"a": "real", "b": "imaginary"}
WAYS: dict[str, tuple[tuple[str, bool], ...]] = {
    "electrical_impedance": tuple((what, False) for what in (ONE, *ROWS, PEAK)),
    "terminals": (*((what, True) for what in (ONE, *ROWS)), *((f, False) for f in FACTORS), (ONE, False)),
    "mechanical_impedance": tuple((what, False) for what in ROWS),
    "stiffness": ((MANY, False), (MANY, True)),
}
"""What is tried by the kind of port, and whether beside all that is there.

One in series at the mechanical side is a second_mode, and any beside it is one in the electrical impedance.
Crosstalk and filters of the recording chain are factors: 1 + (a + jb)/(1 + jQ(u − 1/u)); so is a gain that
changes, by a + jb from where u^Q/(1 + u^Q) has risen.
"""


def row(u: Any, Q: Any, what: str, moving: bool, j: Any, exp: Any) -> Any:
    """Σ_n 1/(1 + jQ(u/n − n/u)), u = ω/ω_1, or waves; times ju where a stiffness moves.

    Waves: E = e^(−2jkl) is what a wave keeps on its way there and back, with kl = πu(1 − j/2Q) where ends are
    alike, −j cot kl = (1 + E)/(1 − E), and half of it where not, j tan kl = (1 − E)/(1 + E).
    """
    if what in (CLOSED, OPEN):
        path = (2 if what == CLOSED else 1) * np.pi * u
        E = exp(-path * (j + 1 / (2 * Q)))
        total = (1 + E) / (1 - E) if what == CLOSED else (1 - E) / (1 + E)
        total *= np.pi / ((2 if what == CLOSED else 4) * Q)
    elif what == STEP:
        total = 1 / (1 + u**-Q)
    elif what == PEAK:
        total = 2 / (u**Q + u**-Q)
    else:
        count = MODES if what == MANY else 1
        total = sum(1 / (1 + j * Q * (u / n - n / u)) for n in range(1, count + 1))
    return total * (j * u if moving else 1)


def kind(a: Addition) -> tuple[str, bool]:
    """What is described, and whether of a stiffness."""
    return next(
        x for x in (*ROWS, ONE, PEAK, *FACTORS) if a.effect.says.startswith(x)
    ), a.port.kind == "stiffness"


def places(model: Model) -> Iterator[tuple[Effect, Port]]:
    """Each kind of resonance at each port that can have one."""
    kinds = {p.kind for p in model.ports}
    for port in model.ports:
        twice = port.kind == "stiffness" and "mechanical_impedance" in kinds
        if twice or "omega" not in dict(port.variables):
            continue
        for what, beside in WAYS.get(port.kind, ()):
            if (port.kind, what, beside) != ("terminals", ONE, False) or "electrical_impedance" not in kinds:
                yield _resonance(port, what, beside), port


def _resonance(port: Port, what: str, beside: bool) -> Effect:
    """a Σ_n 1/(1 + jQ (ω/nω_1 − nω_1/ω)), or waves, added to the port's quantity, or `beside` it: to its
    inverse.

    A stiffness gets an impedance that resonates: jω/ω_1 times that.
    """

    lone, factor = what not in ROWS, what in FACTORS
    sharpness = QUALITY.get(what, (0.5, 500.0) if lone else (3.0, 100.0))
    unit = "1" if factor else "1/({port})" if beside else "{port}"
    heights = [Strength("a", unit, text="height of a resonance")]
    if factor:
        heights = [Strength(n, unit, bounds=ANY, text=f"height, {part} part") for n, part in PARTS.items()]

    def terms(at: Port, p: Any) -> Any:
        height = p["a"] + j * p["b"] if factor else p["a"]
        return height * row(at["omega"] / p["omega_1"], p["Q"], what, at.kind == "stiffness", j, exp)

    def parallel(model: Model, at: Port, p: Any) -> Model:
        return model.extend(at.equation, lambda Z: Z / (1 + Z * terms(at, p)))

    def times(model: Model, at: Port, p: Any) -> Model:
        return model.extend(at.equation, lambda Z: Z * (1 + terms(at, p)))

    where = "times" if factor else "beside" if beside else "in series with"
    return Effect(
        f"unknown_{port.name}",
        (port.kind,),
        f"{what} {where} all that the {port.name} port has",
        SOURCE,
        tuple(heights),
        times if factor else parallel if beside else add(terms),
        (
            Shape("omega_1", "rad/s", "omega", 0.7 if lone else 0.2, 1.5, text="the first"),
            Shape("Q", "1", "1", *sharpness, 4, text="quality factor, or how sharp"),
        ),
        needs=("omega",),
        common=RARE if lone or what == MANY else RARE**2,
    )
