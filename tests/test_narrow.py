"""Resonances so narrow that a sweep has them in single samples, as it has glitches."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from coils import HEAD, verdict
from scipy.optimize import brentq

SHARE, MASS = 0.3, 0.013
"""Of the moving mass, that is a rod with waves in it; and all of it [kg]."""


def test_a_narrow_resonance_that_a_law_explains_is_no_outlier(tmp_path: Path) -> None:
    """A rod with a free end, whose mass m tan(kl)/kl cancels the rest of the mass at one sample."""
    f = np.geomspace(20, 20e3, 401)
    lone = brentq(lambda x: 1 - SHARE + SHARE * np.tan(x) / x, np.pi / 2 + 1e-9, np.pi - 1e-9)
    s, kl = 2j * np.pi * f, lone * f / f[391] / 1.0005
    mass = MASS * (1 - SHARE + SHARE * np.tan(kl) / kl)
    Z = 6 + 3e-4 * s + 36 / (1 + mass * s + 2e3 / s)
    found = verdict(tmp_path, f, Z, HEAD.replace("[noise]", f"[constants]\nM_m = {MASS}\n[noise]"))
    assert [e.id for e in found.effects] == ["distributed_rod"]
    assert not found.effects[0].equivalents
    assert not any("outlier" in n for n in found.notes)
