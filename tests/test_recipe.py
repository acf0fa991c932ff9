"""Estimation in stages, the GMM paper's three Methods, and conditions such as passivity."""

from dataclasses import replace

import numpy as np
import pytest

from modelgen.errors import InputError
from modelgen.fit import GaussNewton
from modelgen.fit.conditions import broken
from modelgen.fit.fitting import fit
from modelgen.fit.recipe import run_recipe
from modelgen.models import load
from modelgen.papers.gmm import methods
from modelgen.papers.gmm.truth import DAMPING, MODEL, RANGE, SIX, TRUE, case
from modelgen.recordings import Case, Noise, Recording

WIDE = {"d33_im": (-9e-10, 9e-10), "S33_im": (-1e-11, 1e-11), "mu33_im": (-3.0, 3.0)}


def wide(data: Case) -> Case:
    return replace(data, bounds=data.bounds | WIDE)


def test_method_1_without_damping_puts_it_into_the_compliance() -> None:
    found = run_recipe(methods.METHOD_1, MODEL, wide(case(noise=0.0)), constrained=True)
    assert found.stages[0].objective < 1e-5  # ohm: the data cannot object
    assert found.values["S33_im"] == pytest.approx(-9.566e-13, rel=1e-3)  # errata 17
    assert found.values["d33_im"] < RANGE["d33_im"][0]  # which the paper's ranges exclude


def test_in_the_papers_ranges_method_1_finds_a_mirror_that_no_passive_rod_has() -> None:
    found = run_recipe(methods.METHOD_1, MODEL, case(noise=0.0))
    assert found.stages[0].objective < 2e-5
    assert found.values["S33_im"] == pytest.approx(+9.566e-13, rel=1e-3)
    default = {p.name: p.default for p in MODEL.scalar_parameters}
    assert any("compliance is lossy" in line for line in broken(MODEL, default | dict(found.values)))


def test_method_3_with_the_right_damping_is_right() -> None:
    found = run_recipe(methods.method_3(damped=True), MODEL, case(noise=0.0))
    assert found.stages[1].unit == "deg" and found.stages[1].names == ("mu33_im", "S33_im", "d33_im")
    for name in SIX:
        assert found.values[name] == pytest.approx(TRUE[name], rel=1e-5), name


def test_method_3_is_as_right_as_the_damping() -> None:
    wrong = case(noise=0.0, damping=DAMPING | {"R_f": 324.5469})
    moved = run_recipe(methods.method_3(damped=True), MODEL, wide(wrong))
    change = moved.values["S33_im"] - TRUE["S33_im"]
    assert change == pytest.approx(2.08e-15 * (324.5469 - 349.2303), rel=0.02)  # errata 17


def test_linear_uncertainty_agrees_with_refits() -> None:
    recipe = methods.method_3(GaussNewton(), damped=True)
    spread = {"R_f": 3.0264, "R_d": 0.439}
    rng = np.random.default_rng(3)
    found = []
    for k in range(80):
        believed = {n: v + spread[n] * rng.standard_normal() for n, v in DAMPING.items()}
        found.append(list(run_recipe(recipe, MODEL, wide(case(1.0, k, damping=believed))).values.values()))
    known = run_recipe(recipe, MODEL, wide(case(1.0, 99)), uncertain=spread)
    ratio = np.std(found, axis=0, ddof=1) / [known.std(n) for n in known.names]
    assert np.all((ratio > 0.75) & (ratio < 1.3)), ratio


def test_recipe_as_a_fit_tells_its_stages() -> None:
    result = fit(MODEL, case(), methods.method_3(GaussNewton(), damped=True))
    assert result.rms["ohm"]["fit"] == pytest.approx(0.00046, rel=0.1)
    assert [n.split(":")[0] for n in result.notes[:2]] == ["stage 1", "stage 2"]
    assert set(result.values) == set(SIX)
    with pytest.raises(InputError, match="begins by itself"):
        fit(MODEL, case(), methods.METHOD_1, start={"mu33_re": 2.5})


def test_recordings_of_another_measure_are_refused() -> None:
    whole = case()
    sweep = replace(
        whole.recordings[0], outputs={"Z": np.abs(whole.recordings[0].outputs["Z"])}, kinds={"Z": "modulus"}
    )
    with pytest.raises(InputError, match="holds the modulus of Z alone, its phase is wanted"):
        run_recipe(methods.METHOD_3, MODEL, replace(whole, recordings=(sweep,)))


def test_constrained_fit_stays_passive_where_the_free_one_does_not() -> None:
    # Method 2's means of Table 7 are no passive material: d''² > μ_0 μ'' S''
    active = {"mu33_im": -0.040, "S33_im": -7.170e-15, "d33_im": -2.435e-11}
    data = replace(case(true=TRUE | active), noise=Noise(sigma={"Z": 4.6e-4}))
    free = fit(MODEL, data, GaussNewton())
    told = "break a rule of passive devices, that no power comes from the coupling; `--constrained` fits"
    assert any(told in note for note in free.warnings)
    kept = fit(MODEL, data, GaussNewton(), constrained=True)
    assert not any("passive" in note for note in kept.notes)
    assert kept.rms_over_noise["fit"] > 2 * free.rms_over_noise["fit"]


def test_a_recipe_of_impedances_says_so_where_a_force_is_recorded() -> None:
    way = np.sin(np.arange(50) / 5)
    record = Recording("run", None, "fit", {"t": np.arange(50) / 100, "z": way}, {"F": 2 * way})
    with pytest.raises(InputError, match=r"'run' holds F, which is real: .* models of an impedance"):
        fit(load("kelvin_voigt"), Case(None, "kelvin_voigt", (record,)), methods.METHOD_3)
