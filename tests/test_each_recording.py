"""What a fit looks at in each recording, not in the first alone; starts; profiles as the fit ended."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import modelgen.models as models
from modelgen.codegen import build
from modelgen.errors import InputError
from modelgen.fit import GaussNewton, profiles
from modelgen.fit.experiment import experiment
from modelgen.fit.fitting import fit
from modelgen.fit.motion import with_motion
from modelgen.fit.series import make_series
from modelgen.language import Equation, Input, Model, Output, Parameter, j
from modelgen.recordings import Case, Noise, Recording

ROD = models.magnetostrictive_transducer
DAHL = models.modified_dahl
LIKE_A_SIGMA = 0.6827
f_ = Input("f", "Hz")
COIL = Model(
    "coil",
    (f_,),
    (Parameter("R", "ohm", 5.0, (0.0, 100.0)), Parameter("L", "H", 1.0, (0.0, 100.0))),
    (Equation("Z", Parameter("R", "ohm", 5.0) + j * f_ * Parameter("L", "H", 1.0), "ohm"),),
    (Output("Z"),),
)


def rods(order: str, signs: dict[str, float]) -> Case:
    """Sweeps of rods with losses of these signs: one below zero is no passive material's."""
    known = {p.name: p.default for p in ROD.scalar_parameters if p.default is not None}
    f, found = np.geomspace(100, 5000, 60), {}
    for k, (name, sign) in enumerate(sorted(signs.items())):
        rng = np.random.default_rng(k)
        z = np.asarray(build(ROD)(f=f, S33_im=sign * known["S33_im"]))
        z = z * (1 + 1e-3 * (rng.standard_normal(60) + 1j * rng.standard_normal(60)))
        found[name] = Recording(name, None, "fit", {"f": f}, {"Z": z}, {"Z": "complex"})
    held = {n: v for n, v in known.items() if n not in ("S33_re", "S33_im")}
    return Case(
        None, ROD.id, tuple(found[n] for n in order), constants=held, per_recording=("S33_im",),
        noise=Noise(relative={"Z": 1e-3}), bounds={"S33_im": (-1e-10, 1e-10)},
    )  # fmt: skip


def told(case: Case) -> set[str]:
    return {n for n in fit(ROD, case, GaussNewton()).warnings if "break a rule" in n}


def test_a_broken_rule_is_told_whichever_recording_comes_first() -> None:
    signs = {"a": 1.0, "b": -1.0}
    said = told(rods("ab", signs))
    assert said == told(rods("ba", signs)) and len(said) == 2
    assert all(n.startswith("in 'b' these values break a rule of passive devices") for n in said)


def test_where_all_recordings_break_it_none_is_named() -> None:
    said = told(rods("ab", {"a": -1.0, "b": -1.0}))
    assert said and all(n.startswith("these values break a rule") for n in said)


def coil(noise: Noise | None = None) -> Case:
    """A coil whose inductance falls with frequency, which the model leaves out."""
    f, rng = np.geomspace(20, 2000, 80), np.random.default_rng(0)
    z = 6 + 1j * f * 2e-2 * (1 - 0.1 * np.log10(f / 200))
    z = z + 1e-3 * (rng.standard_normal(80) + 1j * rng.standard_normal(80))
    recording = Recording("sweep", None, "fit", {"f": f}, {"Z": z}, {"Z": "complex"})
    return Case(None, "coil", (recording,), noise=noise or Noise())


@pytest.mark.parametrize(
    "start", [float("nan"), float("inf"), None, "6", 1j, [6.0], pytest.param(10**400, id="huge")]
)
def test_a_start_is_a_finite_number(start: Any) -> None:
    with pytest.raises(InputError, match=r"start: 'R' is .*, wanted a finite number"):
        fit(COIL, coil(), GaussNewton(), start={"R": start})


@pytest.mark.parametrize("start", [6, 6.0, np.float32(6), np.array(6.0)])
def test_any_number_is_a_start(start: Any) -> None:
    assert fit(COIL, coil(), GaussNewton(), start={"R": start})["R"].value == pytest.approx(6, rel=0.1)


@pytest.mark.parametrize("noise", [None, Noise(sigma={"Z": 1e-3})])
def test_profiles_are_as_wide_as_the_fit_says(noise: Noise | None) -> None:
    case = coil(noise)
    found = fit(COIL, case, GaussNewton())
    assert found.rms_over_noise["fit"] > 50
    with ThreadPoolExecutor(1) as pool:
        for p in profiles(COIL, case, found, level=LIKE_A_SIGMA, executor=pool):
            assert (p.high - p.low) / 2 == pytest.approx(found[p.name].std, rel=0.01), p.name


def test_profiles_allow_for_errors_of_the_motion_as_the_fit_does() -> None:
    true = {"k_D": 0.6797, "c_D": 0.1374, "h_D": 0.2309, "rho": 1.44, "F_0": 1.3, "r_0": -0.8}
    t, rng = np.arange(600) / 300.0, np.random.default_rng(1)
    z = -3 * np.cos(5.65 * t) * (0.7 + 0.3 * np.cos(0.82 * t))
    force = build(DAHL)(t=t, z=z, **true) + 5e-4 * rng.standard_normal(t.size)
    inputs = {"t": t, "z": z + 5e-3 * rng.standard_normal(t.size)}
    recording = Recording("a", None, "fit", inputs, {"F": force}, {"F": "real"})
    case = Case(None, DAHL.id, (recording,), noise=Noise(sigma={"F": 5e-4, "z": 5e-3}))
    found = fit(DAHL, case, GaussNewton(), start=true)
    ex = experiment(DAHL, case, [make_series(DAHL, case, recording)])
    theta = np.array([found[n].value for n in ex.layout.names])
    assert with_motion(ex, case, case.fit, theta) is not ex
    with ThreadPoolExecutor(1) as pool:
        (p,) = profiles(DAHL, case, found, ["k_D"], level=LIKE_A_SIGMA, executor=pool)
    assert (p.high - p.low) / 2 == pytest.approx(found["k_D"].std, rel=0.1)
    assert p.better is None
