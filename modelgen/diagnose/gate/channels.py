"""Which output a channel of a recording over time shows, and which port acts on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modelgen.codegen.lower import primary_outputs
from modelgen.fit.series import Series
from modelgen.language import Equation, Model, Port


def shown(model: Model, s: Series) -> list[str]:
    """The outputs that the channels of a recording are."""
    names = primary_outputs(model)
    return [names[k] for k in s.rows]


def one_channel(model: Model, s: Series, c: int) -> Series:
    """A recording of real values as if nothing but channel `c` had been recorded."""
    if len(s.rows) == 1:
        return s
    weight = np.atleast_2d(s.whitener.weight)
    whitener = replace(s.whitener, weight=weight[min(c, len(weight) - 1)][None])
    output = model[shown(model, s)[c]]
    unit = output.unit if isinstance(output, Equation) else s.unit
    return replace(s, data=s.data[c : c + 1], rows=(s.rows[c],), unit=unit, whitener=whitener)


def acts_on(model: Model, port: Port, output: str) -> bool:
    """Whether a port is that of an output, or of what its sensor reads."""
    read = model[output]
    return port.equation == output or (isinstance(read, Equation) and str(read.expr) == port.equation)


def port_at(model: Model, output: str, *kinds: str) -> str:
    """Name of the first port of one of `kinds`, in their order, that acts on `output`; "" without any."""
    for kind in kinds:
        for p in model.ports:
            if p.kind == kind and acts_on(model, p, output):
                return p.name
    return ""


def places(model: Model, series: Sequence[Series], kind: str) -> list[tuple[str, str]]:
    """(port, output) for each output that a port of `kind` acts on; the first port and output where that is
    none, the kind itself for a port where there is none of it."""
    outputs = list(dict.fromkeys(n for s in series for n in shown(model, s)))
    found = [(port, n) for n in outputs if (port := port_at(model, n, kind))]
    first = next((p.name for p in model.ports if p.kind == kind), kind)
    return found or [(first, outputs[0])]
