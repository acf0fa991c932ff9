"""Of a sweep that holds |Z| alone the noise is told as well as of a complex one; a held-out recording is
judged by the noise of the fitted one that is like it, whichever stands first."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.diagnose import diagnose
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.noise.floor import Scatter
from modelgen.diagnose.whole_ports import whole
from modelgen.models import load
from modelgen.recordings import Case, Noise, Recording

COIL = load("electrodynamic_transducer")
F = np.linspace(20, 2000, 300)
S = 2j * np.pi * F


def coil(hung: np.ndarray | float = 0.0, creep: float = 0.0) -> np.ndarray:
    return np.asarray(6 + 5e-4 * S + 36 / (1 + 0.015 * S + (2e3 + creep * S**0.2) / S + hung))


def modulus(Z: np.ndarray, noise: Noise, seed: int = 3) -> Case:
    y = np.abs(Z) * (1 + 1e-3 * np.random.default_rng(seed).standard_normal(F.size))
    record = Recording("a", None, "fit", {"f": F}, {"Z": y}, {"Z": "modulus"})
    return Case(None, COIL.id, (record,), constants={"Bl": 6.0}, noise=noise)


@pytest.mark.parametrize("channels", [1, 2])
@pytest.mark.parametrize("by", [0.01, 7.0])
def test_a_likelihood_does_not_depend_on_the_unit_of_variance(channels: int, by: float) -> None:
    e = np.random.default_rng(1).standard_normal((channels, 200))
    scatter = Scatter(e, np.ones(200), np.ones(196, dtype=bool))
    shape = np.linspace(1, 3, 200)
    assert scatter.deviance(by * shape)[0] == pytest.approx(scatter.deviance(shape)[0], abs=1e-6)


@pytest.mark.parametrize("stated", [False, True])
def test_white_noise_of_a_modulus_is_white(stated: bool) -> None:
    noise = Noise(relative={"Z": 1e-3}) if stated else Noise()
    (series,) = prepare(whole(COIL), modulus(coil(), noise), 0).series
    assumed = 1 / (np.abs(series.whitener.weight).ravel() * series.size)
    assert np.allclose(assumed, 1e-3, rtol=0.25)


def test_what_a_modulus_shows_is_found() -> None:
    hung = 3e-4 * S / (1 + S / (2 * np.pi * 45 * 5) + (S / (2 * np.pi * 45)) ** 2)
    verdict = diagnose(modulus(coil(hung), Noise(relative={"Z": 1e-3})), COIL)
    assert not verdict.adequate and verdict.before.fit_over_noise > 3
    assert verdict.after.fit_over_noise < 1.2


@pytest.mark.slow
def test_a_hold_out_is_judged_alike_in_any_order() -> None:
    """A quiet and a loud recording were fitted; the held-out one, where the effect is half as strong, is
    quiet."""
    f = np.geomspace(20, 20000, 160)
    s = 2j * np.pi * f
    rng = np.random.default_rng(5)

    def record(name: str, role: str, K: float, noise: float) -> Recording:
        Z = 6 + 36 / (1 + 0.015 * s + 2e3 / s) + 5e-4 * s + K * (s / 1j) ** 0.7 * 1j**0.7
        Z = Z * (1 + noise * (rng.standard_normal(160) + 1j * rng.standard_normal(160)))
        return Recording(name, None, role, {"f": f}, {"Z": Z})

    quiet, loud = record("quiet", "fit", 3e-3, 3e-4), record("loud", "fit", 3e-3, 1e-2)
    held = record("held", "holdout", 1.5e-3, 3e-4)
    told = [
        diagnose(Case(None, COIL.id, (*pair, held), constants={"Bl": 6.0}), COIL)
        for pair in ((quiet, loud), (loud, quiet))
    ]
    one, other = ((v.after.holdout_over_noise, v.effects[0].probability) for v in told)
    assert one == pytest.approx(other, rel=1e-3) and one[0] > 10
    assert any("half as sure" in n for n in told[0].notes)
