"""Waves on a cable or in a pipe, told from effects that imitate them."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from coils import coil, verdict

from modelgen.diagnose.gate import unlisted
from modelgen.diagnose.gate.describe import SOURCE
from modelgen.diagnose.gate.resonant import CLOSED, OPEN, row
from modelgen.diagnose.hypotheses.evidence import Level
from modelgen.diagnose.hypotheses.setting import Outcome

Q = 12.0


@pytest.mark.parametrize("ends", [CLOSED, OPEN])
def test_waves_are_those_of_a_line_with_losses(ends: str) -> None:
    u = np.linspace(0.05, 20.0, 999)
    x = np.pi * u * (1 - 0.5j / Q)
    wave = -1j / np.tan(x) / 2 if ends == CLOSED else 1j * np.tan(x / 2) / 4
    found = row(u, Q, ends, False, 1j, np.exp)
    first = row(np.ones(1), Q, ends, False, 1j, np.exp)
    assert found == pytest.approx(wave * np.pi / Q)
    assert first == pytest.approx(1.0, rel=0.02)  # as high as a lone resonance
    assert np.all(found.real > 0)


def stub(f: Any) -> Any:
    """A moving coil with an open line across its terminals, a quarter of a wave at 5 kHz."""
    return 1 / (1 / coil(f) + 4e-4 * np.tanh(0.5j * np.pi * f / 5e3 * (1 - 0.5j / Q)))


@pytest.mark.slow
def test_a_line_across_the_terminals_is_no_resonator_that_hangs_on(tmp_path: Path) -> None:
    f = np.geomspace(10.0, 2e4, 80)
    v = verdict(tmp_path, f, stub(f))
    assert [e.id for e in v.effects] == ["unknown_electrical"]
    assert OPEN in v.effects[0].says
    assert v.after.fit_over_noise == pytest.approx(1.0, abs=0.2)


def a_fit(bic: float, *ids: str, source: str = "a book") -> Any:
    added = tuple(SimpleNamespace(effect=SimpleNamespace(source=source, common=1.0)) for _ in ids)
    white = (np.ones((2, 50)),)
    return SimpleNamespace(bic=bic, ids=ids, hypothesis=SimpleNamespace(added=added), white=white)


@pytest.mark.parametrize(("named", "claimed"), [(-40.0, False), (-5.0, True)])
def test_where_a_named_effect_was_refused_a_description_must_do_better(named: float, claimed: bool) -> None:
    base, row = a_fit(0.0), a_fit(-30.0, "unknown_electrical", source=SOURCE)
    judge = SimpleNamespace(prior=(Level(1.0),), temper=1.0)
    tried = (base, row, a_fit(named, "structural_damping"))
    outcome: Any = SimpleNamespace(base=base, best=base, tried=tried, judge=judge)
    assert (unlisted.cheaper(outcome) is not None) == claimed


@pytest.mark.parametrize(("pair", "chosen"), [(-60.0, 2), (-42.0, 1), (-35.0, 1)])
def test_two_named_effects_go_before_a_description_that_one_does_not_reach(pair: float, chosen: int) -> None:
    """The search had refused the second: a colour of the noise may be all of it. That no longer counts where
    one named effect leaves more than a row of resonances does."""
    base, row = a_fit(0.0), a_fit(-50.0, "unknown_electrical", source=SOURCE)
    one, two = a_fit(-40.0, "second_mode"), a_fit(pair, "inertia", "structural_damping")
    judge = SimpleNamespace(prior=(Level(1.0),), temper=1.0)
    outcome = Outcome(judge, base, one, (base, row, one, two), ())  # type: ignore[arg-type]
    assert len(unlisted.named_rather(outcome).best.ids) == chosen
