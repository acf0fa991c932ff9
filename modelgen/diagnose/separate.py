"""Which recording would tell rival hypotheses apart.

Each of a menu is simulated by the best one, and the rivals are fitted to it and to what is there already.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modelgen.codegen.lower import primary_outputs
from modelgen.diagnose.evidence import effective
from modelgen.diagnose.menu import Plan, plans
from modelgen.diagnose.refit import Fit, Judge
from modelgen.diagnose.setting import Outcome, Setting
from modelgen.errors import InputError
from modelgen.fit import GaussNewton
from modelgen.fit.experiment import Experiment, Layout
from modelgen.fit.problem import Problem
from modelgen.fit.series import Array, Series, make_series
from modelgen.recordings import Noise, Recording

RIVALS = 3
"""Rivals that a recording has to tell from the best hypothesis."""
CLEAR = 6.0
"""χ² below which a recording would tell nothing."""
ROUGH = 4.0
"""χ² per sample from which errors of the best hypothesis hide more than noise does: averaging is no help."""
SPREAD = 4
"""Further starting points for each effect of a rival that has shapes."""
EXACT = 4000
"""Data up to which what is there already is simulated; of more, the tangent at the rival's fit is taken."""

Linear = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class Proposal:
    """A recording, and the smallest χ² by which it would then exclude a rival (0 where it tells nothing)."""

    plan: Plan
    separation: float


def separate(
    setting: Setting, outcome: Outcome, best: Fit, rivals: Sequence[Fit], seconds: float = 1.0
) -> str | None:
    """One sentence: which recording would separate `best` from its `rivals` best, and by how much χ².

    None without rivals. The figure is the smallest misfit that a rival would be left with, all its parameters
    fitted again to old and new recording, both without noise, over the noise as it is now.
    """
    rivals = list(rivals)[:RIVALS]
    if not rivals:
        return None
    found = propose(setting, outcome.judge, best, rivals, time.perf_counter() + seconds)
    ours, theirs = _names(best, rivals)
    if found is None or found.separation < CLEAR:
        kinds = "rate, amplitude, mean, averaging" if setting.model.is_time_model else "band, load, averaging"
        return f"no recording of this menu would tell them apart: {ours} and {theirs}, by another {kinds}"
    figure = f"{float(f'{found.separation:.2g}'):g} (chi-square)"
    least = "at least " if len(rivals) > 1 else ""
    return f"{found.plan.says} would separate {ours} from {theirs} by {least}{figure}"


def _names(best: Fit, rivals: Sequence[Fit]) -> tuple[str, str]:
    """What differs, by name."""
    others = {i for r in rivals for i in r.ids}
    ours = [i for i in best.ids if not all(i in r.ids for r in rivals)] or list(best.ids)
    theirs = [i for i in dict.fromkeys(i for r in rivals for i in r.ids) if i not in best.ids] or sorted(
        others
    )
    listed = " and ".join([", ".join(theirs[:-1]), theirs[-1]] if len(theirs) > 1 else theirs)
    return " + ".join(ours) or "the model as it is", listed or "the model as it is"


def propose(
    setting: Setting, judge: Judge, best: Fit, rivals: Sequence[Fit], until: float
) -> Proposal | None:
    """The plan with the largest smallest separation among those that were tried `until` that time."""
    k = int(np.argmax([s.n for s in setting.series]))
    scale = max(1.0, best.chi2 / effective(best.white))
    e = best.hypothesis.experiment
    fitted = dict(zip(e.layout.wrt, e.local(best.theta, k).tolist(), strict=True))
    known = {p.name: p.default for p in setting.model.scalar_parameters if p.default is not None}
    known |= {**setting.case.constants, **setting.series[k].constants, **fitted}
    held = {n: v for n, v in known.items() if n not in fitted or n in setting.series[k].constants}
    reference = replace(setting.series[k], constants=held)
    series = [reference if i == k else s for i, s in enumerate(setting.series)]
    olds = [_old(judge, best, r) for r in rivals]
    top: Proposal | None = None
    for plan in plans(setting.model, series, k, known):
        if top is not None and time.perf_counter() > until:
            break
        if plan.averaged and scale > ROUGH:
            continue
        new = simulated(setting, judge, best, k, plan)
        if new is None:
            continue
        least = np.inf
        for r, old in zip(rivals, olds, strict=True):
            least = min(least, _misfit(r, old, k, new) / scale)
            if top is not None and least <= top.separation:
                break
        if np.isfinite(least) and (top is None or least > top.separation):
            top = Proposal(plan, float(least))
    return top


def simulated(setting: Setting, judge: Judge, best: Fit, k: int, plan: Plan) -> Series | None:
    """The plan's recording as the best hypothesis gives it, noise only in its weights; None if not finite."""
    model, old, record = setting.model, setting.series[k], setting.case.fit[k]
    names = [o for o in primary_outputs(model) if o in record.outputs]
    n = len(plan.inputs[model.axis])
    case = replace(setting.case, noise=_noise(setting, judge, k, plan.quiet, names))

    def recorded(inputs: Mapping[str, Array], out: Array) -> Series:
        values = [out[0] + 1j * out[1]] if old.measure == "complex" else list(out)
        kinds = {o: record.kinds[o] for o in names}
        constants = {**old.constants, **plan.constants}
        return make_series(
            model,
            case,
            Recording(
                "planned", None, "fit", inputs, dict(zip(names, values, strict=False)), kinds, constants
            ),
        )

    with np.errstate(all="ignore"):
        empty = recorded(plan.inputs, np.ones((len(old.rows), n)))
        e, theta = joined(best, k, empty)
        out = e.raw(theta, 0) + empty.data
        if not np.all(np.isfinite(out)):
            return None
        new = recorded(empty.inputs, out)
    return replace(new, whitener=replace(new.whitener, ar=judge.whiteners[k].ar))


def _noise(setting: Setting, judge: Judge, k: int, quiet: float, names: Sequence[str]) -> Noise:
    """The noise of recording k as it is judged, `quiet` times as large; planned inputs are known exactly."""
    s, stated = setting.series[k], setting.case.noise
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


def joined(fit: Fit, k: int, new: Series) -> tuple[Experiment, Array]:
    """`new` alone as an experiment of the fit's hypothesis, and θ: the fit's, then what `new` has of its own.

    Its constants hold parameters there that are free elsewhere; its own start at their values in recording k.
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
    layout = Layout(old.wrt, tuple(names), tuple(parameters), place[None], held[None], old.own)
    return replace(e, layout=layout, series=(new,)), np.array(theta)


def _old(judge: Judge, best: Fit, rival: Fit) -> Linear:
    """Residual and Jacobian of the rival against what the best hypothesis says of the present recordings."""
    b, r = best.hypothesis.experiment, rival.hypothesis.experiment
    said = tuple(replace(s, data=s.data + b.raw(best.theta, k)) for k, s in enumerate(b.series))
    e = replace(r, series=said)
    if sum(s.data.size for s in said) <= EXACT:
        return lambda theta: e.linearised(theta, judge.whiteners)
    residual, J = e.linearised(rival.theta, judge.whiteners)
    R = np.asarray(np.linalg.qr(np.column_stack([J, residual]), mode="r"))
    return lambda theta: (R[:, -1] + R[:, :-1] @ (theta - rival.theta), R[:, :-1])


def _misfit(rival: Fit, old: Linear, k: int, new: Series) -> float:
    """χ² of the rival after a fit to old and new recording."""
    e, start = joined(rival, k, new)
    size = len(rival.theta)

    def linearise(theta: Array) -> tuple[Array, Array]:
        r0, J0 = old(theta[:size])
        r1, J1 = e.linearised(theta)
        wide = np.hstack([J0, np.zeros((len(r0), len(theta) - size))])
        return np.concatenate([r0, r1]), np.vstack([wide, J1])

    p = e.layout.parameters
    low, high = np.array([q.bounds[0] for q in p]), np.array([q.bounds[1] for q in p])
    problem = Problem(
        e.layout.names, tuple(q.unit for q in p), low, high, np.clip(start, low, high),
        residual=lambda theta: linearise(theta)[0], linearise=linearise, n_data=len(linearise(start)[0]),
    )  # fmt: skip
    least = np.inf
    for other in _starts(rival, start):
        with np.errstate(all="ignore"):
            try:
                found = GaussNewton(max_iter=20, tol=1e-3).run(
                    replace(problem, start=np.clip(other, low, high))
                )
            except (InputError, np.linalg.LinAlgError):
                continue
        least = min(least, float(found.value))
    return least


def _starts(rival: Fit, theta: Array) -> list[Array]:
    """θ, and with the shapes of the rival's effects elsewhere: a new record may ask for quite others."""
    starts = [theta]
    for a in rival.hypothesis.added:
        grid = a.grid()
        for point in grid[:: max(1, len(grid) // SPREAD)] if a.effect.shapes else []:
            other = theta.copy()
            for n, v in point.items():
                other[rival.hypothesis.names.index(n)] = v
            starts.append(other)
    return starts
