"""What is left, described without a catalogue: which variables the remaining residual depends on, and at
which port. All under the noise as it is judged, colour included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from modelgen.diagnose.gate.in_frequency import in_frequency
from modelgen.diagnose.gate.in_time import in_time
from modelgen.diagnose.gate.instrument import misread
from modelgen.diagnose.gate.leftover import Leftover
from modelgen.diagnose.gate.tables import together
from modelgen.diagnose.hypotheses.refit import Fit, Judge, enough
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.whitener import Array
from modelgen.language import Model


def leftover(model: Model, judge: Judge, fit: Fit, sensitivities: Mapping[str, Array]) -> Leftover:
    """Describe what the fit leaves. `sensitivities` (frequency models): port → d(output)/d(port quantity),
    complex.

    `gain` is 0 with empty words when no description gains anything.
    """
    return likeliest(model, descriptions(model, judge, fit, sensitivities))


def descriptions(model: Model, judge: Judge, fit: Fit, sensitivities: Mapping[str, Array]) -> list[Leftover]:
    """All that may describe what the fit leaves, one of each kind; of a handful of samples anything would."""
    if model.is_time_model:
        return in_time(model, judge, fit) if enough(fit) else []
    if all(s.measure == "real" for s in fit.hypothesis.experiment.series):
        return [together(judge, fit)]
    terms = in_frequency(judge, fit, Tangent.of(*judge.tangent(fit)), sensitivities)
    return [*terms, misread(judge, fit)]


def likeliest(model: Model, found: Sequence[Leftover]) -> Leftover:
    """The one that gains most."""
    best = max(found, key=lambda x: x.gain, default=Leftover(0.0, 0.0, "", ""))
    if best.says or not model.is_time_model:
        return best
    # what follows no variable that is known is where the forces add up rather than in a channel
    names = [p.name for p in model.ports if p.kind == "force"]
    return replace(best, port=names[0] if len(names) == 1 else "")
