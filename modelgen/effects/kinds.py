"""Whether any effect knows the kinds of a model's ports."""

from __future__ import annotations

from collections.abc import Sequence

from modelgen.effects.effect import Effect
from modelgen.errors import did_you_mean
from modelgen.language import Model


def unknown_kinds(model: Model, effects: Sequence[Effect] | None = None) -> tuple[str, ...]:
    """Notes on ports whose kind neither catalogue nor `effects` know. Without `effects`, on those alone that
    are near to one, rather a slip of the pen than a kind for effects of somebody's own."""
    from modelgen.effects.catalogue import CATALOGUE

    known = {k for e in (*CATALOGUE, *(effects or ())) for k in (*e.kinds, *e.also)}
    every = "" if effects is None else f"; known are {', '.join(sorted(known))}"
    hints = ((p, did_you_mean(p.kind, known) or every) for p in model.ports if p.kind not in known)
    return tuple(f"port '{p.name}': no effect knows the kind '{p.kind}'{hint}" for p, hint in hints if hint)
