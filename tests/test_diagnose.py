"""The diagnosis on concealed effects made by other numerics, on nothing missing, and on what no catalogue
holds."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelgen.api import read_case
from modelgen.diagnose import Verdict, diagnose
from modelgen.effects import Effect, Strength, family
from modelgen.errors import InputError
from modelgen.models import load
from modelgen.recordings import Case, Recording
from modelgen.truths import draw, write_case


def verdict(tmp_path: Path, seed: int, **drawn: Any) -> tuple[Any, Verdict]:
    secret = draw(seed, **drawn)
    case = read_case(write_case(secret, tmp_path))
    return secret, diagnose(case, load(case.model))


@pytest.mark.parametrize(
    ("domain", "effect", "seed"),
    [
        pytest.param("impedance", "semi_inductance", 1, marks=pytest.mark.slow),
        pytest.param("impedance", "coil_capacitance", 3, marks=pytest.mark.slow),
        ("gmm", "second_mode", 5),
        pytest.param("force", "cubic_stiffness", 3, marks=pytest.mark.slow),
        pytest.param("force", "inertia", 8, marks=pytest.mark.slow),
        pytest.param("force", "backlash", 4, marks=pytest.mark.slow),
    ],
)
def test_a_concealed_effect_is_named_and_the_hold_out_predicted(
    tmp_path: Path, domain: str, effect: str, seed: int
) -> None:
    _, v = verdict(tmp_path, seed, kind="single", domain=domain, effect=effect, d2=(800, 2000))
    assert not v.adequate
    stated = {v.effects[0].id, *v.effects[0].equivalents}
    assert effect in stated
    assert family(v.effects[0].id) == family(effect) or effect in v.effects[0].equivalents
    assert v.after.fit < v.before.fit
    assert v.after.holdout_over_noise < 1.25


@pytest.mark.slow
@pytest.mark.parametrize("unit", ["nm", "km"])
def test_a_sample_of_any_size_has_the_same_physics(tmp_path: Path, unit: str) -> None:
    secret = draw(3, kind="single", domain="force", effect="cubic_stiffness", d2=(800, 2000))
    case = write_case(secret, tmp_path)
    case.write_text(re.sub(r"^z = .*$", "", case.read_text(), flags=re.M))
    for file in tmp_path.glob("*.csv"):
        file.write_text(file.read_text().replace("z [mm]", f"z [{unit}]"))
    v = diagnose(read_case(case), load("modified_dahl"))
    assert [e.id for e in v.effects] == ["cubic_stiffness"]


@pytest.mark.parametrize(
    ("domain", "effects", "noise", "ratio", "seed"),
    [
        pytest.param(
            "stiffness", ("sensor_delay", "temperature_drift"), "coloured", 20.0, 50100054,
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "stiffness", ("cubic_stiffness", "dahl_exponent"), "quantised", 6.0, 60100052,
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "impedance", ("power_law_viscoelasticity", "second_mode"), "coloured", 6.0, 50100051,
            marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_two_effects_that_hide_each_other_are_both_named(
    tmp_path: Path, domain: str, effects: tuple[str, str], noise: str, ratio: float, seed: int
) -> None:
    _, v = verdict(
        tmp_path, seed, kind="pair", domain=domain, effect=effects, d2=(30, 1e4), noise=noise, ratio=ratio
    )
    assert {family(e) for e in effects} <= {family(e.id) for e in v.effects}
    assert v.after.fit_over_noise < 0.3 * v.before.fit_over_noise


@pytest.mark.parametrize(
    ("domain", "noise"),
    [("impedance", "white"), ("impedance", "calibration"), ("impedance", "misstated"), ("force", "white")],
)
def test_nothing_is_found_where_nothing_is_missing(tmp_path: Path, domain: str, noise: str) -> None:
    _, v = verdict(tmp_path, 21, kind="none", domain=domain, noise=noise)
    assert v.adequate
    assert v.effects == ()
    assert v.after.fit_over_noise == pytest.approx(1, abs=0.2)


@pytest.mark.slow
def test_a_line_in_the_force_is_unknown_and_not_physics_of_the_sample(tmp_path: Path) -> None:
    hum = "novel:mains_hum"
    _, v = verdict(tmp_path, 102, kind="novel", domain="force", effect=hum, d2=(60, 1e4))
    assert v.effects[0].id == "unknown_sensor"
    assert "line" in v.effects[0].says
    assert v.after.fit_over_noise == pytest.approx(1, abs=0.1) and v.before.fit_over_noise > 1.2
    assert v.after.holdout_over_noise < 0.9 * v.before.holdout_over_noise


@pytest.mark.parametrize(
    ("domain", "effect", "port", "says"),
    [
        pytest.param(
            "impedance", "novel:cable_trap", "electrical", "a resonance in series", marks=pytest.mark.slow
        ),
        pytest.param(
            "impedance", "novel:cavity_comb", "mechanical", "a row of resonances", marks=pytest.mark.slow
        ),
        pytest.param(
            "stiffness", "novel:mount_modes", "mechanical", "a row of resonances", marks=pytest.mark.slow
        ),
    ],
)
def test_what_no_catalogue_holds_becomes_a_model_all_the_same(
    tmp_path: Path, domain: str, effect: str, port: str, says: str
) -> None:
    secret = draw(3, kind="novel", domain=domain, effect=effect, d2=(300, 1e4), ratio=3.0)
    case = read_case(write_case(secret, tmp_path))
    v = diagnose(case, load(case.model), out=tmp_path)
    assert v.effects[0].id == f"unknown_{port}" and v.effects[0].says.count(says)
    assert v.after.fit_over_noise < 0.6 * v.before.fit_over_noise
    assert v.after.holdout_over_noise < min(1.15, v.before.holdout_over_noise)
    again = diagnose(case, load(f"{v.extended_model}:model"))
    assert again.before.fit_over_noise < 0.6 * v.before.fit_over_noise


def test_an_effect_for_a_port_that_no_model_has_is_refused(tmp_path: Path) -> None:
    c = Strength("c", "{port}")
    wrong = Effect("my_spring", ("stiffnes",), "a spring", "nobody", (c,), lambda model, port, p: model)
    case = read_case(write_case(draw(21, kind="none", domain="stiffness"), tmp_path))
    with pytest.raises(InputError, match=r"my_spring.*'stiffnes'.*did you mean 'stiffness'"):
        diagnose(case, load(case.model), effects=[wrong])


@pytest.mark.slow
def test_one_resonator_is_named_although_a_row_of_them_could_do_the_same(tmp_path: Path) -> None:
    _, v = verdict(
        tmp_path, 3, kind="single", domain="impedance", effect="second_mode", d2=(300, 1e4), ratio=3.0
    )
    assert v.effects[0].id == "second_mode"


def test_the_verdict_keeps_the_contract(tmp_path: Path) -> None:
    _, v = verdict(tmp_path, 1, kind="single", domain="impedance", effect="semi_inductance", d2=(800, 2000))
    d = v.to_dict()
    assert d["schema"] == "modelgen.verdict/1"
    assert set(d) >= {
        "model",
        "adequate",
        "mismatch",
        "effects",
        "parameters",
        "fit",
        "extended_model",
        "seconds",
    }
    assert set(d["fit"]["after"]) == {
        "fit_rms",
        "holdout_rms",
        "fit_rms_over_noise",
        "holdout_rms_over_noise",
    }
    (effect, *_) = d["effects"]
    assert set(effect) >= {
        "id",
        "port",
        "says",
        "probability",
        "equivalents",
        "separating_experiment",
        "parameters",
    }
    assert 0 < effect["probability"] <= 1
    assert {"port", "axis", "from", "to", "unit", "says"} <= set(d["mismatch"][0])


def test_the_extended_model_is_a_model_like_any_other(tmp_path: Path) -> None:
    secret = draw(1, kind="single", domain="impedance", effect="semi_inductance", d2=(800, 2000))
    case = read_case(write_case(secret, tmp_path))
    v = diagnose(case, load(case.model), out=tmp_path / "found")
    assert v.extended_model is not None
    new = load(f"{v.extended_model}:model")
    again = diagnose(case, new)
    assert again.adequate
    assert list((tmp_path / "found").glob("*.c"))


def test_how_fitted_records_began_is_no_default_of_the_extended_model() -> None:
    """A drift that each recording has of its own has their median; what a sample was before, what it had."""
    from modelgen.diagnose.account.extended import _with_values
    from modelgen.fit.result import Estimate

    model = load("modified_dahl")
    found = [
        ("r_0[a]", 0.3),
        ("r_0[b]", 0.4),
        ("k_D", 7.0),
        ("F_0[a]", 1.0),
        ("F_0[b]", 2.0),
        ("F_0[c]", 9.0),
    ]
    after = [Estimate(n, x, 0.1, "1") for n, x in found]
    made, kept = _with_values(model, after)
    assert kept == ["r_0"] and made.parameter("r_0").default == model.parameter("r_0").default
    assert made.parameter("F_0").default == 2.0 and made.parameter("k_D").default == 7.0


def test_the_same_case_gives_the_same_verdict(tmp_path: Path) -> None:
    secret = draw(7, kind="single", domain="impedance", effect="eddy_shunt", d2=(100, 300))
    case = read_case(write_case(secret, tmp_path))
    a, b = (diagnose(case, load(case.model)) for _ in range(2))
    assert [e.id for e in a.effects] == [e.id for e in b.effects]
    assert np.allclose([p.value for p in a.parameters], [p.value for p in b.parameters], rtol=1e-9)


@pytest.mark.slow
def test_a_held_out_copy_is_as_far_over_the_noise_as_what_was_fitted() -> None:
    """Errors of a recorded motion count in it as in the others, and once: a stiff dashpot shows them."""
    rng = np.random.default_rng(5)
    t = np.linspace(0, 20, 2001)
    z = 3 * np.sin(2 * np.pi * 0.5 * t) + 0.5 * np.sin(2 * np.pi * 1.7 * t)
    v = np.gradient(z, t)
    force = 2 * z + 0.8 * v + 0.05 * z**3 + 0.01 * rng.standard_normal(t.size)
    inputs = {"t": t, "z": z + 0.01 * rng.standard_normal(t.size)}
    records = [Recording(n, None, n, inputs, {"F": force}) for n in ("fit", "holdout")]
    v = diagnose(Case(None, "kelvin_voigt", tuple(records)), load("kelvin_voigt"))
    assert v.effects[0].id == "cubic_stiffness"
    for rms in (v.before, v.after):
        assert rms.holdout_over_noise == pytest.approx(rms.fit_over_noise, rel=0.05)


def test_held_out_recordings_choose_nothing(tmp_path: Path) -> None:
    """Not even where they contradict what the others say: then a claim is half as sure, and that is all."""
    secret = draw(7, kind="single", domain="impedance", effect="eddy_shunt", d2=(100, 300))
    case = read_case(write_case(secret, tmp_path))
    upset = [
        r if r.role == "fit" else replace(r, outputs={k: 1.5 * x for k, x in r.outputs.items()})
        for r in case.recordings
    ]
    model = load(case.model)
    a, b = (diagnose(c, model) for c in (case, replace(case, recordings=tuple(upset))))
    assert b.after.holdout_over_noise > 10 * a.after.holdout_over_noise
    assert any("held-out" in n for n in b.notes) and not any("held-out" in n for n in a.notes)
    assert [(e.id, e.probability / 2) for e in a.effects] == [(e.id, e.probability) for e in b.effects]
    assert [(p.name, p.value, p.std) for p in a.parameters] == [
        (p.name, p.value, p.std) for p in b.parameters
    ]
