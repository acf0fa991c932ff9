"""What a fit tells beside its numbers: outliers, noise with a colour, units of a header, and of a folder."""

from __future__ import annotations

import json
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import modelgen as mg
from modelgen.cli import main
from modelgen.cli.methods import read_method
from modelgen.fit.fitting import fit
from modelgen.fit.remarks import Array
from modelgen.fit.result import FitResult
from modelgen.language import Equation, Input, Model, Parameter, State, Symbol, sin
from modelgen.models import kelvin_voigt
from modelgen.recordings import Case, Recording
from modelgen.recordings.case import Noise
from modelgen.report.words import number

SIGMA = 2e-3
t = np.arange(2000) / 200


def record(
    name: str = "a", amplitude: float = 1.0, noise: Array | float = 0.0, times: float = 1.0, role: str = "fit"
) -> Recording:
    z = amplitude * np.sin(np.pi * t) * (1 + 0.3 * np.sin(0.9 * t))
    F = 0.7 * z + 0.05 * np.gradient(z, t) + noise
    return Recording(name, None, role, {"t": t, "z": z}, {"F": F * times})


def white(seed: int = 0) -> Array:
    return SIGMA * np.random.default_rng(seed).standard_normal(t.size)


def coloured(rho: float) -> Array:
    e = white()
    for k in range(1, t.size):
        e[k] += rho * e[k - 1]
    return e


def fitted(*recordings: Recording, sigma: float | None = None) -> FitResult:
    noise = Noise(sigma={} if sigma is None else {"F": sigma})
    return fit(kelvin_voigt, Case(None, "kelvin_voigt", recordings, noise=noise))


def test_of_independent_noise_nothing_is_said() -> None:
    assert fitted(record(noise=white()), record("b", 2.0, white(1))).warnings == ()


def test_noise_that_is_stated_far_too_large() -> None:
    told = [n for n in fitted(record(noise=white()), sigma=100 * SIGMA).notes if "far too large" in n]
    assert len(told) == 1 and re.match(r"the residual is 0\.0\d+ times the stated noise", told[0])
    for sigma in (2 * SIGMA, None):
        assert not any("far too large" in n for n in fitted(record(noise=white()), sigma=sigma).notes)


def test_a_few_gross_samples_are_told_as_such() -> None:
    e = white()
    e[::250] += 0.3
    result = fitted(record(noise=e))
    assert result.rms_over_noise["fit"] > 3
    assert [n for n in result.warnings if n.startswith("8 of 2000 samples carry 99%")]
    assert not any("leaves something out" in n for n in result.notes)


def test_what_is_missed_beside_a_few_gross_samples_is_told_too() -> None:
    e = white()
    e += 3 * e.std() * np.sin(np.arange(2000) / 7)
    e[::250] += 0.9
    result = fitted(record(noise=e), sigma=float(white().std()))
    assert [n for n in result.warnings if n.startswith("8 of 2000 samples")]
    assert any("leaves something out" in n for n in result.notes)


def test_a_stretch_that_the_model_misses_is_no_outliers() -> None:
    e = white()
    e[500:540] += 0.1
    result = fitted(record(noise=e))
    assert not any("outliers" in n for n in result.notes)
    assert any("leaves something out" in n for n in result.notes)


@pytest.mark.parametrize("sigma", [None, 1.05 * SIGMA])
def test_noise_with_a_colour_is_told_though_it_is_small(sigma: float | None) -> None:
    result = fitted(record(noise=coloured(0.35)), sigma=sigma)
    assert 1 < result.rms_over_noise["fit"] < 1.5
    (said,) = result.warnings
    assert "neighbouring residuals are alike (correlation 0.3" in said and "1.4 times too small" in said


@pytest.mark.parametrize(("times", "noise"), [(1.7, True), (1.7, False), (2.5, True)])
def test_a_residual_that_looks_like_more_noise_is_said_to(times: float, noise: bool) -> None:
    """Noise that is stated too small, or a slow wave of the same size beside it."""
    wave = SIGMA * np.sqrt(2 * (times**2 - 1)) * np.sin(5 * t)
    e = times * white() if noise else white() + wave
    notes = fitted(record(noise=e), sigma=SIGMA).notes
    rather = [n for n in notes if "looks like noise of that level" in n]
    firm = [n for n in notes if "noise: the model leaves something out, which" in n]
    assert (len(rather), len(firm)) == ((1, 0) if noise and times < 2 else (0, 1))


def test_a_few_samples_tell_no_noise_from_physics() -> None:
    r = record(noise=1.8 * white())
    few = Recording("a", None, "fit", {n: x[:60] for n, x in r.inputs.items()}, {"F": r.outputs["F"][:60]})
    notes = fitted(few, sigma=SIGMA).notes
    assert [
        n
        for n in notes
        if n.endswith("or the noise is stated too small; the samples are too few to tell which")
    ]


def test_noise_that_is_stated_as_larger_covers_its_colour() -> None:
    assert fitted(record(noise=coloured(0.35)), sigma=3 * SIGMA).warnings == ()


@pytest.mark.parametrize("sigma", [None, SIGMA])
@pytest.mark.parametrize(("times", "role"), [(1e-3, "fit"), (1e3, "fit"), (1e-3, "holdout"), (5.0, "fit")])
def test_a_recording_in_another_unit_than_its_header_says(
    times: float, role: str, sigma: float | None
) -> None:
    odd = record("odd", 2.0, white(1), times, role)
    result = fitted(record(noise=white()), odd, record("c", 1.5, white(2)), sigma=sigma)
    said = [n for n in result.warnings if n.startswith("'odd' is about ")]
    told = f"'odd' is about {times:g} times as large beside the model as 'a', 'c': are the units in their"
    assert len(said) == (times != 5.0) and all(n.startswith(told) for n in said)
    assert any("leaves something out" in n for n in result.notes) is (times == 5.0)


def sine(states: bool) -> Model:
    """A tone of unknown frequency: each wrong count of periods is a valley of its own."""
    t, A = Input("t", "s"), Parameter("A", "mm", 1.0, (0.1, 9.0))
    w, phi = Parameter("w", "1/s", 9.0, (1.0, 300.0)), Symbol("phi", real=True)
    turns = State("phi", 0, rate=w) if states else Equation("phi", w * t)
    x = Equation("x", A * sin(phi), "mm")
    return Model("tone", (t,), (A, w), (turns, x), ("x",))


@pytest.mark.parametrize("states", [False, True])
def test_where_few_starts_arrive_it_says_what_to_do(states: bool) -> None:
    model, e = sine(states), white()
    r = Recording("a", None, "fit", {"t": t}, {"x": 2 * np.sin(150 * t) + e})
    result = fit(model, Case(None, "tone", (r,), noise=Noise(sigma={"x": SIGMA})))
    (said,) = [n for n in result.warnings if "starts reached this optimum" in n]
    assert ("'ipopt(shooting=40)'" in said, "'multistart(200)'" in said) == (states, not states)
    assert read_method(said.split("`--method '")[1].split("'`")[0]) is not None


CASE = 'model = "kelvin_voigt"\n[bounds]\nk_d = {}\n[[recording]]\nfile = "a.csv"\n'


def test_a_folder_names_each_case_by_its_folder_and_shows_its_warnings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    name = kelvin_voigt.scalar_parameters[0].name
    r = record(noise=white())
    rows = np.stack([t, r.inputs["z"], r.outputs["F"]], axis=1)
    for folder, bounds in (("01", "[0.1, 9.0]"), ("02", "[0.8, 9.0]")):
        (tmp_path / folder).mkdir()
        header = "t [s],z [mm],F_m [N]"
        np.savetxt(tmp_path / folder / "a.csv", rows, delimiter=",", header=header, comments="")
        (tmp_path / folder / "case.toml").write_text(CASE.replace("k_d", name).format(bounds))
    monkeypatch.setattr("modelgen.cli.folders.process_executor", lambda tasks: ThreadPoolExecutor(1))
    assert main(["fit", str(tmp_path), "--json", str(tmp_path / "all.json")]) == 0
    lines = capsys.readouterr().out.splitlines()
    first, second = (line.split() for line in lines[2:4])
    assert (first[0], second[0]) == ("01", "02") and first[3] == second[3] == "–"
    assert f"02: {name} lies on its bound" in lines
    assert not any(line.startswith("01: ") for line in lines)
    assert list(json.loads((tmp_path / "all.json").read_text())["cases"]) == ["01/case", "02/case"]


def test_outputs_of_two_units_are_both_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    f = np.geomspace(1, 50, 12)
    rng = np.random.default_rng(0).standard_normal((2, f.size))
    rows = np.stack([f, 1 + 0.1 * np.log(f) + 1e-3 * rng[0], 20 + 0.1 * rng[1]], axis=1)
    np.savetxt(
        tmp_path / "a.csv", rows, delimiter=",", header="f [Hz],k_s [N/mm],loss_angle [deg]", comments=""
    )
    text = 'model = "complex_stiffness"\n[[recording]]\nfile = "a.csv"\nconstants = { A_z = 1.0 }\n'
    (tmp_path / "case.toml").write_text(text)
    assert main(["fit", str(tmp_path / "case.toml"), "--json", str(tmp_path / "fit.json")]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("a "))
    assert " N/mm, " in row and "°" in row
    (told,) = json.loads((tmp_path / "fit.json").read_text())["recordings"]
    assert told["unit"] == "N/mm" and [unit for _, unit in told["others"]] == ["deg"]
    each = [o["rms_over_noise"] for o in told["outputs"]]
    assert [(o["output"], o["unit"]) for o in told["outputs"]] == [("k_s", "N/mm"), ("loss_angle", "deg")]
    assert np.hypot(*each) / 2**0.5 == pytest.approx(told["rms_over_noise"]) and each[0] != each[1]
    assert row.rstrip().endswith("{} ({}, {})".format(*map(number, (told["rms_over_noise"], *each))))


def test_arguments_of_another_kind_are_named() -> None:
    import inspect

    case = Case(None, "kelvin_voigt", ())
    for call, says in (
        (lambda: mg.fit(kelvin_voigt, "case.toml"), "case: found 'case.toml', wanted a Case"),
        (lambda: mg.fit(kelvin_voigt, case, method="pso(4)"), "method: found 'pso(4)'"),
        (lambda: mg.fit("kelvin_voigt", case), "model: found 'kelvin_voigt', wanted a Model"),
        (lambda: mg.diagnose(kelvin_voigt, case), "a case stands where the model is wanted"),
        (lambda: mg.build("kelvin_voigt"), "found 'kelvin_voigt', wanted a Model"),
    ):
        with pytest.raises(mg.InputError, match=re.escape(says)):
            call()
    assert list(inspect.signature(mg.fit).parameters)[:3] == ["model", "case", "method"]
