"""The GMM paper's three estimators (Fig. 5), with its swarm and with ours.

All minimise a plain root mean square: (14) E_1 = √(Σ(|Z| − |Ẑ|)²/I) over the modulus, (15) E_2 = √(Σ(P −
P̂)²/I) over the phase in degrees. Method 1 takes all six constants from |Z|. Method 2 keeps its real parts and
takes the imaginary ones from the phase. Both know nothing of the damping: R_d = R_f = 0, since the paper does
not say otherwise. Method 3 is Method 2 with the measured damping, which the case states.
"""

from __future__ import annotations

from modelgen.fit import PSO, GaussNewton
from modelgen.fit.method import Method
from modelgen.fit.recipe import Recipe, Stage

UNDAMPED = {"R_d": 0.0, "R_f": 0.0}
OURS = PSO(100, 300) >> GaussNewton()
PAPERS = PSO.paper()  # 12 particles, w = 0.5, c1 = c2 = 2 (sec. 4.3)


def method_1(search: Method = OURS) -> Recipe:
    """All six real numbers from |Z|, damping left out."""
    return Recipe(
        "method 1", (_real(search),), f"Method 1 of the GMM paper: all from |Z|, undamped; {search.text}"
    )


def method_2(search: Method = OURS) -> Recipe:
    """Real parts as Method 1, imaginary parts from the phase, damping left out."""
    second = Stage("phase", "imaginary", search, UNDAMPED)
    text = f"Method 2 of the GMM paper: losses from the phase, undamped; {search.text}"
    return Recipe("method 2", (_real(search), second), text)


def method_3(search: Method = OURS, damped: bool = False) -> Recipe:
    """Real parts as Method 1, imaginary parts from the phase with R_d and R_f as the case states them.

    damped: the real parts, too, are found with that damping, which the paper does not say of them.
    """
    first = Stage("modulus", "all", search) if damped else _real(search)
    second = Stage("phase", "imaginary", search)
    text = f"Method 3 of the GMM paper: losses from the phase, damping as stated; {search.text}"
    return Recipe("method 3", (first, second), text)


def _real(search: Method) -> Stage:
    return Stage("modulus", "all", search, UNDAMPED)


METHOD_1, METHOD_2, METHOD_3 = method_1(), method_2(), method_3()
METHOD_1_PAPER, METHOD_2_PAPER, METHOD_3_PAPER = method_1(PAPERS), method_2(PAPERS), method_3(PAPERS)
