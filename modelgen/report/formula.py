"""Names and formulas in HTML: k_D with a subscript, rho as ρ, powers raised. No LaTeX, no script."""

from __future__ import annotations

import re
from collections.abc import Sequence

from markupsafe import Markup, escape

from modelgen.report.words import name_of, short

_NAMES = (
    "alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau phi chi psi omega "
    "Delta Sigma Phi Psi Omega"
)
_GREEK = dict(zip(_NAMES.split(), "αβγδεζηθκλμνξπρστφχψωΔΣΦΨΩ", strict=True))
_TOKEN = re.compile(r"\*\*|[A-Za-z]\w*|\d+\.?\d*(?:[eE][-+]?\d+)?|\s+|.", re.S)


def symbol(name: str) -> Markup:
    """A parameter's name as it is printed in a paper; `F_0[sweep]` keeps the recording's name behind."""
    found = re.fullmatch(r"([A-Za-z]+)([^\[]*)(\[.*\])?", name, re.S)
    if not found:
        return escape(name)
    stem, index, where = found[1], found[2].strip("_").replace("_", ","), found[3] or ""
    known = stem in _GREEK
    if len(stem) > 2 and not known and not index:
        return Markup('<span class="sym">{}</span><small>{}</small>').format(stem, where)
    sub = ",".join(_GREEK.get(part, part) for part in index.split(","))
    below = Markup("<sub>{}</sub>").format(sub) if sub else Markup("")
    return Markup('<span class="sym"><i>{}</i>{}</span><small>{}</small>').format(
        _GREEK.get(stem, stem), below, where
    )


def formula(text: str, ids: Sequence[str] = ()) -> Markup:
    """A formula written in plain text (`**`, `*`, names) in HTML; prose passes unchanged.

    ids: effects whose parameters stand in it: semi_inductance_K is shown as K.
    """
    tokens = [_own(token, ids) for token in _TOKEN.findall(text.strip())]
    out, at = Markup(""), 0
    while at < len(tokens):
        piece, at = _piece(tokens, at)
        out += piece
    return out


def _own(name: str, ids: Sequence[str]) -> str:
    """A parameter's name without the effect's id; its first word is an index where there are several."""
    for k in ids:
        if name.startswith(f"{k}_"):
            short = name.removeprefix(f"{k}_")
            return short if len(ids) == 1 else f"{short}_{k.split('_')[0]}"
    return name


def sentence(text: str) -> Markup:
    """Prose with a capital letter, powers raised, figures as printed; semi_inductance is two words."""
    words = re.sub(r"\b[a-z]{3,}(?:_[a-z]{2,})+\b", lambda m: name_of(m[0]), text.strip())
    words = re.sub(r"(?<![\w.])\d+(?:\.\d+)?e[-+]?\d+\b", lambda m: short(float(m[0])), words)
    words = re.sub(r"^(?:a|[a-z]{2,})\b", lambda m: m[0][:1].upper() + m[0][1:], words)
    words += "." if words and words[-1] not in ".!?" else ""
    parts = re.split(r"(?:\*\*|\^)(\([^()\s]*\)|[-−]?[\w.]*\w)", words)
    sup = Markup("<sup>{}</sup>")
    return Markup("").join(sup.format(p.strip("()")) if k % 2 else p for k, p in enumerate(parts))


def _piece(tokens: list[str], at: int) -> tuple[Markup, int]:
    token = tokens[at]
    if token == "**":
        power, after = _exponent(tokens, at + 1)
        return Markup("<sup>{}</sup>").format(formula(power)), after
    if token == "*":
        return Markup("·"), at + 1
    if token == "-":
        return Markup("−" if at + 1 < len(tokens) and not tokens[at + 1].isalpha() else "-"), at + 1
    if re.match(r"\d", token) and len(token) > 6:
        return escape(short(float(token))), at + 1
    if re.match(r"[A-Za-z]", token) and _is_symbol(token) and not _is_article(tokens, at):
        return symbol(token), at + 1
    return escape(token), at + 1


def _is_symbol(word: str) -> bool:
    """Whether a word is a quantity and not prose: a single letter, a Greek name, or one with an index."""
    return word in _GREEK or len(word) == 1 or "_" in word


def _is_article(tokens: list[str], at: int) -> bool:
    """Whether an "a" or "A" stands before another word: "a force", not "a*M"."""
    return tokens[at] in "aA" and "".join(tokens[at + 1 : at + 3]).lstrip(" ").isalpha()


def _exponent(tokens: list[str], at: int) -> tuple[str, int]:
    """What stands after a power sign: one token with its sign, or what its brackets hold."""
    if at >= len(tokens):
        return "", at
    if tokens[at] == "-":
        rest, after = _exponent(tokens, at + 1)
        return "-" + rest, after
    if tokens[at] != "(":
        return tokens[at], at + 1
    depth, end = 0, at
    while end < len(tokens):
        depth += (tokens[end] == "(") - (tokens[end] == ")")
        end += 1
        if depth == 0:
            break
    return "".join(tokens[at + 1 : end - 1]), end
