"""Kernels that a fit needs and that never write the model's output: sums of squares, JᵀJ and Jᵀe."""

from __future__ import annotations

import re

from modelgen.codegen.kernels import Region, Stages
from modelgen.codegen.loops import SAYS, Kernel, indent, make_kernel, march


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
    lanes = not stages.program.model.states
    columns = len(stages.program.wrt)
    pairs = [(a, b) for a in range(columns) for b in range(a, columns)]
    size = len(pairs) + columns + 1

    def sums(r: Region) -> list[str]:
        at = "][l]" if lanes else "]"
        lines = _errors(r, measure)
        rows = range(len(r.values))
        nonzero = [[c for c in rows if r.jacobian[c][k] != "0.0"] for k in range(columns)]
        lines += [
            f"const double j{c}_{k} = weight[{c} * stride + i] * {r.jacobian[c][k]};"
            for k in range(columns)
            for c in nonzero[k]
        ]
        for m, (a, b) in enumerate(pairs):
            terms = [f"j{c}_{a} * j{c}_{b}" for c in nonzero[a] if c in nonzero[b]]
            lines += [f"sum[{m}{at} += {' + '.join(terms)};"] if terms else []
        for k in range(columns):
            terms = [f"j{c}_{k} * e{c}" for c in nonzero[k]]
            lines += [f"sum[{len(pairs) + k}{at} += {' + '.join(terms)};"] if terms else []
        return [*lines, f"sum[{size - 1}{at} += {' + '.join(f'e{c} * e{c}' for c in rows)};"]

    if lanes:
        lines = [
            f"double sum[{size}][MG_LANES] = {{ {{ 0.0 }} }};", *region.setup,
            *_lanes([*region.body, *sums(region)]),
            f"for (size_t k = 0; k < {size}; ++k) {{", "    double s = 0.0;",
            "    for (size_t l = 0; l < MG_LANES; ++l) {", "        s += sum[k][l];", "    }",
            "    normal[k] = s;", "}",
        ]  # fmt: skip
    else:
        lines = [f"double sum[{size}] = {{ 0.0 }};", *march(region, stages.initial(measure, True), sums),
                 f"for (size_t k = 0; k < {size}; ++k) {{", "    normal[k] = sum[k];", "}"]  # fmt: skip
    ends = ", const double *restrict data, const double *restrict weight, double *restrict normal"
    says = f"{SAYS[measure]}: J^T J (upper triangle by rows), J^T e and e^T e, e the weighted residual."
    return make_kernel(
        stages, prefix, f"normal_{measure}", says, "", ends, lines, region.operations + 2 * size
    )


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
