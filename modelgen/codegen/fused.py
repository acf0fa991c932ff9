"""Kernels that a fit needs and that never write the model's output: sums of squares, JᵀJ and Jᵀe."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from modelgen.codegen.kernels import Region, Stages
from modelgen.codegen.loops import (
    SAYS,
    Kernel,
    Stored,
    alone,
    indent,
    make_kernel,
    printed,
    tiles,
)
from modelgen.codegen.scan import over_time, scan_of
from modelgen.codegen.tape import TAPE

WRITTEN = 24
"""With more columns the products of any two are loops: written out they keep the compiler for minutes."""


def sumsq(stages: Stages, prefix: str, measure: str) -> Kernel:
    """Weighted sums of squares of many parameter sets."""
    region = stages.kernel(measure, False, "squares")
    parameters, columns = len(stages.parameters), len(stages.program.wrt)
    cost, over, adds = region.work, ["double lanes[MG_LANES] = { 0.0 };"], _squares_of_tile(stages)
    if stages.program.model.states:
        lines, cost = over_time(
            stages, measure, False, "squares", lambda r: [f"lanes[0] += {r.text(r.values[0], alone=True)};"],
            _square, adds,
        )  # fmt: skip
        over += [*(["double row[1][MG_TILE];"] if scan_of(stages) else []), *lines]
    elif stages.taped:
        over += [*region.setup, "double row[1][MG_TILE];", *tiles(region, _square(region), adds)]
    else:
        body = [*region.body, f"lanes[l] += {region.text(region.values[0], alone=True)};"]
        over += [*region.setup, *_lanes(body)]
    over += ["double sum = 0.0;", "for (size_t l = 0; l < MG_LANES; ++l) {", "    sum += lanes[l];", "}"]
    over = [re.sub(r"\bp\[", "q[", line) for line in over]
    free = [stages.parameters.index(w) for w in stages.program.wrt]
    lines = [
        f"double q[{parameters}];",
        f"for (size_t k = 0; k < {parameters}; ++k) {{", "    q[k] = p[k];", "}",
        "for (size_t set = 0; set < nset; ++set) {",
        indent([f"q[{k}] = theta[set * {columns} + {j}];" for j, k in enumerate(free)], 1),
        indent(over, 1),
        "    ssq[set] = sum;",
        "}",
    ]  # fmt: skip
    arrays = "".join(f", const double *restrict {a}" for a in ("theta", "data", "weight"))
    says = f"{SAYS[measure]}: weighted sum of squares of (model - data) for each of nset rows of theta."
    return make_kernel(
        stages, prefix, f"sumsq_{measure}", says, "const size_t nset, ", f"{arrays}, double *restrict ssq",
        lines, cost,
    )  # fmt: skip


def _square(r: Region) -> Stored:
    return [("row[0][l]", r.values[0])]


def _squares_of_tile(stages: Stages) -> list[str]:
    """What adds a tile's squares up."""
    if stages.taped:
        return ["mg_tape_sum(count, row[0], lanes);"]
    return _blocks(1, _over_lanes(["lanes[l] += row[0][b + l];"]))


def normal(stages: Stages, prefix: str, measure: str) -> Kernel:
    """JᵀJ (upper triangle by rows), Jᵀe and e·e without storing J."""
    region = stages.kernel(measure, True, "residuals")
    columns, cost = len(stages.program.wrt), region.work
    size = (columns + 1) * (columns + 2) // 2
    lines = [f"double sum[{size}][MG_LANES] = {{ {{ 0.0 }} }};"]
    scan = scan_of(stages)
    rows = Rows.of(region if scan is None else scan.shape(measure), columns)
    if stages.program.model.states:
        more, cost = over_time(
            stages, measure, True, "residuals", _products, _stores, _products_of_tile(stages, rows)
        )
        lines += [*([f"double row[{rows.many}][MG_TILE];"] if scan else []), *more]
    elif stages.taped:
        tape = tiles(region, _stores(region), _products_of_tile(stages, rows))
        lines += [*region.setup, f"double row[{rows.many}][MG_TILE];", *tape]
    else:
        lines += _two_blocks(region, rows)
    lines += [
        f"for (size_t k = 0; k < {size}; ++k) {{", "    double s = 0.0;",
        "    for (size_t l = 0; l < MG_LANES; ++l) {", "        s += sum[k][l];", "    }",
        "    normal[k] = s;", "}",
    ]  # fmt: skip
    ends = ", const double *restrict data, const double *restrict weight, double *restrict normal"
    says = f"{SAYS[measure]}: J^T J (upper triangle by rows), J^T e and e^T e, e the weighted residual."
    return make_kernel(stages, prefix, f"normal_{measure}", says, "", ends, lines, cost.plus(2 * size))


@dataclass(frozen=True)
class Rows:
    """Which rows of a tile hold the columns of (J, e) where these are not zero: (channel, row) of each."""

    columns: tuple[tuple[tuple[int, int], ...], ...]
    channels: int

    @classmethod
    def of(cls, region: Region, columns: int) -> Rows:
        channels, found, many = len(region.values), list[tuple[tuple[int, int], ...]](), 0
        some = [dict(region.columns(c)) for c in range(channels)]
        for k in range(columns):
            there = [c for c in range(channels) if k in some[c]]
            found.append(tuple((c, many + at) for at, c in enumerate(there)))
            many += len(there)
        return cls((*found, tuple((c, many + c) for c in range(channels))), channels)

    @property
    def many(self) -> int:
        return sum(map(len, self.columns))

    @property
    def full(self) -> bool:
        """Whether no derivative is zero everywhere."""
        return self.many == self.channels * len(self.columns)

    @property
    def products(self) -> list[tuple[int, list[tuple[int, int]]]]:
        """Which products add up to each entry: JᵀJ (upper triangle by rows), Jᵀe, e·e."""
        last = len(self.columns) - 1
        pairs = [(a, b) for a in range(last) for b in range(a, last)] + [(a, last) for a in range(last + 1)]
        terms = [[(x, y) for c, x in self.columns[a] for d, y in self.columns[b] if c == d] for a, b in pairs]
        return [(m, t) for m, t in enumerate(terms) if t]


def _nodes(region: Region) -> list[int]:
    """What goes into the rows, in order."""
    columns = range(len(region.jacobian[0]))
    some = [dict(region.columns(c)) for c in range(len(region.values))]
    return [*(x[k] for k in columns for x in some if k in x), *region.values]


def _stores(region: Region) -> Stored:
    return [(f"row[{k}][l]", at) for k, at in enumerate(_nodes(region))]


def _products(region: Region) -> list[str]:
    """One sample's products, summed where there are no lanes."""
    at = [region.text(x) for x in _nodes(region)]
    sums = Rows.of(region, len(region.jacobian[0])).products
    return [f"sum[{m}][0] += {' + '.join(f'{at[x]} * {at[y]}' for x, y in t)};" for m, t in sums]


def _products_of_tile(stages: Stages, rows: Rows) -> list[str]:
    """What adds a tile's products up."""
    if not stages.taped:
        return _blocks(rows.many, _tiled(rows))
    words = [str(w) for m, t in rows.products for w in (m, len(t), *(x for pair in t for x in pair))]
    return [
        f"{TAPE} mg_terms[] = {{ {', '.join(words)} }};",
        f"mg_tape_products(count, {rows.many}, MG_TILE, row[0], {len(rows.products)}, mg_terms, sum[0]);",
    ]


def _tiled(rows: Rows) -> list[str]:
    """Products of two blocks of MG_LANES samples from b on: a sum is loaded and stored once for both."""
    columns = len(rows.columns) - 1
    if columns > WRITTEN and rows.full:
        return _looped(columns, rows.channels)
    halves = ("b + l", "b + MG_LANES + l")
    return _over_lanes(
        f"sum[{m}][l] += {' + '.join(f'row[{x}][{h}] * row[{y}][{h}]' for h in halves for x, y in t)};"
        for m, t in rows.products
    )


def _over_lanes(body: Iterable[str]) -> list[str]:
    return ["for (size_t l = 0; l < MG_LANES; ++l) {", indent([*body], 1), "}"]


def _looped(columns: int, channels: int) -> list[str]:
    """The same with loops over pairs of columns, none of which is zero anywhere."""

    def products(left: str, right: str) -> list[str]:
        each = " + ".join(
            f"row[{left} * {channels} + {c}][{h}] * row[{right} * {channels} + {c}][{h}]"
            for h in ("b + l", "b + MG_LANES + l")
            for c in range(channels)
        )
        return [*_over_lanes([f"sum[at][l] += {each};"]), "++at;"]

    return [
        "size_t at = 0;",
        f"for (size_t lo = 0; lo < {columns}; ++lo) {{",
        f"    for (size_t hi = lo; hi < {columns}; ++hi) {{", indent(products("lo", "hi"), 2), "    }", "}",
        f"for (size_t lo = 0; lo <= {columns}; ++lo) {{", indent(products("lo", str(columns)), 1), "}",
    ]  # fmt: skip


def _blocks(rows: int, products: list[str]) -> list[str]:
    """`products` of all blocks of a tile; behind its last sample there is zero."""
    step = "2 * MG_LANES" if any("MG_LANES + l" in x for x in products) else "MG_LANES"
    return [
        "for (size_t l = count; l < MG_TILE && l % (2 * MG_LANES) != 0; ++l) {",
        *(f"    row[{k}][l] = 0.0;" for k in range(rows)),
        "}",
        f"for (size_t b = 0; b < count; b += {step}) {{",
        indent(products, 1),
        "}",
    ]


def _two_blocks(region: Region, rows: Rows) -> list[str]:
    """Rows of (J, e) for two blocks of MG_LANES samples, then their products."""
    return [
        *region.setup,
        "for (size_t base = 0; base < stride; base += 2 * MG_LANES) {",
        f"    double row[{rows.many}][2 * MG_LANES];",
        *(f"    {x}" for x in alone(region.body)),
        "    for (size_t l = 0; l < 2 * MG_LANES; ++l) {",
        "        const size_t i = base + l;",
        indent(printed(region, _stores(region)), 2),
        "    }",
        indent([x.replace("[b + ", "[") for x in _tiled(rows)], 1),
        "}",
    ]


def _lanes(body: Sequence[str]) -> list[str]:
    """A loop in blocks of MG_LANES, so that sums have one order on every machine and vectorise."""
    return [
        "for (size_t b = 0; b < stride; b += MG_LANES) {",
        "    for (size_t l = 0; l < MG_LANES; ++l) {",
        "        const size_t i = b + l;",
        indent(body, 2),
        "    }",
        "}",
    ]
