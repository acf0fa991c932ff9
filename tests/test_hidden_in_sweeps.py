"""What a search of sweeps passes by when it goes from the base's optimum, or from one effect to the next."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coils import verdict

import modelgen as mg
from modelgen.api import read_case
from modelgen.diagnose import diagnose
from modelgen.models import load
from modelgen.truths import draw, write_case


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "kind", "domain", "effects", "noise", "ratio", "named"),
    [
        pytest.param(
            202700067, "pair", "impedance", ("contact_damping", "structural_damping"), "white", 6.0,
            {"contact_damping", "structural_damping"}, id="either alone is no better than other effects",
        ),
        pytest.param(
            202700065, "single", "impedance", "coil_capacitance", "calibration", 3.0, {"coil_capacitance"},
            id="the base's best optimum is not the one near the truth",
        ),
        pytest.param(
            202700305, "novel", "gmm", "novel:cavity_comb", "white", 1.5, {"unknown_mechanical"},
            id="one member of a row is in the band, and narrow",
        ),
        pytest.param(
            9009, "variant", "impedance", "lossy_rod", "white", 3.0, {"distributed_rod"},
            id="waves in a heavy spring, from a base that is bent to them",
        ),
        pytest.param(
            203000013, "variant", "impedance", "lossy_rod", "white", 6.0, {"distributed_rod"},
            id="a joint does nearly as well, and hides where the rod resonates",
        ),
        pytest.param(
            202900214, "pair", "gmm", ("second_mode", "contact_damping"), "misstated", 3.0,
            {"second_mode", "contact_damping"}, id="a narrow resonance beside a loss, in no beam",
        ),
        pytest.param(
            202900235, "pair", "gmm", ("inertia", "maxwell_branch"), "calibration", 3.0,
            {"inertia", "maxwell_branch"}, id="a part explains less than another single effect does",
        ),
        pytest.param(
            203300172, "pair", "impedance", ("distributed_rod", "second_mode"), "quantised", None,
            {"distributed_rod", "second_mode"}, id="a rod rings within a part of a hundred of the frequency",
        ),
        pytest.param(
            810100305, "pair", "gmm", ("second_mode", "contact_damping"), "calibration", None,
            {"second_mode", "contact_damping"}, id="another partner has led the resonance to its place",
        ),
        pytest.param(
            204600070, "variant", "impedance", "lossy_rod", "calibration", 6.0, {"distributed_rod"},
            id="two other effects together leave next to nothing",
        ),
        pytest.param(
            300100082, "pair", "impedance", ("inertia", "contact_damping"), "calibration", 6.0,
            {"inertia", "contact_damping"}, id="a law of more numbers has the place of a plain loss",
        ),
        pytest.param(
            290100020, "pair", "impedance", ("contact_damping", "structural_damping"), "calibration", 20.0,
            {"contact_damping", "structural_damping"}, id="a bent base tells no first order of two losses",
        ),
        pytest.param(
            300100174, "variant", "gmm", "lossy_rod", "coloured", 3.0, {"distributed_rod"},
            id="a law of more numbers says the smooth error of the instrument",
        ),
    ],
)  # fmt: skip
def test_it_is_found_all_the_same(
    tmp_path: Path,
    seed: int,
    kind: str,
    domain: str,
    effects: str | tuple[str, str],
    noise: str,
    ratio: float | None,
    named: set[str],
) -> None:
    case = read_case(write_case(draw(seed, kind, domain, effects, noise=noise, ratio=ratio), tmp_path))
    v = diagnose(case, load(case.model))
    assert {e.id for e in v.effects} == named
    assert v.after.holdout_over_noise < 1.3


@pytest.mark.slow
def test_a_lag_is_found_in_a_stiffness_without_its_angle(tmp_path: Path) -> None:
    """Its first order vanishes there: |1/(1 + jωτ)| falls with the square of τ."""
    f, rng = np.geomspace(0.5, 100, 60), np.random.default_rng(4)
    x = 2 * np.pi * f * 6e-4
    text = 'model = "complex_stiffness"\n[noise]\nk_s = 1e-3\n'
    model = mg.build(load("complex_stiffness"))
    for k, A in enumerate((0.5, 0.2)):
        K = model(f=f, k_D=1.0, c_D=2e-4, h_D=0.05, rho=8.0, A_z=A)[0] / np.sqrt(1 + x**2)
        table = np.column_stack([f, K + 1e-3 * rng.standard_normal(len(f))])
        np.savetxt(tmp_path / f"r{k}.csv", table, delimiter=",", header="f [Hz],k_s [N/mm]", comments="")
        text += f'[[recording]]\nfile = "r{k}.csv"\nconstants = {{ A_z = {A} }}\n'
    (tmp_path / "case.toml").write_text(text)
    case = read_case(tmp_path / "case.toml")
    v = diagnose(case, load(case.model))
    told = {v.effects[0].id, *v.effects[0].equivalents}
    assert {"force_sensor_lag", "inertia"} <= told  # a mass and a loss make the same modulus


@pytest.mark.slow
@pytest.mark.parametrize("lossy", [False, True])
def test_a_dielectric_that_loses_energy(tmp_path: Path, lossy: bool) -> None:
    """A piezoelectric stack without and with a loss angle of its dielectric and of its elasticity."""
    C, phi, M, K, R, level = 1.1e-9, 0.21, 2.3e-3, 9.1e8, 14.0, 5e-4
    rng, f = np.random.default_rng(5), np.geomspace(60, 160, 301)
    w = 2e3 * np.pi * f
    text = f'model = "piezoelectric_transducer"\n[noise]\nZ_relative = {level}\n'
    for k, added in enumerate((0.0, 4e-4)):
        Z_m = R + 1j * w * (M + added) + K * (1 + 6e-3j * lossy) / (1j * w)
        Z = 1 / (1j * w * C * (1 - 0.018j * lossy) + phi**2 / Z_m)
        noise = rng.standard_normal((2, len(f)))
        Z = Z * (1 + level / np.sqrt(2) * (noise[0] + 1j * noise[1]))
        header = "f [kHz],Re Z [ohm],Im Z [ohm]"
        table = np.column_stack([f, Z.real, Z.imag])
        np.savetxt(tmp_path / f"r{k}.csv", table, delimiter=",", header=header, comments="")
        text += f'[[recording]]\nfile = "r{k}.csv"\nconstants = {{ M_m = {M + added} }}\n'
    (tmp_path / "case.toml").write_text(text)
    case = read_case(tmp_path / "case.toml")
    v = diagnose(case, load(case.model))
    assert {e.id for e in v.effects} == ({"dielectric_loss", "structural_damping"} if lossy else set())
    assert v.adequate is not lossy
    if lossy:  # what is shown at the dielectric's port is the dielectric's alone
        assert v.curve is not None and v.curve.port == "electrical"
        assert np.median(np.abs(v.curve.implied + 0.018j * C)) < 0.05 * 0.018 * C


@pytest.mark.slow
def test_what_a_stated_noise_cannot_be_is_claimed_whatever_its_colour(tmp_path: Path) -> None:
    """Coloured noise of the stated level leaves the base three times that level: something is missing, and
    the softening that takes it away is named."""
    secret = draw(760100112, "single", "stiffness", "payne_softening", noise="coloured", ratio=1.5)
    write_case(secret, tmp_path)
    case = read_case(tmp_path / "case.toml")
    assert "payne_softening" in diagnose(case, load(case.model)).effects[0].id


def test_the_air_in_the_port_of_a_box_is_another_resonator(tmp_path: Path) -> None:
    """A bass-reflex enclosure: the box's air is a spring to the port's, which rubs at the port (Q = 9)."""
    f = np.geomspace(8, 1500, 300)
    s, wb = 2j * np.pi * f, 2 * np.pi * 55.0
    box, port = 3e3, 3e3 / wb**2
    vented = 1 / (s / box + 1 / (s * port + port * wb / 9))
    v = verdict(tmp_path, f, 6 + 3e-4 * s + 36 / (1 + 0.013 * s + 2e3 / s + vented))
    assert [(e.id, e.port) for e in v.effects] == [("second_mode", "mechanical")]
    assert v.after.fit_over_noise == pytest.approx(1.0, abs=0.1) and v.before.fit_over_noise > 20
    found = {e.name: e.value for e in v.effects[0].parameters}
    assert found["omega_3"] == pytest.approx(wb, rel=0.02) and found["Q_3"] == pytest.approx(9, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("grows", [lambda f: np.sqrt(f / 1500), lambda f: np.hypot(1, f / 300) - 1])
def test_a_resistance_that_grows_without_a_reactance(tmp_path: Path, grows: Callable[[Any], Any]) -> None:
    """As measured values of a winding are often given: no eddy current's law, which changes both."""
    f = np.geomspace(8, 1500, 300)
    s = 2j * np.pi * f
    v = verdict(tmp_path, f, 6 + 0.15 * grows(f) + 3e-4 * s + 36 / (1 + 0.013 * s + 2e3 / s))
    assert [e.id for e in v.effects] == ["coil_ac_resistance"]
    assert v.before.fit_over_noise > 2 and v.after.fit_over_noise < 1.1


@pytest.mark.slow
def test_an_effect_that_is_larger_than_what_it_is_added_to(tmp_path: Path) -> None:
    """A winding whose resistance grows sixtyfold bends the base so far that no optimum is left near the
    truth: descents from the bent one end ten times the noise away."""
    write_case(draw(203400081, "variant", "impedance", "proximity", noise="coloured", ratio=20.0), tmp_path)
    case = read_case(tmp_path / "case.toml")
    v = diagnose(case, load(case.model))
    assert [e.id for e in v.effects] == ["coil_ac_resistance"]
    assert v.before.fit_over_noise > 20 and v.after.holdout_over_noise < 1.2
