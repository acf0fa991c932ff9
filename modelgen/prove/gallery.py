"""What a trial looked like: the residual of the first recording, before and after, thinned for a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.prove.records import Array, Record, records
from modelgen.prove.worker import RESIDUALS

POINTS = 150


def glance(folder: Path) -> dict[str, Any]:
    """{"axis": "f" or "t", "x", "before", "after"}: residuals over the noise, of an impedance the real part.

    Of each stretch the sample farthest from zero before is kept, so that no spike is thinned away.
    """
    shown = next((r for r in records(folder / RESIDUALS) if not r.holdout), None)
    if shown is None:
        return {}
    axis = next(n for n in ("f", "t", *shown.inputs) if n in shown.inputs)
    x = shown.inputs[axis]
    before, after = _scaled(shown)
    size = np.nan_to_num(np.abs(before))
    keep = [
        int(part[np.argmax(size[part])]) for part in np.array_split(np.arange(len(x)), POINTS) if len(part)
    ]
    keep = [i for i in keep if np.isfinite(before[i]) and np.isfinite(after[i])]

    def plain(v: Any) -> list[float]:
        return [float(f"{float(v[i]):.4g}") for i in keep]

    return {"axis": axis, "x": plain(x), "before": plain(before), "after": plain(after)}


def _scaled(r: Record) -> tuple[Array, Array]:
    """Residuals before and after, of an impedance over its modulus, on a scale on which the former has the
    rms that it has in the diagnosis. NaN at outliers."""
    ruler = np.abs(r.data) if np.iscomplexobj(r.data) else np.ones(len(r.data))
    raw, rest = ((y - r.data).real / ruler for y in (r.before, r.after))
    good = np.isfinite(r.white[0])
    rms = float(np.sqrt(np.mean(np.square(raw[good])))) or 1.0
    scale = np.where(good, np.sqrt(np.mean(np.square(r.white[0][good]))) / rms, np.nan)
    return raw * scale, rest * scale


def chosen(rows: Sequence[Mapping[str, Any]], missed: Any) -> list[Mapping[str, Any]]:
    """By rule and not by looks: of each device the first case that was read right and the first that was
    not, where its residual stands at least 1.5 times above the noise."""
    found: dict[tuple[str, bool], Mapping[str, Any]] = {}
    for r in rows:
        if r["effects"] and (r["ratio"] or 0) > 1.45 and r.get("glance"):
            found.setdefault((r["domain"], missed(r)), r)
    return [found[key] for key in sorted(found, key=lambda k: (k[1], k[0]))]
