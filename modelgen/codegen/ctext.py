"""Real graph nodes as C: one `const` variable a line, short single-use terms written where they are used."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field

from modelgen.codegen.real import Graph
from modelgen.language.write import free

INFIX = {"add": ("+", 6), "sub": ("-", 6), "mul": ("*", 7), "div": ("/", 7)}
RELATION = {"lt": "<", "le": "<=", "eq": "==", "ne": "!=", "and": "&&", "or": "||"}
FUNCTION = {"fmin": "mg_min", "fmax": "mg_max", "sign": "mg_sign"}
BRANCHLESS = FUNCTION | {f: f"mg_{f}" for f in ("exp", "log", "sin", "cos", "atan2")}
"""For loops that a compiler shall vectorise: templates/vector.h.j2."""
ATOM, LONGEST = 9, 72

RESERVED = frozenset((
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum",
    "extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return",
    "short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void",
    "volatile", "while", "n", "i", "b", "l", "k", "in", "p", "stride", "work", "out", "jac", "data",
    "weight", "acc", "theta", "nset", "ssq", "jtj", "jtr", "lanes", "step", "gamma", "y0", "y1", "yn", "j0",
    "j1", "jn", "exp", "log", "pow", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh",
    "tanh", "sqrt", "fabs", "floor", "ceil", "fmod", "hypot", "erf", "lgamma", "tgamma", "expm1", "log1p",
    "signgam", "time", "index", "div", "abs", "labs", "remove", "rename", "round", "trunc", "rint", "fmin",
    "fmax", "fma", "significand", "drem", "scalb", "main", "NULL", "EOF", "size_t", "NAN", "INFINITY",
    "nan", "inf", "q", "set", "sum", "normal", "x", "lo", "hi", "at", "newton", "inside", "next", "before",
    "sign", "residual", "slope", "cbrt", "exp2", "log2", "log10", "asinh", "acosh", "atanh", "erfc",
    "nearbyint", "fdim", "copysign", "isnan", "isinf", "isfinite", "signbit", "fpclassify", "HUGE_VAL",
    "errno", "linux", "unix", "asm", "state", "tangent", "status", "row",
))  # fmt: skip

_INTEGERS = r"(?:U?INT(?:_LEAST|_FAST)?(?:8|16|32|64)|U?INTMAX|U?INTPTR|PTRDIFF|SIZE|SIG_ATOMIC|W?CHAR|WINT)"
MACROS = re.compile(
    rf"(?:FLT|DBL|LDBL)_[A-Z0-9_]+|DECIMAL_DIG|{_INTEGERS}_(?:MIN|MAX|C)|FP_(?:NAN|INFINITE|ZERO|SUBNORMAL|NORMAL|"
    r"FAST_FMA[FL]?|ILOGB0|ILOGBNAN)|HUGE_VAL[FL]|MATH_ERRNO|MATH_ERREXCEPT|math_errhandling|MAXFLOAT|"
    r"M_(?:E|LN2|LN10|LOG2E|LOG10E|PI|PI_2|PI_4|1_PI|2_PI|2_SQRTPI|SQRT2|SQRT1_2|"
    r"3PI_4|TWOPI|SQRTPI|SQRT3|LN2LO|LN2HI|LOG2_E|INVLN2|IVLN10)|"  # Newlib's own
    r"BUFSIZ|FILENAME_MAX|FOPEN_MAX|L_tmpnam|TMP_MAX|SEEK_(?:SET|CUR|END)|std(?:in|out|err)|"
    r"EXIT_SUCCESS|EXIT_FAILURE|RAND_MAX|MB_CUR_MAX|EXPORT"
)
"""Of <float.h>, <math.h>, <stdint.h>, <stdio.h>, <stdlib.h>, and of the C of a co-simulation unit: replaced
wherever they stand, in a struct as well."""

# what the templates and the printer name themselves
_OURS = re.compile(r"mg_.*|MG_.*|solve_.*|residual_.*|_.*|[est]\d+|j\d+_\d+|.*_next")


def c_name(name: str) -> str:
    """A name of the model as a C identifier that takes nothing over; different names stay different."""
    base = name.rstrip("_")
    ours = base in RESERVED or MACROS.fullmatch(base) or _OURS.fullmatch(base)
    return f"{name}_" if ours else name


def number(value: float) -> str:
    """A double as a C literal that reads back exactly."""
    if value != value:
        return "NAN"
    if value in (float("inf"), float("-inf")):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    text = repr(value)
    text = text if any(ch in text for ch in ".en") else text + ".0"
    return text if value >= 0 else f"({text})"


@dataclass
class Printer:
    """Prints nodes of one graph. `names` holds what is defined already: node → C expression; `called` the
    names that nodes shall get."""

    graph: Graph
    names: dict[int, str] = field(default_factory=dict)
    functions: Mapping[str, str] = field(default_factory=lambda: FUNCTION)
    called: Mapping[int, str] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)
    comments: set[str] = field(default_factory=set)

    def lines(self, ids: Iterable[int], roots: Iterable[int], named: Container[int] = ()) -> list[str]:
        """Declarations of `ids` (in order) that `roots` or each other need; roots get a name or stay
        inline, `named` always get one."""
        ids = [at for at in sorted(set(ids)) if at not in self.names and self.graph.nodes[at].op != "const"]
        uses = self._uses(ids, roots)
        out = []
        for at in ids:
            node = self.graph.nodes[at]
            text, _ = self._expression(at)
            label = self.graph.labels.get(at)
            is_pair = node.op == "call" and (at in self._pair_calls())
            if (
                not label
                and at not in named
                and at not in self.called
                and not is_pair
                and (node.op in ("re", "im") or (uses.get(at, 0) <= 1 and len(text) <= LONGEST))
            ):
                continue
            known = self.called.get(at) or (c_name(label[0]) if label else f"t{at}")
            name = self.fresh(known)
            says = label[1] if label and label[1] not in self.comments else ""
            remark = f"  /* {comment(says)} */" if says else ""
            if label:
                self.comments.add(label[1])
            out.append(f"const {'mg_complex' if is_pair else 'double'} {name} = {text};{remark}")
            self.names[at] = name
        return out

    def whole(self, at: int) -> str:
        """C expression of a node, as it stands alone."""
        return self._expression(at)[0]

    def value(self, at: int) -> str:
        """C expression of a node (an atom or in parentheses)."""
        text, level = self._expression(at)
        return text if level >= ATOM else f"({text})"

    def _pair_calls(self) -> set[int]:
        if not hasattr(self, "_pairs"):
            self._pairs = {n.args[0] for n in self.graph.nodes if n.op in ("re", "im")}
        return self._pairs

    def _uses(self, ids: list[int], roots: Iterable[int]) -> dict[int, int]:
        uses: dict[int, int] = {}
        for at in ids:
            for a in self.graph.nodes[at].args:
                uses[a] = uses.get(a, 0) + 1
        for r in roots:
            uses[r] = uses.get(r, 0) + 1
        return uses

    def fresh(self, name: str) -> str:
        """`name`, or one like it that the function has not yet."""
        return free(name, self.taken)

    def _expression(self, at: int) -> tuple[str, int]:
        """(C text, precedence) of a node."""
        if at in self.names:
            return self.names[at], ATOM
        node = self.graph.nodes[at]
        if node.op == "const":
            return number(float(node.data)), ATOM
        if node.op == "in":
            raise KeyError(f"input '{node.data}' has no place")
        if node.op in INFIX:
            sign, level = INFIX[node.op]
            a, la = self._expression(node.args[0])
            b, lb = self._expression(node.args[1])
            left = a if la >= level else f"({a})"
            right = b if lb > level else f"({b})"
            return f"{left} {sign} {right}", level
        if node.op == "neg":
            a, la = self._expression(node.args[0])
            return f"-{a}" if la >= ATOM else f"-({a})", 8
        if node.op == "sel":
            a, b = self.value(node.args[1]), self.value(node.args[2])
            return f"{self._truth(node.args[0])} ? {a} : {b}", 2
        if node.op == "ifz":
            return f"{self._truth(node.args[0])} ? {self.value(node.args[1])} : 0.0", 2
        if node.op in RELATION or node.op == "not":
            return f"{self._truth(at)} ? 1.0 : 0.0", 2
        if node.op in ("re", "im"):
            return f"{self.value(node.args[0])}.{node.op}", ATOM
        function = str(node.data) if node.op == "call" else self.functions.get(node.op, node.op)
        return f"{function}({', '.join(self._expression(a)[0] for a in node.args)})", ATOM

    def _truth(self, at: int) -> str:
        """C condition of a node, in parentheses."""
        node = self.graph.nodes[at]
        if at not in self.names:
            if node.op == "not":
                return f"(!{self._truth(node.args[0])})"
            if node.op in ("and", "or"):
                return f"({self._truth(node.args[0])} {RELATION[node.op]} {self._truth(node.args[1])})"
            if node.op in RELATION:
                return f"({self.value(node.args[0])} {RELATION[node.op]} {self.value(node.args[1])})"
        return f"({self.value(at)} != 0.0)"


_SIGNS = {"−": "-", "–": "-", "·": "*", "×": "x", "±": "+-", "′": "'", "µ": "u", "°": "deg", "…": "..."}
_MICRO = re.compile("μ(?=[A-Za-z])")  # before a unit; elsewhere it is the letter
_LETTERS = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigma sigma tau "
    "upsilon phi chi psi omega"
)
_GREEK = dict(zip("αβγδεζηθικλμνξοπρςστυφχψω", _LETTERS.split(), strict=True))
_WORDS = {"√": "sqrt"} | _GREEK | {letter.upper(): word.capitalize() for letter, word in _GREEK.items()}
_RAISED = re.compile("[⁰¹²³⁴-⁹ⁿ⁻]+")


def comment(text: str) -> str:
    """Text for a C comment: basic characters, which any compiler reads, and nothing that could end the
    comment.

    Greek letters are spelt out, apart from letters beside them: "jωL" becomes "j omega L".
    """
    text = _RAISED.sub(lambda m: f"^{unicodedata.normalize('NFKD', m[0])}", _MICRO.sub("u", text))
    text = "".join(_SIGNS.get(ch, ch) for ch in re.sub(f"[{''.join(_WORDS)}]", _spelt, text))
    text = unicodedata.normalize("NFD", " ".join(text.split()))
    text = "".join(ch for ch in text if not unicodedata.combining(ch)).replace("\\", "/")
    text = text.encode("ascii", "replace").decode()
    return text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")


def _spelt(sign: re.Match[str]) -> str:
    """A Greek letter or a root as a word, with a blank where a letter or a number stands beside it."""
    before, after = sign.string[: sign.start()][-1:], sign.string[sign.end() :][:1]
    return " " * before.isalnum() + _WORDS[sign[0]] + " " * after.isalpha()
