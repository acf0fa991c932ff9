"""Products of what is known before a loop, and their values in a finite field: what is equal to what.

Each symbol stands for a random element and j for a root of −1. Expressions that are equal as rational
functions have equal values; others do not, but for a chance of d/2⁶⁴ at degree d (Schwartz, Zippel 1979–80).
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import casadi as ca

FIELD = 2**64 - 2**32 + 1  # a prime, 1 mod 4, so that −1 has a root:
ROOT = 2**48
SAMPLE, FREE, STATE = 1, 2, 4

Powers = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Atom:
    """An expression that is not in the loop (`mask` FREE, SAMPLE or 0), and its value in the field.

    never_zero: it may be divided by where the paper does not.
    """

    sx: Any
    mark: int
    mask: int = 0
    never_zero: bool = False

    def __mul__(self, other: Atom) -> Atom:
        if self.mark == 1 or other.mark == 1:
            return other if self.mark == 1 else self
        safe = self.never_zero and other.never_zero
        return Atom(self.sx * other.sx, self.mark * other.mark % FIELD, self.mask | other.mask, safe)

    def __add__(self, other: Atom) -> Atom:
        return Atom(self.sx + other.sx, (self.mark + other.mark) % FIELD, self.mask | other.mask)

    def inverse(self) -> Atom:
        return self if self.mark == 1 else Atom(1 / self.sx, pow(self.mark, -1, FIELD), self.mask, True)


ONE = Atom(ca.SX(1), 1, never_zero=True)
MINUS = Atom(ca.SX(-1), FIELD - 1, never_zero=True)


@dataclass(frozen=True)
class Term:
    """One product: coefficient (parameters alone), sample (samples alone), powers of factors (both)."""

    coefficient: Atom
    sample: Atom = ONE
    powers: Powers = ()

    @property
    def key(self) -> tuple[int, Powers]:
        return self.sample.mark, self.powers

    def __mul__(self, other: Term) -> Term:
        powers = dict(self.powers)
        for f, n in other.powers:
            powers[f] = powers.get(f, 0) + n
        left = tuple(sorted((f, n) for f, n in powers.items() if n))
        return Term(self.coefficient * other.coefficient, self.sample * other.sample, left)

    def inverse(self) -> Term:
        return Term(self.coefficient.inverse(), self.sample.inverse(), tuple((f, -n) for f, n in self.powers))


Form = tuple[Term, ...]


def number_mark(value: float) -> int:
    if value != value or value in (float("inf"), float("-inf")):
        return random_mark(repr(value))
    top, bottom = float(value).as_integer_ratio()
    return top * pow(bottom, -1, FIELD) % FIELD


def random_mark(text: str) -> int:
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little") % (FIELD - 2) + 2
