"""Characterization of giant magnetostrictive materials by three complex parameters and particle swarms."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from modelgen.papers.gmm.paper import PAPER

__all__ = ["PAPER"]


def __getattr__(name: str) -> Any:
    """Loads the tables, and the compiler with them, when the paper is asked for: its Methods need neither."""
    if name == "PAPER":
        from modelgen.papers.gmm import paper

        return paper.PAPER
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
