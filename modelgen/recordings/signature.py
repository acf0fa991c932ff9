"""What a reader must know of a model: the names and units of what goes in, comes out and can be fitted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Channel:
    """One input or output. `measured_as`: further names of columns that hold it (F is recorded as F_m)."""

    name: str
    unit: str
    complex: bool = False
    measured_as: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All names by which a column or a noise entry may call this channel."""
        return (self.name, *self.measured_as)


@dataclass(frozen=True)
class Signature:
    """A model as its recordings see it. `axis` is the input that must be ordered ("f", "t"), "" if none.

    drops: what a case may state though the model has no such parameter, with the value that it must have.
    """

    model: str
    inputs: tuple[Channel, ...]
    outputs: tuple[Channel, ...]
    parameters: Mapping[str, str]  # name -> unit
    axis: str = ""
    drops: Mapping[str, float | None] = field(default_factory=dict)
