"""FMI units: valid, right, the same bytes each time. Simulated by FMPy."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import modelgen.models as models
from modelgen.codegen import build
from modelgen.errors import InputError
from modelgen.export import export
from modelgen.export.c99 import Settings
from modelgen.export.fmu import _facts, stand_alone
from modelgen.export.inverse import inverse
from modelgen.export.routines import make_unit
from modelgen.language import (
    Equation,
    Input,
    Model,
    Parameter,
    State,
    Symbol,
    amplitude_of,
    previous,
    rate_of,
)

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
SHIPPED = [getattr(models, n) for n in ("modified_dahl", "electrodynamic_transducer", "contact_damping")]


@pytest.mark.parametrize("model", SHIPPED, ids=lambda m: m.id)
def test_units_are_valid_and_run(model: Model, tmp_path: Path) -> None:
    from fmpy.validation import validate_fmu

    for path in export(model, "fmu", tmp_path):
        assert validate_fmu(str(path)) == []
        found = fmpy.simulate_fmu(str(path), stop_time=1.0, output_interval=0.125)
        assert len(found) == 9 and all(np.isfinite(found[n]).all() for n in found.dtype.names)


@pytest.mark.parametrize("version", [2, 3])
def test_an_impedance_follows_its_input(version: int, tmp_path: Path) -> None:
    path = export(models.electrodynamic_transducer, "fmu", tmp_path)[version - 2]
    t = np.linspace(0.0, 1.0, 11)
    f = 20.0 * 100**t
    given = np.array(list(zip(t, f, strict=True)), dtype=[("time", float), ("f", float)])
    found = fmpy.simulate_fmu(
        str(path),
        stop_time=1.0,
        output_interval=0.1,
        input=given,
        start_values={"R_e": 7.5},
        output=["Z_re", "Z_im"],
    )
    wanted = build(models.electrodynamic_transducer)(R_e=7.5, f=np.concatenate([f[:1], f[:-1]]))
    assert found["Z_re"] + 1j * found["Z_im"] == pytest.approx(np.asarray(wanted), rel=1e-9)


class Stepper:
    """A unit driven call by call, as a co-simulation master does."""

    def __init__(self, path: Path, version: int) -> None:
        self.description: Any = fmpy.read_model_description(str(path))
        kind = {2: fmpy.fmi2.FMU2Slave, 3: fmpy.fmi3.FMU3Slave}[version]
        self.unit = kind(
            guid=self.description.guid, unzipDirectory=fmpy.extract(str(path)), instanceName="unit",
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.version = version
        self.refs = {v.name: v.valueReference for v in self.description.modelVariables}
        self.unit.instantiate()
        self.ready = False

    def set(self, **values: float) -> None:
        write = self.unit.setReal if self.version == 2 else self.unit.setFloat64
        write([self.refs[n] for n in values], list(values.values()))

    def get(self, name: str) -> float:
        read = self.unit.getReal if self.version == 2 else self.unit.getFloat64
        return float(read([self.refs[name]])[0])

    def start(self) -> None:
        if self.version == 2:
            self.unit.setupExperiment(startTime=0.0)
        self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()

    def step(self, time: float, dt: float) -> None:
        self.unit.doStep(currentCommunicationPoint=time, communicationStepSize=dt)


@pytest.mark.parametrize("version", [2, 3])
def test_a_time_model_steps_as_its_batch_does(version: int, tmp_path: Path) -> None:
    path = export(models.modified_dahl, "fmu", tmp_path, Settings(fix=["b=1"]))[version - 2]
    t = np.linspace(0.0, 2.0, 101)
    z = 3 * np.sin(2 * np.pi * t)
    before = np.concatenate([z[:1], z[:-1]])
    v = np.concatenate([[0.0], np.diff(z) / np.diff(t)])
    wanted = np.asarray(build(models.modified_dahl)(rho=2.0, t=t, z=z, v=v, a=0 * t, z_turn=before))
    unit = Stepper(path, version)
    for _ in range(2):
        unit.set(z=z[0], rho=2.0)
        unit.start()
        found = [unit.get("F")]
        for k in range(1, len(t)):
            unit.set(z=z[k])
            unit.step(t[k - 1], t[k] - t[k - 1])
            found.append(unit.get("F"))
        assert np.array(found) == pytest.approx(wanted, rel=1e-12)
        unit.unit.reset()


def lag(clock: str, tau: float) -> Model:
    """A low-pass filter by Euler's rule, which tells its time: the clock and the lag are in `clock`."""
    t, u, lag = Input("t", clock), Input("u", "V", range=(0.0, 1.0)), Parameter("tau", clock, tau)
    before, x = previous(t), Symbol("x", real=True)
    state = State("x", 0, update=x + (t - before) / lag * (u - x), unit="V")
    at = Equation("at", t * 1, clock)
    return Model("lag", (t, u, before), (lag,), (state, Equation("y", x, "V"), at), ("y", "at"))


@pytest.mark.parametrize("version", [2, 3])
def test_a_clock_in_milliseconds_is_given_the_seconds_of_a_simulation_as_such(
    version: int, tmp_path: Path
) -> None:
    unit = Stepper(export(lag("ms", 5.0), "fmu", tmp_path)[version - 2], version)
    unit.set(u=1.0)
    unit.start()
    wanted = 0.0
    for k in range(8):
        unit.step(k / 1024, 1 / 1024)
        wanted += 1000 / 1024 / 5 * (1 - wanted)
        assert unit.get("y") == pytest.approx(wanted, rel=1e-12)
        assert unit.get("at") == pytest.approx(1000 * (k + 1) / 1024, rel=1e-12)


def test_a_clock_in_seconds_or_of_no_unit_is_taken_as_it_is() -> None:
    for clock in ("s", "1"):
        assert _facts(make_unit(lag(clock, 5.0)), 2)["sources"][:2] == ["dt", "c->time"]
    with pytest.raises(InputError, match=r"model 'lag' steps along 't' \[mm\], wanted a time"):
        _facts(make_unit(lag("mm", 5.0)), 2)


def test_a_driven_state_sees_the_speed_of_its_input(tmp_path: Path) -> None:
    t, q, k = Input("t", "s"), Input("q", "m"), Parameter("k", "1/s", 3.0)
    w = rate_of(q, "w", "m/s")
    x = State("x", 0.0, rate=w - k * Symbol("x", real=True), unit="m", substeps=4)
    model = Model("washout", (t, q, w), (k,), (x, Equation("y", x, "m")), ("y",))
    unit = Stepper(export(model, "fmu", tmp_path)[0], 2)
    at, h = np.arange(81) / 40, 1 / 40
    drive, wanted = np.sin(2 * np.pi * at), [0.0]
    for rise in np.diff(drive):  # x' = w − k x, w = rise/h
        wanted.append(wanted[-1] * np.exp(-3 * h) + rise / h * (1 - np.exp(-3 * h)) / 3)
    unit.set(q=drive[0])
    unit.start()
    found = [unit.get("y")]
    for n in range(1, len(at)):
        unit.set(q=drive[n])
        unit.step(at[n - 1], h)
        found.append(unit.get("y"))
    assert np.array(found) == pytest.approx(np.array(wanted), abs=0.01)


def test_a_step_can_be_taken_back_and_a_bad_one_is_none(tmp_path: Path) -> None:
    unit = Stepper(export(models.modified_dahl, "fmu", tmp_path)[0], 2)
    unit.start()
    kept = unit.unit.getFMUState()
    unit.set(z=1.0)
    unit.step(0.0, 0.1)
    first = unit.get("F")
    with pytest.raises(Exception, match="DoStep"):
        unit.set(z=float("nan"))
        unit.step(0.1, 0.1)
    unit.unit.setFMUState(kept)
    unit.set(z=1.0)
    unit.step(0.0, 0.1)
    assert unit.get("F") == first
    unit.unit.freeFMUState(kept)


def test_the_inverse_is_a_unit_too(tmp_path: Path) -> None:
    unit = Stepper(export(inverse(models.modified_dahl), "fmu", tmp_path)[1], 3)
    unit.start()
    unit.set(F_wanted=2.0)
    unit.step(0.0, 0.01)
    assert unit.get("F") == pytest.approx(2.0, abs=1e-12) and unit.get("z") > 0


def test_bytes_depend_on_the_model_alone(tmp_path: Path) -> None:
    first = [p.read_bytes() for p in export(models.modified_dahl, "fmu", tmp_path / "a")]
    again = [p.read_bytes() for p in export(models.modified_dahl, "fmu", tmp_path / "b")]
    other = [
        p.read_bytes() for p in export(models.modified_dahl.variant(initial="steady"), "fmu", tmp_path / "c")
    ]
    assert first == again and first != other
    names = zipfile.ZipFile(tmp_path / "a" / "modified_dahl_fmi3.fmu").namelist()
    assert {"modelDescription.xml", "sources/buildDescription.xml", "sources/modified_dahl.c"} <= set(names)


def test_what_one_step_cannot_tell_is_refused() -> None:
    t, z = Input("t", "s"), Input("z", "mm")
    y = Equation("y", z * amplitude_of(z).symbol, "mm**2")
    with pytest.raises(InputError, match=r"needs 'z_amplitude'.*no single step can tell"):
        stand_alone(Model("m", (t, z, amplitude_of(z)), (), (y,), ("y",)))
