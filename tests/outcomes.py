"""What a diagnosis has found before it says so, for studies of the search itself."""

from __future__ import annotations

from collections.abc import Sequence

from modelgen.diagnose.diagnosis import _accounted, _prepared
from modelgen.diagnose.hypotheses.setting import Outcome, Setting
from modelgen.diagnose.noise.bridged import bridged
from modelgen.diagnose.noise.thin import thin
from modelgen.diagnose.whole_ports import whole
from modelgen.effects import Effect
from modelgen.language import Model
from modelgen.recordings import Case


def outcome_of(
    model: Model, case: Case, catalogue: Sequence[Effect], seed: int = 0
) -> tuple[Setting, Outcome]:
    """Setting and outcome without a verdict."""
    model = whole(model)
    made = _prepared(model, thin(model, bridged(model, case)[0]), seed)
    _, setting, outcome = _accounted(model, made, catalogue, seed)
    return setting, outcome
