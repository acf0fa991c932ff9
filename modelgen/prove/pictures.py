"""The figures of the page: scores over depth, what is confused with what, reliability, concealment,
rivals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from modelgen.prove import scores, studies
from modelgen.prove.scores import Row, Share
from modelgen.report import svg
from modelgen.report.axes import log_ticks
from modelgen.report.words import name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DEPTH_ORDER = [scores.FAINT, *(name for *_, name in scores.RATIOS)]
METHODS = {"modelgen": "modelgen", "chi2": "χ² alone", "sindy": "PySINDy", "gp": "Gaussian process"}


def _interval(axes: Axes, x: float, s: Share, color: str, size: float = 5.0) -> None:
    """A dot with its 95 % interval."""
    axes.plot([x, x], [100 * s.low, 100 * s.high], color=color, linewidth=1.2, alpha=0.6)
    axes.plot([x], [100 * s.value], "o", color=color, markersize=size)


def over_depth(rows: Sequence[Row]) -> str:
    """Found, family and first name, by how far the best base's residual stands above the noise."""
    from matplotlib.figure import Figure

    marks = {
        "something missing: found": (scores.detected, svg.DATA),
        "family right": (lambda r: r.get("family"), svg.AFTER),
        "first name right": (lambda r: r.get("named"), svg.BEFORE),
        "not in the catalogue: called unknown": (lambda r: r.get("unknown"), svg.MARK),
    }
    groups = scores.grouped([r for r in rows if r["effects"]], scores.by_depth, DEPTH_ORDER)
    with svg.style():
        figure = Figure(figsize=(8.6, 3.1), layout="constrained")
        axes = figure.subplots()
        for k, (name, (mark, color)) in enumerate(marks.items()):
            places = np.arange(len(groups)) + 0.09 * (k - 1.5)
            shares = [scores.share(map(mark, g)) for g in groups.values()]
            points = [(float(x), s) for x, s in zip(places, shares, strict=True) if s.n]
            axes.plot([x for x, _ in points], [100 * s.value for _, s in points], color=color, label=name)
            for x, s in points:
                _interval(axes, x, s, color)
        axes.set_xticks(range(len(groups)), [f"{n}\n{len(g)} trials" for n, g in groups.items()])
        axes.set_xlabel("rms of the best base model's residual over the noise")
        axes.set_ylim(0, 104)
        axes.set_ylabel("% of trials")
        axes.legend(frameon=False, labelcolor=svg.MUTED, loc="lower center", ncols=4,
                    bbox_to_anchor=(0.5, 1.06), fontsize=8)  # fmt: skip
        return svg.inline(figure, "shares of right verdicts over the depth of concealment", "depth")


def power_curve(rows: Sequence[Row]) -> str:
    """Who notices that something is missing, by how much of it the best base can't hide."""
    from matplotlib.figure import Figure

    colors = (svg.AFTER, svg.BEFORE, svg.MARK, svg.DATA)
    curves = studies.power(rows)
    with svg.style():
        figure = Figure(figsize=(8.6, 3.0), layout="constrained")
        axes = figure.subplots()
        for k, (name, color) in enumerate(zip([m for m in METHODS if m in curves], colors, strict=False)):
            points = [(p["d2"] * 1.05 ** (k - 1.5), p["found"]) for p in curves[name] if p["found"].n]
            axes.plot(
                [x for x, _ in points], [100 * s.value for _, s in points], color=color, label=METHODS[name]
            )
            for x, s in points:
                _interval(axes, x, s, color, 5.5 if k == 0 else 4.0)
        axes.axvline(scores.POWER_FROM, color=svg.INK, linewidth=0.8, dashes=(4, 3))
        axes.set_xscale("log")
        log_ticks(axes.xaxis, np.array([p["d2"] for curve in curves.values() for p in curve]))
        axes.set_ylim(0, 104)
        axes.set_xlabel("d²: squared misfit over the noise that the best base model leaves")
        axes.set_ylabel("% noticed")
        axes.legend(frameon=False, labelcolor=svg.MUTED, loc="lower center", ncols=4,
                    bbox_to_anchor=(0.5, 1.0), fontsize=8)  # fmt: skip
        return svg.inline(figure, "share of concealed effects that are noticed, over d²", "power")


def gallery(row: Row) -> str:
    """The residual of one trial's first recording, before and after, over the noise."""
    from matplotlib.figure import Figure

    from modelgen.report.axes import fold, folded_ticks, label

    told = row["glance"]
    x, before, after = (np.array(told[k]) for k in ("x", "before", "after"))
    with svg.style():
        figure = Figure(figsize=(4.6, 1.9), layout="constrained")
        axes = figure.subplots()
        axes.axhspan(-1, 1, color=svg.BAND, linewidth=0)
        axes.plot(x, fold(before), ".", color=svg.BEFORE, markersize=2.6)
        axes.plot(x, fold(after), ".", color=svg.AFTER, markersize=2.6)
        folded_ticks(axes, float(np.max(np.abs([before, after]), initial=3.0)))
        axes.set_xlabel(label(told["axis"], {"f": "Hz", "t": "s"}.get(told["axis"], "")))
        if told["axis"] == "f" and x.min() > 0 and x.max() > 20 * x.min():
            axes.set_xscale("log")
            log_ticks(axes.xaxis, x)
        axes.set_title("residual over the noise")
        return svg.inline(figure, "residuals before and after", f"case{row['index']}")


def concealment(rows: Sequence[Row]) -> str:
    """Each trial: what the concealing fit leaves unexplained, and how far its parameters were bent."""
    from matplotlib.figure import Figure

    from modelgen.prove.run import missed

    shown = [r for r in rows if r["effects"]]
    with svg.style():
        figure = Figure(figsize=(8.6, 3.3), layout="constrained")
        left, right = figure.subplots(1, 2)
        for ok, color, name in ((True, svg.AFTER, "right"), (False, svg.BEFORE, "wrong")):
            part = [r for r in shown if missed(r) != ok]
            x = [r["ratio"] for r in part]
            left.plot(
                x,
                [100 * max(r["unexplained"], 1e-8) for r in part],
                "o",
                color=color,
                markersize=3.2,
                alpha=0.75,
            )
            bent = [max(100 * np.expm1(min(r["bent"], 5)), 1e-3) for r in part]
            right.plot(x, bent, "o", color=color, markersize=3.2, alpha=0.75, label=name)
        left.axhline(0.1, color=svg.INK, linewidth=0.8, dashes=(4, 3))
        left.set_title("variance that the concealing fit leaves, %")
        right.set_title("how far its most bent parameter is off, %")
        for axes in (left, right):
            axes.set_xscale("log")
            axes.set_yscale("log")
            log_ticks(
                axes.yaxis, np.concatenate([line.get_ydata() for line in axes.get_lines()]).astype(float)
            )
            axes.set_xticks([1, 1.5, 3, 6, 20], ["1", "1.5", "3", "6", "20"])
            axes.set_xticks([], minor=True)
            axes.set_xlabel("rms of its residual over the noise")
        right.legend(frameon=False, labelcolor=svg.MUTED, loc="lower right")
        return svg.inline(figure, "depth of concealment of each trial", "hidden")


def confusions(rows: Sequence[Row]) -> str:
    """The confusion matrix: what was concealed against what was named first, shares of each row."""
    from matplotlib.figure import Figure

    counts = studies.confusion(rows)
    truths = sorted({t for t, _ in counts}, key=_place)
    named = sorted({n for _, n in counts} | {t for t in truths if not t.startswith("novel:")}, key=_place)
    matrix = np.array([[counts[t, n] for n in named] for t in truths], dtype=float)
    total = matrix.sum(axis=1, keepdims=True)
    with svg.style():
        side = 0.205
        figure = Figure(figsize=(2.6 + side * len(named), 1.9 + side * len(truths)), layout="constrained")
        axes = figure.subplots()
        axes.grid(False)
        for i, j in zip(*np.nonzero(matrix), strict=True):
            part = float(matrix[i, j] / total[i, 0])
            _cell(axes, i, j, matrix[i, j], part, _right(truths[i], named[j]))
        axes.set_xlim(-0.5, len(named) - 0.5)
        axes.set_ylim(len(truths) - 0.5, -0.5)
        axes.set_xticks(range(len(named)), [_words(n) for n in named], rotation=90, fontsize=7.5)
        labels = [f"{_words(t)}  {int(n)}" for t, n in zip(truths, total[:, 0], strict=True)]
        axes.set_yticks(range(len(truths)), labels, fontsize=7.5)
        axes.tick_params(length=0)
        axes.xaxis.tick_top()
        axes.set_title("named first →", fontsize=8.5, color=svg.MUTED)
        return svg.inline(
            figure, "confusion matrix: concealed effect against the effect named first", "confused"
        )


def matrix_width(rows: Sequence[Row]) -> int:
    """Width in rem at which the matrix' words are as large as the page's."""
    names = {x for pair in studies.confusion(rows) for x in pair}
    return min(58, 16 + round(1.3 * len(names)))


def _right(truth: str, named: str) -> bool:
    return truth == named or (truth.startswith("novel:") and named == "unknown")


def _cell(axes: Axes, i: int, j: int, count: float, part: float, right: bool) -> None:
    from matplotlib.patches import Rectangle

    color = svg.AFTER if right else svg.BEFORE
    box = Rectangle((j - 0.47, i - 0.47), 0.94, 0.94, facecolor=color, alpha=0.15 + 0.75 * part, linewidth=0)
    axes.add_patch(box)
    axes.text(j, i, f"{count:.0f}", ha="center", va="center", fontsize=6.5, color=svg.INK)


def _words(effect: str) -> str:
    return name_of(effect.removeprefix("novel:")) + (" *" if effect.startswith("novel:") else "")


def _place(effect: str) -> tuple[int, str, str]:
    """Nothing first, then listed effects by family, then what no catalogue holds."""
    from modelgen.truths.secret import family

    rank = 0 if effect == "nothing" else 2 if effect.startswith("novel:") or effect == "unknown" else 1
    return rank, family(effect), effect


def reliability(rows: Sequence[Row]) -> str:
    """Stated probability against how often the name was right."""
    from matplotlib.figure import Figure

    with svg.style():
        figure = Figure(figsize=(3.9, 3.5), layout="constrained")
        axes = figure.subplots()
        axes.plot([0, 100], [0, 100], color=svg.INK, linewidth=0.8, dashes=(4, 3))
        for b in studies.calibration(rows):
            x, s = 100 * b["stated"], b["right"]
            _interval(axes, x, s, svg.AFTER, 3 + 1.1 * np.log2(1 + s.n))
            axes.annotate(str(s.n), (x, 100 * s.value), (-7, 5), textcoords="offset points",
                          fontsize=7.5, color=svg.MUTED, ha="right")  # fmt: skip
        axes.set_xlim(0, 104)
        axes.set_ylim(0, 104)
        axes.set_xlabel("stated probability, %")
        axes.set_title("first name right, % (and of how many)")
        return svg.inline(
            figure, "reliability diagram: stated probabilities against shares right", "reliable"
        )


def rivals(methods: Mapping[str, Mapping[str, Share]]) -> str:
    """The diagnosis beside simpler methods."""
    from matplotlib.figure import Figure

    marks = list(next(iter(methods.values())))
    colors = (svg.AFTER, svg.BEFORE, svg.MARK, svg.DATA)
    with svg.style():
        figure = Figure(figsize=(8.6, 3.0), layout="constrained")
        axes = figure.subplots()
        for k, (name, color) in enumerate(zip([m for m in METHODS if m in methods], colors, strict=False)):
            for i, mark in enumerate(marks):
                if methods[name][mark].n:
                    _interval(axes, i + 0.13 * (k - 1.5), methods[name][mark], color, 5.5)
            axes.plot([], [], "o", color=color, label=METHODS[name])
        axes.set_xticks(range(len(marks)), [LABELS[m] for m in marks])
        axes.set_ylim(0, 104)
        axes.set_ylabel("% of trials")
        axes.legend(
            frameon=False, labelcolor=svg.MUTED, loc="lower center", ncols=4, bbox_to_anchor=(0.5, 1.0)
        )
        axes.grid(axis="x", visible=False)
        return svg.inline(
            figure, "shares of right answers of modelgen and of three simpler methods", "rivals"
        )


LABELS: dict[str, Any] = {
    "false alarm": "false alarms\n(fewer is better)",
    "found": "found that\nsomething is missing",
    "first name": "first name\nright",
    "family": "family\nright",
    "hold-out": "hold-out as good\nas the true law's",
}


def left_out(tables: Sequence[Mapping[str, Any]]) -> str:
    """Tab. 3: error of the frequency left out, before and after."""
    from matplotlib.figure import Figure

    with svg.style():
        figure = Figure(figsize=(8.6, 1.9), layout="constrained")
        axes = figure.subplots()
        for i, t in enumerate(tables):
            axes.plot([100 * t["after"], 100 * t["before"]], [i, i], color=svg.GRID, linewidth=3)
            axes.plot([100 * t["before"]], [i], "o", color=svg.BEFORE, markersize=7)
            axes.plot([100 * t["after"]], [i], "o", color=svg.AFTER, markersize=7)
        axes.set_xscale("log")
        axes.set_xticks([0.1, 0.2, 0.5, 1, 2, 5, 10], ["0.1", "0.2", "0.5", "1", "2", "5", "10"])
        axes.minorticks_off()
        axes.set_yticks(range(len(tables)), [t["name"] for t in tables])
        axes.set_ylim(len(tables) - 0.5, -0.5)
        axes.set_xlabel("error of the frequency that was left out, %")
        return svg.inline(
            figure, "errors of predicted stiffness at frequencies that were left out", "leftout"
        )
