"""Damping of two rough surfaces in contact, by fractal contact mechanics (GMM paper, eq. 16–18, A1–A12).

Corrected: the exponents in (A5), (A11), (A12), the last term of (A6) and its H_G1, which the paper leaves
undefined (areas of elasto-plastic asperities grow as δ^1.16), r_2 = √2 r_1, and W_p is the plastic energy. As
printed: (18), and G_eq as a 2(D_eq − 1)-th root. The paper's Table 3 lacks inputs: corrected, not validated.

D stands in exponents, so lengths are in units of l_0 = 1 m there. Powers whose exponent passes through 0 for
some D between 2 and 3 are written by `powdiff`: nothing is singular in that range.
"""

from typing import Any

from sympy import Symbol, nan

from modelgen.language import (
    Equation,
    Implicit,
    Max,
    Model,
    Output,
    Parameter,
    Piecewise,
    Rational,
    Statement,
    check_option,
    cos,
    exp,
    log,
    pi,
    powdiff,
    sqrt,
)
from modelgen.language import gamma as Gamma

TABLE_1, TABLE_2 = "GMM paper, Table 1", "GMM paper, Table 2"
ASSUMED = "assumed, not in the paper"


Range = tuple[float, float]


def given(name: str, unit: str, default: float, bounds: Range, text: str, source: str) -> Parameter:
    """A parameter that is held unless a case frees it."""
    return Parameter(name, unit, default, bounds, text, source, known=True)


ROUGH = (1e-9, 1e-4)
R_q_1 = given("R_q_1", "m", 0.661e-6, ROUGH, "rms roughness of surface 1 (softer): rod", TABLE_1)
R_q_2 = given("R_q_2", "m", 0.347e-6, ROUGH, "rms roughness of surface 2: iron column", TABLE_1)
L_m = given("L_m", "m", 2538.46e-6, (1e-6, 1.0), "length of the profile", "GMM paper, sec. 3.2.1")
D_1 = given("D_1", "1", 2.5747, (2.0, 3.0), "fractal dimension of surface 1", TABLE_2)
D_2 = given("D_2", "1", 2.6167, (2.0, 3.0), "fractal dimension of surface 2", TABLE_2)
G_1 = given("G_1", "m", 2.2525e-10, (1e-18, 1e-3), "fractal roughness of surface 1", TABLE_2)
G_2 = given("G_2", "m", 2.8175e-10, (1e-18, 1e-3), "fractal roughness of surface 2", TABLE_2)
E_1 = given("E_1", "Pa", 30e9, (1e5, 1e13), "elastic modulus of surface 1: Terfenol-D", ASSUMED)
E_2 = given("E_2", "Pa", 200e9, (1e5, 1e13), "elastic modulus of surface 2: iron", ASSUMED)
nu_1 = given("nu_1", "1", 0.3, (0.0, 0.5), "Poisson's ratio of surface 1", ASSUMED)
nu_2 = given("nu_2", "1", 0.3, (0.0, 0.5), "Poisson's ratio of surface 2", ASSUMED)
H = given("H", "Pa", 1.2e9, (1e5, 1e12), "hardness of the softer material", ASSUMED)
F = given("F", "N", 3141.592653589793, (1e-3, 1e8), "normal load: 10 MPa on the rod", "GMM paper, Table 3")
M = given("M", "kg", 1.0, (1e-9, 1e6), "mass of the structure", ASSUMED)
gamma = given("gamma", "1", 1.5, (1.0, 10.0), "dimension parameter of the spectral density", ASSUMED)
l_0 = given("l_0", "m", 1.0, (0.5, 2.0), "unit of the lengths in powers with D in the exponent", "SI")


def roughness(index: int, R_q: Parameter, g_form: str) -> tuple[Statement, ...]:
    """Fractal dimension and roughness of one surface from its rms roughness (16)–(18)."""
    D_s = Equation(
        f"D_s_{index}", Rational("1.548") / (10**6 * R_q / l_0) ** Rational("0.041"), "1", "(16)", "R_q in µm"
    )
    D = Equation(f"D_{index}", D_s + 1, "1", "(17)", "fractal dimension")
    # sin(πx/2) Γ(x) = π/(2 cos(πx/2) Γ(1 − x)), x = 2 D_s − 3: finite at x = 0, where R_q = 2.15 µm
    spectrum = pi / (2 * cos(pi * (2 * D_s - 3) / 2) * Gamma(4 - 2 * D_s))
    power = 2 - D_s if g_form == "printed" else 2 * (2 - D_s)
    inner = (R_q / l_0) ** 2 * spectrum / (L_m / l_0) ** power
    G = Equation(f"G_{index}", l_0 * inner ** (1 / (2 * (D_s - 1))), "m", "(18)", "fractal roughness")
    return D_s, D, G


D_eq = Equation("D_eq", Max(D_1, D_2), "1", "sec. 3.2.2", "equivalent fractal dimension")
G_eq = Equation(
    "G_eq",
    l_0 * ((G_1 / l_0) ** (2 * (D_1 - 1)) + (G_2 / l_0) ** (2 * (D_2 - 1))) ** (1 / (2 * (D_eq - 1))),
    "m", "sec. 3.2.2", "equivalent fractal roughness",
)  # fmt: skip
D, g = D_eq.symbol, G_eq / l_0
E = Equation("E", 1 / ((1 - nu_1**2) / E_1 + (1 - nu_2**2) / E_2), "Pa", "(A7)", "equivalent elastic modulus")
k = Equation("k", Rational("0.454") + Rational("0.41") * nu_1, "1", "(A8)", "hardness coefficient")

s = Symbol("psi", real=True)
psi = Implicit(
    "psi",
    powdiff(sqrt(s), (1 + s ** ((1 - D) / 2)) ** (-1 / (D - 1)), 3 - D) - 1 / (D - 1),
    (1, 3), "1", "(A6)", "domain extension factor",
)  # fmt: skip
a1c = Equation(
    "a1c",
    G_eq**2 * (2 ** (11 - 2 * D) * log(gamma) * E**2 / (pi ** (4 - D) * (k * H) ** 2)) ** (1 / (D - 2)),
    "m²", "(A8)", "critical area of an asperity, elastic above",
)  # fmt: skip
a2c = Equation("a2c", a1c / Rational("76.4") ** (1 / (D - 2)), "m²", "(A9)", "critical area, plastic below")
H_G1 = Equation("H_G1", 2 / (a1c / l_0**2) ** (Rational("0.16") * (D - 2)), "1", "(A6)", "closed by δ^1.16")
H_G2 = Equation(
    "H_G2",
    2 ** (Rational("4.18") - Rational("0.76") * D) * (k * H) ** Rational("0.24") * E ** Rational("0.76")
    / (3 * pi ** (Rational("1.52") - Rational("0.38") * D))
    * g ** (Rational("0.76") * (D - 2)) * log(gamma) ** Rational("0.38"),
    "Pa", "(A10)", "coefficient of the elasto-plastic load",
)  # fmt: skip
a1, a2 = a1c / l_0**2, a2c / l_0**2


def density(a_l: Any) -> Any:
    """(D − 1) ψ^((3−D)/2) a_l^((D−1)/2): the factor of the size distribution of contact areas, twice."""
    return (D - 1) * psi ** ((3 - D) / 2) * a_l ** ((D - 1) / 2)


def load(a_l: Any) -> tuple[Any, Any, Any]:
    """Plastic, elasto-plastic and elastic part of the load [N], largest contact a_l [l_0²] (A3)."""
    n = density(a_l) * l_0**2
    elastic = 2 ** ((11 - 2 * D) / 2) / (3 * pi ** ((4 - D) / 2)) * sqrt(log(gamma)) * g ** (D - 2) * E
    return (
        n * H * a2 ** ((3 - D) / 2) / (3 - D),
        n * H_G2 * powdiff(a1, a2, Rational("2.26") - Rational("0.88") * D) / 2,
        n * elastic * powdiff(a_l, a1, (5 - 2 * D) / 2) / 2,
    )


F_1c = Equation("F_1c", sum(load(a1)), "N", "(A3)", "load up to which no asperity is elastic")
# The plastic part alone bounds a_l from above.
ln_a_l = Implicit(
    "ln_a_l",
    log(sum(load(exp(Symbol("ln_a_l", real=True)))) / F),
    (log(a1), 2 / (D - 1) * log(F / load(1)[0])),
    "1", "(A3)", "logarithm of the largest area, which carries the load",
)  # fmt: skip
elastic = Piecewise((exp(ln_a_l), F_1c < F), (nan, True))  # else (A4) divides by no energy
a_l = Equation("a_l", l_0**2 * elastic, "m²", "(A3)", "largest truncated area, where F > F_1c")
beta_l = Equation(
    "beta_l",
    2 * l_0 * g ** (D - 2) * sqrt(log(gamma)) * (2 * sqrt(a_l / (pi * l_0**2))) ** (3 - D),
    "m", "(A1)", "deformation of the largest asperity, a_l = π r_2²",
)  # fmt: skip
R_l = Equation("R_l", a_l / (2 * pi * beta_l), "m", "(A2)", "its radius of curvature")
F_pl, F_ep, F_el = (
    Equation(f"F_{kind}", part, "N", "(A3)", f"load on {word} asperities")
    for kind, word, part in zip(
        ("pl", "ep", "el"), ("plastic", "elasto-plastic", "elastic"), load(a_l / l_0**2), strict=True
    )
)
al = a_l / l_0**2
n = density(al)
A_r = Equation(
    "A_r",
    n * l_0**2 * (
        powdiff(al, a1, (3 - D) / 2) / 4
        + powdiff(a1, a2, Rational("1.82") - Rational("0.66") * D) / (2 * H_G1)
        + a2 ** ((3 - D) / 2) / (3 - D)
    ),
    "m²", "(A6)", "real area of contact; not used by R_n",
)  # fmt: skip
K_el = Equation(
    "K_el",
    n * sqrt(2) * E * l_0 * (4 - D) * powdiff(al, a1, (2 - D) / 2) / (3 * sqrt(pi) * (3 - D)),
    "N/m", "(A5)", "stiffness of elastic asperities",
)  # fmt: skip
K_ep = Equation(
    "K_ep",
    n * H_G2 * l_0 * pi ** ((3 - D) / 2) * (Rational("1.76") - Rational("0.38") * D)
    * powdiff(a1, a2, Rational("0.76") - Rational("0.38") * D)
    / (2 ** (4 - D) * g ** (D - 2) * sqrt(log(gamma)) * (3 - D)),
    "N/m", "(A5)", "stiffness of elasto-plastic asperities",
)  # fmt: skip
K_n = Equation("K_n", K_el + K_ep, "N/m", "(A5)", "normal stiffness")
W_e = Equation(
    "W_e",
    n * 2 ** ((19 - 4 * D) / 2) * E * l_0**3 * g ** (2 * (D - 2)) * log(gamma) * (3 - D)
    * powdiff(al, a1, (8 - 3 * D) / 2) / (6 * pi ** ((7 - 2 * D) / 2) * (7 - 2 * D)),
    "J", "(A11)", "elastic energy",
)  # fmt: skip
W_p = Equation(
    "W_p",
    n * 2 ** (3 - D) * H * l_0**3 * g ** (D - 2) * sqrt(log(gamma)) * a2 ** (3 - D)
    / ((5 - D) * pi ** ((3 - D) / 2)),
    "J", "(A12)", "plastic energy",
)  # fmt: skip
eta = Equation("eta", W_p / W_e, "1", "(A4)", "loss factor, of the first loading")
R_n = Equation("R_n", eta * sqrt(M * K_n), "N*s/m", "(A4)", "normal damping of the contact")


def build(surface: str = "roughness", g_form: str = "printed") -> Model:
    """The model from R_q and L_m of the surfaces ("roughness"), or from their D and G ("fractal").

    (18) is not homogeneous in length as printed; "homogeneous" has L_m^(2(2−D_s)), not L_m^(2−D_s).
    Raises InputError on another value.
    """
    check_option("surface", surface, ("roughness", "fractal"))
    check_option("g_form", g_form, ("printed", "homogeneous"))
    shape: tuple[Parameter, ...] = (D_1, G_1, D_2, G_2)
    first: tuple[Statement, ...] = ()
    if surface == "roughness":
        shape = (R_q_1, R_q_2, L_m)
        first = (*roughness(1, R_q_1, g_form), *roughness(2, R_q_2, g_form))
    statements = (
        *first, D_eq, G_eq, E, k, psi, a1c, a2c, H_G1, H_G2, F_1c, ln_a_l, a_l, beta_l, R_l, F_pl, F_ep, F_el,
        A_r, K_el, K_ep, K_n, W_e, W_p, eta, R_n,
    )  # fmt: skip
    return Model(
        "contact_damping",
        parameters=(*shape, E_1, E_2, nu_1, nu_2, H, F, M, gamma, l_0),
        statements=statements,
        outputs=(Output("R_n"),),
        source="GMM paper, eq. 16–18, A3–A12",
        text="contact damping of two rough surfaces",
        options=(("surface", surface), ("g_form", g_form)),
        builder=build,
        checked=True,
    )


contact_damping = build()
