"""Inputs that follow from a recorded one are in the unit that they declare, whatever that one's unit is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from modelgen.codegen import build
from modelgen.errors import InputError
from modelgen.export.exact import run
from modelgen.export.fmu import stand_alone
from modelgen.export.inverse import inverse
from modelgen.fit.experiment import experiment
from modelgen.fit.fitting import fit
from modelgen.fit.motion import motion_error
from modelgen.fit.series import make_series, signature_of
from modelgen.language import Equation, Input, Model, Parameter, acceleration_of, rate_of
from modelgen.recordings.case import load_case
from modelgen.recordings.casefile import read_case_file
from modelgen.units import factor

UNITS = [("s", "um", "mm/s", "m/s**2"), ("min", "mm", "mm/s", "mm/min**2"), ("ms", "mm", "um/us", "km/h/s")]
IDS = ["/".join(u[:2]) for u in UNITS]
C, M = 0.02, 0.003  # N s/mm, N s²/mm


def damper(t: str = "s", z: str = "mm", v: str = "mm/s", a: str = "mm/s**2") -> Model:
    """The same mass on a dashpot, its motion in other units."""
    time, moved = Input("t", t), Input("z", z, range=(-1 * factor("mm", z), factor("mm", z)))
    speed, bend = rate_of(moved, "v", v), acceleration_of(moved, "a", a)
    c = Parameter("c", f"N/({v})", C * factor("N*s/mm", f"N/({v})"), (0.0, 1e9))
    m = Parameter("m", f"N/({a})", M * factor("N*s**2/mm", f"N/({a})"), (0.0, 1e9))
    F = Equation("F", c * speed + m * bend, "N")
    return Model("damper", (time, moved, speed, bend), (c, m), (F,), ("F",))


def motion(model: Model) -> dict[str, np.ndarray]:
    """One in seconds and millimetres, in the model's units."""
    t = np.arange(400) / 200.0
    z = np.sin(2 * np.pi * t) + 0.2 * np.sin(9 * t)
    return {"t": t * factor("s", model.inputs[0].unit), "z": z * factor("mm", model.inputs[1].unit)}


@pytest.mark.parametrize("units", UNITS, ids=IDS)
def test_a_rate_is_in_its_own_unit(units: tuple[str, str, str, str]) -> None:
    one, other = damper(), damper(*units)
    wanted = build(one)(**motion(one))
    assert build(other)(**motion(other)) == pytest.approx(wanted, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("units", UNITS, ids=IDS)
def test_a_fit_finds_the_same_dashpot_in_any_unit(units: tuple[str, str, str, str], tmp_path: Path) -> None:
    """Columns stay in s and mm: the model's units alone are others."""
    rng, t = np.random.default_rng(2), motion(damper())["t"]
    noise = rng.standard_normal((2, t.size)) * [[2e-3], [1e-3]]
    table = np.column_stack([t, motion(damper())["z"], build(damper())(**motion(damper()))])
    table[:, 1:] += noise.T
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="t [s],z [mm],F [N]", comments="")
    found = []
    for model in (damper(), damper(*units)):
        sigma = f"F = 1e-3\nz = {2e-3 * factor('mm', model.inputs[1].unit)}\n"
        (tmp_path / "c.toml").write_text(f'model = "x"\n[noise]\n{sigma}[[recording]]\nfile = "a.csv"\n')
        case = load_case(read_case_file(tmp_path / "c.toml"), signature_of(model))
        ex = experiment(model, case, [make_series(model, case, case.fit[0])])
        theta = np.array([p.default for p in model.scalar_parameters])
        error = motion_error(ex, case, case.fit[0], theta, 0)
        assert error is not None
        c = fit(model, case)["c"]
        ratio = factor(c.unit, "N*s/mm")
        found.append([c.value * ratio, c.std * ratio, float(np.mean(error.variance))])
    assert found[0][0] == pytest.approx(C, rel=0.02)
    assert found[1] == pytest.approx(found[0], rel=1e-3)


@pytest.mark.parametrize("units", UNITS, ids=IDS)
@pytest.mark.parametrize("rewritten", [stand_alone, inverse])
def test_what_forms_the_rate_over_a_step_forms_it_in_its_unit(rewritten, units) -> None:
    """The FMI unit, and the inverse: from sample to sample both are the same in any unit."""

    def output(model: Model) -> list[float]:
        path = motion(model)
        force = {"F_wanted": 0.1 * np.cos(path["t"] * factor(model.inputs[0].unit, "s"))}
        given = path if rewritten is stand_alone else {"t": path["t"], **force}
        rows = [{n: float(x[k]) for n, x in given.items()} for k in range(8)]
        made = rewritten(model)
        values = {p.name: float(p.default) for p in made.scalar_parameters}
        out, ratio = ("F", 1.0) if rewritten is stand_alone else ("z", factor(model.inputs[1].unit, "mm"))
        return [float(row[out]) * ratio for row in run(made, rows, **values)]

    assert output(damper(*units)) == pytest.approx(output(damper()), rel=1e-9, abs=1e-12)


def of(**changes: object) -> Model:
    """A model with an input that is derived in a wrong way."""
    wrong = Input(**({"name": "w", "unit": "um/s", "derived": ("rate", "z")} | changes))  # type: ignore[arg-type]
    k = Parameter("k", f"N/({wrong.unit})", 1.0)
    return Model(
        "m", (Input("t", "s"), Input("z", "um"), wrong), (k,), (Equation("F", k * wrong, "N"),), ("F",)
    )


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"unit": "mm"}, "model 'm', input 'w', rate of 'z': it is in mm, wanted a unit of µm/s"),
        ({"unit": "mm", "derived": ("previous", "z")}, "previous of 'z': it is in mm, wanted um as 'z' is"),
        ({"unit": "mm", "derived": ("amplitude", "z")}, "amplitude of 'z': it is in mm, wanted um"),
        ({"derived": ("speed", "z")}, "unknown kind 'speed' of derived input"),
        ({"derived": ("rat", "z")}, "unknown kind 'rat' of derived input, did you mean 'rate'"),
        ({"derived": ("rate", "zz")}, "'zz', whose rate it is, is no input, did you mean 'z'"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(changes: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says) as why:
        of(**changes)
    assert "\n" not in str(why.value)


def test_a_rate_of_a_temperature_has_no_offset() -> None:
    t, T = Input("t", "s"), Input("T", "degC")
    rate, k = rate_of(T, "r", "K/min"), Parameter("k", "W*min/K", 1.0)
    model = Model("heat", (t, T, rate), (k,), (Equation("P", k * rate, "W"),), ("P",))
    time = np.linspace(0.0, 1.0, 30)
    assert build(model)(t=time, T=20 + 2 * time) == pytest.approx(120.0)
