"""The catalogue: physics that models leave out. A tuple of values, a file a subject."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from modelgen.effects.catalogue import CATALOGUE
    from modelgen.effects.effect import Effect, Shape, Strength, search_range
    from modelgen.effects.load import load_effects

FAMILIES: dict[str, tuple[str, ...]] = {
    "eddy": ("semi_inductance", "eddy_shunt", "permeability_relaxation"),
    "viscoelastic": ("power_law_viscoelasticity", "maxwell_branch", "structural_damping"),
    "lag": ("sensor_delay", "force_sensor_lag"),
    "second resonance": ("second_mode", "contact_compliance"),
    "friction shape": ("second_dahl_element", "dahl_exponent"),
}
"""Effects that one kind of recording can often not tell apart; all others stand alone."""

_WHERE = {
    "CATALOGUE": "catalogue", "Effect": "effect", "Shape": "effect", "Strength": "effect",
    "search_range": "effect", "load_effects": "load",
}  # fmt: skip

__all__ = ["CATALOGUE", "FAMILIES", "Effect", "Shape", "Strength", "family", "load_effects", "search_range"]


def family(effect: str | Effect) -> str:
    """The family of an effect or of its id; an effect that stands alone is a family of its own."""
    id = effect if isinstance(effect, str) else effect.id
    own = "" if isinstance(effect, str) else effect.family
    return own or next((name for name, members in FAMILIES.items() if id in members), id)


def __getattr__(name: str) -> Any:
    """Loads sympy only when the catalogue is asked for."""
    from importlib import import_module

    if name not in _WHERE:
        raise AttributeError(f"module 'modelgen.effects' has no attribute '{name}'")
    return getattr(import_module(f"modelgen.effects.{_WHERE[name]}"), name)
