"""A meter that is not linear: what is left of sweeps is a factor that depends on |Z| alone.

A voltmeter that clips softly where |Z| is high damps a resonance as drag does, but by the same law in all
recordings and whatever the frequency: no law of any port does.
"""

from __future__ import annotations

import numpy as np

from modelgen.diagnose.gate.gains import gain_of
from modelgen.diagnose.gate.in_frequency import whitened
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge
from modelgen.diagnose.search.screen import Tangent

POWERS = (1, 2, 4, 8, 16)
"""Powers of |Z| over the greatest: Z (1 + Σ a_p |Z|^p)."""
SAYS = "a distortion of the meter: Z is off by a factor that depends on its modulus alone"


def distorted(judge: Judge, base: Fit) -> Leftover:
    """What real factors that depend on |Z| gain beside the base, at first order; 0 where there are none."""
    e = base.hypothesis.experiment
    series, ports = e.series, {p.name for p in e.model.ports}
    if any(s.measure != "complex" for s in series):
        return Leftover(0.0, 0.0, "", "")
    top = max(float(s.size.max()) for s in series)
    shapes = [(s.size[:, None] / top) ** np.array(POWERS) for s in series]
    columns = np.concatenate([s.reference[:, None] * x for s, x in zip(series, shapes, strict=True)])
    port = "electrical" if "electrical" in ports else min(ports, default="model")
    tangent = Tangent.of(*judge.tangent(base))
    gain, chi2, _ = gain_of(tangent, whitened(judge, series, columns), effective(base.white))
    return Leftover(gain, chi2, port, SAYS)
