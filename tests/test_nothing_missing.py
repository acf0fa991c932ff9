"""Sweeps of a moving coil that lacks nothing, in noise that is not what it is stated or taken to be."""

import re
from pathlib import Path

import numpy as np
import pytest
from coils import write_sweep

import modelgen as mg
from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.noise.noise import first_order
from modelgen.fit.scatter import rounding
from modelgen.fit.series import make_series
from modelgen.models import load

R_E, L_E, BL, K_M, R_M = 6.2, 6e-4, 5.5, 900.0, 0.7


def pink(rng: np.random.Generator, n: int) -> np.ndarray:
    """Noise of power 1/f along the samples, standard deviation 1."""
    spectrum = np.fft.rfft(rng.standard_normal(2 * n))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
    spectrum[0] = 0
    x = np.fft.irfft(spectrum)[:n]
    return np.asarray(x / x.std())


def judged(
    tmp_path: Path,
    noise: str,
    stated: float | None,
    seed: int,
    n: int,
    off: float = 0.0,
    more: str = "",
    floor: float = 0.0,
    slope: float = 0.0,
    ammeter: float = 0.0,
) -> Verdict:
    """Two sweeps with known masses and 0.1 % noise; `off` adds to the held-out third's mass, unstated;
    `more` goes into the case; `floor` [ohm] of the instrument; `slope`: power of f in the noise; `ammeter`:
    noise of the current [1/ohm of a volt]."""
    rng = np.random.default_rng(seed)
    f = np.geomspace(20, 2000, n)
    w = 2 * np.pi * f
    text = (
        'model = "electrodynamic_transducer"\n'
        + (f"[noise]\nZ_relative = {stated}\n" if stated else "")
        + more
    )
    for k, m in enumerate((0.008, 0.013, 0.01)):
        there = m + (off if k == 2 else 0.0)
        Z = R_E + 1j * w * L_E + BL**2 / (R_M + 1j * w * there + K_M / (1j * w))
        e = [pink(rng, n) if noise == "pink" else rng.standard_normal(n) for _ in range(4)]
        absolute = floor + ammeter * np.abs(Z) ** 2
        Z = Z * (1 + 1e-3 * (f / 200) ** slope * (e[0] + 1j * e[1])) + absolute * (e[2] + 1j * e[3])
        rows = "\n".join(f"{a:.9g},{b:.9g},{c:.9g}" for a, b, c in zip(f, Z.real, Z.imag, strict=True))
        (tmp_path / f"r{k}.csv").write_text(f"f [Hz],Re Z [ohm],Im Z [ohm]\n{rows}\n")
        role = "holdout" if k == 2 else "fit"
        text += f'[[recording]]\nfile = "r{k}.csv"\nrole = "{role}"\nconstants = {{ M_m = {m} }}\n'
    (tmp_path / "case.toml").write_text(text)
    case = read_case(tmp_path / "case.toml")
    return diagnose(case, load(case.model))


@pytest.mark.parametrize("stated", [2e-4, 3.3e-4, 5e-3])
def test_a_stated_noise_that_is_wrong_by_far_is_no_physics_and_is_told(tmp_path: Path, stated: float) -> None:
    v = judged(tmp_path, "white", stated, 1, 201)
    assert v.adequate
    told = re.search(r"That is (\S+) times the noise that is stated", v.summary)
    assert told and float(told[1]) == pytest.approx(1e-3 / stated, rel=0.1)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_peaks_of_coloured_noise_are_no_resonances(tmp_path: Path, seed: int) -> None:
    v = judged(tmp_path, "pink", None, seed, 401)
    assert v.adequate, v.summary


@pytest.mark.parametrize("stated", [None, 1e-3])
def test_the_floor_of_an_instrument_is_noise(tmp_path: Path, stated: float | None) -> None:
    v = judged(tmp_path, "white", stated, 2, 401, floor=0.1)
    assert v.adequate, v.summary
    assert v.after.holdout_over_noise == pytest.approx(1.0, abs=0.08)
    case = read_case(tmp_path / "case.toml")
    for s in prepare(load(case.model), case, 0).series:
        floor, relative, _ = s.spread
        assert floor == pytest.approx(0.1, rel=0.15)
        assert relative < 2e-3


@pytest.mark.parametrize("stated", [None, 1e-3])
def test_the_floor_of_an_ammeter_is_noise(tmp_path: Path, stated: float | None) -> None:
    v = judged(tmp_path, "white", stated, 2, 401, ammeter=4e-4)
    assert v.adequate, v.summary
    assert v.after.holdout_over_noise == pytest.approx(1.0, abs=0.08)
    case = read_case(tmp_path / "case.toml")
    for s in prepare(load(case.model), case, 0).series:
        assert s.spread[2] == pytest.approx(4e-4, rel=0.2)


@pytest.mark.parametrize("stated", [None, 3e-4])
def test_noise_of_fewer_averages_at_low_frequencies_is_noise(tmp_path: Path, stated: float | None) -> None:
    v = judged(tmp_path, "white", stated, 3, 150, slope=-0.5)
    assert v.adequate, v.summary
    assert v.after.holdout_over_noise == pytest.approx(1.0, abs=0.15)
    case = read_case(tmp_path / "case.toml")
    for s in prepare(load(case.model), case, 0).series:
        over = np.abs(s.whitener.weight * s.reference)
        assert over[-1] / over[0] == pytest.approx(10.0, rel=0.6)


def test_a_hold_out_that_is_missed_is_told(tmp_path: Path) -> None:
    v = judged(tmp_path, "white", 1e-3, 1, 201, off=4e-4)
    assert v.adequate
    assert "misses the held-out" in v.summary


@pytest.mark.slow
def test_a_bound_of_the_case_that_holds_a_parameter_is_told(tmp_path: Path) -> None:
    v = judged(tmp_path, "white", 1e-3, 1, 60, more="[bounds]\nR_e = [8.0, 20.0]\n")
    assert not v.adequate
    told = [n for n in v.notes if "on its bound" in n]
    assert told == ["R_e lies on its bound of 8: what seems left out may be what this forbids"]


def test_a_handful_of_values_has_no_resonances(tmp_path: Path) -> None:
    assert judged(tmp_path, "white", None, 1, 3).adequate


def test_noise_of_the_first_order_is_told_from_what_is_smooth() -> None:
    rng = np.random.default_rng(5)
    ends, t = 0, np.linspace(0, 6, 60)
    for _ in range(100):
        x = np.zeros((2, 60))
        for k in range(1, 60):
            x[:, k] = 0.95 * x[:, k - 1] + rng.normal(size=2)
        ends += first_order(x)
        assert not first_order(20 * np.sin(t) + rng.normal(size=(2, 60)))
    assert ends >= 94


def test_rounding_is_seen_on_a_grid_only() -> None:
    x = np.random.default_rng(6).normal(size=200)
    assert rounding(x) == 0
    assert rounding(np.round(x / 0.3) * 0.3) == pytest.approx(0.3 / np.sqrt(12))


@pytest.mark.slow
def test_a_held_out_sweep_is_missed_by_as_much_as_was_foreseen(tmp_path: Path) -> None:
    """Beyond the band and with another mass, what is uncertain of the parameters counts more than noise:
    χ²/N of the hold-out is on average what the verdicts had foreseen."""
    found = []
    for seed in range(6):
        rng, text = (
            np.random.default_rng(seed),
            'model = "electrodynamic_transducer"\n[noise]\nZ_relative = 1e-3\n',
        )
        for k, (m, low, high) in enumerate(((0.008, 150, 600), (0.010, 150, 600), (0.013, 10, 80))):
            f = np.geomspace(low, high, 60)
            w = 2 * np.pi * f
            Z = R_E + 1j * w * L_E + BL**2 / (R_M + 1j * w * m + K_M / (1j * w))
            Z = Z * (1 + 1e-3 * (rng.standard_normal(60) + 1j * rng.standard_normal(60)))
            np.savetxt(
                tmp_path / f"r{k}.csv", np.column_stack([f, Z.real, Z.imag]), delimiter=",",
                header="f [Hz],Re Z [ohm],Im Z [ohm]", comments="",
            )  # fmt: skip
            role = "holdout" if k == 2 else "fit"
            text += f'[[recording]]\nfile = "r{k}.csv"\nrole = "{role}"\nconstants = {{ M_m = {m} }}\n'
        (tmp_path / "case.toml").write_text(text)
        case = read_case(tmp_path / "case.toml")
        v = diagnose(case, load(case.model))
        assert v.adequate
        found.append((v.after.holdout_over_noise**2, v.after.foreseen**2))
    seen, expected = np.mean(found, axis=0)
    assert expected > 1.5 and 0.6 * expected < seen < 1.5 * expected


def test_what_stays_on_one_tread_is_no_finer_than_the_tread(tmp_path: Path) -> None:
    """A stiffness rounded to 0.003 N/mm that happens to stay where it is says nothing of its noise."""
    f = np.geomspace(0.3, 15, 28)
    k_s = 0.003 * np.round((0.776 + 4e-5 * f**2) / 0.003)
    rows = np.column_stack([f, k_s, 5 + 0.9 * f])
    head = "f [Hz],k_s [N/mm],loss_angle [deg]"
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header=head, comments="", fmt="%.9g")
    text = (
        'model = "complex_stiffness"\n[constants]\nA_z = 0.2\n[[recording]]\nfile = "a.csv"\nrole = "fit"\n'
    )
    (tmp_path / "case.toml").write_text(text)
    case = read_case(tmp_path / "case.toml")
    s = make_series(load(case.model), case, case.fit[0])
    assert 1 / s.whitener.weight[0].max() >= 0.999 * 0.003 / np.sqrt(12)


def flicker(rng: np.random.Generator, n: int) -> np.ndarray:
    """`pink` with what its mean is over the samples taken out."""
    white = np.fft.rfft(rng.normal(size=2 * n))
    x = np.fft.irfft(white / np.sqrt(np.maximum(np.arange(len(white)), 1)))[:n]
    return np.asarray((x - x.mean()) / x.std())


@pytest.mark.slow
def test_noise_of_another_level_in_each_band_hides_nothing(tmp_path: Path) -> None:
    """Louder about the mains, too, partly 1/f, rounded: resonances of no catalogue would describe it,
    and a little more loss gains the evidence of a claim."""
    rng, f = np.random.default_rng(402), np.geomspace(12, 4000, 300)
    level = 1.5e-3 * np.where(f < 40, 2.2, np.where(f > 1500, 0.4, 0.8)) * np.where(abs(f - 50) < 3, 3, 1)
    text, s = 'model = "electrodynamic_transducer"\n', 2j * np.pi * f
    for k, M in enumerate((0.0235, 0.0355, 0.0535)):
        Z = 5.9 + 6.1e-4 * s + 8.8**2 / (1.7 + M * s + 3300 / s)
        white = rng.normal(size=f.size) + 1j * rng.normal(size=f.size)
        Z = Z * (1 + level * white + 4.5e-4 * (flicker(rng, f.size) + 1j * flicker(rng, f.size)))
        write_sweep(tmp_path / f"r{k}.csv", f, np.round(Z, 3))
        text += f'[[recording]]\nfile = "r{k}.csv"\nconstants = {{ M_m = {M} }}\n'
    (tmp_path / "case.toml").write_text(text)
    model, case = mg.open_case(tmp_path / "case.toml")
    assert diagnose(case, model).adequate
