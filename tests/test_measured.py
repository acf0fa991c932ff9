"""Verdicts on measured recordings, as a physicist would have them; skipped where these are not beside the
repository."""

from pathlib import Path

import pytest

from modelgen.api import open_case
from modelgen.diagnose import diagnose
from modelgen.diagnose.verdict import Verdict

SHARED = Path(__file__).parents[2] / "shared" / "data"
pytestmark = pytest.mark.skipif(not SHARED.is_dir(), reason="no ../shared/data beside this repository")


def verdict_on(name: str) -> Verdict:
    model, case = open_case(SHARED / name / "case.toml")
    return diagnose(case, model)


def test_a_woofer_has_eddy_currents_and_creep() -> None:
    """Its L_e falls with frequency (Vanderkooy 1989), its suspension creeps (Knudsen and Jensen 1993); what
    is left is far more than noise, and no name of that is told."""
    verdict = verdict_on("loudspeaker_l16rnx")
    assert [f.family for f in verdict.effects] == ["eddy", "viscoelastic"]
    assert "semi_inductance" in (verdict.effects[0].id, *verdict.effects[0].equivalents)
    assert verdict.after.fit < 0.1 * verdict.before.fit
    asked = [f.separating_experiment for f in verdict.effects]
    assert all(x and "the same sweep" not in x for x in asked)  # it would be as far from all of them


@pytest.mark.slow
def test_a_stretched_acrylic_relaxes_over_decades_of_time() -> None:
    verdict = verdict_on("vhb4910_relaxation")
    assert [f.id for f in verdict.effects] == ["power_law_viscoelasticity"]


@pytest.mark.slow
def test_an_electronic_oscillator_has_a_mass_and_a_hardening_spring() -> None:
    """Built to obey m z̈ + d ż + (a + b z²) z = u (Wigren and Schoukens 2013)."""
    verdict = verdict_on("silverbox")
    assert {f.id for f in verdict.effects} == {"inertia", "cubic_stiffness"}


@pytest.mark.slow
def test_a_friction_damper_has_play() -> None:
    """Its authors built and modelled it as friction with backlash (Downey et al.)."""
    assert verdict_on("friction_damper_36lb").effects[0].id == "backlash"
