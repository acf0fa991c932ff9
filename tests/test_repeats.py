"""Repeats of a sweep, between which the device has changed."""

from pathlib import Path

import numpy as np
import pytest

import modelgen as mg
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.noise.noise import first_order

R_E, K_M = 6.0, 2e3


def repeated(folder: Path, R: tuple[float, ...], K: tuple[float, ...]) -> Verdict:
    """Sweeps of a moving coil with 0.1 % noise, each with a resistance [ohm] and a stiffness [N/m] of its
    own; the last one is held out."""
    rng = np.random.default_rng(7)
    f = np.geomspace(10, 5000, 120)
    s = 2j * np.pi * f
    text = 'model = "electrodynamic_transducer"\n[constants]\nM_m = 0.013\n'
    for k, (r, stiffness) in enumerate(zip(R, K, strict=True)):
        Z = r + 3e-4 * s + 36 / (1 + 0.013 * s + stiffness / s)
        Z = Z * (1 + 1e-3 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)))
        rows = "\n".join(f"{a:.9g},{z.real:.9g},{z.imag:.9g}" for a, z in zip(f, Z, strict=True))
        (folder / f"r{k}.csv").write_text(f"f [Hz],Re Z [ohm],Im Z [ohm]\n{rows}\n")
        role = "holdout" if k == len(R) - 1 else "fit"
        text += f'[[recording]]\nfile = "r{k}.csv"\nrole = "{role}"\n'
    (folder / "case.toml").write_text(text)
    model, case = mg.open_case(folder / "case.toml")
    return diagnose(case, model)


@pytest.mark.parametrize(
    ("R", "K", "port"),
    [
        pytest.param(
            (1.0, 1.01, 1.013, 1.02),
            (1.0, 1.0, 1.0, 1.0),
            "electrical",
            id="the coil warms up",
            marks=pytest.mark.slow,
        ),
        pytest.param((1.0, 1.0, 1.0), (1.0, 0.97, 0.96), "mechanical", id="the suspension yields"),
    ],
)
def test_a_device_that_is_another_in_each_sweep(
    tmp_path: Path, R: tuple[float, ...], K: tuple[float, ...], port: str
) -> None:
    v = repeated(tmp_path, tuple(R_E * x for x in R), tuple(K_M * x for x in K))
    (found,) = v.effects
    assert (found.id, found.port) == ("temperature_drift", port)
    assert v.after.holdout_over_noise == pytest.approx(1.0, abs=0.15)  # with a value of its own, too
    own = {e.name: e.value for e in found.parameters}
    if port == "electrical":
        assert own["dR_each[r1]"] == pytest.approx(0.06, abs=0.005)
        assert own["dR_each[r2]"] == pytest.approx(0.078, abs=0.005)
    else:
        assert own["dK_each[r1]" if "dK_each[r1]" in own else "dK_each"] == pytest.approx(-0.03, abs=0.003)


def test_repeats_of_the_same_device(tmp_path: Path) -> None:
    assert repeated(tmp_path, (R_E,) * 4, (K_M,) * 4).adequate


def test_a_steady_difference_is_no_noise_of_the_first_order() -> None:
    x = np.random.default_rng(1).standard_normal((2, 200))
    assert first_order(x)
    assert not first_order(x + 5.0)
