"""Two tiers of compiled code: equal numbers, the swap from one to the other, what may go wrong meanwhile."""

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelgen import ToolError, models
from modelgen.codegen import Function, build_many, instant
from modelgen.codegen.build import default_wrt
from modelgen.codegen.roofline import example
from modelgen.codegen.tiers import Tiers
from modelgen.models import SHIPPED, kelvin_voigt

BANDS = {  # [Hz], of the papers' own measurements: below and above, derivatives are small differences
    "magnetostrictive_transducer": (500, 5000), "electrodynamic_transducer": (10, 5000),
    "complex_stiffness": (1, 10), "piezoelectric_transducer": (1e3, 1e6),
}  # fmt: skip
Build = Callable[..., Function]
AT = np.linspace(1e-3, 0.5, 50)
MOTION = {"t": AT, "z": 0.4 * np.sin(12 * AT)}


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Build:
    """`build` with nothing in the cache."""
    from modelgen.codegen.build import _build

    monkeypatch.setenv("MODELGEN_CACHE", str(tmp_path))
    return lambda model: _build.__wrapped__(model, default_wrt(model))


def answers(F: Function, tiers: Tiers, at: dict[str, Any]) -> tuple[list[Any], list[Any]]:
    """Values and Jacobian, and every equation, by one tier."""
    one = Function(F.model, F.wrt, F.free, tiers)
    both = (x if isinstance(x, tuple) else (x,) for x in (one(**at), one.jacobian(**at)))
    return [a for x in both for a in x], list(one.all(**at).values())


@pytest.mark.parametrize("name", SHIPPED)
def test_both_tiers_give_the_same_numbers(name: str, fresh: Build) -> None:
    F = fresh(getattr(models, name))
    at = example(F.model, 200) | ({"f": np.geomspace(*BANDS[name], 200)} if F.model.axis == "f" else {})
    at_once = F.tiers._at_once
    assert at_once is not None
    never = threading.Event()
    waiting = Tiers(lambda: (never.wait(60), F.code)[1], at_once)
    try:
        first = answers(F, waiting, at)
        assert not waiting._library.done()
    finally:
        never.set()
    # equations beside the outputs: modes of a springpot are small differences of large numbers
    for bound, one, other in zip((1e-12, 1e-9), first, answers(F, Tiers(lambda: F.code), at), strict=True):
        for a, b in zip(one, other, strict=True):
            assert a.shape == b.shape and np.array_equal(np.isnan(a), np.isnan(b))
            assert np.nanmax(np.abs(a - b), initial=0) <= bound * np.nanmax(np.abs(b), initial=0)


def test_library_takes_over_when_it_is_there(fresh: Build) -> None:
    F = fresh(kelvin_voigt)
    gate = threading.Event()
    tiers = Tiers(lambda: (gate.wait(60), F.code)[1], F.tiers._at_once)
    with tiers.answer("values") as code:
        assert isinstance(code.library, instant.Memory)
    gate.set()
    assert tiers.library() is F.code
    with tiers.answer("values") as code:
        assert isinstance(code.library, Path)


def test_recordings_wait_for_the_library(fresh: Build) -> None:
    assert isinstance(fresh(kelvin_voigt).prepare(**MOTION).code.library, Path)


def test_a_compiler_that_refuses_is_told_at_the_next_call(fresh: Build) -> None:
    at_once = fresh(kelvin_voigt).tiers._at_once

    def refuse() -> Any:
        raise ToolError("the C compiler refused")

    tiers = Tiers(refuse, at_once)
    with pytest.raises(ToolError, match="refused"):
        tiers.library()
    with pytest.raises(ToolError, match="refused"), tiers.answer("values"):
        pass


def test_without_the_first_tier_calls_wait(fresh: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(instant, "_tiny", lambda: None)
    F = fresh(kelvin_voigt)
    assert np.isfinite(F(**MOTION)).all()
    assert F.tiers._library.done()


def test_threads_may_call_while_the_library_is_compiled(fresh: Build) -> None:
    F = fresh(kelvin_voigt)
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: F(**MOTION), range(64)))
    assert np.ptp(found, axis=0).max() < 1e-12


SCRIPT = """
import numpy as np
from modelgen import build, models
t = np.arange(10) * 0.01
F = build(models.kelvin_voigt)
print(F(t=t, z=t)[-1])
"""


def run(script: str, cache: Path) -> subprocess.CompletedProcess[str]:
    env = {**os.environ, "MODELGEN_CACHE": str(cache)}
    return subprocess.run(
        [sys.executable, "-c", script], env=env, capture_output=True, text=True, timeout=60, check=False
    )


def test_a_process_that_ends_leaves_a_whole_library(tmp_path: Path) -> None:
    first = run(SCRIPT, tmp_path)
    assert (first.returncode, first.stderr) == (0, "")
    assert sorted(p.suffix for p in tmp_path.iterdir() if p.is_file()) == [".json", ".so"]
    assert not [p for p in tmp_path.iterdir() if p.name.startswith("build-")]
    assert float(run(SCRIPT, tmp_path).stdout) == pytest.approx(float(first.stdout), rel=1e-12)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_child_compiles_for_itself(tmp_path: Path) -> None:
    forked = (
        "import os, sys\n"
        + SCRIPT
        + "sys.stdout.flush()\n"
        + "child = os.fork()\n"
        + "os.write(1, b'%d\\n' % F.prepare(t=t, z=t).n)\n"
        + "if child: assert os.waitpid(child, 0)[1] == 0\n"
    )
    done = run(forked, tmp_path)
    assert (done.returncode, done.stderr, done.stdout.split()[1:]) == (0, "", ["10", "10"])


def test_code_in_memory_gives_way_to_a_library_of_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Models built together answer from memory, as text in the cache; what is worked in long becomes a
    library, which rounds every operation alike."""
    monkeypatch.setenv("MODELGEN_CACHE", str(tmp_path))
    pairs = [(m, default_wrt(m)) for m in (models.complex_stiffness, models.modified_dahl, kelvin_voigt)]
    for again in (False, True):  # kept as text, then as a library
        for F, (model, _) in zip(build_many(pairs), pairs, strict=True):
            at = example(model, 200)
            ready, measure = F.prepare(**at), F.code.source.measures[0]
            theta = ready.p[F.free]
            slow, code = ready.jacobian(theta, measure), F.code
            kept = again and code.source.tapes != "all"  # tapes are as fast
            assert isinstance(code.library, Path if kept else instant.Memory)
            if code.rise is not None:
                code.rise.worked(10.0)
                assert code.rise._library is not None
                assert isinstance(code.rise._library.result().library, Path)
                assert code.addresses is code.rise._library.result().addresses
            for a, b in zip(slow, ready.jacobian(theta, measure), strict=True):
                assert np.array_equal(a, b, equal_nan=True) and np.isfinite(a).any()
