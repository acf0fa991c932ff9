"""Figures of force-displacement loops: against closed forms, their uncertainty, sweeps, bad recordings."""

import json
from math import pi, tan
from pathlib import Path

import numpy as np
import pytest

from modelgen.cli import main
from modelgen.errors import InputError
from modelgen.fit.loops import crossings, measure_loops, shift, strain, stress

K, C, A = 0.4, 0.1, 3.0


def recording(f: float = 0.5, cycles: float = 5.2, rate: float = 400.0, noise: float = 0.0, seed: int = 0):
    """Kelvin–Voigt: F = 1 + K z + C ż."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(cycles / f * rate)) / rate
    z = -A * np.cos(2 * pi * f * t - 0.4)
    F = 1 + K * z + C * A * 2 * pi * f * np.sin(2 * pi * f * t - 0.4)
    return t, z + noise * rng.standard_normal(t.size), F + noise * rng.standard_normal(t.size)


def test_figures_of_a_dashpot_are_exact() -> None:
    f = 0.5
    found = measure_loops(*recording(f)).mean()
    w = 2 * pi * f
    wanted = {
        "f": f, "A_z": A, "F_0": 1.0, "k_s": np.hypot(K, C * w), "c_s": np.hypot(K, C * w) / w,
        "h_s": C * w * A, "W": pi * C * w * A**2, "c_loss": C, "loss_angle": np.degrees(np.arctan(C * w / K)),
    }  # fmt: skip
    for name, value in wanted.items():
        assert found[name][0] == pytest.approx(value, rel=2e-5), name


def test_standard_deviations_are_those_of_many_recordings() -> None:
    many = [measure_loops(*recording(noise=0.02, seed=k, cycles=3.2)).mean() for k in range(60)]
    for name in ("F_0", "W", "h_s", "loss_angle"):
        values, stds = np.array([m[name] for m in many]).T
        assert np.std(values) == pytest.approx(np.sqrt(np.mean(stds**2)), rel=0.35), name


def test_noise_makes_no_second_crossing() -> None:
    t, z, _ = recording(rate=4000.0, noise=0.05)
    clean = crossings(*recording(rate=4000.0)[:2])
    assert crossings(t, z) == pytest.approx(clean, abs=2e-3)


def test_a_sweep_is_told_and_grouped() -> None:
    t = np.arange(0, 60, 1 / 500)
    phase = 2 * pi * 0.3 * 60 / np.log(30) * (30 ** (t / 60) - 1)
    z, v = -np.cos(phase), np.sin(phase) * np.gradient(phase, t)
    found = measure_loops(t, z, K * z + C * v)
    assert found.swept()
    for group in found.groups(6):
        mean = found.mean(group)
        assert mean["c_loss"][0] == pytest.approx(C, rel=0.03)
        assert tan(np.radians(mean["loss_angle"][0])) == pytest.approx(
            C * 2 * pi * mean["f"][0] / K, rel=0.05
        )


def test_an_offset_is_found_and_a_stiffness_is_not_one() -> None:
    t, z, F = recording(noise=1e-3)
    before = measure_loops(t, z, F)
    moved = shift(before, measure_loops(*recording(noise=1e-3, seed=1)[:2], F + 0.15))
    assert moved.value == pytest.approx(0.15, abs=4 * moved.std) and moved.uneven < 0.01
    stiffer = shift(before, measure_loops(t, z, F + 0.05 * z))
    assert abs(stiffer.value) < 1e-3 and stiffer.uneven > 0.05
    with pytest.raises(InputError, match="two recordings of one motion"):
        shift(before, measure_loops(t, 2 * z, F))
    with pytest.raises(InputError, match="frequencies are"):
        shift(before, measure_loops(t / 10, z, F))


def test_strain_and_stress() -> None:
    assert strain(np.array([-3.0, 0.0, 3.0]), 43.0) == pytest.approx(
        [0, 300 / 43, 600 / 43]
    )  # 13.95 %, Tab. 2
    assert stress(np.array([2.4832]), 256.0) == pytest.approx([9.70])


def write(path: Path, *columns: np.ndarray) -> Path:
    np.savetxt(path, np.c_[columns], delimiter=",", header="t [ms],z [um],F_m [mN]", comments="")
    return path


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t, z, F = recording()
    file = write(tmp_path / "a.csv", 1e3 * t, 1e3 * z, 1e3 * F)
    after = write(tmp_path / "b.csv", 1e3 * t, 1e3 * z, 1e3 * F + 150)
    out = tmp_path / "loops.json"
    assert (
        main(
            ["loops", str(after), "--against", str(file), "--json", str(out), "--length", "43", "--area", "9"]
        )
        == 0
    )
    found = json.loads(out.read_text())
    assert found["loops"][0]["c_loss"]["value"] == pytest.approx(C, rel=1e-4)
    assert found["shift"]["value"] == pytest.approx(0.15) and found["ranges"]["strain"][
        "to"
    ] == pytest.approx(13.95, abs=0.01)
    assert "± " in capsys.readouterr().out
    for bad in (["--skip", "9"], ["--skip", "-1"], ["--area", "0"], ["--against", "no.csv"]):
        assert main(["loops", str(file), *bad]) == 2
        assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_plots_of_a_loop_and_of_a_sweep(tmp_path: Path) -> None:
    t, z, F = recording(cycles=3.2)
    loop = write(tmp_path / "a.csv", 1e3 * t, 1e3 * z, 1e3 * F)
    t = np.arange(0, 20, 1 / 200)
    z = -np.cos(2 * pi * (0.5 * t + 0.05 * t**2))
    sweep = write(tmp_path / "s.csv", 1e3 * t, 1e3 * z, 1e3 * K * z)
    for file, axis in ((loop, "z [mm]"), (sweep, "loss angle [°]")):
        out = file.with_suffix(".svg")
        assert main(["loops", str(file), "--plot", str(out)]) == 0
        assert axis in out.read_text()
    assert main(["loops", str(loop), "--plot", str(tmp_path / "a.gif")]) == 2


def test_cycles_that_cannot_be_measured_are_told() -> None:
    t, z, F = recording(rate=4.0)
    with pytest.raises(InputError, match="samples in the cycle"):
        measure_loops(t, z, F)
    t, z, F = recording()
    with pytest.raises(InputError, match="force does not change"):
        measure_loops(t, z, 0 * F)
    there = (t < 3.1) | (t > 3.5)
    with pytest.raises(InputError, match="samples are missing in the cycle"):
        measure_loops(t[there], z[there], F[there])


@pytest.mark.parametrize("rate", [400.0, 6000.0])
def test_a_few_lost_samples_do_no_harm(rate: float) -> None:
    t, z, F = recording(rate=rate)
    there = (t < 3.1) | (t > 3.12)
    assert measure_loops(t[there], z[there], F[there]).mean()["c_loss"][0] == pytest.approx(C, rel=1e-4)


def test_cycles_of_unlike_amplitudes_are_noted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t, z, F = recording(cycles=6.2)
    for name, grows in (("ramp", 0.2), ("steady", 0.0)):
        a = 1 + grows * t
        rows = "".join(f"{x:.6f},{y:.6f},{w:.6f}\n" for x, y, w in zip(t, a * z, a * F, strict=True))
        (tmp_path / f"{name}.csv").write_text(f"t [s],z [mm],F [N]\n{rows}")
        assert main(["loops", str(tmp_path / f"{name}.csv")]) == 0
        assert ("figures are means of unlike cycles" in capsys.readouterr().err) == (name == "ramp")
