"""What grows with the level of a sweep and keeps its shape is no error of the instrument."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.diagnose import diagnose
from modelgen.diagnose.verdict import Verdict
from modelgen.models import load
from modelgen.recordings import Case, Noise, Recording

F = np.geomspace(20, 20e3, 181)
NOISE = 3e-3


def verdict(sizes: tuple[float, ...], seed: int = 4) -> Verdict:
    """Of a moving coil, swept at three levels, beside a smooth deviation of so many thousandths of |Z| in
    each, with one shape in all."""
    rng = np.random.default_rng(seed)
    s = 2j * np.pi * F
    Z = 6 + 3e-4 * s + 36 / (1 + 0.012 * s + 2e3 / s)
    shape = np.cos(1.7 * np.log(F / 300)) + 0.7j * np.sin(1.3 * np.log(F / 90))
    records = []
    for k, size in enumerate(sizes):
        noise = rng.standard_normal((2, F.size))
        measured = Z * (1 + 1e-3 * size * shape) + NOISE * abs(Z) * (noise[0] + 1j * noise[1])
        records.append(Recording(f"level {k}", None, "fit", {"f": F}, {"Z": measured}))
    told = Noise(relative={"Z": NOISE})
    case = Case(None, "x", tuple(records), constants={"M_m": 0.012}, noise=told)
    return diagnose(case, load("electrodynamic_transducer"))


def test_what_grows_from_sweep_to_sweep_is_unknown() -> None:
    found = verdict((0.2, 1.0, 4.0))
    assert [e.id for e in found.effects] == ["unknown_electrical"]
    assert "differs in size from sweep to sweep" in found.summary
    assert not any("counted as noise" in n for n in found.notes)


@pytest.mark.parametrize("sizes", [(2.0, 2.0, 2.0), (0.0, 0.0, 0.0)])
def test_what_is_alike_in_all_is_the_instruments(sizes: tuple[float, ...]) -> None:
    assert verdict(sizes).adequate
