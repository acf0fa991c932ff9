"""What simpler methods make of the same recordings and the same fitted base: the scores to beat.

- `chi2`: χ² alone. Something is missing if the base's χ² is too large for its noise (1 %), and it is the
  effect whose refit leaves the least. The refits are the diagnosis's own, which is more than it has a right
    to.
- `sindy`: sparse regression (STLSQ of PySINDy) of the residual on a dictionary of terms; the largest term
  names the effect. Brunton, Proctor and Kutz 2016; for discrepancies Kaheman et al. 2019.
- `gp`: a Gaussian process for the discrepancy, Kennedy and O'Hagan 2001. It says that something is missing,
  and predicts; it names nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from modelgen.prove import dictionary, discrepancy
from modelgen.prove.oracle import Reference, in_units, of_truth
from modelgen.prove.records import Array, Record, records
from modelgen.prove.worker import RESIDUALS
from modelgen.truths import Secret
from modelgen.truths.scoring import accepted
from modelgen.truths.secret import family

Marks = dict[str, Any]
WORST = 1e30
"""Stands for a hold-out ratio that is infinite."""


def rivals(secret: Secret, verdict: Mapping[str, Any], folder: Path) -> dict[str, Marks]:
    """Each baseline's marks on a case: found, name, named and family (None where there is nothing to name),
    and `holdout`, its mean squared hold-out residual over that of the true law.

    The entry "diagnosis" has `before` and `holdout` of the diagnosis itself.
    """
    cases = records(folder / RESIDUALS)
    fit, held = [r for r in cases if not r.holdout], [r for r in cases if r.holdout]
    truth = of_truth(secret, fit, held)
    found = {
        "chi2": ranking(verdict, fit),
        "gp": discrepancy.explain(fit, held),
    }
    if dictionary.available():
        found["sindy"] = dictionary.explain(fit, held, verdict.get("parameters_before") or {})
    rests = {name: m["rest"] for name, m in found.items()} | {"before": [r.white for r in held]}
    over = {n: _over_truth(truth, held, rest) for n, rest in rests.items()}
    ours = {
        "before": over["before"],
        "holdout": _finite(truth.ratio([r.left for r in held])) if truth else None,
    }
    return {"diagnosis": ours} | {name: _marked(secret, m, over[name]) for name, m in found.items()}


def _over_truth(truth: Reference | None, held: Sequence[Record], rests: Sequence[Array]) -> float | None:
    """The hold-out of a method that leaves `rests` over the noise; None where it predicts nothing."""
    if truth is None or not rests:
        return None
    units = [in_units(r, x) for r, x in zip(held, rests, strict=True)]
    return _finite(truth.ratio([truth.but_for_outliers(k, x, held[k]) for k, x in enumerate(units)]))


def _finite(ratio: float | None) -> float | None:
    """A ratio as JSON can hold it, which has no infinity."""
    return ratio if ratio is None else min(ratio, WORST)


def ranking(verdict: Mapping[str, Any], fit: list[Record]) -> Marks:
    """χ² alone, among single effects."""
    white = np.concatenate([r.white[np.isfinite(r.white)] for r in fit])
    missing = bool(np.sum(white**2) > chi2.ppf(0.99, len(white)))
    single = [t for t in verdict.get("hypotheses") or [] if len(t["ids"]) == 1 and t["rms_over_noise"]]
    best = min(single, key=lambda t: t["rms_over_noise"], default=None)
    return {"found": missing, "name": best["ids"][0] if missing and best else "", "rest": []}


def _marked(secret: Secret, found: Marks, holdout: float | None) -> Marks:
    """The marks of one answer."""
    names = {n for good in accepted(secret).values() for n in good}
    marks = {"found": found["found"], "name": found["name"], "holdout": holdout}
    if not names or found["name"] is None:
        return marks | {"named": None, "family": None}
    right = {family(n) for n in names}
    return marks | {"named": found["name"] in names, "family": family(found["name"]) in right}
