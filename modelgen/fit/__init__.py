"""The estimator harness: one problem description, several optimisers, and what the data say about the result.

mg.fit(model, case, …) calls `fitting.fit`: help(mg.fit.__wrapped__) shows its arguments.

outcome = (PSO(40) >> GaussNewton()).run(problem)
known = assess(problem, outcome.theta)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from modelgen.fit.farm import fit_cases, profiles
    from modelgen.fit.gauss_newton import GaussNewton
    from modelgen.fit.ipopt import IPOPT
    from modelgen.fit.likelihood import Profile, profile
    from modelgen.fit.method import Chain, Method, Outcome, Reason
    from modelgen.fit.multistart import MultiStart
    from modelgen.fit.problem import Inequality, Problem
    from modelgen.fit.pso import PSO
    from modelgen.fit.recipe import Recipe, Stage, run_recipe
    from modelgen.fit.result import Estimate, FitResult, OutputFit, RecordingFit, estimates
    from modelgen.fit.uncertainty import Uncertainty, assess

_HOME = {
    "GaussNewton": "gauss_newton",
    "IPOPT": "ipopt",
    "Chain": "method",
    "Method": "method",
    "Outcome": "method",
    "Reason": "method",
    "MultiStart": "multistart",
    "Inequality": "problem",
    "Problem": "problem",
    "Profile": "likelihood",
    "profile": "likelihood",
    "profiles": "farm",
    "fit_cases": "farm",
    "PSO": "pso",
    "Recipe": "recipe",
    "Stage": "recipe",
    "run_recipe": "recipe",
    "Estimate": "result",
    "FitResult": "result",
    "OutputFit": "result",
    "RecordingFit": "result",
    "estimates": "result",
    "Uncertainty": "uncertainty",
    "assess": "uncertainty",
}

__all__ = [
    "IPOPT",
    "PSO",
    "Chain",
    "Estimate",
    "FitResult",
    "GaussNewton",
    "Inequality",
    "Method",
    "MultiStart",
    "Outcome",
    "OutputFit",
    "Problem",
    "Profile",
    "Reason",
    "Recipe",
    "RecordingFit",
    "Stage",
    "Uncertainty",
    "assess",
    "estimates",
    "fit_cases",
    "profile",
    "profiles",
    "run_recipe",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
