"""Errors of how sweeps are taken, by the meter or by the source: unknown, and told as what they are."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.models import load

Array = np.ndarray
Change = Callable[[Array], Array]
SET = np.geomspace(20.0, 2000.0, 201)
UP_AND_DOWN, UP = (True, False), (True, True)


def loudspeaker(f: Array) -> Array:
    jw = 2j * np.pi * f
    return np.asarray(4.0 + 6e-4 * jw + 7.0**2 / (0.7 + 0.015 * jw + 6500 / jw))


def as_is(Z: Array) -> Array:
    return Z


def nowhere(f: Array) -> Array:
    return 0 * f


def swept(folder: Path, upwards: tuple[bool, ...], read: Change = as_is, off: Change = nowhere) -> Verdict:
    """Sweeps of a loudspeaker, with what a meter makes of the readings in the order in which they came, and
    at frequencies that are `off` by a part of those that are told."""
    rng, text = np.random.default_rng(3), 'model = "electrodynamic_transducer"\n[constants]\nM_m = 0.015\n'
    text += "[noise]\nZ_relative = 1e-3\n"
    for k, up in enumerate(upwards):
        order = slice(None) if up else slice(None, None, -1)
        f = SET[order]
        shown = read(loudspeaker(f * (1 + off(f))))
        noise = 1e-3 * np.abs(shown) * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
        rows = np.column_stack([f, (shown + noise).real, (shown + noise).imag])
        header = "f [Hz],Re Z [ohm],Im Z [ohm]"
        np.savetxt(folder / f"r{k}.csv", rows, delimiter=",", header=header, comments="")
        text += f'[[recording]]\nfile = "r{k}.csv"\n'
    (folder / "case.toml").write_text(text)
    return diagnose(read_case(folder / "case.toml"), load("electrodynamic_transducer"))


def kept(part: float) -> Change:
    """A detector that keeps a part of each reading in the next."""

    def read(Z: Array) -> Array:
        shown = Z.copy()
        for i in range(1, len(Z)):
            shown[i] = (1 - part) * Z[i] + part * shown[i - 1]
        return shown

    return read


@pytest.mark.slow
def test_a_meter_that_does_not_settle_is_no_physics_of_the_loudspeaker(tmp_path: Path) -> None:
    """One sweep upwards and one downwards: the resonance is at two places."""
    (found,) = swept(tmp_path, UP_AND_DOWN, kept(0.03)).effects
    assert found.id == "unknown_electrical"
    assert "each reading keeps a part of the one before" in found.says


@pytest.mark.slow
def test_a_range_that_is_switched_is_told_with_its_modulus(tmp_path: Path) -> None:
    switched = swept(tmp_path, UP, lambda Z: Z * np.where(np.abs(Z) > 8.0, 1.008 + 0.006j, 1.0))
    (found,) = switched.effects
    assert found.id == "unknown_electrical"
    told = re.search(r"where \|Z\| is above ([0-9.]+) ohm", found.says)
    assert told and float(told[1]) == pytest.approx(8.0, rel=0.1)


@pytest.mark.slow
def test_a_phase_that_creeps_is_told(tmp_path: Path) -> None:
    def read(Z: Array) -> Array:
        return np.asarray(Z * np.exp(-0.002j * np.log1p(np.arange(Z.size) / Z.size / 0.15)))

    (found,) = swept(tmp_path, UP_AND_DOWN, read).effects
    assert found.id == "unknown_electrical" and "creeps with time" in found.says


def test_a_phase_that_creeps_alike_in_sweeps_that_go_one_way_may_be_a_smooth_error(tmp_path: Path) -> None:
    """Of the instrument, over frequency: that is noise which nobody stated."""

    def read(Z: Array) -> Array:
        return np.asarray(Z * np.exp(-0.002j * np.log1p(np.arange(Z.size) / Z.size / 0.5)))

    found = swept(tmp_path, UP, read)
    assert found.adequate and "a smooth error of the instrument" in found.summary


def test_many_sweeps_with_nothing_but_noise_are_adequate(tmp_path: Path) -> None:
    assert swept(tmp_path, (True,) * 5).adequate


def test_a_detector_whose_references_are_skewed_is_told(tmp_path: Path) -> None:
    (found,) = swept(tmp_path, UP, lambda Z: Z + 0.004j * Z.real).effects
    assert found.id == "unknown_electrical" and "not at right angles" in found.says


@pytest.mark.slow
def test_a_source_that_its_load_pulls_is_no_spring_that_hardens(tmp_path: Path) -> None:
    """The resonance leans over, alike at all levels, and by so much is the frequency off."""

    def off(f: Array) -> Array:
        return np.asarray(0.003 * np.sin(np.angle(loudspeaker(f))))

    (found,) = swept(tmp_path, UP, off=off).effects
    assert found.id == "unknown_electrical"
    told = re.search(r"off by up to ([0-9.]+) of it, as the sine of the phase", found.says)
    assert told and float(told[1]) == pytest.approx(0.003, rel=0.1)
    left = re.search(r"without it ([0-9.]+) times the noise", found.says)
    assert left and float(left[1]) == pytest.approx(1.0, abs=0.2)


@pytest.mark.slow
def test_a_frequency_axis_that_is_bowed_is_told(tmp_path: Path) -> None:
    (found,) = swept(tmp_path, UP, off=lambda f: 0.006 * np.sin(3 * np.log(f / 20))).effects
    assert found.id == "unknown_electrical" and "a frequency axis that is bowed" in found.says
