"""Recordings that show less than they seem to: few samples, the other sign of time, a staircase of treads."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from coils import coil, verdict
from interpreter import Reading

from modelgen.api import read_case
from modelgen.diagnose import diagnose
from modelgen.diagnose.gate.describe import levelling
from modelgen.diagnose.gate.mirrored import opposed
from modelgen.diagnose.gate.spectrum import filled
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.diagnose.hypotheses.starts import base_starts
from modelgen.diagnose.noise.glitches import abrupt
from modelgen.diagnose.noise.noise import outliers
from modelgen.diagnose.noise.recurring import without_recurring
from modelgen.diagnose.noise.resolved import unresolved
from modelgen.fit.scatter import rounding, stands
from modelgen.fit.series import make_series
from modelgen.models import load
from modelgen.truths import draw, write_case


def swing(folder: Path, samples: int) -> Path:
    """A case of a swing of `samples` a cycle."""
    n = np.arange(200)
    z = np.sin(2 * np.pi * n / samples + 0.3)
    rows = "\n".join(f"{k / 100},{x},{2 * x}" for k, x in zip(n, z, strict=True))
    (folder / "swing.csv").write_text(f"t [s],z [mm],F_m [N]\n{rows}\n")
    (folder / "case.toml").write_text(
        'model = "modified_dahl"\n[[recording]]\nfile = "swing.csv"\nrole = "fit"\n'
    )
    return folder / "case.toml"


def test_what_recurs_where_the_motion_comes_is_no_outlier() -> None:
    """Contacts of two samples at the top of each stroke stand off their neighbours as glitches do."""
    rng, t = np.random.default_rng(3), np.arange(4000) / 400
    z = np.sin(2 * np.pi * 17.3 * t)
    glitches = rng.choice(4000, 20, replace=False)
    white = rng.standard_normal((1, 4000)) + 400 * np.maximum(z - 0.96, 0)
    white[0, glitches] += 30
    model = load("kelvin_voigt")
    s = SimpleNamespace(inputs={i.name: z if i.name == "z" else np.gradient(z, t) for i in model.inputs})
    marks = outliers(white)
    assert marks.sum() > 100
    kept = without_recurring(model, s, white, marks, outliers)
    assert kept[glitches].sum() > 15 and kept.sum() < 25


@pytest.mark.parametrize(("samples", "told"), [(7, True), (40, False)])
def test_a_motion_of_few_samples_a_cycle_is_told(tmp_path: Path, samples: int, told: bool) -> None:
    case, model = read_case(swing(tmp_path, samples)), load("modified_dahl")
    # the time before comes last: it is no motion
    model = replace(model, inputs=tuple(sorted(model.inputs, key=lambda i: i.name == "t_prev")))
    notes = unresolved(model, [make_series(model, case, r) for r in case.fit])
    assert [n.startswith("'swing' turns every") for n in notes] == [True] * told


@pytest.mark.parametrize("sign", [1, pytest.param(-1, marks=pytest.mark.slow)])
def test_the_other_sign_of_time_is_told(tmp_path: Path, sign: int) -> None:
    case = write_case(draw(7, kind="none", domain="impedance"), tmp_path)
    for file in tmp_path.glob("*.csv"):
        head, *rows = file.read_text().splitlines()
        assert head.endswith("Im Z [ohm]")
        turned = [",".join((*r.split(",")[:2], str(sign * float(r.split(",")[2])))) for r in rows]
        file.write_text("\n".join((head, *turned)) + "\n")
    told = any("e^(−jωt)" in n for n in diagnose(read_case(case), load("electrodynamic_transducer")).notes)
    assert told == (sign < 0)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_force_that_counts_the_other_way_is_told(tmp_path: Path, sign: int) -> None:
    """A dashpot and a gas spring on a rig that shows compression as positive: no effect makes up for that."""
    t = np.arange(0, 4, 0.01)
    z = 18 * np.sin(2 * np.pi * 0.9 * t) * (1 + 0.3 * np.sin(t))
    force = 0.3 * z + 1.4 * np.gradient(z, t) + np.random.default_rng(2).normal(0, 0.5, len(t))
    rows = "\n".join(f"{a},{b},{sign * c}" for a, b, c in zip(t, z, force, strict=True))
    (tmp_path / "rig.csv").write_text(f"t [s],z [mm],F_m [N]\n{rows}\n")
    (tmp_path / "case.toml").write_text(
        'model = "kelvin_voigt"\n[[recording]]\nfile = "rig.csv"\nrole = "fit"\n'
    )
    model, case = load("kelvin_voigt"), read_case(tmp_path / "case.toml")
    base = prepare(model, case, 0).base
    assert bool(opposed(model, case, base, base, 0)) == (sign < 0)


@pytest.mark.parametrize(("off", "size"), [(0, 0.3), (-1, 0.15)])
def test_a_glitch_on_top_of_a_narrow_resonance_is_an_outlier(tmp_path: Path, off: int, size: float) -> None:
    """The base follows it, as few other samples tell how high the resonance is, and all about it is wrong."""
    f = np.arange(20.0, 300.0, 2.0)
    s = 2j * np.pi * f
    Z = 6 + 3e-4 * s + 36 / (0.35 + 0.013 * s + 2e3 / s)
    Z[np.argmax(np.abs(Z)) + off] *= 1 + size * (1 - 0.4j)
    v = verdict(tmp_path, f, Z)
    assert v.adequate
    assert any("1 outlier in 'sweep' is marked" in n for n in v.notes)


@pytest.mark.parametrize(("first", "count", "by"), [(139, 2, 1.2), (60, 4, 0.02), (138, 4, 0.02)])
def test_a_burst_of_glitches_is_marked(tmp_path: Path, first: int, count: int, by: float) -> None:
    """A range that switches, a contact that opens: least squares bend the whole base to them."""
    f = np.geomspace(10, 3000, 150)
    Z = coil(f)
    Z[first : first + count] *= by
    v = verdict(tmp_path, f, Z)
    assert v.adequate
    assert any(f"{count} outliers in 'sweep' are marked" in n for n in v.notes)


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 2))])
def test_a_noisy_end_of_a_band_is_noise(tmp_path: Path, seed: int) -> None:
    f = np.geomspace(10, 3000, 300)
    r = np.random.default_rng(seed).standard_normal((2, f.size))
    v = verdict(tmp_path, f, coil(f) * (1 + 5e-3 * (f < 30) * (r[0] + 1j * r[1])))
    assert v.adequate
    assert v.before.fit_over_noise < 1.1


def dahl(t: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The force [N] of spring, dashpot and Dahl friction at z(t) [mm]."""
    r, F = 0.0, np.empty_like(z)
    v = np.gradient(z, t)
    for i, dz in enumerate(np.diff(z, prepend=z[0])):
        r = np.sign(dz) + (r - np.sign(dz)) * np.exp(-2.0 * abs(dz))
        F[i] = 0.4 * z[i] + 0.08 * v[i] + 0.09 * r + 1.4
    return F


@pytest.mark.slow
def test_few_digits_are_no_physics(tmp_path: Path) -> None:
    """A staircase hardly scatters: its neighbours say nothing of how far it is from the truth."""
    f = np.linspace(10, 3000, 300)
    Z = coil(f) * (1 + 1e-3 * np.random.default_rng(4).standard_normal(f.size))
    rows = np.column_stack([f, np.round(Z.real, 1), np.round(Z.imag, 1)])
    np.savetxt(tmp_path / "r.csv", rows, delimiter=",", header="f [Hz],Re Z [ohm],Im Z [ohm]", comments="")
    (tmp_path / "case.toml").write_text(
        'model = "electrodynamic_transducer"\n[[recording]]\nfile = "r.csv"\n'
    )
    v = diagnose(read_case(tmp_path / "case.toml"), load("electrodynamic_transducer"))
    assert v.adequate


def test_a_narrow_resonance_is_no_burst() -> None:
    """It has flanks."""
    f = np.arange(1.0, 200.0)
    peak = np.abs(300 / (1 + 2j * 40 * (f / 100.4 - 1))) ** 2 + 2
    assert not abrupt(peak).any()
    assert np.flatnonzero(abrupt(np.where((f > 49) & (f < 53), 3e4, 2.0))).tolist() == [49, 50, 51]


def test_steps_of_a_staircase_are_no_outliers() -> None:
    x = np.linspace(0, 1, 1000)
    seen = np.round(x / 0.1) * 0.1
    assert stands(seen) and not stands(x)
    assert rounding(seen) == pytest.approx(0.1 / np.sqrt(12), rel=1e-6)
    white = (x - seen)[None] / 1e-3  # the scatter between neighbours says nothing of the rounding
    assert outliers(white).any()
    assert not outliers(white, least=rounding(seen) / 1e-3).any()


@pytest.mark.slow
def test_a_coarse_converter_is_no_distortion(tmp_path: Path) -> None:
    """Where a motion turns, rounding to eight times the noise is an error that stays, as far as a force."""
    rng, text = np.random.default_rng(5), 'model = "modified_dahl"\n'
    for k, (A, f) in enumerate(((3.0, 0.1), (0.6, 1.0))):
        t = np.arange(0, 20, 4e-3)
        z = A * np.sin(2 * np.pi * f * t)
        F = dahl(t, z) + 1.2e-3 * rng.standard_normal(t.size)
        rows = np.column_stack([t, np.round(z, 3), np.round(F / 9.8e-3) * 9.8e-3])
        np.savetxt(tmp_path / f"r{k}.csv", rows, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
        text += f'[[recording]]\nfile = "r{k}.csv"\nrole = "fit"\n'
    (tmp_path / "case.toml").write_text(text)
    v = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"))
    assert v.adequate, v.summary


@pytest.mark.parametrize("size", [1.0, 1e2, 1e-3])
def test_a_cycle_of_another_size_is_searched_for_in_its_own_units(tmp_path: Path, size: float) -> None:
    rows = "\n".join(f"{f},{2.0 + f / 100},{5.0}" for f in (1.0, 5.0, 10.0))
    (tmp_path / "k.csv").write_text(f"f [Hz],k_s [N/mm],loss_angle [deg]\n{rows}\n")
    (tmp_path / "case.toml").write_text(
        'model = "complex_stiffness"\n[[recording]]\nfile = "k.csv"\nrole = "fit"\n'
        f"constants = {{ A_z = {size} }}\n"
    )
    model, case = load("complex_stiffness"), read_case(tmp_path / "case.toml")
    (base,) = make_hypotheses(model, case, [make_series(model, case, r) for r in case.fit], [()])
    k, c, h, rho = base_starts(base, 0)[1]
    assert [k, c, h, rho] == pytest.approx([2.05, 2.05 / (20 * np.pi), 2.05 * size, 1 / size])


def test_a_short_sweep_may_have_five_gross_errors() -> None:
    """One sample in eight, each alone: of a long sweep that would be what the model misses."""
    white = np.random.default_rng(3).standard_normal((2, 39))
    at = [4, 10, 17, 24, 31]
    white[0, at] += 40.0
    assert np.flatnonzero(outliers(white)).tolist() == at
    assert not outliers(np.tile(white, 4)).any()


@pytest.mark.slow
def test_gross_errors_that_the_missing_physics_hides_are_found_once_it_is_known(tmp_path: Path) -> None:
    """A relaxing elastomer's swept stiffness with one wrong angle: the elastic model's misfit looks odder."""
    rng, f = np.random.default_rng(0), np.geomspace(0.3, 15, 28)
    s, text = 2j * np.pi * f, 'model = "complex_stiffness"\n'
    for k, A in enumerate((0.4, 0.8)):
        K = 0.5 + 0.006 * s + 0.8 * 0.01 * s / (1 + 0.01 * s)
        angle = np.degrees(np.angle(K)) + 0.02 * rng.standard_normal(28)
        angle[24] += 1.0 if k else 0.0
        stiffness = np.abs(K) * (1 + 2e-4 * rng.standard_normal(28))
        rows = "\n".join(f"{a},{b},{c}" for a, b, c in zip(f, stiffness, angle, strict=True))
        (tmp_path / f"{k}.csv").write_text(f"f [Hz],k_s [N/mm],loss_angle [deg]\n{rows}\n")
        text += f'[[recording]]\nfile = "{k}.csv"\nrole = "fit"\nconstants = {{ A_z = {A} }}\n'
    (tmp_path / "case.toml").write_text(text)
    verdict = diagnose(read_case(tmp_path / "case.toml"), load("complex_stiffness"))
    assert [e.id for e in verdict.effects] == ["maxwell_branch"]
    assert [np.flatnonzero(t.outliers).tolist() for t in verdict.traces] == [[], [24]]
    assert [n for n in verdict.notes if "outlier" in n] == ["1 outlier in '1' is marked and weighs nothing"]


@pytest.mark.parametrize("mains", [50.0, 60.0])
@pytest.mark.slow
def test_hum_with_harmonics_is_heard_where_it_is_far_louder_than_noise(tmp_path: Path, mains: float) -> None:
    """Its harmonics stand out of the spectrum more than it does, once the slope of that is taken out; and all
    of it looks like noise of some colour."""
    rng = np.random.default_rng(4)
    t = np.arange(3000) / 500.0
    z = 0.6 * np.sin(2 * np.pi * 0.7 * t) + 0.2 * np.sin(2 * np.pi * 1.9 * t)
    hum = sum(3.0**-n * np.sin(2 * np.pi * mains * n * t + n) for n in (1, 2, 3))
    force = 2.0 * z + 0.05 * np.gradient(z, t) + 0.3 * hum + 2e-3 * rng.standard_normal(t.size)
    rows = np.column_stack([t, z + 5e-4 * rng.standard_normal(t.size), force])
    np.savetxt(tmp_path / "r.csv", rows, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
    (tmp_path / "case.toml").write_text(
        'model = "kelvin_voigt"\n[[recording]]\nfile = "r.csv"\nrole = "fit"\n'
    )
    found = diagnose(read_case(tmp_path / "case.toml"), load("kelvin_voigt")).effects
    assert [e.id for e in found] == ["unknown_sensor"]
    assert f"a line at {mains:.0f} Hz" in found[0].says


def elastic(folder: Path, rates: dict[str, float], seconds: float, more: Callable[[str, Any], Any]) -> None:
    """Records of spring and dashpot with a wandering motion, sampled at `rates` [Hz], with `more` force
    [N] (name, t)."""
    rng, text = np.random.default_rng(4), 'model = "kelvin_voigt"\n[noise]\nF_m = 2e-3\nz = 1e-4\n'
    for name, rate in rates.items():
        t = np.arange(int(seconds * rate)) / rate
        z = 0.6 * np.sin(2 * np.pi * 0.7 * t) + 0.2 * np.sin(2 * np.pi * 1.9 * t)
        v = 0.84 * np.pi * np.cos(2 * np.pi * 0.7 * t) + 0.76 * np.pi * np.cos(2 * np.pi * 1.9 * t)
        force = 2.0 * z + 0.05 * v + more(name, t) + 2e-3 * rng.standard_normal(t.size)
        rows = np.column_stack([t, z + 1e-4 * rng.standard_normal(t.size), force])
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
        text += f'[[recording]]\nfile = "{name}.csv"\n'
    (folder / "case.toml").write_text(text)


def test_mains_that_a_sampling_folds_down_are_lines_elsewhere_in_each_record(tmp_path: Path) -> None:
    """50 Hz, sampled at 88 and at 63 Hz, are 38 and 13 Hz."""
    mains = lambda name, t: 1.2e-3 * np.sin(2 * np.pi * 50.0 * t)  # noqa: E731
    elastic(tmp_path, {"a": 88.0, "b": 63.0}, 20.0, mains)
    (found,) = diagnose(read_case(tmp_path / "case.toml"), load("kelvin_voigt")).effects
    assert found.id == "unknown_sensor"
    assert "38 Hz in a" in found.says and "13 Hz in b" in found.says


@pytest.mark.slow
def test_a_clamp_that_slips_is_told_with_its_moment(tmp_path: Path) -> None:
    slip = lambda name, t: np.where((t > 7.0) & (name == "b"), 1.5e-3, 0.0)  # noqa: E731
    elastic(tmp_path, {"a": 100.0, "b": 100.0}, 20.0, slip)
    (found,) = diagnose(read_case(tmp_path / "case.toml"), load("kelvin_voigt")).effects
    assert found.id == "unknown_force"
    told = re.search(r"a jump of the force at ([0-9.]+) s in b", found.says)
    assert told and abs(float(told[1]) - 7.0) < 0.4


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("n", [1.5, 12.0, 2000.0])
def test_a_channel_s_end_is_as_sharp_as_asked_for(side: int, n: float) -> None:
    """From a soft amplifier's to that of a converter, whose u^n no number holds."""
    model = replace(load("kelvin_voigt"), checked=True)
    port = next(p for p in model.ports if p.kind == "sensor")
    effect = levelling("unknown_sensor", port, side * 1.0, side)
    z = np.linspace(-4.0, 4.0, 81)
    motion = dict.fromkeys(("t_prev", "v", "a"), np.zeros(81)) | dict.fromkeys(("z", "z_prev", "z_turn"), z)
    values = {"unknown_sensor_bend": 0.5, "unknown_sensor_n": n, "k_D": 1.0, "c_D": 0.0, "F_0": 0.0}
    shown = Reading(effect.extend(model, port))({"t": np.ones(81), **motion}, **values)[port.equation]
    u = np.maximum(side * z / 2, 1e-9)
    exact = np.minimum(side * z, 2.0) * side if n > 1e3 else z * (1 + u**n) ** (-1 / n)
    assert np.allclose(shown, exact, atol=1e-3)


def test_a_steep_residual_holds_no_more_outliers_than_a_flat_one() -> None:
    """On a slope most samples are the median of their neighbours: what they scatter by is more than that."""
    rng, t = np.random.default_rng(2), np.arange(2000) / 200
    noise = rng.standard_normal(2000)
    noise[100::200] += 12.0
    for size in (0.0, 25.0, 50.0):
        marked = outliers((size * np.sin(9.4 * t) + noise)[None])
        assert marked[100::200].all() and marked[3:-3].sum() == 10  # the ends have neighbours on one side


def test_a_line_is_where_it_is_though_rows_are_missing(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    text = 'model = "kelvin_voigt"\n[noise]\nF_m = 0.005\n'
    for k, gaps in enumerate(((300, 700, 1500), (250, 900, 1300))):
        t = np.arange(2000) / 400.0
        z = 0.6 * np.sin(2 * np.pi * (0.7 + 0.4 * k) * t)
        force = 2.0 * z + 0.05 * np.gradient(z, t) + 0.004 * np.sin(314.16 * t + k)
        rows = np.column_stack([t, z, force + 0.005 * rng.standard_normal(t.size)])
        kept = np.all([np.abs(np.arange(2000) - g) > 30 * (k + 1) for g in gaps], axis=0)
        np.savetxt(
            tmp_path / f"{k}.csv", rows[kept], delimiter=",", header="t [s],z [mm],F_m [N]", comments=""
        )
        text += f'[[recording]]\nfile = "{k}.csv"\nrole = "fit"\n'
    (tmp_path / "case.toml").write_text(text)
    found = diagnose(read_case(tmp_path / "case.toml"), load("kelvin_voigt")).effects
    assert [e.id for e in found] == ["unknown_sensor"]
    assert float(found[0].says.split("a line at ")[1].split(" Hz")[0]) == pytest.approx(50.0, abs=0.05)


def test_a_record_in_bursts_is_not_filled_between_them() -> None:
    """An hour at steps of a millisecond would be millions of samples."""
    burst = np.arange(200) / 1000
    t = np.concatenate([burst, burst + 3600.0, burst + 7200.0])
    assert len(filled(t, np.sin(t))) == 600
    assert len(filled(np.delete(t[:200], slice(50, 80)), np.ones(170))) == 200
