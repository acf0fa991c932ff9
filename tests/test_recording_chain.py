"""Sweeps through a recording chain that adds a resonance of its own, and coils with more than one eddy
current: each is told as one thing."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coils import coil, verdict

from modelgen.diagnose.gate.resonant import CHAIN


def resonant(f: Any, f0: float, Q: float) -> Any:
    return 1 / (1 + 1j * Q * (f / f0 - f0 / f))


@pytest.mark.slow
def test_crosstalk_is_no_effect_of_the_device(tmp_path: Path) -> None:
    f = np.geomspace(10.0, 2e4, 120)
    v = verdict(tmp_path, f, coil(f) * (1 + 0.03 * np.exp(2.1j) * resonant(f, 700.0, 0.7)))
    assert [e.id for e in v.effects] == ["unknown_electrical"]
    assert CHAIN in v.effects[0].says
    assert v.after.fit_over_noise == pytest.approx(1.0, abs=0.15)


def test_two_shorted_turns_are_one_effect(tmp_path: Path) -> None:
    f = np.geomspace(10.0, 2e4, 120)
    s = 2j * np.pi * f
    v = verdict(
        tmp_path, f, coil(f, sum(L * s / (1 + 1j * f / at) for L, at in ((8e-4, 600.0), (2e-4, 6e3))))
    )
    assert [e.id for e in v.effects] == ["eddy_shunt"]
    assert v.after.fit_over_noise == pytest.approx(1.0, abs=0.15)
