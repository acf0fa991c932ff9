"""Laws of fewer numbers that leave next to nothing of what they explain, and accounts that hang on a second
effect which may not be there."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from coils import write_sweep
from outcomes import outcome_of

import modelgen as mg
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.hypotheses.ranking import Standing, standings
from modelgen.effects import CATALOGUE
from modelgen.models import load
from modelgen.recordings import Case, Recording


def hung_on(folder: Path, joint: float) -> Verdict:
    """A coil in free air and with a known mass; 3 g more hang on a joint that resonates at `joint` [Hz]."""
    f = np.geomspace(10.0, 400.0, 150)
    rng, s = np.random.default_rng(5), 2j * np.pi * f
    text = 'model = "electrodynamic_transducer"\n[noise]\nZ_relative = 1e-3\n'
    for name, mass in (("free", 0.013), ("loaded", 0.026)):
        more = 3e-3 / (1 + (s / (2 * np.pi * joint)) ** 2)
        Z = 6 + 3e-4 * s + 36 / (1 + s * (mass + more) + 2e3 / s)
        noise = rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)
        write_sweep(folder / f"{name}.csv", f, Z * (1 + 1e-3 * noise))
        text += f'[[recording]]\nfile = "{name}.csv"\nconstants = {{ M_m = {mass} }}\n'
    (folder / "case.toml").write_text(text)
    model, case = mg.open_case(folder / "case.toml")
    return diagnose(case, model)


@pytest.mark.parametrize(("joint", "told"), [(800.0, False), (1500.0, True)])
def test_a_mass_on_a_joint_is_told_from_a_mass_where_the_joint_is_seen(
    tmp_path: Path, joint: float, told: bool
) -> None:
    """Far below its resonance all of 47 times the noise but a thousandth is a mass, and what is left of it no
    more than what other people's masses differ by: the joint is the better account, a mass is not
    excluded."""
    (effect,) = hung_on(tmp_path, joint).effects
    assert effect.id == "second_mode"
    assert ("inertia" in effect.equivalents) is told
    assert (effect.probability < 0.6) is told


@pytest.mark.slow
def test_a_second_effect_that_may_not_be_there_decides_nothing() -> None:
    """A mass on a spring and a dashpot makes a force early, as a displacement that is late does: a second
    effect which brings next to nothing leaves that open."""
    t = np.arange(0.0, 8.0, 2e-3)
    z = 2 * np.sin(2 * np.pi * (0.5 * t + 0.3 * t**2))
    v, a = np.gradient(z, t), np.gradient(np.gradient(z, t), t)
    noise = 0.3 * np.random.default_rng(1).standard_normal(t.size)
    F = 50 * z + 5.0 * v + 1e-3 * a + 0.03 * z**3
    record = Recording("chirp", None, "fit", {"t": t, "z": z}, {"F": F + noise})
    _, outcome = outcome_of(load("kelvin_voigt"), Case(None, "early", (record,)), CATALOGUE)
    single = [f for f in outcome.tried if len(f.ids) == 1]
    alone = min((f for f in single if f.ids == ("inertia",)), key=lambda f: f.bic)
    pair = next(f for f in outcome.tried if set(f.ids) == {"inertia", "cubic_stiffness"})

    def first(part: float) -> Standing:
        """Of the pair, were its other effect to bring this part of the evidence."""
        bic = alone.bic - part * (outcome.base.bic - alone.bic)
        best = replace(pair, bic=bic)
        return standings(replace(outcome, best=best, tried=(*single, best)))[0]

    assert first(0.01).addition.id == first(0.5).addition.id == "inertia"
    assert "sensor_delay" in first(0.01).equivalents and not first(0.5).equivalents
    assert first(0.01).probability < 0.9 < first(0.5).probability
