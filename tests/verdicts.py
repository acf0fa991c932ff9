"""Verdicts of the kinds that a diagnosis gives, made from closed forms, to look at as a page."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from modelgen.diagnose.verdict import Finding, Mismatch, PortCurve, Rms, Trial, Verdict
from modelgen.fit.result import Estimate
from modelgen.fit.trace import Trace

RNG = np.random.default_rng(7)
NAN = float("nan")


def coil(f: Any, n: float = 0.5, K: float = 0.03, M: float = 0.015) -> Any:
    """Impedance of a moving coil with a semi-inductance K(jω)^n."""
    s = 2j * np.pi * f
    return 6 + 5e-4 * s + K * s**n + 36 / (1 + s * M + 2e3 / s)


def sweep(name: str, role: str = "fit", M: float = 0.015, points: int = 401, outliers: int = 0) -> Trace:
    """An impedance sweep with 0.2 % noise; the model before lacks the semi-inductance."""
    f = np.geomspace(10, 20e3, points)
    true = coil(f, M=M)
    before = coil(f, K=0.0, M=M) * 1.0 + 0.02 * (2j * np.pi * f) ** 0.5 * 1.02
    noise = 2e-3 * np.abs(true)
    e = RNG.standard_normal((2, points))
    data = true + noise * (e[0] + 1j * e[1]) * np.exp(1j * np.angle(true))
    bad = np.zeros(points, bool)
    bad[RNG.choice(points, outliers, replace=False)] = True
    data[bad] *= 1.08
    turn = np.exp(-1j * np.angle(data)) / noise

    def white(model: Any) -> Any:
        w = (model - data) * turn
        return np.stack([w.real, w.imag])

    return Trace(
        name, role, "f", "Hz", "ohm", "complex", f, data, before, true, white(before), white(true), bad,
        {"f": f},
    )  # fmt: skip


def stroke(name: str, role: str = "fit", samples: int = 4000, rate: float = 1.0) -> Trace:
    """A force record over a sine with backlash that the model before does not have."""
    t = np.arange(samples) / 200.0
    z = 3 * np.sin(2 * np.pi * rate * t) + 0.4 * np.sin(2 * np.pi * 0.37 * rate * t)
    v = np.gradient(z, t)
    before = 0.38 * z + 0.09 * v / rate / 6 + 0.3 * np.tanh(v)
    gap = 0.4 * np.exp(-((z / 0.35) ** 2)) * np.sign(v) * np.minimum(np.abs(v), 1)
    true = before - gap
    data = true + 0.01 * RNG.standard_normal(samples)
    return Trace(
        name, role, "t", "s", "N", "real", t, data, before, true, (before - data)[None] / 0.01,
        (true - data)[None] / 0.01, np.zeros(samples, bool), {"t": t, "z": z, "v": v},
    )  # fmt: skip


COIL_TRIALS = (
    ("semi_inductance", "eddy", -4211.0, 0.93), ("eddy_shunt", "eddy", -4207.0, 0.07),
    ("coil_capacitance", "", -1205.0, 0.0), ("coil_ac_resistance", "", -960.0, 0.0),
    ("sensor_delay", "lag", -430.0, 0.0), ("second_mode", "second resonance", 3.0, 0.0),
    ("structural_damping", "viscoelastic", 5.8, 0.0),
)  # fmt: skip


def missing_semi_inductance(recordings: int = 1) -> Verdict:
    """A moving coil whose eddy currents were left out; the last of several sweeps is held out."""
    traces = [sweep("sweep.csv", outliers=3)]
    traces += [sweep(f"load_{k}.csv", M=0.015 + 0.01 * k) for k in range(1, recordings - 1)]
    traces += [sweep("other_mass.csv", "holdout", M=0.04)] if recordings > 1 else []
    f = np.geomspace(10, 20e3, 120)
    law = 0.03 * (2j * np.pi * f) ** 0.5
    std = 2e-3 * np.abs(coil(f))
    implied = law + std * (RNG.standard_normal(120) + 1j * RNG.standard_normal(120))
    own = (
        Estimate("semi_inductance_K", 0.03004, 1.2e-4, "ohm*s**0.5/rad**0.5"),
        Estimate("semi_inductance_n", 0.5003, 6e-4, "1"),
    )
    finding = Finding(
        "semi_inductance", "electrical",
        "Eddy currents in solid iron make the coil's inductance a semi-inductance K(jω)^n.",
        0.93, "eddy", "Wright, JAES 38 (1990) 749", ("eddy_shunt",),
        "A sweep to 80 kHz would tell semi_inductance from eddy_shunt by 14 standard deviations.", own, 0.98,
    )  # fmt: skip
    held = recordings > 1
    return Verdict(
        "electrodynamic_transducer",
        adequate=False,
        mismatch=(
            Mismatch("electrical", "f", 800.0, 2e4, "Hz", "Above 800 Hz |Z| grows more slowly than ωL."),
        ),
        effects=(finding,),
        parameters=(
            Estimate("R_e", 6.001, 0.002, "ohm"), Estimate("L_e", 4.99e-4, 2.1e-6, "H"),
            Estimate("Bl", 6.0, 0.004, "N/A"), Estimate("R_m", 0.0, NAN, "N*s/m", at_bound=True), *own,
        ),
        parameters_before=(
            Estimate("R_e", 6.31, 0.003, "ohm"), Estimate("L_e", 6.22e-4, 0.9e-6, "H"),
            Estimate("Bl", 6.005, 0.004, "N/A"), Estimate("R_m", 1.12, 0.01, "N*s/m"),
        ),
        before=Rms(0.81, 0.7 if held else NAN, 12.4, 9.8 if held else NAN),
        after=Rms(0.031, 0.03 if held else NAN, 1.01, 1.03 if held else NAN),
        unit="ohm",
        extended_model="out/electrodynamic_transducer_semi_inductance.py",
        seconds=1.84,
        summary="Eddy currents in solid iron make the coil's inductance fall as frequency grows: a "
        "semi-inductance K(jω)^n with n = 0.500 ± 0.001. With it the misfit falls from 12.4 to 1.01 times "
        "the noise; a shorted turn would fit these data as well.",
        trials=tuple(Trial((i,), fam, d, 2, 1.01 if d < -4e3 else 9.0, p) for i, fam, d, p in COIL_TRIALS),
        traces=tuple(traces),
        curve=PortCurve("electrical", "impedance", "ohm", "f", "Hz", f, implied, law, std),
        notes=("3 of 401 samples are outliers (more than 5 standard deviations) and were down-weighted.",),
        noise="White, relative to |Z|: 0.2 %, as stated.",
        law="Z_e = R_e + j*omega*L_e + K*(j*omega)**n",
    )  # fmt: skip


def missing_backlash(samples: int = 4000) -> Verdict:
    """A damper with a gap; two records, one held out."""
    gap = Estimate("backlash_gap", 0.352, 0.004, "mm")
    z = np.linspace(-3.2, 3.2, 90)
    law = -0.4 * np.exp(-((z / 0.35) ** 2))
    implied = law + 0.02 * RNG.standard_normal(90)
    says = "The rod moves freely within a gap before it meets the sample."
    where = "The force is missing within 0.4 mm of the middle, after each reversal."
    return Verdict(
        "modified_dahl",
        adequate=False,
        mismatch=(Mismatch("force", "z", -0.4, 0.4, "mm", where, "slow.csv"),),
        effects=(
            Finding("backlash", "force", says, 0.999, "backlash", "textbook", parameters=(gap,), share=0.97),
        ),
        parameters=(
            Estimate("k_D", 0.380, 2e-4, "N/mm"), Estimate("rho", 1.46, 0.02, "1/mm"),
            Estimate("F_0[slow.csv]", 0.01, 0.02, "N"), gap,
        ),
        parameters_before=(
            Estimate("k_D", 0.391, 2e-4, "N/mm"), Estimate("rho", 0.71, 0.01, "1/mm"),
            Estimate("F_0[slow.csv]", 0.02, 0.02, "N"),
        ),
        before=Rms(0.11, 0.13, 11.0, 13.0),
        after=Rms(0.0101, 0.0104, 1.01, 1.04),
        unit="N",
        extended_model="out/modified_dahl_backlash.py",
        seconds=2.2,
        summary="Within 0.35 mm of the middle no force is transmitted after a reversal: a gap. With it only "
        "noise is left, on the held-out record as well.",
        trials=(
            Trial(("backlash",), "backlash", -8000.0, 1, 1.01, 1.0),
            Trial(("second_dahl_element",), "friction_shape", -900.0, 2, 9.0, 0.0),
        ),
        traces=(stroke("slow.csv", samples=samples), stroke("fast.csv", "holdout", samples, 3.0)),
        curve=PortCurve(
            "force", "force", "N", "z", "mm", z, implied, law, np.full(90, 0.02), log_x=False
        ),
        law="F = F_r(z - g*r)",
    )  # fmt: skip


def adequate() -> Verdict:
    """A sweep that the model fits."""
    one = sweep("sweep.csv")
    one = replace(one, before=one.after, white_before=one.white_after)
    known = (Estimate("R_e", 6.0, 0.002, "ohm"), Estimate("M_m", 1.5e-2, NAN, "kg"))
    fine = Rms(0.03, NAN, 1.0, NAN)
    return Verdict(
        "electrodynamic_transducer", True, (), (), known, known, fine, fine, "ohm", None, 0.6,
        summary="The model fits to the noise. None of 21 hypotheses gains more than chance would give.",
        trials=(
            Trial(("semi_inductance",), "eddy", 7.1, 2, 1.0, 0.01),
            Trial(("sensor_delay",), "lag", 4.0, 1, 1.0, 0.03),
        ),
        traces=(one,),
        noise="White, estimated.",
    )  # fmt: skip


def unknown() -> Verdict:
    """Something at the force port that no catalogued effect explains."""
    v = missing_backlash()
    says = "A force that depends on displacement and on the path since the last reversal."
    curve = None if v.curve is None else replace(v.curve, law=None)
    finding = Finding("unknown_force", "force", says, 0.88)
    return replace(v, effects=(finding,), summary="", curve=curve, law="", trials=())


def stiffness() -> Verdict:
    """Five points of small-signal stiffness, as in the MRE paper's Tab. 3."""
    f = np.array([0.1, 1.0, 3.0, 6.0, 9.0])
    data = np.array([0.55, 0.9, 1.6, 2.6, 3.4])
    before = np.full(5, 0.56)
    after = data + 0.01
    one = Trace(
        "tab3.csv", "fit", "f", "Hz", "N/mm", "real", f, data, before, after, (before - data)[None] / 0.02,
        (after - data)[None] / 0.02, np.zeros(5, bool), {"f": f},
    )  # fmt: skip
    finding = Finding(
        "power_law_viscoelasticity", "mechanical", "The matrix creeps by a power law.", 0.8, "viscoelastic",
        "", ("maxwell_branch",), "Record 0.01 and 30 Hz as well.",
        (Estimate("power_law_viscoelasticity_alpha", 0.62, 0.03, "1"),),
    )  # fmt: skip
    trials = (
        Trial(("power_law_viscoelasticity",), "viscoelastic", -30.0, 2, 0.9, 0.8),
        Trial(("maxwell_branch",), "viscoelastic", -27.0, 2, 1.0, 0.2),
    )
    return Verdict(
        "complex_stiffness", False, (), (finding,), (Estimate("k_D", 0.3, 0.02, "N/mm"),),
        (Estimate("k_D", 0.56, 0.02, "N/mm"),), Rms(1.5, NAN, 75, NAN), Rms(0.01, NAN, 0.9, NAN),
        "N/mm", None, 0.4, traces=(one,), trials=trials,
    )  # fmt: skip


ALL = {
    "sweep": missing_semi_inductance,
    "force": missing_backlash,
    "adequate": adequate,
    "unknown": unknown,
    "several": lambda: missing_semi_inductance(4),
    "stiffness": stiffness,
}
