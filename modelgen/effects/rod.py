"""Waves in a rod: K·kl·cot(kl) with one end held, jωm·tan(kl)/kl with one end free."""

from dataclasses import replace
from functools import cmp_to_key
from typing import Any

from sympy import Add, Basic, Mul, Pow, sympify

from modelgen.effects.effect import AROUND, Effect, Shape, Strength, add_impedance, change
from modelgen.effects.resonance import LOSS
from modelgen.language import im, j, re

LEVELS = 22


def xcotx(q: Any) -> Any:
    """√q cot √q by Lambert's continued fraction 1 − q/(3 − q/(5 − …)).

    Meromorphic, finite and smooth at q = 0, poles where they belong; its error is below 1e-6 of max(1, |x
    cot x|) for |q| < 160, where the first four poles lie, and below 1e-11 for |q| < 90.
    """
    tail: Any = 2 * LEVELS + 1
    for n in range(2 * LEVELS - 1, 0, -2):
        tail = n + over(-q, tail)
    return tail


def over(a: Any, x: Any) -> Any:
    """a/x, put together as sympy does, which would ask of all that is within x whether it can vanish."""
    if not isinstance(x, Add):
        return a / x
    number, factors = sympify(a).as_coeff_mul()
    parts = sorted((*factors, Pow(x, -1, evaluate=False)), key=cmp_to_key(Basic.compare))
    return Mul(*(() if number == 1 else (number,)), *parts, evaluate=False)


def _lossy(K: Any) -> Any:
    """K/Re K, in numbers whose powers are of no size."""
    return 1 + j * im(K) / re(K)


def _rod(lossy: bool) -> Effect:
    """A rod with one end held. The time that a wave needs along it says where its resonances are, whatever
    its stiffness; its mass is K τ², and real also where K loses energy: there waves do, too."""
    says, tau2 = ("waves run in the rod and fade", "tau2_eta") if lossy else ("waves run in the rod", "tau2")
    loss = ", (kl)² = (ωτ)²(1 − jη) Re K/K" if lossy else ", (kl)² = (ωτ)² Re K/K, by its own mass Re K τ²"
    fades = "; complex wavenumber: L. Cremer, M. Heckl, B. Petersson, Structure-Borne Sound (2005), ch. 3"
    return Effect(
        "distributed_rod",
        ("stiffness",),
        f"{says}: its stiffness is K·kl·cot(kl){loss}",
        "L. E. Kinsler et al., Fundamentals of Acoustics (2000), sec. 3.6: rod with one end held"
        + fades * lossy,
        (
            Strength(
                tau2, "s**2", text="square of the time τ that a wave needs along the rod",
                scale="1/max(omega)**2", low=0.0025, high=160.0, points=200,
            ),
        ),
        change(
            lambda K, at, p: (
                K * xcotx(at["omega"] ** 2 * p[tau2] * (1 - j * p["eta"] if lossy else 1) / _lossy(K))
            )
        ),
        (LOSS,) if lossy else (),
        needs=("omega",),
        secant=True,  # a third of the rod's mass at first order, which any moving mass absorbs
        acts=AROUND,
    )  # fmt: skip


distributed_rod, lossy_rod = _rod(False), _rod(True)

counted_rod = replace(
    distributed_rod,
    says=f"{distributed_rod.says}; a third of the rod's mass is in the moving mass already",
    source="Lord Rayleigh, The Theory of Sound I (1877), sec. 156: a third of a spring's mass; "
    + distributed_rod.source,
    strengths=(replace(distributed_rod.strengths[0], name="tau2_third"),),
    apply=change(
        lambda K, at, p: (
            K * xcotx(at["omega"] ** 2 * p["tau2_third"] / _lossy(K))
            + at["omega"] ** 2 * p["tau2_third"] * re(K) / 3
        )
    ),
)

moving_rod = Effect(
    "distributed_rod",
    ("mechanical_impedance",),
    "waves run in a moving rod: its far end is free, so its mass grows like tan(kl)/kl",
    "L. E. Kinsler et al., Fundamentals of Acoustics (2000), sec. 3.5: rod with one end free",
    (
        Strength(
            "m_free", "{impedance}*s", text="mass of the rod", scale="median(port/omega)", low=0.1, high=1.0,
            points=3,
        ),
    ),
    add_impedance(
        lambda at, p: (
            over(j * at["omega"] * p["m_free"], xcotx((at["omega"] * p["tau_free"]) ** 2))
            - j * at["omega"] * p["m_free"]
        )
    ),
    (Shape("tau_free", "s", "1/max(omega)", 0.3, 12.6, 200, text="time that a wave needs along the rod"),),
    needs=("omega",),
    secant=True,  # a little of it has its resonances where much of it hasn't
)  # fmt: skip

RODS = (distributed_rod, counted_rod, lossy_rod)
"""Where any stiffness might be that of a rod."""
OF_LENGTH = tuple(replace(e, lacks=("l",)) for e in RODS) + tuple(
    replace(e, needs=(*e.needs, "l"), common=4.0 * e.common) for e in RODS
)
"""Where the port tells its length l, it is one, and as certain as that it has mass."""

EFFECTS = (*OF_LENGTH, moving_rod)
