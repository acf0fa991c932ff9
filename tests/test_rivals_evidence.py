"""Evidence of rival accounts: with unlike numbers of effects, and where errors of the motion decide."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from modelgen.diagnose.hypotheses.ranking import as_ranked
from modelgen.diagnose.hypotheses.setting import ALARM, Outcome
from modelgen.diagnose.noise import replica


def account(ids: str, bic: float) -> Any:
    """What the ranking asks of a fit."""
    return SimpleNamespace(ids=tuple(ids), bic=bic, chi2=100.0, parameters=5)


@pytest.mark.parametrize(
    ("extended", "behind"),
    [(-500.0, 20.0), (-470.0, 0.0), (None, 0.0)],
)
def test_what_any_law_leaves_a_second_effect_mends_beside_it(
    monkeypatch: pytest.MonkeyPatch, extended: float | None, behind: float
) -> None:
    """A mass and a delay, one claimed: that the delay does better with hysteresis beside it tells nothing, as
    the mass does still better with it."""
    mass, other = account("m", 0.0), account("dh", -480.0)
    tried = [mass, other] + ([] if extended is None else [account("mh", extended)])
    monkeypatch.setattr("modelgen.diagnose.hypotheses.ranking._alike", lambda *_: False)
    monkeypatch.setattr("modelgen.diagnose.hypotheses.ranking.replace", lambda f, bic: bic)
    ranked = as_ranked(cast(Outcome, SimpleNamespace(best=mass, tried=tried)), other)
    assert cast(float, ranked) == pytest.approx(behind)
    far = account("dk", 5.0)
    assert (
        cast(float, as_ranked(cast(Outcome, SimpleNamespace(best=mass, tried=[mass, far])), far)) == 5 + ALARM
    )


@pytest.mark.parametrize(
    ("here", "if_best", "if_rival", "taken"),
    [
        (30.0, [2184.0, 106.0, 263.0], [2163.0, 62.0, 221.0], 30.0),  # its lead is within what it scatters by
        (30.0, [205.0, 195.0, 210.0], [-90.0, -80.0, -85.0], 0.0),  # a rival that is there would lead
        (90.0, [95.0, 85.0, 90.0], [1.0, -2.0, 2.0], 0.0),  # it doesn't lead where the rival is there
        (20.0, [60.0, 62.0, 58.0], [18.0, 21.0, 22.0], 20.0),  # as much as if the rival were there
    ],
)
def test_a_lead_that_errors_of_the_motion_give_is_none(
    monkeypatch: pytest.MonkeyPatch, here: float, if_best: list[float], if_rival: list[float], taken: float
) -> None:
    monkeypatch.setattr(replica, "on", lambda h, series: series)
    judge = cast(Any, SimpleNamespace(fit=lambda series, starts: series))
    fit = cast(Any, SimpleNamespace(hypothesis=None, theta=None))
    monkeypatch.setattr(replica, "_ahead", lambda judge, best, rival: here if best is fit else best)
    lead = replica.unfair(judge, fit, fit, cast(Any, iter(if_best)), cast(Any, iter(if_rival)))
    assert lead == pytest.approx(taken, abs=0.5)
