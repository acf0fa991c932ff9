"""Whether any effect knows the kinds of a model's ports."""

from __future__ import annotations

from collections.abc import Sequence

from modelgen.effects.effect import Effect
from modelgen.errors import did_you_mean
from modelgen.language import Model


def unknown_kinds(model: Model, effects: Sequence[Effect] = ()) -> tuple[str, ...]:
    """Notes on ports whose kind neither catalogue nor `effects` know, though it is near to one: rather a slip
    of the pen than a kind for effects of somebody's own."""
    from modelgen.effects.catalogue import CATALOGUE

    known = {k for e in (*CATALOGUE, *effects) for k in e.kinds}
    near = ((p, did_you_mean(p.kind, known)) for p in model.ports if p.kind not in known)
    return tuple(f"port '{p.name}': no effect knows the kind '{p.kind}'{n}" for p, n in near if n)
