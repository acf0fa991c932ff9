"""Resonant atoms of long sweeps are made in slices: memory is bounded, and what is found the same."""

from __future__ import annotations

import tracemalloc
from functools import cache

import numpy as np
import pytest

from modelgen.diagnose.gate import in_frequency as atoms
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.search.screen import Tangent
from modelgen.diagnose.search.search import white_judge
from modelgen.fit.series import make_series
from modelgen.models import load
from modelgen.recordings import Case, Noise, Recording


@cache
def swept(n: int) -> tuple[Judge, Fit, Tangent]:
    """A moving coil with two resonances that its model lacks, at n frequencies."""
    model, f = load("electrodynamic_transducer"), np.geomspace(20.0, 20e3, n)
    s, rng = 2j * np.pi * f, np.random.default_rng(5)
    Z = 6 + 5e-4 * s + 36 / (1 + s * 0.015 + 2e3 / s)
    Z = Z + 0.05 / (1 + 9j * (f / 700 - 700 / f)) + 0.4 / (1 + 60j * (f / 4000 - 4000 / f))
    Z = Z * (1 + 1e-3 * (rng.standard_normal(n) + 1j * rng.standard_normal(n)))
    record = Recording("a", None, "fit", {"f": f}, {"Z": Z})
    case = Case(None, model.id, (record,), constants={"Bl": 6.0}, noise=Noise(relative={"Z": 1e-3}))
    series = (make_series(model, case, record),)
    judge, (h,) = white_judge(series), make_hypotheses(model, case, series, [()])
    fit = judge.fit(h, [np.array([h._defaults[k] for k in h.names])])
    return judge, fit, Tangent.of(*judge.tangent(fit))


def found(n: int) -> tuple[Leftover, int]:
    """What is left at the electrical port, and the most memory [bytes] that it took to see it."""
    judge, fit, tangent = swept(n)
    tracemalloc.start()
    try:
        (best,) = atoms.in_frequency(judge, fit, tangent, {"electrical": np.ones(n, dtype=complex)})
        return best, tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_sweep() -> None:
    best, most = found(6000)
    assert "718.8" in best.says and "3948" in best.says
    assert most < 150e6


def test_slices_find_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    whole, much = found(500)
    monkeypatch.setattr(atoms, "AT_ONCE", 50_000)
    sliced, less = found(500)
    assert (sliced.says, sliced.terms) == (whole.says, whole.terms)
    assert sliced.gain == pytest.approx(whole.gain, rel=1e-10) and less < 0.3 * much
