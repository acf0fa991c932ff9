"""Kernels that a fit needs and that never write the model's output: sums of squares, JᵀJ and Jᵀe."""

from __future__ import annotations

import re
from collections.abc import Iterable

from modelgen.codegen.kernels import Region, Stages
from modelgen.codegen.loops import SAYS, Kernel, alone, indent, make_kernel
from modelgen.codegen.scan import over_time, scan_of

WRITTEN = 24
"""With more columns the products of any two are loops: written out they keep the compiler for minutes."""


def sumsq(stages: Stages, prefix: str, measure: str) -> Kernel:
    """Weighted sums of squares of many parameter sets."""
    region = stages.kernel(measure, False)
    parameters, columns = len(stages.parameters), len(stages.program.wrt)
    cost = region.work
    squares = " + ".join(f"e{c} * e{c}" for c in range(len(region.values)))
    total = ["double lanes[MG_LANES] = { 0.0 };"]
    if stages.program.model.states:
        lines, cost = over_time(
            stages, measure, False, lambda r: [*_errors(r, measure), f"lanes[0] += {squares};"],
            lambda r: [*_errors(r, measure), f"row[0][l] = {squares};"],
            _blocks(1, _over_lanes(["lanes[l] += row[0][b + l];"])),
        )  # fmt: skip
        total += [*(["double row[1][MG_TILE];"] if scan_of(stages) else []), *lines]
    else:
        body = [*region.body, *_errors(region, measure), f"lanes[l] += {squares};"]
        total += [*region.setup, *_lanes(body)]
    total += ["double sum = 0.0;", "for (size_t l = 0; l < MG_LANES; ++l) {", "    sum += lanes[l];", "}"]
    total = [re.sub(r"\bp\[", "q[", line) for line in total]
    free = [stages.parameters.index(w) for w in stages.program.wrt]
    lines = [
        f"double q[{parameters}];",
        f"for (size_t k = 0; k < {parameters}; ++k) {{", "    q[k] = p[k];", "}",
        "for (size_t set = 0; set < nset; ++set) {",
        indent([f"q[{k}] = theta[set * {columns} + {j}];" for j, k in enumerate(free)], 1),
        indent(total, 1),
        "    ssq[set] = sum;",
        "}",
    ]  # fmt: skip
    arrays = "".join(f", const double *restrict {a}" for a in ("theta", "data", "weight"))
    says = f"{SAYS[measure]}: weighted sum of squares of (model - data) for each of nset rows of theta."
    return make_kernel(
        stages, prefix, f"sumsq_{measure}", says, "const size_t nset, ", f"{arrays}, double *restrict ssq",
        lines, cost.plus(3 * len(region.values)),
    )  # fmt: skip


def normal(stages: Stages, prefix: str, measure: str) -> Kernel:
    """JᵀJ (upper triangle by rows), Jᵀe and e·e without storing J."""
    region = stages.kernel(measure, True)
    columns, cost = len(stages.program.wrt), region.work
    size = (columns + 1) * (columns + 2) // 2
    lines = [f"double sum[{size}][MG_LANES] = {{ {{ 0.0 }} }};"]
    if stages.program.model.states:
        scan = scan_of(stages)
        shape = region if scan is None else scan.shape(measure)
        more, cost = over_time(
            stages, measure, True, lambda r: [*_rows(r, measure), *_products(r)],
            lambda r: [*_rows(r, measure), *_stores(r)],
            _blocks(len(_names(shape)), _tiled(shape)),
        )  # fmt: skip
        lines += [*([f"double row[{len(_names(shape))}][MG_TILE];"] if scan else []), *more]
    else:
        lines += _tiles(region, measure)
    lines += [
        f"for (size_t k = 0; k < {size}; ++k) {{", "    double s = 0.0;",
        "    for (size_t l = 0; l < MG_LANES; ++l) {", "        s += sum[k][l];", "    }",
        "    normal[k] = s;", "}",
    ]  # fmt: skip
    ends = ", const double *restrict data, const double *restrict weight, double *restrict normal"
    says = f"{SAYS[measure]}: J^T J (upper triangle by rows), J^T e and e^T e, e the weighted residual."
    return make_kernel(stages, prefix, f"normal_{measure}", says, "", ends, lines, cost.plus(2 * size))


def _rows(region: Region, measure: str) -> list[str]:
    """Weighted residuals e0, e1, … and derivatives j0_0, … of one sample."""
    lines = _errors(region, measure)
    for c, row in enumerate(region.jacobian):
        nonzero = [(k, d) for k, d in enumerate(row) if d != "0.0"]
        lines += [f"const double j{c}_{k} = weight[{c} * stride + i] * {d};" for k, d in nonzero]
    return lines


def _places(region: Region) -> list[list[tuple[int, str]]]:
    """Of each column of (J, e): its (channel, name) where it is not zero."""
    channels, columns = range(len(region.values)), range(len(region.jacobian[0]))
    found = [[(c, f"j{c}_{k}") for c in channels if region.jacobian[c][k] != "0.0"] for k in columns]
    return [*found, [(c, f"e{c}") for c in channels]]


def _sums(region: Region) -> list[tuple[int, list[tuple[str, str]]]]:
    """Which products add up to each entry: JᵀJ (upper triangle by rows), Jᵀe, e·e."""
    places = _places(region)
    columns = len(places) - 1
    pairs = [(a, b) for a in range(columns) for b in range(a, columns)]
    pairs += [(a, columns) for a in range(columns + 1)]
    terms = [[(x, y) for c, x in places[a] for d, y in places[b] if c == d] for a, b in pairs]
    return [(m, t) for m, t in enumerate(terms) if t]


def _products(region: Region) -> list[str]:
    """One sample's products, summed where there are no lanes."""
    return [f"sum[{m}][0] += {' + '.join(f'{x} * {y}' for x, y in t)};" for m, t in _sums(region)]


def _names(region: Region) -> list[str]:
    return [x for column in _places(region) for _, x in column]


def _stores(region: Region) -> list[str]:
    return [f"row[{k}][l] = {x};" for k, x in enumerate(_names(region))]


def _tiled(region: Region) -> list[str]:
    """Products of two blocks of MG_LANES samples from b on: a sum is loaded and stored once for both."""
    columns, channels = len(region.jacobian[0]), len(region.values)
    if columns > WRITTEN and len(_names(region)) == channels * (columns + 1):
        return _looped(columns, channels)
    at = {x: f"row[{k}]" for k, x in enumerate(_names(region))}
    halves = ("b + l", "b + MG_LANES + l")
    return _over_lanes(
        f"sum[{m}][l] += {' + '.join(f'{at[x]}[{h}] * {at[y]}[{h}]' for h in halves for x, y in t)};"
        for m, t in _sums(region)
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


def _tiles(region: Region, measure: str) -> list[str]:
    """Rows of (J, e) for two blocks of MG_LANES samples, then their products."""
    return [
        *region.setup,
        "for (size_t base = 0; base < stride; base += 2 * MG_LANES) {",
        f"    double row[{len(_names(region))}][2 * MG_LANES];",
        *(f"    {x}" for x in alone(region.body)),
        "    for (size_t l = 0; l < 2 * MG_LANES; ++l) {",
        "        const size_t i = base + l;",
        indent([*region.body, *_rows(region, measure), *_stores(region)], 2),
        "    }",
        indent([x.replace("[b + ", "[") for x in _tiled(region)], 1),
        "}",
    ]


def _errors(region: Region, measure: str) -> list[str]:
    """Weighted residuals e0, e1, … of one sample."""
    lines = []
    for c, v in enumerate(region.values):
        difference = f"{v} - data[{c} * stride + i]"
        difference = f"mg_wrap({difference})" if measure == "phase" else f"({difference})"
        lines.append(f"const double e{c} = weight[{c} * stride + i] * {difference};")
    return lines


def _lanes(body: list[str]) -> list[str]:
    """A loop in blocks of MG_LANES, so that sums have one order on every machine and vectorise."""
    return [
        "for (size_t b = 0; b < stride; b += MG_LANES) {",
        "    for (size_t l = 0; l < MG_LANES; ++l) {",
        "        const size_t i = b + l;",
        indent(body, 2),
        "    }",
        "}",
    ]
