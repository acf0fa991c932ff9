"""Find the physics that was left out: locate the mismatch, try hypotheses, decide, extend the model.

mg.diagnose(case, model, …) calls `diagnosis.diagnose`: help(mg.diagnose.__wrapped__) shows its arguments.
"""

from typing import Any

__all__ = ["Verdict", "diagnose"]


def __getattr__(name: str) -> Any:
    """Loads numpy, scipy and sympy only when a diagnosis is asked for."""
    from importlib import import_module

    if name not in __all__:
        raise AttributeError(f"module 'modelgen.diagnose' has no attribute '{name}'")
    return getattr(
        import_module(f"modelgen.diagnose.{'verdict' if name == 'Verdict' else 'diagnosis'}"), name
    )
