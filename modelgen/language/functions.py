"""Functions of the language that sympy or C's math library has under no name, each with its derivative.

A function here is opaque to the derivative engine: it becomes one call in the C, and its derivative is stated by
`fdiff` in terms of other functions of the language. Their C stands in `templates/functions.h.j2`.
"""

from __future__ import annotations

from typing import Any

import sympy as sp


class eddy_factor(sp.Function):  # noqa: N801  (a function, named as in the papers)
    """Eddy-current factor of a round rod, χ(p) = 2 J1(x) / (x J0(x)) with x² = −j p, p = f/f_c (GMM paper, eq. 5).

    Complex for real p; χ(0) = 1, Re χ > 0 > Im χ for p > 0.
    """

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        # with q = j p:  dχ/dq = (1 − χ)/q − χ²/4, and (1 − χ)/q is a function of its own: no cancellation at p → 0
        p = self.args[0]
        return sp.I * (eddy_deficit(p) - eddy_factor(p) ** 2 / 4)


class eddy_deficit(sp.Function):  # noqa: N801
    """(1 − χ(p)) / (j p), accurate for small p; 1/8 at p = 0."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        p = self.args[0]
        return -(self.func(p) - eddy_factor(p) ** 2 / 4 + self.func(p)) / p


class powj(sp.Function):  # noqa: N801
    """(j w)^n for real w > 0 and real n: w^n (cos(nπ/2) + j sin(nπ/2)). Fractional order elements."""

    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:
        w, n = self.args
        if argindex == 1:
            return n * self / w
        return self * (sp.log(w) + sp.I * sp.pi / 2)


class gamma(sp.Function):  # noqa: N801
    """Euler's Γ(x) of a real x > 0."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        return self * digamma(self.args[0])


class digamma(sp.Function):  # noqa: N801
    """ψ(x) = Γ'(x)/Γ(x) of a real x > 0. Its own derivative is not needed and not offered."""

    nargs = 1


class cpow(sp.Function):  # noqa: N801
    """z^n of a complex z (principal branch) and a real n; what a power of a complex quantity is lowered to."""

    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:
        z, n = self.args
        return n * cpow(z, n - 1) if argindex == 1 else self * clog(z)


class clog(sp.Function):  # noqa: N801
    """Principal logarithm of a complex number."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        return 1 / self.args[0]


COMPLEX_VALUED = (eddy_factor, eddy_deficit, powj, cpow, clog)
"""Functions whose value is complex whatever their arguments are."""
