"""What a fit in stages says of parameters that it cannot tell apart, and of recordings that it never saw."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import modelgen.models as models
from modelgen.codegen import build
from modelgen.errors import InputError
from modelgen.fit import GaussNewton, Recipe, Stage, run_recipe
from modelgen.fit.fitting import fit
from modelgen.language import (
    ComplexParameter,
    Equation,
    Input,
    Model,
    Output,
    Parameter,
    complex_parameter,
    j,
)
from modelgen.recordings import Case, Recording

f_ = Input("f", "1")
F = np.geomspace(0.1, 10, 60)
SPEAKER = models.electrodynamic_transducer
DIRECT = Recipe("direct", (Stage("complex", "all", GaussNewton()),))
TWO = Recipe("two", (Stage("modulus", "all", GaussNewton()), Stage("phase", "all", GaussNewton())))


def sweep(model: Model, seed: int = 0, role: str = "fit", noise: float = 1e-3, **true: float) -> Recording:
    f = np.geomspace(20, 2000, 60) if model is SPEAKER else F
    rng = np.random.default_rng(seed)
    z = np.asarray(build(model)(f=f, **true))
    z = z + noise * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    return Recording(f"{role}{seed}", None, role, {"f": f}, {"Z": z}, {"Z": "complex"})


def of(model: Model, *recordings: Recording) -> Case:
    return Case(None, model.id, recordings)


def series_resistances(powers: bool) -> Model:
    R, U, L = (Parameter(n, "1", 2.0, (0.1, 100.0)) for n in "RUL")
    resistance = R * U / 3 if powers else R + U
    return Model("two_in_a_row", (f_,), (R, U, L), (Equation("Z", resistance + j * L * f_),), (Output("Z"),))


def test_a_fit_in_stages_says_what_it_leaves_open_as_any_other() -> None:
    case = of(SPEAKER, sweep(SPEAKER, noise=0.01))
    plain, staged = fit(SPEAKER, case, GaussNewton()), fit(SPEAKER, case, DIRECT)
    assert staged.rank == plain.rank == 5 and staged.undetermined == plain.undetermined
    for e in staged.parameters:
        assert e.determined == plain[e.name].determined == (e.name in ("R_e", "L_e")), e.name
        assert np.isnan(e.std) != e.determined
    assert "Bl, M_m, K_m and R_m apart" in staged.undetermined[0]


@pytest.mark.parametrize("powers, only", [(False, "R + U"), (True, "R*U")])
def test_what_is_known_of_two_is_named(powers: bool, only: str) -> None:
    model = series_resistances(powers)
    found = fit(model, of(model, sweep(model)), DIRECT)
    assert found.undetermined == (f"the data don't determine R and U apart: only {only}",)
    assert found.rank == 2 and found["L"].std > 0 and np.isnan(found.correlation[0]).all()


def test_a_parameter_wider_than_its_bounds_is_not_determined() -> None:
    R, U = Parameter("R", "1", 2.0, (0.1, 9.0)), Parameter("U", "1", 0.5, (0.4, 0.6))
    model = Model("faint", (f_,), (R, U), (Equation("Z", R + j * f_ * U * 1e-5),), (Output("Z"),))
    found = fit(model, of(model, sweep(model)), DIRECT)
    assert found["R"].determined and not found["U"].determined and np.isnan(found["U"].std)
    assert found.undetermined == ("the data say nothing about U within the bounds",) and found.rank == 1


def complex_one(name: str, default: complex) -> ComplexParameter:
    return complex_parameter(name, "1", default, re=(0.1, 90.0), im=(-9.0, 9.0))


def test_a_later_stage_inherits_what_was_left_open() -> None:
    c, d = complex_one("c", 2 + 0j), complex_one("d", 3 + 0.5j)
    Z = c.re + d.re + j * (c.im * c.re + d.im * f_)  # c'' is known by its product with c', that with d' alone
    model = Model("in_part", (f_,), (c, d), (Equation("Z", Z),), (Output("Z"),))
    stages = (Stage("complex", "real", GaussNewton()), Stage("complex", "imaginary", GaussNewton()))
    found = run_recipe(Recipe("both", stages), model, of(model, sweep(model, c_im=1.0)))
    known = dict(zip(found.names, found.determined.tolist(), strict=True))
    assert known == {"c_re": False, "c_im": False, "d_re": False, "d_im": True} and found.rank == 3
    (said,) = found.undetermined
    assert all(n in said.partition(":")[0] for n in ("c_re", "c_im", "d_re")) and np.isnan(found.std("c_im"))


def test_a_later_stage_closes_what_was_left_open() -> None:
    c, d, k = complex_one("c", 2 + 1j), complex_one("d", 3 + 0.5j), Parameter("k", "1", 1.0)
    Z = c.re + d.re * f_ + j * (c.im + d.im * (1 + k * f_))
    model = Model("by_k", (f_,), (c, d, k), (Equation("Z", Z),), (Output("Z"),))
    first = Stage("complex", "all", GaussNewton(), {"k": 0.0})  # c'' and d'' are told apart by k alone
    case = replace(of(model, sweep(model)), constants={"k": 1.0})
    before = run_recipe(Recipe("one", (first,)), model, case)
    assert dict(zip(before.names, before.determined.tolist(), strict=True)) == {
        "c_re": True, "c_im": False, "d_re": True, "d_im": False,
    }  # fmt: skip
    both = run_recipe(Recipe("both", (first, Stage("complex", "imaginary", GaussNewton()))), model, case)
    assert both.determined.all() and both.rank == 4 and both.undetermined == ()
    assert both.values["d_im"] == pytest.approx(0.5, abs=0.01) and 0 < both.std("d_im") < 0.01


def test_what_is_held_out_is_predicted_in_each_measure() -> None:
    model = series_resistances(False)
    more = [sweep(model, 1, "holdout"), sweep(model, 2, "holdout", L=2.1)]
    case = replace(of(model, sweep(model), *more), constants={"U": 2.0})
    found = fit(model, case, TWO)
    assert [(r.file, r.role) for r in found.recordings] == [
        ("fit0", "fit"), ("holdout1", "holdout"), ("holdout2", "holdout"),
    ]  # fmt: skip
    alike, other = found.recordings[1:]
    Z = build(model)(f=F, **found.values, U=2.0)
    assert other.unit == "1" and other.others[0][1] == "deg" and len(other.outputs) == 2
    phase = np.degrees(np.angle(more[1].outputs["Z"] / Z))
    assert other.others[0][0] == pytest.approx(np.sqrt(np.mean(phase**2)), rel=1e-6)
    assert alike.rms < 2e-3 < 0.05 < other.rms
    assert found.rms["1"]["holdout"] == pytest.approx(np.hypot(alike.rms, other.rms) / 2**0.5)
    assert found.to_dict()["rms"]["holdout"] > 0.05 and "on what is held out" in found.notes[0]
    without = fit(model, replace(case, recordings=case.fit), TWO)
    assert without.values == found.values and set(without.rms["1"]) == {"fit"}


def test_what_is_held_out_in_another_measure_is_refused() -> None:
    model = series_resistances(False)
    held = sweep(model, 1, "holdout")
    held = replace(held, outputs={"Z": np.abs(held.outputs["Z"])}, kinds={"Z": "modulus"})
    with pytest.raises(InputError, match="'holdout1' holds the modulus of Z alone, its phase is wanted"):
        fit(model, of(model, sweep(model), held), TWO)
