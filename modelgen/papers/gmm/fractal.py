"""Tables 2 and 3: fractal dimension and roughness of the surfaces (16)–(18), and of their contacts."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.special import gamma

from modelgen.papers.gmm.roughness import COLUMN, MEAN, PLUNGER, ROD, STANDARD
from modelgen.papers.number import Published
from modelgen.papers.paper import Table

Array = np.ndarray[Any, np.dtype[Any]]
L_M = 2538.46e-6  # [m], length of the microscope's field
DRAWS = 1_000_000
D_PRINTED = {ROD: "2.5747", COLUMN: "2.6167", PLUNGER: "2.6214"}
G_PRINTED = {ROD: "2.2525e-10", COLUMN: "2.8175e-10", PLUNGER: "2.8890e-10"}
CONTACTS = {"G-M": (ROD, COLUMN), "M-D": (COLUMN, PLUNGER), "M-H": (COLUMN, COLUMN)}


def dimension(R_q: Any) -> Any:
    """D = 1.548/R_q^0.041 + 1, R_q in µm (16), (17)."""
    return 1.548 / R_q**0.041 + 1


def roughness(R_q: Any, D: Any) -> Any:
    """G by (18) as printed, lengths in m: (R_q² sin(πx/2) Γ(x)/L_m^(2−D_s))^(1/(2(D_s−1))), x = 2D_s − 3."""
    D_s, x = D - 1, 2 * D - 5
    inner = (R_q * 1e-6) ** 2 * np.sin(np.pi * x / 2) * gamma(x) / L_M ** (2 - D_s)
    return inner ** (1 / (2 * (D_s - 1)))


def of_contact(D_1: Any, G_1: Any, D_2: Any, G_2: Any) -> tuple[Any, Any]:
    """D_eq = max(D_1, D_2), G_eq = (G_1^(2(D_1−1)) + G_2^(2(D_2−1)))^(1/(2(D_eq−1))) (sec. 3.2.2)."""
    D = np.maximum(D_1, D_2)
    return D, (G_1 ** (2 * (D_1 - 1)) + G_2 ** (2 * (D_2 - 1))) ** (1 / (2 * (D - 1)))


def contact(name: str) -> tuple[float, float]:
    """D_eq and G_eq [m] from Table 2 as printed."""
    D, G = of_contact(*(float(t[s]) for s in CONTACTS[name] for t in (D_PRINTED, G_PRINTED)))
    return float(D), float(G)


@cache
def drawn_roughness() -> dict[str, Array]:
    """DRAWS values of R_q [µm] of each surface, normal with Table 1's mean and standard uncertainty."""
    rng = np.random.default_rng(101)
    return {s: float(MEAN[s]) + float(STANDARD[s]) * rng.standard_normal(DRAWS) for s in MEAN}


def contact_std(name: str, which: int) -> float:
    """Standard deviation of D_eq (0) or G_eq [m] (1) over the draws.

    The two faces of M-H are drawn apart: they are other faces of the same finish.
    """
    first, second = CONTACTS[name]
    R_1, R_2 = drawn_roughness()[first], drawn_roughness()[second]
    R_2 = R_2[::-1] if first == second else R_2
    D_1, D_2 = dimension(R_1), dimension(R_2)
    found = of_contact(D_1, roughness(R_1, D_1), D_2, roughness(R_2, D_2))
    return float(np.std(found[which], ddof=1))


def _dimension(surface: str) -> float:
    return float(dimension(float(MEAN[surface])))


def _roughness(surface: str) -> float:
    return float(roughness(float(MEAN[surface]), float(D_PRINTED[surface])))


def _part(of: Callable[[str], tuple[float, float]], name: str, which: int) -> float:
    return of(name)[which]


def _surface(surface: str) -> tuple[Published, ...]:
    return (
        Published(
            surface, "D", D_PRINTED[surface], "1", "(16), (17), R_q in µm from Table 1",
            partial(_dimension, surface),
        ),
        Published(
            surface, "G", G_PRINTED[surface], "m", "(18) as printed with this table's D, L_m = 2538.46 µm",
            partial(_roughness, surface),
        ),
    )  # fmt: skip


EQUIVALENT = {  # D_eq, its u, G_eq, its u
    "G-M": ("2.6167", "0.0011", "4.3788e-10", "9.6892e-12"),
    "M-D": ("2.6214", "0.0009", "3.6296e-10", "2.8896e-13"),
    "M-H": ("2.6167", "0.0011", "3.4991e-10", "2.4283e-13"),
}
DIGIT = "Table 2 gives {} by the paper's own formula, one digit off and beyond the stated ± {}: a misprint"
U_D = "Table 1's u(R_q) = 0.011 µm gives about twice that through (16), u(D) = 0.041 D_s u(R_q)/R_q"
U_G = "Table 1's u(R_q) = 0.011 µm gives more through (16)–(18), and the contacts cannot differ 30-fold in it"
MISPRINT = {"M-D": DIGIT.format("3.6496e-10 m", "2.9e-13"), "M-H": DIGIT.format("3.4911e-10 m", "2.4e-13")}
ONE_MILLION = "Monte Carlo, 1e6 draws of R_q (Table 1) through (16)–(18)"


def equivalents(name: str) -> tuple[Published, ...]:
    """D_eq and G_eq of one contact with their uncertainties (Table 3)."""
    D, u_D, G, u_G = EQUIVALENT[name]
    row = f"{name} surface"
    return (
        Published(row, "D_eq", D, "1", "the larger D of Table 2", partial(_part, contact, name, 0)),
        Published(row, "u(D_eq)", u_D, "1", ONE_MILLION, partial(contact_std, name, 0), wrong=U_D),
        Published(
            row, "G_eq", G, "m", "2(D_eq−1)-th root, from Table 2", partial(_part, contact, name, 1),
            wrong=MISPRINT.get(name, ""), within=float(u_G),
        ),
        Published(
            row, "u(G_eq)", u_G, "m", ONE_MILLION, partial(contact_std, name, 1),
            wrong="" if name == "G-M" else U_G,
        ),
    )  # fmt: skip


FRACTAL = Table(
    "Table 2",
    "Fractal dimension D and roughness G of the surfaces. D of the rod would need R_q = 0.659 µm, not "
    "Table 1's 0.661; (18) is not homogeneous in length, and is taken literally",
    tuple(n for s in MEAN for n in _surface(s)),
)
