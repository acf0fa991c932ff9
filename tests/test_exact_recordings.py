"""Recordings that are simulated, without noise: nothing is missing, and what is, is found all the same."""

from pathlib import Path

import numpy as np
import pytest

from modelgen.api import read_case
from modelgen.codegen import build
from modelgen.codegen.inputs import complete_inputs
from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.gate.exact import recorded_exactly
from modelgen.fit.series import Series
from modelgen.fit.whitener import Whitener
from modelgen.models import load
from modelgen.report.words import headline

DIGITS = ("%.18e", "%.10g", "%.7g", "%.6g")


def _coil(folder: Path, digits: str, f: np.ndarray, eddy: float = 0.0) -> Verdict:
    s = 2j * np.pi * f
    Z = 4 + 3e-4 * s + eddy * s / (1 + s / 9e3) + 35 / (1.8 + 0.02 * s + 2e3 / s)
    rows = np.column_stack([f, Z.real, Z.imag])
    head = "f [Hz],Re Z [ohm],Im Z [ohm]"
    np.savetxt(folder / "a.csv", rows, delimiter=",", header=head, comments="", fmt=digits)
    text = 'model = "electrodynamic_transducer"\n[constants]\nM_m = 0.02\n'
    (folder / "case.toml").write_text(text + '[[recording]]\nfile = "a.csv"\nrole = "fit"\n')
    case = read_case(folder / "case.toml")
    return diagnose(case, load(case.model))


@pytest.mark.parametrize("digits", DIGITS)
@pytest.mark.parametrize(("n", "top"), [(70, 2000), (100, 3000), (250, 2000)])
def test_an_exact_sweep_lacks_nothing(tmp_path: Path, digits: str, n: int, top: float) -> None:
    v = _coil(tmp_path, digits, np.geomspace(10, top, n))
    assert v.adequate and any("no noise" in note for note in v.notes)


def test_as_many_numbers_as_parameters_do_not_tell_noise(tmp_path: Path) -> None:
    v = _coil(tmp_path, "%.6g", np.geomspace(65, 70, 3))
    assert v.adequate and not v.judged and "can't be judged" in v.summary
    assert headline(v).startswith("Too few values")
    assert not any("no noise" in note for note in v.notes)


def test_each_output_is_exact_by_itself() -> None:
    """Degrees beside N/m: the larger numbers say nothing of the smaller."""
    data = np.stack([np.linspace(0, 1e6, 50), np.linspace(0, 1, 50)])
    s = Series("a", "fit", {}, data, "real", (0, 1), "", Whitener(np.ones((2, 50))))
    assert recorded_exactly(s, 1e-6 * np.ptp(data, axis=1, keepdims=True) * np.ones((2, 50)))
    assert not recorded_exactly(s, np.stack([np.zeros(50), np.full(50, 1e-3)]))


def test_what_an_exact_sweep_lacks_is_found(tmp_path: Path) -> None:
    v = _coil(tmp_path, "%.6g", np.geomspace(10, 3000, 120), eddy=1e-5)
    assert [e.id for e in v.effects] == ["eddy_shunt"]


@pytest.mark.parametrize("digits", DIGITS)
def test_an_exact_record_over_time_lacks_nothing(tmp_path: Path, digits: str) -> None:
    model, t = load("modified_dahl"), np.linspace(0, 20, 4001)
    z = 3 * np.sin(0.2 * np.pi * t)
    inputs, _ = complete_inputs(model, {"t": t, "z": z}, {"z": 0.0})
    values = {p.name: p.default for p in model.scalar_parameters if p.default is not None}
    values |= {"k_D": 0.45, "c_D": 0.09, "h_D": 0.06, "rho": 1.2, "F_0": 1.5, "r_0": 0.0}
    F = build(model, (), wait=True).all(**inputs, **values)["F_r"]
    rows, head = np.column_stack([t, z, F]), "t [s],z [mm],F_m [N]"
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header=head, comments="", fmt=digits)
    text = 'model = "modified_dahl"\n[constants]\nr_0 = 0.0\n'
    (tmp_path / "case.toml").write_text(text + '[[recording]]\nfile = "a.csv"\nrole = "fit"\n')
    v = diagnose(read_case(tmp_path / "case.toml"), model)
    assert v.adequate and any("no noise" in note for note in v.notes)
