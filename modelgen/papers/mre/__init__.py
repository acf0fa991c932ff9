"""Laboratory testing and modelling of magnetorheological elastomers in tension mode."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from modelgen.papers.mre.paper import PAPER

__all__ = ["PAPER"]


def __getattr__(name: str) -> Any:
    """Loads the tables, and the compiler with them, when the paper is asked for."""
    if name == "PAPER":
        from modelgen.papers.mre import paper

        return paper.PAPER
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
