"""Independent simulators which record devices with a concealed effect, and the scores of a diagnosis on them.

Nothing here imports the rest of the package: the truths use other numerics than the models that are fitted to
them (quadrature, Bessel functions, ladders of many cells, transfer matrices, convolutions, event-located
friction), so that a diagnosis is judged on recordings which its own code could not have made.
"""

from __future__ import annotations

from .drawing import draw
from .scoring import score
from .secret import NotDetectable, Secret, seal, unseal
from .write import write_case

__all__ = ["NotDetectable", "Secret", "draw", "score", "seal", "unseal", "write_case"]
