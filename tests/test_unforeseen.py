"""Truths that nobody had in mind: what they do to a recording, and that older draws are as they were."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.prove.plan import plan
from modelgen.truths import draw, drawing, gmm, impedance, unforeseen
from modelgen.truths.drawing import scene_of
from modelgen.truths.secret import DOMAINS, FORESEEN, Secret


def novel(domain):
    return {e for e in drawing.catalogue(domain) if e.startswith("novel:")}


def test_new_kinds_are_apart_from_those_in_mind_and_all_are_drawn():
    new = {*unforeseen.SWEEPS, *unforeseen.FORCE, *unforeseen.STIFFNESS}
    assert not new & set(FORESEEN)
    assert set().union(*map(novel, DOMAINS)) == new | set(FORESEEN)
    tasks = plan(400, 7)
    assert new | set(FORESEEN) == {t.effects[0] for t in tasks if t.kind == "novel"}
    assert tasks[:90] == plan(90, 7)


@pytest.mark.parametrize(
    ("domain", "effect"), [(d, e) for d in DOMAINS for e in sorted(novel(d) - set(FORESEEN))]
)
def test_the_same_seed_conceals_the_same_to_the_depth_that_is_asked_for(domain, effect):
    one, again = (draw(12, "novel", domain, effect, ratio=3.0) for _ in range(2))
    assert one == again
    assert one.ratio == pytest.approx(3.0, rel=0.02)


OLD = {
    "second_mode": (1.1535972081467223, 0.0036363401956189738),
    "mains_hum": (0.2922073759187107, 0.05985104388691646),
}


def test_what_is_drawn_of_older_kinds_stays():
    """Numbers of a draw before the new kinds were there: none of theirs is drawn in between."""
    secret = draw(4, "single", "impedance", "second_mode", ratio=3.0)
    told = (secret.strength["second_mode"]["at"], secret.strength["second_mode"]["size"])
    assert told == pytest.approx(OLD["second_mode"], rel=1e-6)
    hum = draw(4, "novel", "force", "novel:mains_hum", ratio=3.0).strength["novel:mains_hum"]
    assert (hum["fall"], hum["size"]) == pytest.approx(OLD["mains_hum"], rel=1e-6)


def test_a_line_echoes_at_regular_frequencies():
    x = np.linspace(0, 1, 2001)
    added = unforeseen.echo(x, {"size": 0.01, "trips": 5.0}).real
    tops = np.flatnonzero((added[1:-1] > added[:-2]) & (added[1:-1] > added[2:])) + 1
    np.testing.assert_allclose(x[tops], [0.2, 0.4, 0.6, 0.8], atol=1e-3)


def test_a_saturating_resonance_jumps_elsewhere_on_the_way_back():
    x, s = np.linspace(0.7, 1.6, 3001), {"q": 10.0, "bend": 5.0}
    up, down = unforeseen.ferroresonance(x, s), unforeseen.ferroresonance(x[::-1], s)[::-1]
    jumps = [float(x[np.argmax(np.abs(np.diff(y)))]) for y in (up, down)]
    assert jumps[0] > jumps[1] + 0.05
    assert min(up.real.min(), down.real.min()) > 0
    left = x - 1 / x < 0  # below resonance there is one branch alone
    np.testing.assert_allclose(up[left], down[left], atol=1e-9)
    weak = unforeseen.ferroresonance(x, s | {"bend": 1e-9})
    np.testing.assert_allclose(weak, 1 / (1 + 10j * (x - 1 / x)), atol=1e-6)


def test_a_heater_goes_on_and_off_without_a_step():
    t, form = np.linspace(0, 20, 20_001), {"size": 0.1, "period": 5.0, "duty": 0.4, "slow": 0.3, "phase": 0.2}
    gain = unforeseen.gain(t, {"novel:thermostat": form})
    assert gain.min() > 1 and gain.max() < 1.1
    assert np.abs(np.diff(gain)).max() < 1e-3
    np.testing.assert_allclose(gain[:15_000], gain[5000:20_000], atol=1e-9)


def test_a_winding_that_heats_is_not_shunted_with_the_inductance():
    """R(t) stands before the shorted turn, whatever it has become."""
    rng = np.random.default_rng(1)
    base = drawing.DRAWS["gmm"].draw_base(rng)
    setup = drawing.DRAWS["gmm"].draw_setup(rng, base, ("temperature_drift", "eddy_shunt"))
    secret = Secret("gmm", (), {}, base, "white", 1, setup=setup, levels={"Z_relative": 2e-4, "stated": 1.0})
    scene = scene_of(secret)
    heat = {"temperature_drift": {"size": 0.1, "law": "", "tau": 1.0}}
    shunt = {"eddy_shunt": {"size": 0.5, "law": "", "at": 0.1, "ratio": 0.1}}
    order = impedance.in_order(len(scene.f[0]), setup["sweeps"][0]["n"])
    more = base["R_0"] * (gmm._winding(2 * np.pi * scene.f[0], heat, scene.top, order) - 1)
    np.testing.assert_allclose(
        scene.simulate(heat | shunt)[0] - scene.simulate(shunt)[0], more, atol=1e-9 * np.abs(more).max()
    )
