"""What is left, described without a catalogue: which variables the remaining residual depends on, and at
which port."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from modelgen.diagnose.gate.in_frequency import in_frequency
from modelgen.diagnose.gate.in_time import ends, in_time
from modelgen.diagnose.gate.instrument import misread
from modelgen.diagnose.gate.leftover import NOTHING, Leftover
from modelgen.diagnose.gate.tables import together
from modelgen.diagnose.hypotheses.refit import Fit, enough
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.search.screen import Tangent
from modelgen.fit.whitener import Array


@dataclass(frozen=True, eq=False)
class Remains:
    """What the base and the best hypothesis leave: descriptions of each, one of each kind, made when they are
    first asked for.

    sensitivities: of models over frequency, port → d(output)/d(port quantity), complex.
    """

    setting: Setting
    outcome: Outcome
    sensitivities: Mapping[str, Array]

    @cached_property
    def of_base(self) -> list[Leftover]:
        return self._of(self.outcome.base)

    @cached_property
    def ends_of_base(self) -> list[Leftover]:
        """The ends of channels' ranges alone, over time."""
        return ends(self.setting.model, self.outcome.judge, self.outcome.base)

    @cached_property
    def of_best(self) -> list[Leftover]:
        return self._of(self.outcome.best) if self.outcome.best.hypothesis.added else self.of_base

    def likeliest(self, found: Sequence[Leftover]) -> Leftover:
        """The one that gains most; with a gain of 0 and empty words where none gains anything."""
        best = max(found, key=lambda x: x.gain, default=NOTHING)
        best = best if best.gain > 0 else replace(best, says="")
        model = self.setting.model
        if best.says or not model.is_time_model:
            return best
        # what follows no variable that is known is where the forces add up rather than in a channel
        names = [p.name for p in model.ports if p.kind == "force"]
        return replace(best, port=names[0] if len(names) == 1 else "")

    def _of(self, fit: Fit) -> list[Leftover]:
        """All under the noise as it is judged, colour included; of a handful of samples anything would do."""
        model, judge = self.setting.model, self.outcome.judge
        if model.is_time_model:
            return in_time(model, judge, fit) if enough(fit) else []
        if all(s.measure == "real" for s in fit.hypothesis.experiment.series):
            return [together(judge, fit)]
        terms = in_frequency(judge, fit, Tangent.of(*judge.tangent(fit)), self.sensitivities)
        return [*terms, misread(judge, fit)]


def misreading(found: Sequence[Leftover]) -> Leftover:
    """The error of how sweeps were taken among descriptions; nothing where there is none."""
    return next((x for x in found if x.weights), NOTHING)
