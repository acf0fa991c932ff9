"""What a planned recording would do to rival hypotheses: made as one of them says, and all the others fitted
to it and to what is there already."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import erf, hypot, log, sqrt

import numpy as np

from modelgen.codegen.lower import primary_outputs
from modelgen.diagnose.experiment.menu import Plan
from modelgen.diagnose.hypotheses.addition import Addition, ranged, widened
from modelgen.diagnose.hypotheses.bounds import free
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.hypotheses.scales import record_scales
from modelgen.diagnose.hypotheses.setting import CLOSE, Setting
from modelgen.diagnose.noise.smooth_error import quietness, with_smooth
from modelgen.errors import InputError
from modelgen.fit import GaussNewton
from modelgen.fit.experiment import Experiment, Layout
from modelgen.fit.motion import errors_in_motion
from modelgen.fit.problem import Problem
from modelgen.fit.series import Array, Series, input_noise, make_series
from modelgen.fit.whitener import Whitener
from modelgen.recordings import Case, Noise, Recording
from modelgen.recordings.noise import noise_std

SPREAD = 4
"""Further starting points for each effect of a rival that has shapes."""


@dataclass(frozen=True, eq=False)
class Rivals:
    """Hypotheses that the data do not exclude, all under one judge.

    near: others that come next, and might come back; they are not taken for the truth. scale: χ² per sample
    of the best; k: the recording that a planned one is like. together: what leaves the same of every sample
    need not be told apart.
    """

    setting: Setting
    judge: Judge
    fits: tuple[Fit, ...]
    near: tuple[Fit, ...]
    k: int
    scale: float
    together: bool = False

    @cached_property
    def _normals(self) -> dict[int, Array]:
        return {}

    def normal(self, fit: Fit) -> Array:
        """Normal matrix of the recordings that are there."""
        if id(fit) not in self._normals:
            e = fit.hypothesis.experiment
            self._normals[id(fit)] = e.normal(fit.theta, self.judge.whiteners)[2]
        return self._normals[id(fit)]

    def others(self, i: int) -> list[Fit]:
        """Those that would have to be excluded if the one at `i` is true."""
        return self._others[i]

    @cached_property
    def _others(self) -> list[list[Fit]]:
        every = (*self.fits, *self.near)
        return [
            [g for g in every if set(g.ids) != set(f.ids) and not (self.together and same(f, g))]
            for f in self.fits
        ]


SAME = 1e-3
"""Standard deviations of the noise by which laws that are one under two names differ by rounding."""


def same(a: Fit, b: Fit) -> bool:
    """Whether two hypotheses leave the same of every sample."""
    return all(np.allclose(x, y, atol=SAME) for x, y in zip(a.white, b.white, strict=True))


@dataclass(frozen=True)
class Exclusion:
    """χ² and BIC by which a rival would stay behind the truth in old and new recording, and how likely it is
    that it would be excluded."""

    behind: float
    lead: float
    chance: float


def excluded(rivals: Rivals, plan: Plan, i: int) -> Exclusion:
    """The hardest to exclude of all other rivals, if hypothesis `i` is what is there.

    Each has all its parameters fitted again, its shapes free in the ranges that the new recording opens.
    """
    truth, made = rivals.fits[i], simulated(rivals, rivals.fits[i], plan)
    worst: Exclusion | None = None
    if made is None:
        return NOT
    for rival in rivals.others(i):
        left = _left(rivals, truth, rival, made.series)
        worst = left if worst is None else min(worst, left, key=_weakness)
        if worst.chance < HOPELESS:
            break
    return worst or NOT


NOT = Exclusion(0.0, 0.0, 0.0)
HOPELESS = 0.05
"""Chance of an exclusion below which it is given up."""


def _weakness(x: Exclusion) -> tuple[float, float]:
    return x.chance, x.behind


UNSURE = 0.5
"""Relative standard deviation of a foreseen χ²: the truth is like the fitted hypothesis, not the same."""


def chance(lead: float, more: float) -> float:
    """How likely a rival ends up excluded that is expected to be behind by `lead` in BIC, `more` of it by the
    new recording: by noise the χ² by which a wrong law loses has a standard deviation of twice its root."""
    more = max(more, 1.0)
    return 0.5 * (1 + erf((lead - CLOSE) / hypot(2 * sqrt(more), UNSURE * more) / sqrt(2)))


def _left(rivals: Rivals, truth: Fit, rival: Fit, new: Series) -> Exclusion:
    """What a fit to all recordings leaves a rival, from several starts as long as it is excluded."""
    whiteners = (*rivals.judge.whiteners, new.whitener)
    scales = record_scales(rivals.setting.model, [*rivals.setting.series, new])
    added = tuple(ranged(a, scales) for a in rival.hypothesis.added)
    e, start = joined(rival, rivals.k, new)
    e = replace(e, layout=widened(e.layout, added))
    n = effective(truth.white)
    more_data = log((n + new.data.size) / n)
    worst: Exclusion | None = None
    own = [a for a, b in zip(added, rival.hypothesis.added, strict=True) if b.key not in truth.hypothesis.key]
    try:
        problem = e.problem(start, whiteners)
    except InputError:
        return NOT
    for value, theta in _ends(problem, _starts(e.layout, own, start, truth)):
        behind = (value - truth.chi2) / rivals.scale
        more = max(behind - (rival.chi2 - truth.chi2) / rivals.scale, 0.0) / rivals.judge.temper
        if rivals.judge.temper > 1.0:  # by what both are wrong already, neither is excluded
            behind = more
        count = free(e.layout, theta, rival.hypothesis.shapes, rival.hypothesis.pasts)
        price = (count - rival.parameters) * log(n) + (count - truth.parameters) * more_data
        lead = rival.bic - truth.bic + price + more
        now = Exclusion(behind, lead, chance(lead, more))
        worst = now if worst is None else min(worst, now, key=lambda x: x.lead)
        if worst.chance < HOPELESS:
            break
    return worst or NOT


BEGUN, ON, FOLLOWED = GaussNewton(max_iter=20, tol=1e-3), GaussNewton(max_iter=100, tol=1e-5), 3
"""Descents from all starts, and how those that have come farthest go on."""


def _ends(problem: Problem, starts: Sequence[Array]) -> Iterator[tuple[float, Array]]:
    """(r·r, θ) where descents have come, from the first start at first; then where the best of them end."""
    found: list[tuple[float, Array]] = []
    for some, local in ((starts[:1], BEGUN), (starts[1:], BEGUN), ([], ON)):
        begun = some or [x for _, x in sorted(found, key=lambda e: e[0])[:FOLLOWED]]
        if not begun:
            continue
        with np.errstate(all="ignore"):
            ends = local.descents(problem, np.clip(np.array(begun), problem.lower, problem.upper))
        new = [(float(v), x) for v, x in zip(ends.value, ends.theta, strict=True) if np.isfinite(v)]
        found += new
        yield from new


def _starts(layout: Layout, added: Sequence[Addition], theta: Array, truth: Fit) -> list[Array]:
    """θ, and with the shapes of the rival's own effects (`added`) elsewhere: a new record may ask for quite
    others. At θ and at the ends, where laws become simpler ones, also with what the truth has of the same
    parameters: under another load, sharp resonances leave valleys on the way there."""
    starts, ends = [theta], [theta]
    for a in added:
        grid = a.grid if a.effect.shapes else []
        for point in grid[:: max(1, len(grid) // SPREAD)]:
            starts.append(_with(layout, theta, point))
        ends += [_with(layout, theta, point) for point in (grid[0], grid[-1])] if grid else []
    there = dict(zip(truth.hypothesis.names, truth.theta.tolist(), strict=True))
    return starts + [_with(layout, x, there) for x in ends]


def _with(layout: Layout, theta: Array, values: Mapping[str, float]) -> Array:
    """θ with these values of the parameters that it has."""
    own = zip(layout.names, theta.tolist(), strict=True)
    return np.array([values.get(n, x) for n, x in own])


# -- the planned recording -----------------------------------------------------------------------------------


def planned(rivals: Rivals, plan: Plan) -> Series:
    """The plan's recording before anything is known of its outputs."""
    values = np.ones((len(rivals.setting.series[rivals.k].rows), len(plan.inputs[rivals.setting.model.axis])))
    return make_series(rivals.setting.model, *_case(rivals, plan, plan.inputs, values))


def _case(rivals: Rivals, plan: Plan, inputs: Mapping[str, Array], out: Array) -> tuple[Case, Recording]:
    """The plan's recording with these outputs, and a case of its noise."""
    setting, k = rivals.setting, rivals.k
    old, record = setting.series[k], setting.case.fit[k]
    names = [o for o in primary_outputs(setting.model) if o in record.outputs]
    values = [out[0] + 1j * out[1]] if old.measure == "complex" else list(out)
    kinds, outputs = {o: record.kinds[o] for o in names}, dict(zip(names, values, strict=False))
    case = replace(setting.case, noise=_noise(setting, rivals.judge, k, plan.quiet, names))
    constants = {**old.constants, **plan.constants}
    return case, Recording("planned", None, "fit", inputs, outputs, kinds, constants)


INEXACT = 0.01
"""What a law leaves of its effect's part of a recording, since it is never quite the right one: less than
that tells nothing, however often a recording is averaged."""


@dataclass(frozen=True, eq=False)
class Made:
    """A planned recording as a hypothesis gives it: `plain` with the noise only in its weights; inexact: (n,)
    what its laws may leave."""

    plain: Series
    inexact: Array

    def whitener(self, times: int = 1) -> Whitener:
        """Of the mean of so many recordings; the error of laws stays what it is."""
        w = self.plain.whitener
        weight = w.weight * times**0.5
        less = 1 / np.hypot(1.0, np.mean(np.abs(np.atleast_2d(weight)), axis=0) * self.inexact)
        root = None if w.root is None else replace(w.root, size=w.root.size * times)
        return replace(w, weight=weight * less, root=root)

    @property
    def series(self) -> Series:
        return replace(self.plain, whitener=self.whitener())


def simulated(rivals: Rivals, truth: Fit, plan: Plan, empty: Series | None = None) -> Made | None:
    """The plan's recording as a hypothesis gives it; None if not finite.

    empty: as `planned`.
    """
    setting, judge, k = rivals.setting, rivals.judge, rivals.k
    model, empty = setting.model, empty or planned(rivals, plan)
    with np.errstate(all="ignore"):
        e, theta = joined(truth, k, empty)
        last = alone(e)
        out = last.raw(theta, 0) + empty.data
        if not np.all(np.isfinite(out)):
            return None
        case, made = _case(rivals, plan, empty.inputs, out)
        new = make_series(model, case, made)
        if model.is_time_model:
            noisy = replace(case, noise=case.noise.but(_motion_noise(setting, k, plan)))
            new = errors_in_motion(replace(last, series=(new,)), noisy, made, theta, 0)
    whitener = replace(new.whitener, ar=judge.whiteners[k].ar)
    if judge.smooth is not None and whitener.root is None:
        over = quietness(setting.series, judge.whiteners)[k] / plan.quiet
        (whitener,) = with_smooth((whitener,), [np.log(new.inputs[model.axis])], judge.smooth, [over])
    return Made(replace(new, whitener=whitener), _inexact(last, truth, theta, out, empty))


def _inexact(e: Experiment, truth: Fit, theta: Array, out: Array, empty: Series) -> Array:
    """(n,) share of the part of the output that a hypothesis' effects have; 0 where that is not finite."""
    nulls = {n: null for a in truth.hypothesis.added for n, null in a.nulls.items()}
    base = np.array([nulls.get(n, x) for n, x in zip(e.layout.names, theta, strict=True)])
    without = e.raw(base, 0) + empty.data
    with np.errstate(over="ignore", invalid="ignore"):
        mean = np.mean((out - without) ** 2, axis=0)
    change = np.sqrt(mean * (len(out) if empty.measure == "complex" else 1))
    return np.where(np.isfinite(change), INEXACT * change, 0.0)


def _noise(setting: Setting, judge: Judge, k: int, quiet: float, names: Sequence[str]) -> Noise:
    """The noise of recording k as it is judged, `quiet` times as large; planned inputs are known exactly."""
    s, stated = setting.series[k], setting.case.noise_of(setting.case.fit[k])
    inputs = {i.name: 0.0 for i in setting.model.inputs if i.derived is None}
    weight = np.atleast_2d(np.abs(judge.whiteners[k].weight))
    used = np.all(weight > 0, axis=0)
    sigma = quiet / weight[:, used]
    if s.measure in ("complex", "modulus"):
        level, relative = sigma[0], sigma[0] / s.size[used]
        if np.ptp(np.log(relative)) <= np.ptp(np.log(level)):
            return Noise(inputs, {names[0]: float(np.median(relative))}, stated.calibration)
        return Noise(inputs | {names[0]: float(np.median(level))}, {}, stated.calibration)
    return Noise(
        inputs | {n: float(np.median(x)) for n, x in zip(names, sigma, strict=True)}, {}, stated.calibration
    )


def _motion_noise(setting: Setting, k: int, plan: Plan) -> Noise:
    """What errors recording k has in its displacement, stated or its own, averaged as planned."""
    record, model = setting.case.fit[k], setting.model
    told = input_noise(model, setting.case, record)
    moved = {
        i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"
    } & record.inputs.keys()
    t = record.inputs[model.axis]
    found = {n: noise_std(t, record.inputs[n]) if told[n] is None else told[n] for n in moved}
    return Noise({n: x / plan.averaged**0.5 for n, x in found.items()})


def joined(fit: Fit, k: int, new: Series) -> tuple[Experiment, Array]:
    """The fit's experiment with `new` beside its recordings, and θ: the fit's, then what `new` has of its
    own.

    Constants of `new` hold parameters there that are free elsewhere; its own start at their values in
    recording k.
    """
    e = fit.hypothesis.experiment
    old = e.layout
    place, held = old.place[k].copy(), old.held[k].copy()
    names, parameters, theta = list(old.names), list(old.parameters), list(fit.theta)
    for i, n in enumerate(old.wrt):
        if n in new.constants:
            place[i], held[i] = -1, new.constants[n]
        elif n in old.own and place[i] >= 0:
            parameters.append(old.parameters[place[i]])
            theta.append(fit.theta[place[i]])
            place[i] = len(names)
            names.append(f"{n}[{new.name}]")
    rows = np.vstack([old.place, place]), np.vstack([old.held, held])
    layout = Layout(old.wrt, tuple(names), tuple(parameters), *rows, old.own)
    return replace(e, layout=layout, series=(*e.series, new)), np.array(theta)


def alone(e: Experiment) -> Experiment:
    """The last recording of an experiment alone."""
    layout = replace(e.layout, place=e.layout.place[-1:], held=e.layout.held[-1:])
    return replace(e, layout=layout, series=e.series[-1:])
