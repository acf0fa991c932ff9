"""Equations of the GMM paper that are wrong in print, and what they would do."""

from __future__ import annotations

import numpy as np

from modelgen.codegen import build
from modelgen.papers.gmm.fractal import L_M, dimension, roughness
from modelgen.papers.gmm.truth import ASSUMED, DAMPING, MODEL, TRUE, function
from modelgen.papers.paper import Found

F = 1600.0  # [Hz]


def misprints() -> Found:
    """Where, as printed, right, and how that shows."""
    values = {**ASSUMED, **DAMPING, **TRUE}
    right = function().all(f=np.array([F]), **values)
    Z = complex(right["Z"][0])
    wrong = complex(build(MODEL.variant(eddy_sign="printed"), wait=True)(f=np.array([F]), **values)[0])
    K, literal = _stiffness()
    G = [roughness(0.347, dimension(0.347)), _homogeneous(0.347, dimension(0.347))]
    rows = (
        ("(5)", "473/4343680", "473/4423680", "the series of 2J_1(x)/(x J_0(x)); 1.8 % of the last term"),
        (
            "(6), R_g1", "χ_r + jχ_i", "χ_r − jχ_i",
            f"with e^(+jωt). As printed eddy currents give out power: Re Z(1600 Hz) = {wrong.real:.2f} in "
            f"place of {Z.real:.2f} Ω, a gap like Method 3's RMSE of |Z|, 1.34 Ω",
        ),
        (
            "(9), K_G*", "jω(R_g2 + 1/(jωK_g)), R_g2 = A/(ωlS'')", "A/(lS*)",
            f"a stiffness, not a compliance: {K.real:.4g} N/m. As printed it is −j {-literal.imag:.2g} N/m, "
            "and the device has no resonance",
        ),
        (
            "(13), text", "K_mps, k_M, (12)", "K_spr of (9), k_M² of the table, (13)",
            "names; the equation itself is right",
        ),
        ("R_d", "2ξ M_d ω_1 with ω_1 in Hz", "ω_1 in rad/s", "6.79 in place of 42.68 N·s/m"),
        (
            "(18)", "L_m to the power 2 − D_s", "to the power 2(2 − D_s)",
            f"printed, G is no length; right, it is {G[1]:.3g} in place of {G[0]:.3g} m. Table 2 was "
            "computed as printed, and so is ours",
        ),
        ("before (A1)", "r_2 = r_1/√2", "r_1 = r_2/√2", "r_2² = 2Rβ of the cut area, r_1² = Rβ of Hertz's"),
        ("(A4), text", "W_p elastic, W_e plastic", "the other way round", "as (A11), (A12) have them"),
        ("(A5)", "exponents (0.76 − 0.38D)/2", "0.76 − 0.38D", "else K_n is not in N/m"),
        (
            "(A6)", "a'_c, H_G1 undefined, 2.7 − 1.1D", "a'_2c, 1.82 − 0.66D",
            "the area must be continuous where asperities become plastic: it grows as δ^1.16. R_n does not "
            "use it",
        ),
        ("(A11)", "exponents (3 − 3D)/2", "(8 − 3D)/2", "else W_e is negative, and not in J"),
        ("(A12)", "exponent (3 − D)/2 of a'_2c", "3 − D", "else W_p is not in J"),
    )  # fmt: skip
    return Found(
        (
            "the models here have the right forms; what the paper's tables were computed with is told "
            "apart by the numbers above; the exponents of (A5), (A11), (A12) may have suffered in the text "
            "at hand",
        ),
        ("where", "as printed", "right", "how it shows"),
        rows,
        prose=True,
    )


def _stiffness() -> tuple[complex, complex]:
    """K_G* at 1600 Hz, and by (9) as it is printed [N/m]."""
    S = complex(TRUE["S33_re"], TRUE["S33_im"])
    A, l = (float(MODEL.parameter(n).default or 0) for n in ("A", "l"))
    w = 2 * np.pi * F
    K_g = A * S.real / (l * abs(S) ** 2)
    R_g2 = A / (w * l * S.imag)
    return complex(A / (l * S)), complex(1j * w * (R_g2 + 1 / (1j * w * K_g)))


def _homogeneous(R_q: float, D: float) -> float:
    """G [m] by (18) with the exponent that makes it a length; R_q in µm."""
    D_s = D - 1  # (18) has L_m^(2 − D_s) once and ought to have it twice
    return float(roughness(R_q, D) * L_M ** ((D_s - 2) / (2 * (D_s - 1))))
