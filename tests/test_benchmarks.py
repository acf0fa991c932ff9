"""The benchmarks' yardstick gives the answers of generated code; their harness names what is missing."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))  # benchmarks is no part of the package

from benchmarks import dahl, fits, point, transducer
from benchmarks.timing import difference, flat, race

needs_cc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


@needs_cc
def test_hand_written_c_is_a_fair_yardstick() -> None:
    s, m = transducer.setting(101, 30), dahl.motion(3000)
    for contestants, work in (
        (transducer.BATCH, s), (point.JACOBIAN, s), (dahl.SIMULATE, m), (dahl.NORMAL, m),
    ):  # fmt: skip
        makers: Any = contestants
        ours, by_hand = flat(makers["modelgen"](work)()), flat(makers["C by hand"](work)())
        assert difference(by_hand, ours) < 1e-12


def test_models_that_no_compiler_has_seen_give_the_same_sums() -> None:
    s = transducer.setting(101, 1)
    wanted = flat(point.FUSED["modelgen"](s)())
    for who, make in point.FUSED.items():
        assert difference(flat(make(s)()), wanted) < 1e-12, who


def test_fits_that_are_raced_find_the_truth() -> None:
    problem = fits.problem()
    assert problem.compiled is not None
    best = fits.swarm_ours()()
    assert best < 2.0 * problem.n_data * 1e-4 * np.mean(np.abs(fits.recording().data) ** 2)


def test_the_textbook_form_is_the_model() -> None:
    s = transducer.setting(50, 5)
    assert flat(transducer.batch_numpy(s, True)()) == pytest.approx(
        flat(transducer.batch_ours(s)()), rel=1e-10
    )
    assert difference(flat(point.lambdified(s)()), flat(point.ours(s)())) < 1e-11
    re, im = transducer.real_form([1500.0, *s.sets[0]])
    F = transducer.function()
    assert complex(re, im) == pytest.approx(complex(F(f=1500.0, **dict(zip(F.wrt, s.sets[0], strict=True)))))


def test_a_contestant_that_is_not_installed_or_fails_is_named() -> None:
    def missing() -> Any:
        import no_such_tool  # noqa: F401

    def broken() -> Any:
        raise RuntimeError("no such thing")

    runs = {"modelgen": lambda: lambda: 1.0, "off": lambda: lambda: 1.5, "a": missing, "b": broken}
    found = {e.who: e for e in race("nothing", runs, patience=1e-3)}
    assert found["modelgen"].seconds and found["off"].difference == 0.5
    assert "no_such_tool" in found["a"].note and "no such thing" in found["b"].note
    assert np.isnan(difference(np.ones(2), np.ones(3)))
