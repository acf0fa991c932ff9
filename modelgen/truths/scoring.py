"""Judge a verdict (contract: `modelgen.verdict/1`) by the secret that it was made without."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .secret import PORTS, Secret, family, ports

# Laws that stand between the catalogue's effects: any of these names is right.
ALSO: dict[str, tuple[str, ...]] = {
    "relaxing_friction": ("stribeck_friction", "power_law_viscoelasticity", "second_dahl_element"),
    "log_creep": ("structural_damping",),
    "bilinear": ("end_stop", "cubic_stiffness"),
    "lossy_rod": (),
    "solid_core": ("coil_ac_resistance",),
}
PORT_WORDS: dict[str, tuple[str, ...]] = {
    "electrical": ("electr", "induct", "coil", "terminal", "winding", "permeab", "magnet"),
    "channel": ("channel", "measur", "sensor", "lag", "delay", "terminal"),
    "mechanical": ("mech", "force", "stiff", "displac", "friction", "mass", "damp", "rod", "elast", "offset"),
}


def accepted(secret: Secret) -> dict[str, set[str]]:
    """For each concealed effect, the ids that name it rightly."""
    return {e: {e, *ALSO.get(secret.variant, ())} for e in secret.effects if not e.startswith("novel:")}


def score(secret: Secret, verdict: Mapping[str, Any]) -> dict[str, Any]:
    """What is right in a verdict. Marks that don't apply to the case are None.

    adequate       "adequate" is what it should be         named     the first id is one that is concealed
    family         the first id's family is right          in_set    ids and equivalents hold the right one
    port           the first effect's port is right        both      both families of a pair are named
    alarm          an effect is claimed where none is      unknown   novel physics is called unknown
    misnamed       novel physics bears a catalogued name   extra     effects claimed beyond those concealed
    set_size       ids and equivalents of the first claim  claimed   the first claim's stated probability
    holdout_chi2   (rms/noise)² of the held-out recordings after
    covered        share of the identifiable base parameters within 1.96 std of their true values; one that
                   the verdict does not give is not
    """
    effects: Sequence[Mapping[str, Any]] = verdict.get("effects") or []
    first = effects[0] if effects else {}
    name = str(first.get("id", ""))
    named = [str(e.get("id", "")) for e in effects]
    marks: dict[str, Any] = {
        "adequate": bool(verdict.get("adequate")) == (not secret.effects),
        "extra": max(0, len(named) - len(secret.effects)),
        "holdout_chi2": _holdout(verdict),
        "covered": coverage(secret, verdict),
        "first": name,
        "claimed": first.get("probability"),
        "seconds": verdict.get("seconds"),
    }
    right = accepted(secret)
    marks |= dict.fromkeys(
        ("alarm", "named", "family", "in_set", "port", "both", "unknown", "misnamed", "set_size")
    )
    if not secret.effects:
        marks["alarm"] = bool(named)
    elif not right:
        marks["unknown"] = name.startswith("unknown")
        marks["misnamed"] = bool(name) and not marks["unknown"]
    else:
        marks |= _of_first(first, right, secret.domain)
        if len(right) > 1:
            marks |= _of_pair(effects, right)
    return marks


def _stated(effect: Mapping[str, Any]) -> set[str]:
    """A claim's id and its equivalents."""
    return {str(effect.get("id", "")), *map(str, effect.get("equivalents") or [])} - {""}


def _of_first(first: Mapping[str, Any], right: Mapping[str, set[str]], domain: str) -> dict[str, Any]:
    """How the first claim does where listed effects are concealed."""
    name, stated, ids = str(first.get("id", "")), _stated(first), set().union(*right.values())
    return {
        "named": name in ids,
        "family": family(name) in {family(i) for i in ids},
        "in_set": bool(stated & ids),
        "port": _port_right(first, right, domain),
        "set_size": len(stated),
    }


def _of_pair(effects: Sequence[Mapping[str, Any]], right: Mapping[str, set[str]]) -> dict[str, bool]:
    """Whether each concealed effect's family is named, and is in what some claim states."""
    wanted = [{family(i) for i in good} for good in right.values()]
    named = {family(str(e.get("id", ""))) for e in effects}
    claims = [{family(n) for n in _stated(e)} for e in effects]
    return {
        "both": all(families & named for families in wanted),
        "both_in_sets": all(any(families & c for c in claims) for families in wanted),
    }


def _port_right(first: Mapping[str, Any], right: Mapping[str, set[str]], domain: str) -> bool:
    """Whether the port's name speaks of the right kind of place; where it says nothing, the id decides, as it
    does for what a sensor does: a channel is often called by what it measures. No claim is of no place."""
    if not first:
        return False
    said, name = str(first.get("port", "")).lower(), str(first.get("id", ""))
    kinds = set().union(*(ports(e, domain) for e in right))
    hits = {k for k, words in PORT_WORDS.items() if any(w in said for w in words)}
    at = ports(name, domain) if name in PORTS["channel"] or not hits else hits
    return bool(at & kinds)


def _holdout(verdict: Mapping[str, Any]) -> float | None:
    ratio = ((verdict.get("fit") or {}).get("after") or {}).get("holdout_rms_over_noise")
    return float(ratio) ** 2 if isinstance(ratio, int | float) else None


def coverage(secret: Secret, verdict: Mapping[str, Any]) -> float | None:
    """Share of the identifiable base parameters whose value ± 1.96 std holds the true one."""
    told = verdict.get("parameters") or {}
    hits = []
    for name in secret.identifiable:
        value, std = (told.get(name) or {}).get("value"), (told.get(name) or {}).get("std")
        if isinstance(value, int | float) and isinstance(std, int | float):
            hits.append(abs(value - secret.base[name]) <= 1.96 * std)
        else:
            hits.append(False)
    return float(np.mean(hits)) if hits else None
