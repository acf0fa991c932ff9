"""The roofline that `modelgen build` prints: what is counted, what is measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import modelgen.codegen.roofline as codegen_roofline
import modelgen.models as models
from modelgen.cli import main
from modelgen.cli.building import _share
from modelgen.codegen import build
from modelgen.codegen.roofline import machine, roofline


def test_limits_of_the_machine_are_of_the_order_of_a_processor() -> None:
    m = machine()
    assert 1e-3 < m.arithmetic < 2 and 1e-2 < m.division < 20 and 1e-3 < m.memory < 5
    assert m.arithmetic < m.division


def test_a_kernel_is_held_against_the_unit_that_it_keeps_busy_longest() -> None:
    function = build(models.electrodynamic_transducer)
    kernels = {k.name: k for k in function.code.source.kernels}
    m = machine()
    for roof in roofline(function):
        work, words = kernels[roof.kernel].work, kernels[roof.kernel].words
        assert roof.operations == work.operations and roof.reached > 0
        assert roof.limit is not None and roof.share == pytest.approx(roof.limit / roof.reached)
        assert roof.limit >= max(work.divisions * m.division, words * m.memory) * (1 - 1e-12)


@pytest.mark.parametrize(
    ("whole", "bare", "cost"), [(5e-7, 1e-7, 4e-7), (1e-7, 1e-7, 1e-7), (1e-7, 3e-7, 1e-7)]
)
def test_a_cost_that_cannot_be_told_from_an_empty_call_is_the_whole_call(
    monkeypatch: pytest.MonkeyPatch, whole: float, bare: float, cost: float
) -> None:
    call, empty = (lambda: None), (lambda: None)
    monkeypatch.setattr(codegen_roofline, "fastest", lambda f, _: whole if f is call else bare)
    kernel = next(k for k in build(models.kelvin_voigt).code.source.kernels if k.name == "values_real")
    found = codegen_roofline._nanoseconds(kernel, call, empty)
    assert found == pytest.approx(cost * 1e9 / codegen_roofline.SAMPLES)


def test_words_are_what_a_sample_loads_and_stores() -> None:
    """Kelvin and Voigt: F = k z + c v with z, v given, F stored; its two derivatives are z and v."""
    kernels = {k.name: k.words for k in build(models.kelvin_voigt).code.source.kernels}
    columns = len(build(models.kelvin_voigt).wrt)
    assert kernels["values_real"] == 3 and kernels["jacobian_real"] == 3 + columns
    assert kernels["sumsq_real"] == 4


def test_what_iterates_has_no_limit() -> None:
    shares = {r.kernel: r.share for r in roofline(build(models.complex_stiffness))}
    assert shares["values_real"] is None and shares["prepare"] is not None


@pytest.mark.parametrize("n", [16, 500, 512, 1024, 4096])
def test_rows_do_not_push_each_other_out_of_the_cache(n: int) -> None:
    ready = build(models.kelvin_voigt).prepare(t=np.arange(n) * 1.0, z=np.sin(np.arange(n) * 1.0))
    assert n <= ready.stride < n + 32 and ready.stride % 512 and ready.stride % 16 == 0


def test_build_shows_it(tmp_path: Path, capsys: Any) -> None:
    assert main(["build", "kelvin_voigt", "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "reached" in shown and "%" in shown and "sumsq_real" in shown
    assert not any("reached" in f.read_text() for f in tmp_path.iterdir())


@pytest.mark.parametrize(("limit", "shown"), [(None, "–"), (0.5, "50%"), (1.4, "at the limit")])
def test_no_kernel_is_said_to_beat_the_machine(limit: float | None, shown: str) -> None:
    assert _share(codegen_roofline.Roof("values_real", 3, 1.0, limit, "memory")) == shown
