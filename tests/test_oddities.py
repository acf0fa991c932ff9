"""Errors that are no accidents: saturation of a force record, and the mains in impedance sweeps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from modelgen.api import open_case
from modelgen.diagnose import diagnose
from modelgen.diagnose.gate.hum import hum
from modelgen.diagnose.gate.narrow import lone
from modelgen.diagnose.gate.oddities import mains, saturation
from modelgen.fit.series import Series
from modelgen.fit.whitener import Whitener

SIGMA = 2e-3


def _force(clip: float | None, seed: int = 0) -> tuple[Series, np.ndarray, np.ndarray]:
    """A sine of 1 N with noise, its whitened residual against the true sine, and the samples beyond 6 σ."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 8, 4000)
    true = np.sin(2 * np.pi * t)
    seen = (np.minimum(true, clip) if clip else true) + SIGMA * rng.standard_normal(t.size)
    white = ((true - seen) / SIGMA)[None]
    s = Series("a", "fit", {"t": t}, seen[None], "real", (0,), "N", Whitener(np.full((1, t.size), 1 / SIGMA)))
    return s, white, np.abs(white[0]) > 6


def test_a_clipped_record_is_told_with_its_level() -> None:
    s, white, marks = _force(clip=0.98)
    found, _ = saturation([s], [white], [marks])
    assert found is not None and found.port == "force"
    assert "0.98" in found.says


def test_a_record_cut_at_half_its_height_is_told_without_an_outlier_and_marked() -> None:
    s, white, _ = _force(clip=0.5)
    found, marks = saturation([s], [white], [np.zeros(s.n, dtype=bool)])
    assert found is not None and "0.5" in found.says
    assert np.mean(marks[0]) == pytest.approx(1 / 3, abs=0.02)  # a sine is above a half for that long


def test_a_record_cut_for_most_of_its_time_is_told_as_its_motion_goes_on() -> None:
    s, white, _ = _force(clip=-0.6)
    found, marks = saturation([s], [white], [np.zeros(s.n, dtype=bool)])
    assert found is not None and np.mean(marks[0]) == pytest.approx(0.705, abs=0.02)


def test_a_level_that_a_record_goes_beyond_is_no_end_of_it() -> None:
    """A force that stays while a motion is uniform, and jerks elsewhere."""
    s, white, _ = _force(clip=0.9)
    x, rng = s.data[0].copy(), np.random.default_rng(1)
    for k in np.flatnonzero(np.sin(2 * np.pi * s.inputs["t"]) < -0.1)[::7]:
        x[k : k + 3] = rng.uniform(1.1, 1.6)
    jerky = replace(s, data=x[None])
    found, _ = saturation([jerky], [white + (s.data - jerky.data) / SIGMA], [np.zeros(s.n, dtype=bool)])
    assert found is None


def test_a_plateau_is_marked_whole_where_outliers_lie_on_it_and_with_its_edges() -> None:
    """Of the samples beside a plateau those that noise lifted are on it: what is left of them is biased."""
    s, white, _ = _force(clip=0.5)
    few = np.zeros(s.n, dtype=bool)
    few[np.argsort(s.data[0])[-4:]] = True
    found, marks = saturation([s], [white], [few])
    assert found is not None and np.mean(marks[0]) == pytest.approx(1 / 3, abs=0.02)
    cut = np.flatnonzero(np.diff(np.sin(2 * np.pi * s.inputs["t"]) > 0.5))
    assert all(marks[0][k - 2 : k + 4].all() for k in cut)


def test_a_smooth_top_is_no_plateau_even_under_a_wrong_model() -> None:
    s, white, _ = _force(clip=None)
    t = s.inputs["t"]
    wrong = white + (np.sin(2 * np.pi * t + 0.5) - np.sin(2 * np.pi * t)) / SIGMA
    assert saturation([s], [wrong], [np.zeros(s.n, dtype=bool)])[0] is None


def test_a_record_that_rests_is_not_saturated() -> None:
    """Behind a play wider than its stroke a sample shows one force all the time, whatever the model says."""
    s, white, _ = _force(clip=0.5)
    still = replace(s, data=np.full_like(s.data, 0.7) + SIGMA * np.random.default_rng(1).standard_normal(s.n))
    wrong = white + (s.data - still.data) / SIGMA
    found, marks = saturation([still], [wrong], [np.zeros(s.n, dtype=bool)])
    assert found is None and not marks[0].any()


def test_gross_errors_are_no_saturation() -> None:
    s, white, _ = _force(clip=None)
    rng = np.random.default_rng(1)
    hit = rng.random(s.n) < 0.01
    gross = hit * rng.choice([-1.0, 1.0], s.n) * 30.0
    from dataclasses import replace

    s = replace(s, data=s.data + SIGMA * gross)
    assert saturation([s], [white - gross], [hit])[0] is None


def _sweeps(count: int, hum: float, base: float, seed: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    rng = np.random.default_rng(seed)
    f = [np.geomspace(20, 5000, 300)[:: 1 if k % 2 == 0 else -1] for k in range(count)]
    white = []
    for x in f:
        e = rng.standard_normal((2, len(x)))
        for n in (1, 3, 5):
            e[0, int(np.argmin(np.abs(x - n * base)))] += hum / n
        white.append(e)
    return f, white


@pytest.mark.parametrize("base", [50.0, 60.0])
def test_mains_in_two_sweeps_are_told_with_their_frequency(base: float) -> None:
    f, white = _sweeps(2, 20.0, base, seed=0)
    found, marks = mains(f, white, "electrical")
    assert found is not None and f"mains of {base:.0f} Hz" in found.says
    for x, m in zip(f, marks, strict=True):
        assert m[np.argmin(np.abs(x - base))]
        assert m.mean() < 0.1


def test_the_first_line_goes_with_its_harmonics_where_a_resonance_is_missed_beside_it() -> None:
    """Harmonics tell what it is; at 50 Hz the residual is loud all about."""
    f, white = _sweeps(2, 40.0, 50.0, seed=1)
    for x, e in zip(f, white, strict=True):
        e[0] += 15.0 * np.exp(-(((x - 50.0) / 8.0) ** 2))
    found, marks = mains(f, white, "electrical")
    assert found is not None and "mains of 50 Hz" in found.says
    assert all(m[np.abs(x - 50.0) < 6.0].all() for x, m in zip(f, marks, strict=True))


@pytest.mark.slow
def test_mains_in_sweeps_of_a_stiffness_are_no_physics_of_the_sample(tmp_path: Path) -> None:
    """What a rig picks up at 50 and 150 Hz looks like resonances."""
    rng, f = np.random.default_rng(2), np.arange(5.0, 185.0)
    for k in range(3):
        K = 31.0 + 0.02j * f
        for n, size in ((1, 2.0), (3, 1.2), (5, 0.0)):
            phase = np.exp(1j * rng.uniform(0, 6.3))
            K = K + size * phase * np.exp(-(((f - n * 50.0) / 1.5) ** 2))
        rows = np.stack([f, np.abs(K), np.degrees(np.angle(K))], axis=1)
        rows[:, 1:] += rng.standard_normal((len(f), 2)) * [0.1, 0.2]
        head = "f [Hz],k_s [N/mm],loss_angle [deg]"
        np.savetxt(tmp_path / f"r{k}.csv", rows, delimiter=",", header=head, comments="")
    text = 'model = "complex_stiffness"\n[constants]\nh_D = 0.0\nrho = 1.0\nA_z = 0.1\n'
    text += "[noise]\nk_s = 0.1\nloss_angle = 0.2\n"
    text += "".join(f'[[recording]]\nfile = "r{k}.csv"\nrole = "fit"\n' for k in range(3))
    (tmp_path / "case.toml").write_text(text)
    model, case = open_case(tmp_path / "case.toml")
    found = diagnose(case, model)
    assert found.effects[0].id.startswith("unknown_") and "mains of 50 Hz" in found.summary


def test_noise_and_scattered_gross_errors_are_no_mains() -> None:
    alarms = 0
    for seed in range(60):
        f, white = _sweeps(3, 0.0, 50.0, seed)
        rng = np.random.default_rng(1000 + seed)
        for e in white:
            e[:, rng.random(e.shape[1]) < 0.01] += 20.0
        alarms += mains(f, white, "electrical")[0] is not None
    assert alarms <= 2


def _humming(size: float, seed: int, colour: float = 0.0) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Two sweeps of 301 frequencies, 1 to 2.5 kHz; the 21st harmonic and all odd ones above leak through a
    filter 4 Hz wide."""
    rng = np.random.default_rng(seed)
    f = [np.linspace(1000, 2500, 301)] * 2
    away = [np.min(np.abs(x - 50.0 * np.arange(21, 50, 2)[:, None]), axis=0) for x in f]
    noise = [lfilter([1.0], [1.0, -colour], rng.standard_normal((2, 301))) for _ in f]
    return f, [e + size * np.exp(-((d / 4) ** 2)) for e, d in zip(noise, away, strict=True)]


def test_many_weak_harmonics_make_a_hum_that_no_outlier_shows() -> None:
    f, white = _humming(3.0, seed=0)
    assert mains(f, white, "electrical")[0] is None
    found, marks = hum(f, white, "electrical")
    assert found is not None and found.port == "electrical" and "odd multiples of 50 Hz" in found.says
    for x, m in zip(f, marks, strict=True):
        assert m[np.argmin(np.abs(x - 1350))] and not m[np.argmin(np.abs(x - 1400))]


def test_a_hum_that_falls_with_its_order_is_heard_beside_its_loudest_line() -> None:
    heard = 0
    for seed in range(12):
        f, rng = [np.geomspace(20, 20e3, 301) * by for by in (1.0, 1.001)], np.random.default_rng(seed)
        white = [rng.standard_normal((2, x.size)) for x in f]
        for e, x in zip(white, f, strict=True):
            for n in range(1, 40, 2):
                e += 30.0 / n * np.sinc((x - 50.0 * n) / 5.0) * [[np.cos(n)], [np.sin(n)]]
        found, marks = hum(f, white, "electrical")
        heard += found is not None
        if found is not None:  # its skirts are taken out as well
            assert np.mean([np.mean(e[:, ~m] ** 2) for e, m in zip(white, marks, strict=True)]) < 2
    assert heard >= 9


def test_gross_errors_do_not_hum() -> None:
    for seed in range(40):
        f, white = _humming(0.0, seed)
        rng = np.random.default_rng(100 + seed)
        spoilt = [e + 30.0 * (rng.random(e.shape[1]) < 0.012) for e in white]
        assert hum(f, spoilt, "electrical")[0] is None


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_noise_of_any_colour_does_not_hum(colour: float) -> None:
    assert all(hum(*_humming(0.0, seed, colour), "electrical")[0] is None for seed in range(40))


def test_one_narrow_resonance_at_a_harmonic_does_not_hum() -> None:
    f, white = _humming(0.0, seed=0)
    for x, e in zip(f, white, strict=True):
        e[0] += 60 / (1 + ((x - 1350) / 3) ** 2)
    assert hum(f, white, "electrical")[0] is None


@pytest.mark.parametrize(("width", "narrow"), [(0.002, True), (0.1, False)])
def test_a_claim_needs_more_than_a_few_frequencies(width: float, narrow: bool) -> None:
    rng = np.random.default_rng(0)
    f = [np.geomspace(20, 5000, 300)] * 2
    noise = [rng.standard_normal((2, 300)) for _ in f]
    line = 20 / (1 + (np.log(f[0] / f[0][147]) / width) ** 2)
    still = [np.zeros(len(x)) for x in f]
    found = lone(f, [e + line for e in noise], noise, still, "mechanical")
    assert (found is not None) == narrow
    if found is not None:
        assert "Hz" in found[0].says
        assert all(m[147] and not m[:140].any() for m in found[1])
    # where the model has as sharp a resonance, that has moved
    peak = [e + 30.0 for e in still]
    assert lone(f, [e + line for e in noise], noise, peak, "mechanical") is None


def test_what_rises_towards_the_end_of_the_band_is_no_line() -> None:
    """A resonance beyond it is seen at its last samples, in either sweep."""
    rng = np.random.default_rng(0)
    f = [np.geomspace(20, 5000, 300), np.geomspace(5000, 20, 280)]
    noise = [rng.standard_normal((2, len(x))) for x in f]
    still = [np.zeros(len(x)) for x in f]
    rise = [12 / (1 + ((5050 - x) / 60) ** 2) for x in f]
    assert lone(f, [e + x for e, x in zip(noise, rise, strict=True)], noise, still, "mechanical") is None


def test_gross_errors_anywhere_are_no_mains() -> None:
    """Four on lines of 60 Hz, two of them on the same: told, unless seven more lie elsewhere."""
    rng = np.random.default_rng(3)
    f = [np.geomspace(100, 350, n) for n in (401, 301)]
    white = [rng.standard_normal((2, len(x))) for x in f]
    for k, at in ((0, 179.2), (0, 180.5), (0, 300.0), (1, 300.0)):
        white[k][:, np.argmin(np.abs(f[k] - at))] += 25.0
    assert mains(f, white, "electrical")[0] is not None
    for k, at in ((0, 105), (0, 124), (0, 131), (0, 337), (1, 122), (1, 243), (1, 349)):
        white[k][:, np.argmin(np.abs(f[k] - at))] += 25.0
    assert mains(f, white, "electrical")[0] is None
