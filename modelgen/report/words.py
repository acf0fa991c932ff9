"""How numbers, units and findings are put into words: plain text, shared by the page and the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable

from modelgen.diagnose.verdict import Finding, Verdict
from modelgen.units import LIFTED
from modelgen.units import unit_text as unit_text


def unit_cell(unit: str) -> str:
    """A unit alone in a column of units: "1" of a pure number, which has none beside its value."""
    return unit_text(unit) or "1"


def superscript(number: object) -> str:
    """Digits raised: 10 → ¹⁰."""
    return str(number).translate(LIFTED)


def number(x: float, digits: int = 3) -> str:
    """`x` with so many significant digits: 0.0123, 1.23·10⁻⁷, "–" where there is no such figure."""
    if not math.isfinite(x):
        return "–"
    if x == 0:
        return "0"
    exponent = math.floor(math.log10(abs(float(f"{x:.{digits - 1}e}"))))
    if -4 < exponent < 6:
        return _minus(f"{x:.{max(digits - 1 - exponent, 0)}f}")
    return f"{_minus(f'{x / 10.0**exponent:.{digits - 1}f}')}·10{superscript(exponent)}"


def short(x: float, digits: int = 4) -> str:
    """`x` with up to so many significant digits and no trailing zeros, for ranges and known constants."""
    shown = number(x, digits)
    head, dot, rest = shown.partition("·")
    return (head.rstrip("0").rstrip(".") if "." in head else head) + dot + rest


SURE = 15  # decimal digits that a double holds
ALONE = 1e-12  # of a value: smaller deviations are no digits of it that one can read


def measured(value: float, std: float) -> str:
    """Value and standard deviation to its last two figures: 0.3834 ± 0.0012, (1.20 ± 0.03)·10⁻⁵; a tiny one
    stands by itself: 100 ± 1.0·10⁻¹⁴."""
    if not math.isfinite(value):
        return "–"
    if not (math.isfinite(std) and std > 0):
        return number(value, 4)
    if std < ALONE * abs(value):
        return f"{short(value, SURE)} ± {number(std, 2)}"
    size = max(abs(value), std)
    exponent = math.floor(math.log10(size))
    shift = 0 if -4 < exponent < 6 else exponent
    value, std = value / 10.0**shift, std / 10.0**shift
    decimals = max(1 - math.floor(math.log10(std)), 0)
    value = round(value, decimals) + 0.0  # no minus before a zero
    text = f"{_minus(f'{value:.{decimals}f}')} ± {std:.{decimals}f}"
    return f"({text})·10{superscript(shift)}" if shift else text


def percent(p: float) -> str:
    """A probability or a share; never certain."""
    if not math.isfinite(p):
        return "–"
    if p > 0.995:
        return "> 99 %"
    return "< 1 %" if p < 0.005 else f"{100 * p:.0f} %"


def in_english(things: Iterable[str]) -> str:
    """a, b and c."""
    *most, last = list(things) or [""]
    return f"{', '.join(most)} and {last}" if most else last


PEOPLE = ("bouc", "coulomb", "dahl", "kelvin", "maxwell", "stribeck", "voigt", "warburg", "wen")
"""Whose names ids spell small."""


def name_of(id: str) -> str:
    """An effect's or a model's id as words."""
    return " ".join(w.capitalize() if w in PEOPLE else w for w in id.split("_"))


def is_unknown(effect: Finding) -> bool:
    """Whether no catalogued effect explains what this finding stands for."""
    return effect.id.startswith("unknown_")


def headline(verdict: Verdict) -> str:
    """The verdict in a line."""
    if not verdict.judged:
        return "Too few values to tell whether anything is missing"
    if verdict.adequate:
        return "Nothing is missing that these recordings could show"
    if not verdict.effects:
        return "The model misses these recordings, and no hypothesis explains how"
    known = [name_of(e.id) for e in verdict.effects if not is_unknown(e)]
    ports = [e.port for e in verdict.effects if is_unknown(e)]
    if ports:
        known.append(f"physics at the {in_english(ports)} port that no catalogued effect describes")
    return f"Left out: {in_english(known)}"


def summary(verdict: Verdict) -> str:
    """The verdict's own two sentences, or two made from its figures."""
    if verdict.summary:
        return verdict.summary
    before, after = verdict.before.fit_over_noise, verdict.after.fit_over_noise
    if verdict.adequate:
        return f"The model fits to {number(before)} times the noise. The recordings tell no more than that."
    rest = f"The misfit is {number(before)} times the noise"
    if not verdict.effects:
        return f"{rest}. None of the hypotheses that were tried takes it away."
    said = " ".join(e.says.rstrip(".") + "." for e in verdict.effects)
    return f"{said} {rest}, and {number(after)} times with it."


def joint_probability(verdict: Verdict) -> float:
    """Probability of the least certain of the effects: the verdict stands or falls with it."""
    return min((e.probability for e in verdict.effects), default=math.nan)


def _minus(text: str) -> str:
    return text.replace("-", "−")
