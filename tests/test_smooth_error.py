"""A Gaussian process that nobody stated, against dense matrices; what motion errors give, against records."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen.models
from modelgen.diagnose import diagnose
from modelgen.diagnose.diagnosis import set_up
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.noise.replica import motion_matters, on, replicas, undeserved
from modelgen.diagnose.noise.smooth_error import (
    SIZES,
    Smooth,
    _deviances,
    _groups,
    _seen,
    part_of_reading,
    smooth_error,
    with_smooth,
)
from modelgen.effects import CATALOGUE
from modelgen.fit.series import signature_of
from modelgen.fit.together import Together, smooth_modes
from modelgen.fit.whitener import Whitener
from modelgen.language import Equation, Input, Model, Parameter, Port, j, pi
from modelgen.recordings import Case, Recording, load_case, read_case_file
from modelgen.truths import draw, write_case

RNG = np.random.default_rng(3)


def _kernel(x: np.ndarray, length: float) -> np.ndarray:
    return np.exp(-0.5 * ((x[:, None] - x[None, :]) / length) ** 2)


def _dense(x: list[np.ndarray], channels: list[int], shared: bool) -> np.ndarray:
    """The process' covariance over all residuals, of unit size."""
    modes, size = smooth_modes(x, 0.6), sum(len(s) * c for s, c in zip(x, channels, strict=True))
    K = np.zeros((size, size))
    for group in _groups([len(s) for s in x], channels, shared):
        B = np.zeros((size, modes[0].shape[1]))
        for m, rows in group:
            B[rows] = modes[m]
        K += B @ B.T
    return K


def test_likelihoods_are_those_of_the_dense_covariance() -> None:
    x = np.linspace(3, 8, 60)
    K = _dense([x], [2], shared=False)
    assert np.allclose(K[:60, :60], _kernel(x, 0.6), atol=0.03)  # interpolated between knots
    r, J = RNG.standard_normal(120), np.linalg.qr(RNG.standard_normal((120, 3)))[0]
    seen = _seen(smooth_modes([x], 0.6), _groups([60], [2], False), np.ones(120), np.column_stack([r, J]))
    for rms, got in _deviances(r, J, *seen, 120):
        inverse = np.linalg.inv(np.eye(120) + rms**2 * K)
        free = J @ np.linalg.solve(J.T @ inverse @ J, J.T @ inverse @ r)
        left = (r - free) @ inverse @ (r - free)
        wanted = 120 * np.log(left / 120) - np.linalg.slogdet(inverse)[1]
        assert got == pytest.approx(wanted, abs=0.05)


def test_an_error_shared_by_sweeps_is_the_same_in_all_and_apart_in_real_and_imaginary() -> None:
    x = np.linspace(3, 8, 40)
    K = _dense([x, x], [2, 2], shared=True).reshape(4, 40, 4, 40)
    assert np.allclose(K[0, :, 0], K[0, :, 2])
    assert np.allclose(K[0, :, 1], 0)
    assert np.allclose(_dense([x, x], [2, 2], shared=False).reshape(4, 40, 4, 40)[0, :, 2], 0)


def test_the_process_whitens_what_it_makes() -> None:
    x = np.linspace(3, 8, 60)
    w = with_smooth((Whitener(np.ones((1, 60))),), [x], Smooth(2.0, 0.6, shared=False))[0]
    assert w.root is not None
    K = np.eye(60) + 4 * _kernel(x, 0.6)
    root = w.root.apply(np.eye(60))
    assert np.allclose(root @ K @ root.T, np.eye(60), atol=1e-4)


@pytest.mark.parametrize(("noise", "found"), [("white", False), ("coloured", True)])
def test_a_smooth_error_is_found_where_there_is_one(tmp_path: Path, noise: str, found: bool) -> None:
    write_case(draw(7, kind="none", domain="impedance", noise=noise), tmp_path)
    file = read_case_file(tmp_path / "case.toml")
    model = modelgen.models.load(file.model)
    ground = prepare(model, load_case(file, signature_of(model)), 0)
    _, gain, process = smooth_error(ground.judge, ground.base)
    assert (process is not None) is found
    assert (gain > 0) is found
    assert process is None or process.rms in SIZES


@pytest.mark.slow
def test_a_law_that_is_far_off_is_no_error_of_the_instrument() -> None:
    """A ferrite choke beyond its self-resonance: two relaxations, of which the catalogue's one law leaves
    many times the noise."""
    f = Input("f", "Hz")
    R, L = Parameter("R", "ohm", 0.1, (0.0, 100.0)), Parameter("L", "H", 1e-6, (1e-9, 1.0))
    omega, L_c = Equation("omega", 2 * pi * f, "rad/s"), Equation("L_c", L, "H")
    Z_w = Equation("Z_w", R + j * omega * L_c, "ohm")
    at = (("omega", omega.symbol),)
    ports = (
        Port("winding", "electrical_impedance", "Z_w", at),
        Port("core", "inductance", "L_c", at),
        Port("coil", "terminals", "Z", at),
    )
    coil = Model("coil", (f,), (R, L), (omega, L_c, Z_w, Equation("Z", Z_w, "ohm")), ("Z",), ports)
    rng, hertz = np.random.default_rng(3), np.linspace(5e4, 4e7, 250)
    s = 2j * np.pi * hertz
    late = s / (2 * np.pi * 6e6)
    z = 0.3 + s * 54e-6 / (1 + 0.5 * late**0.8 + 0.05 * late**0.3)
    z = z / (1 + s * 6.5e-12 * z) * (1 + 2e-4 * (rng.normal(size=250) + 1j * rng.normal(size=250)))
    v = diagnose(Case(None, "coil", (Recording("z", None, "fit", {"f": hertz}, {"Z": z}),)), coil)
    assert {e.id for e in v.effects} == {"coil_capacitance", "permeability_relaxation", "eddy_shunt"}
    noise = np.sqrt(2) * 2e-4 * float(np.sqrt(np.mean(np.abs(z) ** 2)))  # ohm
    assert v.before.fit > 1000 * noise
    assert v.after.fit < 2 * noise  # not by counting it as noise


def test_what_motion_errors_alone_give_is_told_by_records_without_the_effect(tmp_path: Path) -> None:
    write_case(draw(11, kind="none", domain="force", noise="displacement"), tmp_path)
    file = read_case_file(tmp_path / "case.toml")
    model = modelgen.models.load(file.model)
    case = load_case(file, signature_of(model))
    ground = prepare(model, case, 0)
    assert motion_matters([s.whitener for s in ground.series])
    made = replicas(model, case, ground.base, ground.judge.whiteners, seed=0)
    again = ground.judge.fit(on(ground.base.hypothesis, made), [ground.base.theta])
    assert again.chi2 == pytest.approx(sum(e.size for e in again.white), rel=0.15)
    inertia = next(a for a in set_up(model, case, ground, CATALOGUE).additions if a.id == "inertia")
    child = make_hypotheses(model, case, ground.series, [(inertia,)])[0]
    fit = ground.judge.fit(child, [np.append(ground.base.theta, 0.0)])
    assert 0 <= undeserved(ground.judge, ground.base, fit, made) < np.inf


def test_a_smooth_error_makes_no_model_smaller(tmp_path: Path) -> None:
    """Weights that hold their own sample's noise would: R_e half a percent too small here, of 0.2 %."""
    f = np.geomspace(20, 2000, 800)
    s = 2j * np.pi * f
    Z = 6.0 + 5e-4 * s + 36.0 / (1.0 + 0.015 * s + 2e3 / s)
    root = np.linalg.cholesky(_kernel(np.log(f), 0.7) + 1e-9 * np.eye(f.size))
    (tmp_path / "case.toml").write_text(
        'model = "electrodynamic_transducer"\n[constants]\nM_m = 0.015\n[noise]\nZ_relative = 2e-3\n'
        'Z_calibration = [3e-3, 0.7]\n[[recording]]\nfile = "a.csv"\nrole = "fit"\n'
    )
    file = read_case_file(tmp_path / "case.toml")
    model = modelgen.models.load(file.model)
    found = []
    for seed in range(5):
        a, b, c, d = np.random.default_rng(seed).standard_normal((4, f.size))
        y = Z * (1 + 3e-3 * root @ (a + 1j * b) + 2e-3 * (c + 1j * d))
        rows = np.column_stack([f, y.real, y.imag])
        header = "f [Hz],Re Z [ohm],Im Z [ohm]"
        np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header=header, comments="")
        base = prepare(model, load_case(file, signature_of(model)), 0).base
        found.append(base.theta[base.hypothesis.experiment.layout.names.index("R_e")] / 6.0 - 1)
    assert abs(np.mean(found)) < 3 * 2e-3 / np.sqrt(5)


@given(st.integers(3, 60), st.floats(0.02, 2.0), st.floats(0.1, 30.0))
@settings(max_examples=30, deadline=None)
def test_errors_together_are_whitened_by_their_modes(n: int, length: float, rms: float) -> None:
    """Against the n by n covariance: cov⁻¹ of what is kept, and samples that are masked aren't touched."""
    lnf = np.log(np.geomspace(20.0, 2e4, n))
    B = rms * smooth_modes([lnf], length)[0]
    covariance = np.eye(n) + rms**2 * np.exp(-0.5 * ((lnf[:, None] - lnf[None, :]) / length) ** 2)
    assert np.allclose(np.eye(n) + B @ B.T, covariance, atol=1e-5 * rms**2)
    white = Together.of(B).apply(np.eye(n))
    assert np.allclose(white @ covariance @ white.T, np.eye(n), atol=1e-5 * rms**2)
    keep = np.where(np.arange(n) == 1, 0.0, 1.0)
    masked = Together.of(B).weighed(keep).apply(np.eye(n))
    assert np.array_equal(masked[1], np.eye(n)[1])
    seen = keep > 0
    part = np.linalg.inv(covariance[np.ix_(seen, seen)])
    assert np.allclose((masked.T @ masked)[np.ix_(seen, seen)], part, atol=1e-4 * (1 + rms**2))


def test_an_error_is_said_as_a_part_of_the_reading() -> None:
    """Seven times a noise of 1e-3 of the reading, in the noisier of two sweeps of 1e-3 and 1e-4."""
    s = [Whitener(np.full((1, 50), 1 / (level * 5.0))) for level in (1e-3, 1e-4)]
    series = [SimpleNamespace(size=np.full(50, 5.0), whitener=w) for w in s]
    assert part_of_reading(series, Smooth(7.0, 0.6, False)) == pytest.approx(7e-3)
