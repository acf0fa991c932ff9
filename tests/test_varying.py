"""Parameters that vary with a condition of a recording: levels, powers, derivatives, and a joint fit."""

import numpy as np
import pytest

from modelgen.codegen import build
from modelgen.errors import InputError
from modelgen.fit.fitting import fit
from modelgen.language import Parameter, varying
from modelgen.models.complex_stiffness import complex_stiffness
from modelgen.models.magnetostrictive_transducer import magnetostrictive_transducer
from modelgen.models.modified_dahl import build as dahl
from modelgen.models.modified_dahl import modified_dahl
from modelgen.recordings import Case, Noise, Recording

M = Parameter("M", "1", 0.0, (0.0, 1.0), "magnets on", known=True)
A_z = Parameter("A_z", "mm", 0.4, (1e-3, 1e3), "amplitude", known=True)
F = np.array([0.5, 1.0, 3.0, 9.0])


def test_a_switch_has_the_two_levels() -> None:
    model = varying(complex_stiffness, ("k_D", "rho"), M)
    f, plain = build(model), build(complex_stiffness)
    off, on = (f(f=F, M=m, k_D=0.4, k_D_M=0.3, rho=1.4, rho_M=0.2)[0] for m in (0.0, 1.0))
    assert off == pytest.approx(plain(f=F, k_D=0.4, rho=1.4)[0], rel=1e-14)
    assert on == pytest.approx(plain(f=F, k_D=0.7, rho=1.6)[0], rel=1e-14)
    assert f(f=F, M=1.0)[0] == pytest.approx(plain(f=F)[0], rel=1e-14)  # nothing varies by default


def test_a_power_and_an_initial_value() -> None:
    model = varying(varying(dahl("steady"), ("rho",), M), ("rho", "k_D"), A_z, "power")
    t = np.linspace(0, 2, 200)
    motion = {"t": t, "z": -np.cos(np.pi * t), "v": np.pi * np.sin(np.pi * t)}
    values = {"rho_M": 0.5, "rho_A_z": -0.7, "k_D_A_z": 0.3}
    ratio = 1.2 / 0.4
    same = {"rho": 1.46 * ratio**-0.7 + 0.5, "k_D": 0.3834 * ratio**0.3, "A_z": 1.2}
    ours = build(model)(**motion, **values, M=1.0, A_z=1.2)
    assert ours == pytest.approx(build(dahl("steady"))(**motion, **same), rel=1e-12)


@pytest.mark.slow
def test_one_fit_finds_base_and_change() -> None:
    model = varying(modified_dahl, ("k_D", "h_D"), M)
    f, rng, t = build(model), np.random.default_rng(0), np.arange(0, 3, 0.01)
    motion = {"z": -2 * np.cos(2 * np.pi * t), "v": 4 * np.pi * np.sin(2 * np.pi * t)}
    recordings = tuple(
        Recording(
            f"M{m:.0f}", None, "fit", {"t": t, "z": motion["z"]},
            {"F": f(t=t, **motion, M=m, k_D_M=0.3, h_D_M=0.2) + 1e-3 * rng.standard_normal(t.size)},
            constants={"M": m},
        )
        for m in (0.0, 1.0)
    )  # fmt: skip
    found = fit(model, Case(None, model.id, recordings, noise=Noise(sigma={"F": 1e-3})))
    for name, true in (("k_D", 0.3834), ("k_D_M", 0.3), ("h_D", 0.0353), ("h_D_M", 0.2)):
        assert found[name].value == pytest.approx(true, abs=4 * found[name].std), name
        assert found[name].std < 2e-3


def test_wrong_conditions_are_told() -> None:
    with pytest.raises(InputError, match="did you mean 'k_D'"):
        varying(complex_stiffness, ("k_d",), M)
    with pytest.raises(InputError, match="default above 0"):
        varying(complex_stiffness, ("k_D",), M, "power")
    with pytest.raises(InputError, match="law"):
        varying(complex_stiffness, ("k_D",), M, "cubic")
    with pytest.raises(InputError, match="part of a complex parameter"):
        varying(magnetostrictive_transducer, ("mu33_re",), M)
