"""Synthetic recordings in place of the paper's, which are not published.

Truth is the modified Dahl model with the published stage-4 parameters (Table 4) and the noise of sec. 3.3.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from modelgen.codegen import build
from modelgen.fit.fitting import fit
from modelgen.models.modified_dahl import modified_dahl
from modelgen.papers.mre.stages import FOUR, Estimated, Reading, estimate, moving_average
from modelgen.recordings import Case, Noise, Recording

Array = np.ndarray[Any, np.dtype[np.float64]]
STAGE_2 = {
    "M0": {"k_D": 0.3494, "c_D": 0.0811, "h_D": 0.1972, "rho": 1.59},
    "M1": {"k_D": 0.6602, "c_D": 0.1130, "h_D": 0.2906, "rho": 1.41},
}
STAGE_4 = {
    "M0": {"k_D": 0.3834, "c_D": 0.0912, "h_D": 0.0353, "rho": 1.46},
    "M1": {"k_D": 0.6797, "c_D": 0.1374, "h_D": 0.2309, "rho": 1.44},
}
OFFSET = {"M0": 1.3, "M1": 1.85}
A_Z, FREQUENCY, RATE, CYCLES = 3.0, 0.1, 4000.0, 5
SHIFT = {"M0": 6.63, "M1": 6.64}
NOISE_Z, NOISE_F = 2.88e-4, 1.85e-3
RUNS = 10
SAMPLES = 400  # of a cycle in the repeated runs
DIRECT = 200.0  # [Hz] rate at which our own fit takes the record: means of 20 samples


@cache
def record(case: str, seed: int = 0) -> tuple[Array, Array, Array]:
    """t [s], z [mm], F_m [N] of five cycles at 4 kHz."""
    t = np.arange(round(CYCLES / FREQUENCY * RATE)) / RATE
    phase = 2 * np.pi * FREQUENCY * (t - SHIFT[case])
    z = -A_Z * np.cos(phase)
    f = build(modified_dahl, wait=True)
    F = f(t=t, z=z, v=A_Z * 2 * np.pi * FREQUENCY * np.sin(phase), F_0=OFFSET[case], **STAGE_4[case])
    rng = np.random.default_rng(seed)
    return (
        t,
        z + NOISE_Z * rng.standard_normal(t.size),
        np.asarray(F) + NOISE_F * rng.standard_normal(t.size),
    )


@cache
def repeats(case: str, reading: Reading = "inside") -> tuple[Estimated, ...]:
    """The paper's procedure ten times, on one record as the paper did it (Tables 4 and 5)."""
    return tuple(estimate(*record(case), seed=k, reading=reading, samples=SAMPLES) for k in range(RUNS))


@dataclass(frozen=True)
class Direct:
    """Our fit of one record: the four parameters and their std by name, and time [s]."""

    values: dict[str, float]
    std: dict[str, float]
    seconds: float


@cache
def direct(case: str, seed: int = 0) -> Direct:
    """All of the model's free parameters by `modelgen.fit`, from the measured z and F."""
    t, z, F = record(case, seed)
    every = round(RATE / DIRECT)
    at = slice(every // 2, None, every)
    inputs, outputs = {"t": t[at], "z": moving_average(z)[at]}, {"F": moving_average(F)[at]}
    noise = Noise(sigma={"F": NOISE_F / every**0.5, "z": NOISE_Z / every**0.5})
    recording = Recording("record", None, "fit", inputs, outputs)
    began = time.perf_counter()
    found = fit(modified_dahl, Case(None, "modified_dahl", (recording,), noise=noise))
    seconds = time.perf_counter() - began
    return Direct({n: found[n].value for n in FOUR}, {n: found[n].std for n in FOUR}, seconds)
