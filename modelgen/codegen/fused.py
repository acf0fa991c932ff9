"""Kernels that a fit needs and that never write the model's output: sums of squares, JᵀJ and Jᵀe."""

from __future__ import annotations

import re

from modelgen.codegen.kernels import Region, Stages
from modelgen.codegen.loops import SAYS, Kernel, alone, indent, make_kernel, march


def sumsq(stages: Stages, prefix: str, measure: str) -> Kernel:
    region = stages.kernel(measure, False)
    parameters, columns = len(stages.parameters), len(stages.program.wrt)
    squares = " + ".join(f"e{c} * e{c}" for c in range(len(region.values)))
    if stages.program.model.states:
        total = [
            "double sum = 0.0;",
            *march(
                region, stages.initial(measure, False), lambda r: [*_errors(r, measure), f"sum += {squares};"]
            ),
        ]
    else:
        total = [
            "double lanes[MG_LANES] = { 0.0 };", *region.setup,
            *_lanes([*region.body, *_errors(region, measure), f"lanes[l] += {squares};"]),
            "double sum = 0.0;", "for (size_t l = 0; l < MG_LANES; ++l) {", "    sum += lanes[l];", "}",
        ]  # fmt: skip
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
    ends = (
        "".join(f", const double *restrict {a}" for a in ("theta", "data", "weight"))
        + ", double *restrict ssq"
    )
    says = f"{SAYS[measure]}: weighted sum of squares of (model - data) for each of nset rows of theta."
    return make_kernel(
        stages,
        prefix,
        f"sumsq_{measure}",
        says,
        "const size_t nset, ",
        ends,
        lines,
        region.operations + 3 * len(region.values),
    )


def normal(stages: Stages, prefix: str, measure: str) -> Kernel:
    """JᵀJ (upper triangle by rows), Jᵀe and e·e without storing J."""
    region = stages.kernel(measure, True)
    columns = len(stages.program.wrt)
    size = (columns + 1) * (columns + 2) // 2
    if stages.program.model.states:
        first = stages.initial(measure, True)
        lines = [f"double sum[{size}] = {{ 0.0 }};",
                 *march(region, first, lambda r: [*_rows(r, measure), *_products(r)]),
                 f"for (size_t k = 0; k < {size}; ++k) {{", "    normal[k] = sum[k];", "}"]  # fmt: skip
    else:
        lines = _tiles(region, measure, size)
    ends = ", const double *restrict data, const double *restrict weight, double *restrict normal"
    says = f"{SAYS[measure]}: J^T J (upper triangle by rows), J^T e and e^T e, e the weighted residual."
    return make_kernel(
        stages, prefix, f"normal_{measure}", says, "", ends, lines, region.operations + 2 * size
    )


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
    return [f"sum[{m}] += {' + '.join(f'{x} * {y}' for x, y in t)};" for m, t in _sums(region)]


def _tiles(region: Region, measure: str, size: int) -> list[str]:
    """Rows of (J, e) for two blocks of MG_LANES samples, then their products: a sum is loaded and stored once
    for both."""
    names = [x for column in _places(region) for _, x in column]
    at = {x: f"row[{k}]" for k, x in enumerate(names)}
    products = [
        f"sum[{m}][l] += " + " + ".join(
            f"{at[x]}[{here}] * {at[y]}[{here}]" for here in ("l", "MG_LANES + l") for x, y in t
        ) + ";"
        for m, t in _sums(region)
    ]  # fmt: skip
    return [
        f"double sum[{size}][MG_LANES] = {{ {{ 0.0 }} }};", *region.setup,
        "for (size_t b = 0; b < stride; b += 2 * MG_LANES) {",
        f"    double row[{len(names)}][2 * MG_LANES];",
        *(f"    {x}" for x in alone(region.body)),
        "    for (size_t l = 0; l < 2 * MG_LANES; ++l) {",
        "        const size_t i = b + l;",
        indent([*region.body, *_rows(region, measure)], 2),
        *(f"        {at[x]}[l] = {x};" for x in names),
        "    }",
        "    for (size_t l = 0; l < MG_LANES; ++l) {",
        indent(products, 2),
        "    }",
        "}",
        f"for (size_t k = 0; k < {size}; ++k) {{", "    double s = 0.0;",
        "    for (size_t l = 0; l < MG_LANES; ++l) {", "        s += sum[k][l];", "    }",
        "    normal[k] = s;", "}",
    ]  # fmt: skip


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
