"""A model of what no catalogue holds: the terms that describe it, at the port where they describe it best.

It says no more than the recordings do: a sum of resonant terms over frequency, powers of displacement and
speed in time. But it can be built, fitted, exported and diagnosed like any other model.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.diagnose.hypotheses.functions import LEVEL, LINE, ORDERS, PUMP, WAVE
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome, Setting
from modelgen.effects import Effect, Shape, Strength
from modelgen.effects.effect import ANY, add, change
from modelgen.language import Abs, Max, Min, Port, cos, j, pi, sign, sin

SOURCE = "a description, no law"
Term = tuple[int, int, Callable[[Any, Any], Any]]
"""Powers of displacement and of speed in its unit, and the term of z and v."""

POWERS: dict[str, tuple[Term, ...]] = {
    "displacement": tuple((k, 0, lambda z, v, k=k: z**k) for k in range(2, 6)),  # type: ignore[misc]
    "speed": (
        (0, 0, lambda z, v: sign(v)), (0, 1, lambda z, v: Abs(v)), (0, 2, lambda z, v: v * Abs(v)),
        (0, 2, lambda z, v: v**2), (0, 3, lambda z, v: v**3),
    ),
    "both": tuple(
        term
        for a in (1, 2, 3)
        for term in (
            (a, 1, lambda z, v, a=a: z**a * v), (a, 1, lambda z, v, a=a: z**a * Abs(v)),
            (a, 0, lambda z, v, a=a: z**a * sign(v)),
        )
    ),
}  # fmt: skip


def described(setting: Setting, outcome: Outcome, left: Leftover) -> Fit | None:
    """The base with terms for what is `left` to describe, fitted; None where no terms do or where they gain
    nothing."""
    ports = [p for p in setting.model.ports if p.name == left.port]
    effect = _effect(setting, left, ports[0]) if ports and left.terms else None
    if effect is None:
        return None
    port = next((p for p in effect.fits(setting.model) if p.equation == ports[0].equation), None)
    if port is None:
        return None
    names = tuple(s.name for s in setting.series) if effect.each else ()
    a = Addition(effect, port, {q.name: (q.low, q.high) for q in effect.shapes}, names)
    made = make_hypotheses(setting.model, setting.case, setting.series, [(a,)])
    if not made:
        return None
    base, h = outcome.base, made[0]
    begin: list[dict[str, float]] = [{q.name: float(np.sqrt(q.low * q.high)) for q in effect.shapes}]
    if left.terms[0] == LEVEL:
        begin = [{"bend": 1 / abs(left.terms[1]), "n": n} for n in BENDS]
    starts = [{f"{a.id}_{n}": x for n, x in values.items()} for values in begin]
    # the base is bent to what is missing, and less where the best hypothesis stands for it
    unbent = outcome.best.hypothesis.values_of(outcome.best.theta, base.hypothesis)
    thetas = [base.theta, unbent] if outcome.best.hypothesis.added else [base.theta]
    places = [h.place(base.hypothesis, theta, values) for theta in thetas for values in starts]
    white = replace(outcome.judge, whiteners=tuple(replace(w, ar=None) for w in outcome.judge.whiteners))
    for judge in (outcome.judge, white):  # the colour of what is left may have taken it for noise
        fit = judge.fit(h, places)
        if judge.look(base.hypothesis, base.theta).bic - fit.bic > ALARM:
            return outcome.judge.look(h, fit.theta)
    return None


def _effect(setting: Setting, left: Leftover, port: Port) -> Effect | None:
    id = f"unknown_{port.name}"
    if not setting.model.is_time_model:
        return _resonant(id, port, left.terms)
    name, which, *side = left.terms
    if name == WAVE:
        return wave(id, port, which)
    if name == LINE:
        return humming(id, port, which)
    if name == PUMP:
        return pumped(id, port, which, *side)
    if name == LEVEL:
        return levelling(id, port, which, *side) if which * side[0] > 0 else None
    return powers(id, port, POWERS[name]) if name in POWERS else None


def wave(id: str, port: Port, kappa: float, harmonics: int = 2) -> Effect:
    """Σ a_k cos kκz + b_k sin kκz, added to the force: a wave and its first harmonics."""
    orders = range(1, harmonics + 1)
    strengths = tuple(
        Strength(f"{n}_{k}", "{port}", bounds=ANY, text="amplitude") for k in orders for n in "ab"
    )
    shape = Shape("kappa", "1/({z})", "1", kappa / 1.3, 1.3 * kappa, text="2π over its wavelength")

    def terms(at: Port, p: Any) -> Any:
        turns = ((k, k * p["kappa"] * at["z"]) for k in orders)
        return sum(p[f"a_{k}"] * cos(x) + p[f"b_{k}"] * sin(x) for k, x in turns)

    says = "a wave over displacement that describes what is left"
    return Effect(id, (port.kind,), says, SOURCE, strengths, add(terms), (shape,), ("z",))


def humming(id: str, port: Port, f: float) -> Effect:
    """Σ a_k cos 2πkft + b_k sin 2πkft, of other amplitudes in each recording."""
    strengths, shape, wave = _periodic(f, ORDERS, "{port}")
    says = "a wave in time and its harmonics describe what is left"
    kinds = (port.kind,)
    return Effect(id, kinds, says, SOURCE, strengths, add(wave), (shape,), ("t",), each=True, first=True)


def pumped(id: str, port: Port, f: float, by: str, orders: int) -> Effect:
    """The same times displacement or speed, or the force F that is there: what changes so is a stiffness, a
    dashpot, or a gain."""
    size, needs = ("1", ("t",)) if by == "F" else (f"{{port}}/{{{by}}}", ("t", by))
    strengths, shape, wave = _periodic(f, orders, size)

    def grown(F: Any, at: Port, p: Any) -> Any:
        return F + (F if by == "F" else at[by]) * wave(at, p)

    says, kinds = "what changes with waves in time describes what is left", (port.kind,)
    return Effect(id, kinds, says, SOURCE, strengths, change(grown), (shape,), needs, each=True, first=True)


Wave = Callable[[Port, Any], Any]


def _periodic(f: float, orders: int, unit: str) -> tuple[tuple[Strength, ...], Shape, Wave]:
    """Amplitudes of a wave in time and its harmonics, in a `unit`; its frequency; and the wave."""
    names = [(n, k) for k in range(1, orders + 1) for n in "ab"]
    strengths = tuple(Strength(f"{n}_{k}", unit, bounds=ANY, text="amplitude") for n, k in names)
    shape = Shape("f", "1/s", "1", f / 1.01, 1.01 * f, text="its frequency")

    def wave(at: Port, p: Any) -> Any:
        turns = ((k, 2 * pi * k * p["f"] * at["t"]) for k in range(1, orders + 1))
        return sum(p[f"a_{k}"] * cos(x) + p[f"b_{k}"] * sin(x) for k, x in turns)

    return strengths, shape, wave


BENDS = (3.0, 10.0, 60.0, 400.0)
"""Sharpness of a channel's end from which fits start."""


def levelling(id: str, port: Port, begins: float, side: int) -> Effect:
    """F/(1 + (F/F_s)ⁿ)^(1/n) on one side: a channel whose reading levels off at F_s = 1/bend, beyond where
    that `begins`."""
    strength = Strength(
        "bend", "1/({port})", bounds=(0.0, 3 * side / begins), text="1/F_s, where it levels off"
    )
    shape = Shape("n", "1", "1", 1.5, 2000.0, text="how sharply")

    def shown(F: Any, at: Port, p: Any) -> Any:
        u = Max(side * F * p["bend"], 1e-9)
        return F / Max(u, 1) * (1 + Min(u, 1 / u) ** p["n"]) ** (-1 / p["n"])  # without uⁿ, which overflows

    says = "a reading that levels off describes what is left"
    return Effect(id, (port.kind,), says, SOURCE, (strength,), change(shown), (shape,), ("t",), secant=True)


def _resonant(id: str, port: Port, places: tuple[Any, ...]) -> Effect:
    """Σ (a_k + j b_k)/(1 + j Q_k (ω/ω_k − ω_k/ω)) at the port, near the given (frequency, Q)."""
    strengths, shapes = [], []
    for k, (f0, Q) in enumerate(places, 1):
        w = 2 * np.pi * f0
        strengths += [Strength(f"{n}_{k}", "{port}", bounds=ANY, text="amplitude") for n in "ab"]
        shapes += [
            Shape(f"omega_{k}", "rad/s", "1", w / 1.3, 1.3 * w, text="where"),
            Shape(f"Q_{k}", "1", "1", Q / 4, 4 * Q, text="how narrow"),
        ]

    def terms(at: Port, p: Any) -> Any:
        total: Any = 0
        for k in range(1, len(places) + 1):
            u = at["omega"] / p[f"omega_{k}"]
            total += (p[f"a_{k}"] + j * p[f"b_{k}"]) / (1 + j * p[f"Q_{k}"] * (u - 1 / u))
        return total

    says = "resonant terms that describe what is left"
    return Effect(id, (port.kind,), says, SOURCE, tuple(strengths), add(terms), tuple(shapes), ("omega",))


def powers(id: str, port: Port, chosen: tuple[Term, ...]) -> Effect:
    """Powers of displacement and speed, added to the force."""
    strengths = tuple(
        Strength(f"c_{n}", f"{{port}}/({{z}}**{a}*{{v}}**{b})", bounds=ANY, text="coefficient")
        for n, (a, b, _) in enumerate(chosen, 1)
    )

    def terms(at: Port, p: Any) -> Any:
        return sum(p[f"c_{n}"] * what(at["z"], at["v"]) for n, (_, _, what) in enumerate(chosen, 1))

    return Effect(
        id, (port.kind,), "terms that describe what is left", SOURCE, strengths, add(terms), needs=("z", "v")
    )
