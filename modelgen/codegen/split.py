"""Complex arithmetic as pairs of real nodes. A part that is known to be zero is None, so it costs nothing."""

from __future__ import annotations

import math

from modelgen.codegen.real import Graph

Pair = tuple[int | None, int | None]


class Complex:
    """Complex operations on a real graph."""

    def __init__(self, graph: Graph) -> None:
        self.g = graph

    def const(self, value: float) -> Pair:
        return (self.g.const(value) if value != 0 else None, None)

    def re(self, a: Pair) -> int:
        return self.g.const(0.0) if a[0] is None else a[0]

    def im(self, a: Pair) -> int:
        return self.g.const(0.0) if a[1] is None else a[1]

    def _tidy(self, re: int | None, im: int | None) -> Pair:
        return (
            None if re is None or self.g.value(re) == 0 else re,
            None if im is None or self.g.value(im) == 0 else im,
        )

    def _add(self, a: int | None, b: int | None) -> int | None:
        return b if a is None else a if b is None else self.g.binary("add", a, b)

    def _sub(self, a: int | None, b: int | None) -> int | None:
        if b is None:
            return a
        return self.g.unary("neg", b) if a is None else self.g.binary("sub", a, b)

    def _mul(self, a: int | None, b: int | None) -> int | None:
        return None if a is None or b is None else self.g.binary("mul", a, b)

    def add(self, a: Pair, b: Pair) -> Pair:
        return self._tidy(self._add(a[0], b[0]), self._add(a[1], b[1]))

    def sub(self, a: Pair, b: Pair) -> Pair:
        return self._tidy(self._sub(a[0], b[0]), self._sub(a[1], b[1]))

    def neg(self, a: Pair) -> Pair:
        return self.sub((None, None), a)

    def mul(self, a: Pair, b: Pair) -> Pair:
        if a == b and a[0] is not None and a[1] is not None:  # square: two products fewer
            cross = self.g.binary("mul", a[0], a[1])
            return self._tidy(
                self._sub(self._mul(a[0], a[0]), self._mul(a[1], a[1])), self._add(cross, cross)
            )
        return self._tidy(
            self._sub(self._mul(a[0], b[0]), self._mul(a[1], b[1])),
            self._add(self._mul(a[0], b[1]), self._mul(a[1], b[0])),
        )

    def inv(self, a: Pair) -> Pair:
        one = self.g.const(1.0)
        if a[1] is None:
            return (self.g.binary("div", one, self.re(a)), None)
        if a[0] is None:
            return (None, self.g.unary("neg", self.g.binary("div", one, a[1])))
        scale = self.g.binary("div", one, self.norm(a))
        return self._tidy(self._mul(a[0], scale), self._sub(None, self._mul(a[1], scale)))

    def div(self, a: Pair, b: Pair) -> Pair:
        if b[1] is None and a[1] is None:
            return self._tidy(None if a[0] is None else self.g.binary("div", a[0], self.re(b)), None)
        return self.mul(a, self.inv(b))

    def norm(self, a: Pair) -> int:
        """|a|²."""
        return self.re((self._add(self._mul(a[0], a[0]), self._mul(a[1], a[1])), None))

    def modulus(self, a: Pair) -> Pair:
        return (
            self.g.unary("fabs" if a[1] is None else "sqrt", self.re(a) if a[1] is None else self.norm(a)),
            None,
        )

    def argument(self, a: Pair) -> Pair:
        return (self.g.binary("atan2", self.im(a), self.re(a)), None)

    def exp(self, a: Pair) -> Pair:
        size = self.g.unary("exp", self.re(a))
        if a[1] is None:
            return (size, None)
        return self._tidy(
            self._mul(size, self.g.unary("cos", a[1])), self._mul(size, self.g.unary("sin", a[1]))
        )

    def log(self, a: Pair) -> Pair:
        half_log = self.g.binary("mul", self.g.const(0.5), self.g.unary("log", self.norm(a)))
        return self._tidy(half_log, self.g.binary("atan2", self.im(a), self.re(a)))

    def power(self, a: Pair, n: Pair) -> Pair:
        """Principal value of a^n; of a real n = 1/2 without an angle."""
        exponent = self.g.value(self.re(n)) if n[1] is None else None
        if exponent == 0.5:
            return self.sqrt(a)
        if exponent is not None and exponent == int(exponent) and 0 < abs(exponent) <= 8:
            product = base = a if exponent > 0 else self.inv(a)
            for _ in range(abs(int(exponent)) - 1):
                product = self.mul(product, base)
            return product
        return self.exp(self.mul(n, self.log(a)))

    def sqrt(self, a: Pair) -> Pair:
        """√a: its larger part √((|a| + |re|)/2), the other |im| over twice that: nothing cancels."""
        g, zero, size = self.g, self.g.const(0.0), self.re(self.modulus(a))
        half = g.binary("mul", g.const(0.5), g.binary("add", size, g.unary("fabs", self.re(a))))
        large = g.unary("sqrt", half)
        ratio = g.binary("div", g.unary("fabs", self.im(a)), g.binary("add", large, large))
        small = g.binary("ifz", g.binary("lt", zero, large), ratio)
        ahead = g.binary("le", zero, self.re(a))
        u, v = self._chosen(ahead, large, small), self._chosen(ahead, small, large)
        return self._tidy(u, self._chosen(g.binary("lt", self.im(a), zero), g.unary("neg", v), v))

    def _chosen(self, condition: int, a: int, b: int) -> int:
        """a where the condition, 0 or 1, holds, else b."""
        g = self.g
        return g.binary("add", g.binary("ifz", condition, a), g.binary("ifz", g.unary("not", condition), b))

    def jpow(self, w: Pair, n: Pair) -> Pair:
        """(j w)^n = w^n (cos(nπ/2) + j sin(nπ/2)) for real w > 0, real n."""
        size = self.g.unary("exp", self.g.binary("mul", self.re(n), self.g.unary("log", self.re(w))))
        angle = self.g.binary("mul", self.re(n), self.g.const(math.pi / 2))
        return self._tidy(
            self._mul(size, self.g.unary("cos", angle)), self._mul(size, self.g.unary("sin", angle))
        )

    def sinh_cosh(self, a: Pair) -> tuple[Pair, Pair]:
        g = self.g
        sh, ch = g.unary("sinh", self.re(a)), g.unary("cosh", self.re(a))
        if a[1] is None:
            return (sh, None), (ch, None)
        s, c = g.unary("sin", a[1]), g.unary("cos", a[1])
        return self._tidy(self._mul(sh, c), self._mul(ch, s)), self._tidy(self._mul(ch, c), self._mul(sh, s))

    def times_j(self, a: Pair) -> Pair:
        return self._tidy(self._sub(None, a[1]), a[0])

    def sin(self, a: Pair) -> Pair:
        sh, _ = self.sinh_cosh(self.times_j(a))
        return self.neg(self.times_j(sh))

    def cos(self, a: Pair) -> Pair:
        return self.sinh_cosh(self.times_j(a))[1]

    def tanh(self, a: Pair) -> Pair:
        """tanh (x + jy) = (sinh 2x + j sin 2y)/(cosh 2x + cos 2y), each times 2 e^(−2|x|): no overflow, and
        nothing cancels but at poles."""
        if a[1] is None:
            return (self.g.unary("tanh", self.re(a)), None)
        g, one = self.g, self.g.const(1.0)
        twice = g.binary("mul", g.const(-2.0), g.unary("fabs", self.re(a)))
        faded, angle = g.unary("exp", twice), g.binary("mul", g.const(2.0), a[1])
        double = g.binary("add", faded, faded)
        gone = g.unary("neg", g.unary("expm1", g.binary("add", twice, twice)))
        below = g.binary(
            "add",
            g.binary("add", one, g.binary("mul", faded, faded)),
            g.binary("mul", double, g.unary("cos", angle)),
        )
        x = g.binary("div", g.binary("mul", g.unary("sign", self.re(a)), gone), below)
        y = g.binary("div", g.binary("mul", double, g.unary("sin", angle)), below)
        return self._tidy(x, y)

    def tan(self, a: Pair) -> Pair:
        return self.neg(self.times_j(self.tanh(self.times_j(a))))
