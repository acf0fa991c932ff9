"""Modal fit: exact responses, a simulated hammer test with noise, and what a file may hold."""

import json
from pathlib import Path

import numpy as np
import pytest

from modelgen.cli import main
from modelgen.errors import InputError
from modelgen.fit.modal import Mode, fit_modes
from modelgen.papers.gmm.hammer import HammerTest, accelerance, measure
from modelgen.recordings.frf import Frf, read_frf

BAND = (1500.0, 1700.0)


def bar(f: np.ndarray, test: HammerTest | None = None) -> Frf:
    return Frf(f, accelerance(test or HammerTest(), f)[None], ("H",), ("m/s^2/N",))


def test_exact_responses_give_all_modes_exactly() -> None:
    found = fit_modes(bar(np.linspace(1000.0, 7000.0, 3001)))
    assert [m.f for m in found.modes] == pytest.approx([1600, 3200, 4800, 6400], rel=1e-4)
    assert [m.xi for m in found.modes] == pytest.approx([0.00294] * 4, rel=1e-2)
    assert [m.f for m in fit_modes(bar(np.linspace(1000.0, 7000.0, 3001)), 1).modes] == pytest.approx(
        [6400], rel=1e-4
    )


def test_two_close_modes_are_told_apart() -> None:
    f = np.linspace(90.0, 110.0, 401)
    s = 2j * np.pi * f
    H = sum(
        a / (s**2 + 2 * x * 2 * np.pi * n * s + (2 * np.pi * n) ** 2)
        for a, n, x in ((1, 99, 0.01), (0.6, 101.0, 0.015))
    )
    found = fit_modes(Frf(f, np.array([H]), ("H",), ("m/N",)))
    assert [m.f for m in found.modes] == pytest.approx([99, 101], rel=1e-6)
    assert [m.xi for m in found.modes] == pytest.approx([0.01, 0.015], rel=1e-3)


@pytest.mark.slow
def test_stated_uncertainty_of_a_hammer_test_is_the_scatter() -> None:
    z = []
    for seed in range(25):
        (mode,) = fit_modes(measure(HammerTest(), seed).between(*BAND), 1).modes
        z.append([(mode.f - 1600) / mode.f_std, (mode.xi - 0.00294) / mode.xi_std])
    assert np.all(np.abs(np.mean(z, axis=0)) < 0.6)
    assert np.all((np.std(z, axis=0) > 0.65) & (np.std(z, axis=0) < 1.4))


def test_damping_of_the_plunger_has_omega_in_radians() -> None:
    R, std = Mode(1600.0, 0.0, 0.00294, 0.00019, 1.0).damping(0.722)
    assert (R, std) == pytest.approx((42.679, 2.758), rel=1e-4)  # errata 11: the paper has 6.79, 0.4390


def test_no_resonance_and_too_few_samples_are_said() -> None:
    rng = np.random.default_rng(0)
    f = np.linspace(10.0, 20.0, 200)
    flat = Frf(f, 1 + 0j * f[None], ("H",), ("1",))
    with pytest.raises(InputError, match="no resonance"):
        fit_modes(flat)
    with pytest.raises(InputError, match="at least 8"):
        fit_modes(bar(np.linspace(1590.0, 1610.0, 5)))
    noisy = Frf(f, rng.standard_normal((1, 200)) + 1j * rng.standard_normal((1, 200)), ("H",), ("1",))
    with pytest.raises(InputError, match=r"no resonance|modes are wanted"):
        fit_modes(noisy, 3)


def write(path: Path, header: str, columns: list[np.ndarray]) -> Path:
    rows = [header, *(",".join(f"{x:.12g}" for x in row) for row in zip(*columns, strict=True))]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def test_command_reads_any_notation(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    f = np.linspace(1500.0, 1700.0, 401)
    H = bar(f).H[0]
    a = write(tmp_path / "a.csv", "f [kHz],Re H [m/s^2/N],Im H [m/s^2/N]", [f / 1e3, H.real, H.imag])
    b = write(tmp_path / "b.csv", "f [Hz],|H| [m/s^2/N],phase H [rad]", [f, np.abs(H), np.angle(H)])
    assert np.allclose(read_frf(a).H, read_frf(b).H, rtol=1e-9)
    assert main(["modal", str(a), "--mass", "0.722", "--json", str(tmp_path / "o.json")]) == 0
    assert "42.679" in capsys.readouterr().out
    (mode,) = json.loads((tmp_path / "o.json").read_text())["modes"]
    assert mode["damping"]["value"] == pytest.approx(42.68, rel=1e-3)
    for header, says in (
        ("f [Hz],Re H [1],phase [deg]", "'Im H' is missing"),
        ("f,Re H [1],Im H [1]", "no unit"),
        ("t [s],Re H [1],Im H [1]", "no column 'f [Hz]'"),
        ("f [Hz],x [1],y [1]", "no response"),
        ("f [Hz],Re H,Im H", "no unit"),
        ("f [Hz],|H| [dB],phase H [deg]", "logarithmic"),
        ("f [Hz],|H| [1],phase H [deg]", "is negative, but a modulus can't be"),
        ("f [Hz],f [kHz],|H| [1]", "the same quantity as column 'f [Hz]'"),
    ):
        bad = write(tmp_path / "bad.csv", header, [f, H.real, H.imag])
        assert main(["modal", str(bad)]) == 2
        err = capsys.readouterr().err
        assert says in err and "bad.csv" in err and err.count("\n") == 1
    dead = write(tmp_path / "dead.csv", "f [Hz],Re H [1],Im H [1]", [f, 0 * f, 0 * f])
    assert main(["modal", str(dead)]) == 2
    assert "nothing was measured" in capsys.readouterr().err
    assert main(["modal", str(a), "--from", "5000"]) == 2
    assert "runs from 1500 Hz to 1700 Hz" in capsys.readouterr().err
