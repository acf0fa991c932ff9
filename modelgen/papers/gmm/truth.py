"""A synthetic transducer in place of the paper's recordings, which are not published.

Truth is the model with Method 3's constants (Table 7) and the damping of Tables 3 and 4. What the paper does
not state (R_0, M_t, K_spr, frequencies) is assumed such that |Z| resonates near its 1600 Hz.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from modelgen.codegen import Function, build
from modelgen.models.magnetostrictive_transducer import magnetostrictive_transducer as MODEL
from modelgen.recordings import Case, Noise, Recording

SIX = ("mu33_re", "S33_re", "d33_re", "mu33_im", "S33_im", "d33_im")
RANGE = {  # Table 7
    "mu33_re": (2.0, 3.0),
    "S33_re": (1e-12, 1e-10),
    "d33_re": (5e-10, 5e-9),
    "mu33_im": (-0.3, 0.3),
    "S33_im": (-1e-12, 1e-12),
    "d33_im": (-9e-11, 9e-11),
}
TRUE = {
    "mu33_re": 2.814, "S33_re": 2.547e-11, "d33_re": 1.587e-9,
    "mu33_im": -0.137, "S33_im": -2.178e-13, "d33_im": -5.588e-11,
}  # fmt: skip
ASSUMED = {"R_0": 3.0, "M_t": 1.2501374, "K_spr": 3e6}
DAMPING = {"R_d": 6.79, "R_f": 349.2303}
NOISE_Z, NOISE_P = 0.00046, 0.0058  # [ohm], [deg]: Table 4
FREQUENCIES = np.linspace(1000.0, 2500.0, 301)


@cache
def function() -> Function:
    """The model with derivatives by the six constants."""
    return build(MODEL, SIX, wait=True)


def impedance(f: np.ndarray[Any, Any], values: Mapping[str, float] = TRUE) -> np.ndarray[Any, Any]:
    """Z [ohm] (n,) of the assumed transducer at f [Hz]; `values` go before what is true."""
    return np.asarray(function()(f=f, **{**ASSUMED, **DAMPING, **TRUE, **values}))


def case(
    noise: float = 1.0,
    seed: int = 0,
    f: np.ndarray[Any, Any] = FREQUENCIES,
    damping: Mapping[str, float] | None = None,
    true: Mapping[str, float] | None = None,
) -> Case:
    """One sweep with `noise` times the noise of Table 4 in |Z| and phase, searched in the ranges of Table 7.

    damping: what is believed of it (the truth), {} to leave it free. true: other true values.
    """
    rng = np.random.default_rng(seed)
    Z = impedance(f, true or {})
    size = np.abs(Z) + noise * NOISE_Z * rng.standard_normal(f.size)
    phase = np.angle(Z) + np.radians(noise * NOISE_P) * rng.standard_normal(f.size)
    sweep = Recording("sweep", None, "fit", {"f": f}, {"Z": size * np.exp(1j * phase)})
    known = ASSUMED | dict(DAMPING if damping is None else damping)
    return Case(None, MODEL.id, (sweep,), (), known, RANGE, Noise())
