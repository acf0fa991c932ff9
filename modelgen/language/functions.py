"""Functions of the language that sympy or C's math library has under no name, each with its derivative.

A function here is opaque to the derivative engine: it becomes one call in the C, and its derivative is stated
by `fdiff` in terms of other functions of the language. Their C stands in `templates/functions.h.j2`.
"""

from __future__ import annotations

from typing import Any

import sympy as sp


def Abs(x: Any) -> Any:
    """|x| as it is written: sympy, where it cannot tell that x is real, makes it the root of x², multiplied
    out, which is long and cancels."""
    x = sp.sympify(x)
    return sp.Abs(x, evaluate=x.is_extended_real is not None)


class eddy_factor(sp.Function):
    """Eddy-current factor of a round rod (GMM paper, eq. 5): χ(p) = 2 J1(x)/(x J0(x)), x² = −jp, p = f/f_c.

    Complex for real p; χ(0) = 1, Re χ > 0 > Im χ for p > 0.
    """

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        # with q = jp: dχ/dq = (1 − χ)/q − χ²/4; (1 − χ)/q is a function of its own: no cancellation at p → 0
        p = self.args[0]
        return sp.I * (eddy_deficit(p) - eddy_factor(p) ** 2 / 4)


class eddy_deficit(sp.Function):
    """(1 − χ(p)) / (j p), accurate for small p; 1/8 at p = 0."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        p = self.args[0]
        return -(self.func(p) - eddy_factor(p) ** 2 / 4 + self.func(p)) / p


class powj(sp.Function):
    """(j w)^n for real w > 0 and real n: w^n (cos(nπ/2) + j sin(nπ/2)). Fractional order elements."""

    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:
        w, n = self.args
        if argindex == 1:
            return n * self / w
        return self * (sp.log(w) + sp.I * sp.pi / 2)


class gamma(sp.Function):
    """Euler's Γ(x) of a real x > 0."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        return self * digamma(self.args[0])


class digamma(sp.Function):
    """ψ(x) = Γ'(x)/Γ(x) of a real x > 0. Its own derivative is not needed and not offered."""

    nargs = 1


class cpow(sp.Function):
    """z^n of a complex z (principal branch) and a real n; a power of a complex quantity is lowered to it."""

    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:
        z, n = self.args
        return n * cpow(z, n - 1) if argindex == 1 else self * clog(z)


class clog(sp.Function):
    """Principal logarithm of a complex number."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        return 1 / self.args[0]


class sinhc(sp.Function):
    """sinh(x)/x, even and smooth; 1 at x = 0."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        return sinhc_slope(self.args[0])


class sinhc_slope(sp.Function):
    """d/dx sinh(x)/x = (cosh x − sinh(x)/x)/x, accurate for small x, where it is x/3."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        x = self.args[0]
        return sinhc(x) - 2 * self / x


def powdiff(x: Any, y: Any, e: Any) -> Any:
    """(x^e − y^e)/e of positive x, y with the limit ln(x/y) at e = 0, smooth in e."""
    span = sp.log(x / y)
    return sp.sqrt(x * y) ** e * span * sinhc(e * span / 2)


class dahl_step(sp.Function):
    """Solution of du/dx = −u^b after x >= 0 from u >= 0: one step of the Dahl model (MRE paper, eq. 8).

    u e^(−x) for b = 1, else max(0, u^(1−b) + (b−1) x)^(1/(1−b)). Smooth in b through 1 in the form
    u exp(−w ln(1 + y)/y), w = x u^(b−1), y = (b−1) w, 0 where y <= −1. Stays at 0 (rounding gives u < 0: u).
    """

    nargs = 3

    def fdiff(self, argindex: int = 1) -> Any:
        return (dahl_step_u, dahl_step_x, dahl_step_b)[argindex - 1](*self.args)


class dahl_step_u(sp.Function):
    """∂ dahl_step/∂u = (dahl_step/u)^b = exp(−b w ln(1 + y)/y). Its own derivative is not offered."""

    nargs = 3


class dahl_step_x(sp.Function):
    """∂ dahl_step/∂x = −dahl_step^b. Its own derivative is not offered."""

    nargs = 3


class dahl_step_b(sp.Function):
    """∂ dahl_step/∂b = −dahl_step (w² g + w ln(u)/(1 + y)) with g = (1/(1 + y) − ln(1 + y)/y)/y.

    g = −1/2 at y = 0; the whole is 0 at u <= 0 and where y <= −1. Its own derivative is not offered.
    """

    nargs = 3


class bouc_wen_step(sp.Function):
    """Solution of dq/dx = 1 − c|q|ⁿ after x >= 0 from q, where c = 1 for q > 0 and 1 − 2σ for q < 0.

    A monotonic stroke of the Bouc–Wen model, −1 <= q <= 1, n >= 1, σ >= 1/2. The way from 0 to q, the
    integral of 1/(1 − c|q|ⁿ), is by Gauss's rule of 24 points with the pole at q = 1 taken out: to 1e-14 for
    n <= 2. The same way for every step, so parts of a stroke add up to the whole.
    """

    nargs = 4

    def fdiff(self, argindex: int = 1) -> Any:
        q, x, n, sigma = self.args
        return (
            bouc_wen_step_q(self, q, x, n, sigma),
            bouc_wen_step_x(self, n, sigma),
            bouc_wen_step_n(self, q, n, sigma),
            bouc_wen_step_sigma(self, q, n, sigma),
        )[argindex - 1]


class bouc_wen_step_q(sp.Function):
    """∂ step/∂q = (1 − c|step|ⁿ)/(1 − c|q|ⁿ) of (step, q, x, n, σ). Its own derivative is not offered."""

    nargs = 5


class bouc_wen_step_x(sp.Function):
    """∂ step/∂x = 1 − c|step|ⁿ of (step, n, σ). Its own derivative is not offered."""

    nargs = 3


class bouc_wen_step_n(sp.Function):
    """∂ step/∂n of (step, q, n, σ): −(1 − c|step|ⁿ) times the growth with n of the way. Its own is not
    offered."""

    nargs = 4


class bouc_wen_step_sigma(sp.Function):
    """∂ step/∂σ of (step, q, n, σ): −(1 − c|step|ⁿ) times the growth with σ of the way. Its own is not
    offered."""

    nargs = 4


COMPLEX_VALUED = (eddy_factor, eddy_deficit, powj, cpow, clog)
"""Functions whose value is complex whatever their arguments are."""
