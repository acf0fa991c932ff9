"""The page: what was concealed, what was found, how often it was right, as one HTML file without a script."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

from markupsafe import Markup

from modelgen.prove import gallery, pictures, scores, studies
from modelgen.prove.own import OWN
from modelgen.prove.run import missed
from modelgen.prove.scores import Row, Share

NOISE_WORDS = {
    "white": "white",
    "clean": "white, displacement exact",
    "coloured": "coloured, not stated",
    "calibration": "smooth error of the instrument, stated",
    "displacement": "large errors of the displacement",
    "outliers": "1 % outliers",
    "quantised": "quantised",
    "misstated": "stated wrong by a factor of two",
    OWN: "as in the case",
}
DOMAIN_WORDS = {
    "impedance": "moving coil, impedance",
    "gmm": "magnetostrictive transducer, impedance",
    "force": "elastomer, force over time",
    "stiffness": "elastomer, stiffness over frequency",
    OWN: "somebody's own",
}
STATED_WORDS = {
    "rightly": "stated",
    "not": "not stated",
    "wrongly": "stated wrong by a factor of two",
    "": "as in the case",
}
KIND_WORDS = {
    "none": "nothing missing",
    "single": "one effect",
    "variant": "one effect, another law",
    "pair": "two effects",
    "novel": "in no catalogue, kinds in mind, or looked at since",
    "unforeseen": "in no catalogue, kinds that nobody had in mind",
}


def page(
    rows: Sequence[Row], real: Sequence[Row], left: Sequence[Mapping[str, Any]], facts: Mapping[str, Any]
) -> str:
    """The page as text. `left`: leave-one-out errors of the paper's table; `facts`: command, seed,
    versions."""
    good = scores.usable(rows)
    return str(
        _template().render(
            facts=facts,
            n=len(good),
            made=len(rows),
            failed=[r for r in rows if r["error"]],
            hidden=[r for r in rows if "hidden" in r],
            withheld=[r for r in rows if "withheld" in r],
            foreign=sorted({p for r in rows for p in r.get("foreign", ())}),
            confused=[c for c in studies.mixed_up(good) if c["n"] > 1],
            once=sum(c["n"] == 1 for c in studies.mixed_up(good)),
            strangers=studies.strangers(good),
            proposed=studies.proposals(good),
            gallery=[_shown(r) for r in gallery.chosen(good, missed)],
            board=scores.board(good),
            cover=scores.coverage(good),
            off=studies.expected_error(studies.calibration(good)),
            seconds=scores.seconds(good),
            wall=scores.seconds(good, "wall"),
            tables=tables(good),
            columns=[title for title, _ in scores.COLUMNS],
            figures=_figures(good, left),
            matrix_width=pictures.matrix_width(good),
            effects=len({e for r in good for e in r["effects"]}),
            deep=_deep(good),
            real=real,
            left=left,
            trials=[_trial(r) for r in good],
        )
    )


def tables(good: Sequence[Row]) -> list[dict[str, Any]]:
    """Scores by noise and how it is stated, by depth where that is known, by kind and by device."""
    depths = [*pictures.DEPTH_ORDER, "nothing missing"]
    heavy, deep = scores.weighed(good), list(filter(scores.has_depth, good))
    by_depth = {
        "title": "residual of the best base over the noise",
        "rows": scores.table(deep, scores.by_depth, depths),
    }
    return [
        _by(heavy, "noise", lambda r: r["noise"], NOISE_WORDS),
        _by(heavy, "whether the case states the level of its noise", lambda r: r["stated"], STATED_WORDS),
        *([by_depth] if deep else []),
        _by(heavy, "what is concealed", _kind, KIND_WORDS),
        _by(heavy, "device", lambda r: r["domain"], DOMAIN_WORDS),
    ]


def _kind(row: Row) -> str:
    return "unforeseen" if row["kind"] == "novel" and not scores.in_mind(row) else str(row["kind"])


def _by(
    good: Sequence[Row], title: str, key: Callable[[Row], str], words: Mapping[str, str]
) -> dict[str, Any]:
    return {"title": title, "rows": scores.table(good, lambda r: words[key(r)], list(words.values()))}


def _figures(good: Sequence[Row], left: Sequence[Mapping[str, Any]]) -> dict[str, Markup]:
    if not good:
        return {}
    deep = list(filter(scores.has_depth, good))
    plots = {"depth": pictures.over_depth, "power": pictures.power_curve, "hidden": pictures.concealment}
    drawn = {name: plot(deep) if deep else "" for name, plot in plots.items()} | {
        "confused": pictures.confusions(good),
        "reliable": pictures.reliability(good),
        "rivals": pictures.rivals(studies.baselines(good)),
    }
    if left:
        drawn["left"] = pictures.left_out(left)
    return {name: Markup(text) for name, text in drawn.items()}


def _shown(row: Row) -> dict[str, Any]:
    """One case of the gallery."""
    told = _trial(row)
    return told | {
        "secret": told["secret"].replace("novel:", ""),
        "figure": Markup(pictures.gallery(row)),
        "device": DOMAIN_WORDS[row["domain"]],
        "noise": NOISE_WORDS[row["noise"]],
        "says": (row["verdict"]["effects"] or [{"says": "the model explains the recordings"}])[0]["says"],
        "bent": 100 * math.expm1(min(row["bent"], 5.0)),
        "r2": 1 - row["unexplained"],
    }


def _deep(good: Sequence[Row]) -> float:
    """Share of concealments that explain more than 99.9 % of the variance."""
    concealed = [r["unexplained"] < 1e-3 for r in good if r["effects"] and scores.has_depth(r)]
    return sum(concealed) / len(concealed) if concealed else float("nan")


def _trial(row: Row) -> dict[str, Any]:
    """One line of the list of all trials."""
    first = row["verdict"]["effects"]
    also = f" (or {', '.join(first[0]['equivalents'])})" if first and first[0]["equivalents"] else ""
    return {
        "index": row["index"],
        "sha": row["sha256"],
        "name": row.get("name", ""),
        "nonce": json.loads(row["secret"]).get("nonce", ""),
        "secret": " + ".join(row["effects"]) or "nothing",
        "law": row["variant"],
        "where": f"{row['domain']}, {row['noise']}",
        "ratio": row["ratio"],
        "named": row["error"] or (" + ".join(e["id"] for e in first) or "nothing") + also,
        "ok": not missed(row),
    }


def percent(s: Share) -> str:
    """83 %, or – where it applies to no trial."""
    return f"{100 * s.value:.0f}\u00a0%" if s.n else "–"


def _formatted(text: str, *values: Any) -> str:
    """A number as `text` has it, or – where there is none."""
    return "–" if None in values else text % values


@cache
def _template() -> Any:
    import jinja2

    from modelgen.codegen.emit import templates_folder

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(templates_folder()),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {"percent": percent, "format": _formatted}
    return environment.get_template("proof.html.j2")
