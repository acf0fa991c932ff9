"""What a reader of a fit should know beside its numbers, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from modelgen.fit.method import Outcome
from modelgen.fit.result import Estimate
from modelgen.fit.series import Array, Series
from modelgen.recordings import Case

Part = tuple[Series, Array, Array]
"""A recording, its residual (channels, n) in the model's units, model less data, and the same whitened."""

MISFIT = 1.5  # rms over noise above which a note says that the model leaves something out
LITTLE = 2.0  # and up to which it may be that the stated noise is too small
FAR_BELOW = 0.1  # rms over noise, by degrees of freedom, below which the stated noise is far too large
TELLING = (
    100  # neighbours by whose correlation noise is told from what the model misses, where that is little
)
FEW = 0.25  # share of the starts that arrive, below which the optimum may not be the best
MANY = 200  # starts that are proposed where few arrive
GROSS = 5.0  # robust standard deviations beyond which a sample may be an outlier
RARE = 0.03  # share of the samples that may be
MOST = 0.5  # share of r·r that they must carry to be what is amiss
ALIKE = 0.2  # correlation of neighbouring residuals that makes standard deviations a fifth too small
CHANCE = 4.0  # standard deviations of that correlation which are no accident
PREFIXES = (2, 3, 6, 9)  # powers of ten between the units of one quantity
CLOSE = 0.3  # relative error of such a factor, and share of the data that is left once it is taken out


def warnings(
    case: Case,
    outcome: Outcome,
    found: Sequence[Estimate],
    parts: Sequence[Part],
    over: float,
    cut: bool = False,
) -> list[str]:
    """What may be amiss with recordings, parameters or the search. over: rms of the fitted over noise. cut:
    whether recordings can be cut into segments (multiple shooting)."""
    said = list(case.warnings)
    said += [f"{e.name} lies on its bound" for e in found if e.at_bound]
    said += _of_noise(parts, over)
    if outcome.starts > 1 and outcome.reached < FEW * outcome.starts:
        said.append(_few(outcome, cut))
    return said


def _few(outcome: Outcome, cut: bool) -> str:
    """That few starts arrived, and what to do about it."""
    more = max(MANY, 10 * outcome.starts)
    cure = (
        "for a model with states `--method 'ipopt(shooting=40)'` often arrives from farther away"
        if cut
        else f"`--method 'multistart({more})'` tries more of them"
    )
    return (
        f"only {outcome.reached} of {outcome.starts} starts reached this optimum, so there may be a better "
        f"one: {cure}, narrower [bounds] or `--start NAME=VALUE` begin nearer to it"
    )


def _of_noise(parts: Sequence[Part], over: float) -> list[str]:
    """What makes a residual other than independent noise, beside a model that is wrong."""
    fitted = [white for s, _, white in parts if s.role == "fit"]
    if odd := other_unit(parts):
        return odd
    if gross := outliers(fitted):
        return [gross]
    r = likeness(fitted)
    if not 1 <= over <= MISFIT or r == 0:  # noise that is stated as larger covers it
        return []
    return [
        f"neighbouring residuals are alike (correlation {r:.2f}): the model leaves something out, or the "
        "noise is not independent from sample to sample, as standard deviations take it to be: they may be "
        f"{np.sqrt((1 + r) / (1 - r)):.2g} times too small; `modelgen diagnose` looks for it"
    ]


def misfit(parts: Sequence[Part], over: float, stated: bool, rank: int) -> list[str]:
    """How large the residual is, where that is too large and neither units nor outliers tell why, or far too
    small for the noise that is stated. rank: of combinations of parameters that were fitted."""
    fitted = [white for s, _, white in parts if s.role == "fit"]
    share = 1 - rank / sum(white.size for white in fitted)
    if stated and over**2 < FAR_BELOW**2 * share:
        return [
            f"the residual is {over:.3g} times the stated noise: what is stated is far too large, and with "
            "it are standard deviations"
        ]
    if not over > MISFIT or other_unit(parts) or (outliers(fitted) and not _beside_outliers(fitted) > MISFIT):
        return []
    if stated and over <= LITTLE and (instead := _rather_noise(fitted, over)):
        return [instead]
    noise = "the noise" if stated else "what neighbouring samples scatter by"
    other = "" if stated else ", or the noise is not independent from sample to sample"
    return [
        f"the residual is {over:.3g} times {noise}: the model leaves something out, which "
        f"standard deviations do not cover{other}; `modelgen diagnose` looks for it"
    ]


def _rather_noise(whites: Sequence[Array], over: float) -> str:
    """That a residual somewhat larger than the stated noise may be noise all the same; "" where it is not
    independent from sample to sample."""
    r, pairs = _neighbours(whites)
    doubt = "the model leaves something out, or the noise is stated too small"
    if pairs < TELLING:
        return f"the residual is {over:.3g} times the noise: {doubt}; the samples are too few to tell which"
    if abs(r) > CHANCE / np.sqrt(pairs):
        return ""
    return (
        f"the residual is {over:.3g} times the stated noise and looks like noise of that level (neighbouring "
        "samples are not alike): either what is stated is too small, and with it standard deviations, or the "
        "model leaves something out; `modelgen diagnose` looks for it"
    )


def arrived(outcome: Outcome) -> list[str]:
    """How many starts reached the optimum, where they are not few."""
    if outcome.starts <= 1 or outcome.reached < FEW * outcome.starts:
        return []
    return [f"{outcome.reached} of {outcome.starts} starts reached this optimum"]


def of_holdout(refitted: Sequence[Estimate]) -> list[str]:
    """That not all of a held-out recording is predicted."""
    names = list(dict.fromkeys(e.name.partition("[")[0] for e in refitted))
    if not names:
        return []
    are = f"{', '.join(names)} {'are' if len(names) > 1 else 'is'}"
    return [f"{are} refitted on each held-out recording alone, all else of it is predicted"]


WORSE = 3.0
"""Times as far off as fitted recordings are, from which it is said of held-out ones."""


def carried(over: Mapping[str, float]) -> list[str]:
    """That held-out recordings are missed by far more than the fitted ones; over: the rms of either over its
    noise."""
    far = over["holdout"] / max(over["fit"], 1.0)
    if not far > WORSE:
        return []
    return [
        f"what is held out is missed by {over['holdout']:.2g} times the noise, {far:.2g} times as much as "
        "what is fitted: the model does not carry over"
    ]


def outliers(whites: Sequence[Array]) -> str:
    """The few samples that stand alone and carry most of residuals (channels, n), in words; "" for none.

    Where the residual is large along a stretch, as beside a resonance, it is the model that misses it.
    """
    power, gross = [np.sum(white**2, axis=0) for white in whites], _gross(whites)
    count, of = sum(int(np.sum(g)) for g in gross), sum(g.size for g in gross)
    beside = sum(int(np.sum(g[1:] & g[:-1])) for g in gross)
    if not 0 < count <= RARE * of or 2 * beside > count:
        return ""
    share = sum(float(p[g].sum()) for p, g in zip(power, gross, strict=True)) / sum(p.sum() for p in power)
    if share < MOST:
        return ""
    samples = f"{count} of {of} samples carr{'ies' if count == 1 else 'y'}"
    return f"{samples} {share:.0%} of the residual's square sum: outliers? `modelgen diagnose` marks them"


def _beside_outliers(whites: Sequence[Array]) -> float:
    """rms of residuals (channels, n) without samples that may be outliers."""
    kept = [w[:, ~g] for w, g in zip(whites, _gross(whites), strict=True)]
    return float(np.sqrt(np.mean(np.concatenate([w.ravel() for w in kept]) ** 2)))


def _gross(whites: Sequence[Array]) -> list[Array]:
    """(n,) bool of each recording: samples that stand far out of its residuals (channels, n)."""
    power = [np.sum(white**2, axis=0) for white in whites]
    level = float(np.median(np.concatenate(power)))
    return [p > GROSS**2 * level / CHI2_MEDIAN for p in power]


CHI2_MEDIAN = 0.455
"""Median of χ² with one degree of freedom; with more it is larger, and fewer samples are outliers."""


def likeness(whites: Sequence[Array]) -> float:
    """Correlation of neighbouring residuals (channels, n) of all recordings; 0 where it is an accident or
    makes no difference."""
    r, pairs = _neighbours(whites)
    return r if pairs and r > max(ALIKE, CHANCE / np.sqrt(pairs)) else 0.0


def _neighbours(whites: Sequence[Array]) -> tuple[float, int]:
    """Correlation of neighbouring residuals (channels, n) of all recordings, and of how many pairs."""
    pairs = sum(w.shape[0] * (w.shape[1] - 1) for w in whites)
    power = sum(float(np.sum(w**2)) for w in whites)
    if not (pairs > 0 and power > 0):
        return 0.0, 0
    return sum(float(np.sum(w[:, 1:] * w[:, :-1])) for w in whites) / power, pairs


def other_unit(parts: Sequence[Part]) -> list[str]:
    """Recordings that would agree with the others if they were a power of ten larger or smaller: the header
    of one names another unit than its numbers have."""
    gains = np.array([_gain(s.data, s.data + raw) for s, raw, _ in parts])
    if len(parts) < 2 or not np.all(gains > 0):
        return []
    ratios = gains[:, None] / gains
    alike = np.sum(np.abs(np.log10(ratios)) < np.log10(2), axis=0)
    best = max(range(len(parts)), key=lambda k: (alike[k], -abs(np.log10(gains[k]))))
    powers = np.round(np.log10(ratios[:, best]))
    others = ", ".join(f"'{s.name}'" for (s, _, _), p in zip(parts, powers, strict=True) if p == 0)
    if not np.all((ratios[:, best] / 10.0**powers - 1)[powers != 0] ** 2 < CLOSE**2):
        return []
    return [
        f"'{s.name}' is about {10.0**p:g} times as large beside the model as {others}: are the units in "
        "their headers right?"
        for (s, _, _), p in zip(parts, powers, strict=True)
        if abs(p) in PREFIXES
    ]


def _gain(data: Array, model: Array) -> float:
    """How many times the model the data are; 0 where they are no multiple of it."""
    square = float(np.sum(model**2))
    gain = float(np.sum(data * model)) / square if square > 0 else 0.0
    left = float(np.sum((data - gain * model) ** 2))
    return gain if left < CLOSE**2 * float(np.sum(data**2)) else 0.0
