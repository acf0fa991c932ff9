"""Truths that nobody had in mind, and those looked at since: what they do to a recording, and that older
draws are as they were."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.prove.plan import plan
from modelgen.truths import draw, drawing, gmm, impedance, once_unforeseen, stiffness, unforeseen
from modelgen.truths.drawing import scene_of
from modelgen.truths.secret import DOMAINS, FORESEEN, Secret

LOOKED_AT, NEW = ({*m.SWEEPS, *m.FORCE, *m.STIFFNESS} for m in (once_unforeseen, unforeseen))


def novel(domain):
    return {e for e in drawing.catalogue(domain) if e.startswith("novel:")}


def test_new_kinds_are_apart_from_those_in_mind_and_all_are_drawn():
    assert len(NEW) == 7 and not NEW & set(FORESEEN)
    assert set(FORESEEN) > LOOKED_AT and list(FORESEEN) == sorted(FORESEEN)
    assert set().union(*map(novel, DOMAINS)) == NEW | set(FORESEEN)
    tasks = plan(400, 7)
    assert NEW | set(FORESEEN) == {t.effects[0] for t in tasks if t.kind == "novel"}
    assert tasks[:90] == plan(90, 7)


@pytest.mark.parametrize(
    ("domain", "effect"), [(d, e) for d in DOMAINS for e in sorted(novel(d) & (LOOKED_AT | NEW))]
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
    added = once_unforeseen.echo(x, {"size": 0.01, "trips": 5.0}).real
    tops = np.flatnonzero((added[1:-1] > added[:-2]) & (added[1:-1] > added[2:])) + 1
    np.testing.assert_allclose(x[tops], [0.2, 0.4, 0.6, 0.8], atol=1e-3)


def test_a_saturating_resonance_jumps_elsewhere_on_the_way_back():
    x, s = np.linspace(0.7, 1.6, 3001), {"q": 10.0, "bend": 5.0}
    up, down = once_unforeseen.ferroresonance(x, s), once_unforeseen.ferroresonance(x[::-1], s)[::-1]
    jumps = [float(x[np.argmax(np.abs(np.diff(y)))]) for y in (up, down)]
    assert jumps[0] > jumps[1] + 0.05
    assert min(up.real.min(), down.real.min()) > 0
    left = x - 1 / x < 0  # below resonance there is one branch alone
    np.testing.assert_allclose(up[left], down[left], atol=1e-9)
    weak = once_unforeseen.ferroresonance(x, s | {"bend": 1e-9})
    np.testing.assert_allclose(weak, 1 / (1 + 10j * (x - 1 / x)), atol=1e-6)


def test_a_heater_goes_on_and_off_without_a_step():
    t, form = np.linspace(0, 20, 20_001), {"size": 0.1, "period": 5.0, "duty": 0.4, "slow": 0.3, "phase": 0.2}
    gain = once_unforeseen.gain(t, {"novel:thermostat": form})
    assert gain.min() > 1 and gain.max() < 1.1
    assert np.abs(np.diff(gain)).max() < 1e-3
    np.testing.assert_allclose(gain[:15_000], gain[5000:20_000], atol=1e-9)


def test_a_feeble_oscillator_is_pulled_by_reactance_alone():
    w = np.array([1.0, 10.0, 100.0])
    form = {"novel:pulled_oscillator": {"size": 0.01}}
    np.testing.assert_array_equal(once_unforeseen.pulled(lambda w: 5 + 0j * w, w, form), 5)
    coil = once_unforeseen.pulled(lambda w: 1j * w, w, form)
    np.testing.assert_allclose(coil, 1.01j * w)
    np.testing.assert_allclose(once_unforeseen.pulled(lambda w: 1 / (1j * w), w, form), 1 / (0.99j * w))


def test_a_logarithmic_detector_errs_by_magnitude_alone_and_alike_in_each_stage():
    Z, form = np.exp(np.linspace(0, 2, 50) + 1j), {"size": 0.1, "stage": 0.5, "phase": 1.0}
    told = once_unforeseen.detected(Z, {"novel:log_ripple": form}, 1.0) / Z
    np.testing.assert_allclose(told.imag, 0, atol=1e-12)
    assert 0.9 < told.real.min() < 0.91 and 1.10 < told.real.max() < np.exp(0.1)
    next_stage = once_unforeseen.detected(Z * np.exp(0.5 - 2j), {"novel:log_ripple": form}, 1.0)
    np.testing.assert_allclose(next_stage / (Z * np.exp(0.5 - 2j)), told)


def test_a_chain_without_end_is_as_it_was_with_one_more_bead():
    x = np.linspace(0.01, 3, 301)
    Z = unforeseen.chain(x)
    np.testing.assert_allclose(2j * x + 1 / (1 / Z + 2j * x), Z, atol=1e-9)
    assert (Z.real[x < 1] > 0).all() and not Z.real[x > 1].any()
    assert abs(unforeseen.chain(np.array([50.0]))[0] - 100j) > 90  # the first bead alone moves: 2 j x


def test_sidebands_show_what_bends_with_frequency_alone_and_a_resonance_at_either_side():
    """A resistor and a coil are the mean of their own at both sidebands, even where one is below zero."""
    w, form = (
        2 * np.pi * np.linspace(10, 2000, 1991),
        {"novel:rippling_supply": {"size": 0.4, "ripple": 150.0}},
    )
    np.testing.assert_allclose(unforeseen.rippled(lambda w: 5 + 3j * w, w, form), 5 + 3j * w, atol=1e-2)

    def resonance(w):
        return 1 / (1 + 100j * (w / 6000 - 6000 / w))

    added = np.abs(unforeseen.rippled(resonance, w, form) * 1.08 - resonance(w))
    tops = np.flatnonzero((added[1:-1] > added[:-2]) & (added[1:-1] > added[2:])) + 1
    away = w[tops[np.argsort(added[tops])[-2:]]] / (2 * np.pi) - 6000 / (2 * np.pi)
    np.testing.assert_allclose(sorted(away), [-150, 150], atol=1)
    np.testing.assert_allclose(added[tops].max(), 0.04, rtol=0.05)


def test_a_loose_mass_lies_still_below_g_and_no_force_lifts_it_for_long_above():
    """Against its flight in steps of time: its weight is carried on average, and what it takes up is lost."""
    unit = np.array([0.3, 0.99])
    np.testing.assert_allclose(unforeseen.carried(unit), 1)
    for flight in (1.0, 3.0, 6.0):
        (shaken,), (N,) = unforeseen.hop(np.array([flight]))
        left, n = np.arcsin(1 / shaken), 200_000
        a = left + 2 * np.pi * (np.arange(n) + 0.5) / n
        down, speed = a > left + flight, shaken * np.cos(left)
        blow = shaken * np.cos(left + flight) - (speed - flight)
        held = np.where(down, 1 - shaken * np.sin(a), 0)
        assert held.min() > -1e-9 and held.mean() * 2 * np.pi + blow == pytest.approx(2 * np.pi, rel=1e-4)
        height = 1 + speed * flight - flight**2 / 2
        assert height == pytest.approx(shaken * np.sin(left + flight), abs=1e-9)
        # over a cycle the floor gives π shaken² |Im N| of the mass's (g/ω)²: what the landing takes
        assert -np.pi * shaken**2 * N.imag == pytest.approx(blow**2 / 2, rel=1e-9)
    edge = np.sqrt(1 + np.pi**2)
    before, after = unforeseen.carried(edge * np.array([1 - 1e-9, 1 + 1e-9]))
    assert before == pytest.approx(after, abs=1e-6)
    assert -np.pi * 100 * unforeseen.carried(np.array([10.0]))[0].imag == pytest.approx(2 * np.pi**2)


def test_a_loose_mass_shows_where_it_is_shaken_alone():
    x = np.geomspace(0.1, 10, 200)
    Z = 0.1 + 1j * (x - 1 / x)
    form = {"size": 0.05, "peak": 4.0}
    moved = unforeseen.hopped(7 * Z, x, 7.0, {"novel:hopping_grain": form}) / 7
    shaken = 4 * (x / np.abs(Z)) / (x / np.abs(Z)).max()
    np.testing.assert_allclose(moved[shaken < 0.99], Z[shaken < 0.99], atol=1e-12)
    assert (np.abs(moved - Z)[shaken > 1.2] > 1e-3 * x[shaken > 1.2]).all() and (
        moved.real >= 0.1 - 1e-12
    ).all()


def test_a_dome_snaps_over_and_back_at_places_of_its_own_whatever_the_rate():
    s = {"over": 0.4, "width": 0.5}
    x = np.array([0.0, 0.3, 0.41, 0.0, -0.09, -0.11, 0.0, 0.39, 0.5])
    np.testing.assert_array_equal(unforeseen.snapped(x, s), [0, 0, 1, 1, 1, 0, 0, 0, 1])
    np.testing.assert_array_equal(
        unforeseen.snapped(np.repeat(x, 3), s), np.repeat(unforeseen.snapped(x, s), 3)
    )


def test_a_fixture_is_silent_up_to_a_reversal_and_rings_down_after_it():
    dt, s = 1e-3, {"rings": 20.0, "tau": 0.1}
    v = np.cos(2 * np.pi * (np.arange(1200) + 0.5) * dt * 0.5)  # one reversal, at 0.5 s
    rung = unforeseen.ringing(v, dt, s)
    assert not rung[:500].any()
    period = round(1 / s["rings"] / dt)
    np.testing.assert_allclose(rung[550:1100], rung[500:1050] * np.exp(-period * dt / s["tau"]), atol=1e-9)
    np.testing.assert_allclose(unforeseen.ringing(-v, dt, s), -rung)


def test_a_detector_follows_up_at_once_and_leaks_no_faster_than_it_can():
    t = np.linspace(0, 3, 3001)
    F = 2 + np.sin(2 * np.pi * t)
    low = F.min()
    told = unforeseen.detected(t, F, {"novel:leaky_detector": {"size": 0.3}})
    assert (told >= F - 1e-9).all() and told.max() == pytest.approx(3.0)
    rises = np.diff(told) > 1e-9
    np.testing.assert_allclose(told[1:][rises], F[1:][rises])
    left, floor = told - low, np.exp(-1e-3 / 0.3)
    assert (left[1:] >= left[:-1] * floor - 1e-9).all()
    np.testing.assert_allclose(unforeseen.detected(t, F, {"novel:leaky_detector": {"size": 1e-5}}), F)


def test_a_structure_breaks_down_with_speed_and_remembers_the_way_that_it_came():
    speed, order = np.linspace(0, 9, 40), np.linspace(0, 1, 40)
    form = {"size": 0.4, "at": 3.0, "tau": 0.2}
    up, down = (unforeseen.broken(v, order, {"novel:thixotropy": form}) for v in (speed, speed[::-1]))
    assert (np.diff(up) > 0).all() and (up[5:] < down[::-1][5:])[:-10].all()
    balance = unforeseen.broken(speed, order, {"novel:thixotropy": form | {"tau": 1e-6}})
    np.testing.assert_allclose(balance, 0.4 * speed / (3 + speed), atol=1e-9)
    assert not unforeseen.broken(0 * speed, order, {"novel:thixotropy": form}).any()


def test_amplitude_and_frequency_soften_a_thixotropic_sample_as_their_product():
    """So it is not amplitude alone that does it."""
    p, w = {"k_D": 0.5, "c_D": 0.0, "h_D": 0.0, "rho": 1.0}, np.full(3, 10.0)
    e = {"novel:thixotropy": {"size": 0.4, "law": "", "at": 1.0, "tau": 1e-6}}
    one, other = stiffness.steady_cycle(w, p, e, 0.4, 0.8), stiffness.steady_cycle(w / 2, p, e, 0.8, 0.8)
    np.testing.assert_allclose(one[1:] / 0.4, other[1:] / 0.8, rtol=1e-9)


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
