"""Parameters of which the recordings tell nothing, or only a combination."""

from pathlib import Path

import numpy as np

import modelgen as mg
from modelgen.fit.separating import _with


def test_a_branch_that_is_not_there_has_no_time(tmp_path: Path) -> None:
    """Spring and dashpot alone: nothing tells the relaxation time of the standard solid's arm."""
    t = np.arange(800) / 200.0
    w = 2 * np.pi * 1.5
    z, v = 3 * np.sin(w * t), 3 * w * np.cos(w * t)
    F = 2.0 * z + 0.02 * v + 0.01 * np.random.default_rng(1).standard_normal(t.size)
    rows = np.column_stack([t, z, F])
    np.savetxt(tmp_path / "x.csv", rows, delimiter=",", header="t [s],z [mm],F_m [N]", comments="")
    (tmp_path / "case.toml").write_text(
        'model = "four_parameter_viscoelastic"\n[[recording]]\nfile = "x.csv"\n'
    )
    model, case = mg.open_case(tmp_path / "case.toml")
    found = mg.fit(model, case)
    values = {e.name: e for e in found.parameters}
    assert np.isfinite(values["k_D"].value) and abs(values["k_D"].value + values["k_M"].value - 2.0) < 0.1
    assert any(not e.determined or e.at_bound or e.std > abs(e.value) for e in found.parameters)


def test_what_is_told_of_one_parameter_is_not_lost_for_another_that_nothing_tells_of() -> None:
    info = np.array([[4.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    more = np.zeros((3, 3))
    assert _with(info, more, 0) == 0.5
    assert _with(info, more, 1) == np.inf
    assert np.isclose(_with(info, np.diag([0.0, 0.0, 3.0]), 2), 0.5)
