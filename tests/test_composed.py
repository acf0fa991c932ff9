"""Several effects in one model: how they act on each other, and how a search comes by them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

import modelgen as mg
import modelgen.models as models
from modelgen.codegen import build
from modelgen.diagnose.diagnosis import set_up
from modelgen.diagnose.ground import prepare
from modelgen.diagnose.hypotheses.hypothesis import make_hypotheses
from modelgen.effects import CATALOGUE, Effect
from modelgen.language import Model
from modelgen.recordings import Case, Recording

Array = np.ndarray
DAHL = {"k_D": 0.5, "c_D": 0.05, "h_D": 0.2, "rho": 2.0, "F_0": 0.3, "r_0": 0.0}
SPEAKER = {"R_e": 6.0, "L_e": 5e-4, "Bl": 6.0, "M_m": 0.015, "K_m": 2e3, "R_m": 1.0}


def stroke() -> Recording:
    t = np.arange(1500) / 500.0
    z = 1.2 * np.sin(2 * np.pi * t) + 0.4 * np.sin(2 * np.pi * 2.7 * t)
    return recorded(models.modified_dahl, {"t": t, "z": z}, DAHL, "F", 1e-3)


def sweep() -> Recording:
    return recorded(models.electrodynamic_transducer, {"f": np.geomspace(20, 2e4, 150)}, SPEAKER, "Z", 1e-3)


def recorded(
    model: Model, inputs: Mapping[str, Array], values: Mapping[str, float], output: str, noise: float
) -> Recording:
    y = build(model)(**inputs, **values)
    y = np.asarray(y[0] if isinstance(y, tuple) else y)
    rng = np.random.default_rng(3)
    e = rng.normal(size=y.size) + 1j * rng.normal(size=y.size) * np.iscomplexobj(y)
    y = y * (1 + noise * e) if np.iscomplexobj(y) else y + noise * e.real
    return Recording("one", None, "fit", dict(inputs), {output: y})


@pytest.mark.parametrize(
    ("model", "record", "ids", "values"),
    [
        (
            "modified_dahl", stroke, ("cubic_stiffness", "contact_compliance", "force_sensor_lag"),
            {"cubic_stiffness_k_3": 0.1, "contact_compliance_c": 0.1, "force_sensor_lag_tau": 0.02},
        ),
        (
            "electrodynamic_transducer", sweep,
            ("inertia", "cubic_stiffness", "coil_capacitance", "sensor_delay"),
            {
                "inertia_M": 2e-3, "cubic_stiffness_kappa": 1e3, "coil_capacitance_C": 1e-7,
                "sensor_delay_tau": 1e-6,
            },
        ),
    ],
)  # fmt: skip
def test_effects_make_the_same_model_in_whichever_order_they_are_found(
    model: str, record: Callable[[], Recording], ids: tuple[str, ...], values: Mapping[str, float]
) -> None:
    base = getattr(models, model)
    case = Case(None, base.id, (record(),))
    first: dict[str, Effect] = {}
    for e in CATALOGUE:
        plain = {f"{e.id}_{q.name}" for q in e.strengths} <= set(values) and not e.shapes
        if e.id in ids and plain and e.fits(base):
            first.setdefault(e.id, e)
    assert set(first) == set(ids)
    ground = prepare(base, case, 0)
    setting = set_up(base, case, ground, list(first.values()))
    sets = list(itertools.permutations(setting.additions))
    answers = []
    for h in make_hypotheses(base, case, ground.series, sets):
        theta = h.place(ground.base.hypothesis, ground.base.theta, values)
        answers.append(h.experiment.raw(theta, 0))
    assert len(answers) == len(sets)
    assert all(np.allclose(a, answers[0], rtol=1e-9, atol=1e-12) for a in answers)
    alone = ground.base.hypothesis.experiment.raw(ground.base.theta, 0)
    assert not np.allclose(alone, answers[0], rtol=1e-3)


def test_a_lag_of_the_sensor_is_that_of_all_that_acts() -> None:
    """Of two effects the one at the sensor shows what the other adds late, too."""
    base, record = models.modified_dahl, stroke()
    case = Case(None, base.id, (record,))
    there = [e for e in CATALOGUE if e.fits(base)]
    lag = next(e for e in there if e.id == "force_sensor_lag" and e.strengths[0].name == "tau")
    cubic = next(e for e in there if e.id == "cubic_stiffness" and e.strengths[0].name == "k_3")
    ground = prepare(base, case, 0)
    setting = set_up(base, case, ground, [lag, cubic])
    by_id = {a.id: a for a in setting.additions}
    late, spring = by_id["force_sensor_lag"], by_id["cubic_stiffness"]
    both, only = make_hypotheses(base, case, ground.series, [(late, spring), (spring,)])
    tau, values = 0.02, {"cubic_stiffness_k_3": 0.3, "force_sensor_lag_tau": 0.02}
    fast = only.experiment.raw(only.place(ground.base.hypothesis, ground.base.theta, values), 0)[0]
    slow = both.experiment.raw(both.place(ground.base.hypothesis, ground.base.theta, values), 0)[0]
    data, dt = ground.series[0].data[0], 1 / 500.0
    F, shown = fast + data, slow + data  # a residual is model less recording
    late_by_hand = np.empty_like(F)
    late_by_hand[0], keep = shown[0], np.exp(-dt / tau)
    for k in range(1, F.size):
        middle = 0.5 * (F[k] + F[k - 1])
        late_by_hand[k] = middle + (late_by_hand[k - 1] - middle) * keep
    assert np.max(np.abs(late_by_hand - shown)[50:]) < 5e-3 * np.ptp(F)
    assert np.max(np.abs(F - shown)[50:]) > 2e-2 * np.ptp(F)


def test_a_motion_may_be_held_in_one_recording(tmp_path: Path) -> None:
    """As when a sample relaxes after a step, or a gap is kept."""
    rng = np.random.default_rng(0)
    t = np.arange(800) / 400.0
    z = {"held": np.full_like(t, 0.5), "moved": 0.5 + 0.3 * np.sin(7 * t)}
    for name, at in z.items():
        v = np.gradient(at, t)
        F = 2.0 * at + 0.05 * v + 0.1 + 2e-3 * rng.standard_normal(t.size)
        np.savetxt(
            tmp_path / f"{name}.csv", np.column_stack([t, at, F]), delimiter=",",
            header="t [s],z [mm],F_m [N]", comments="",
        )  # fmt: skip
    recordings = "".join(f'[[recording]]\nfile = "{n}.csv"\n' for n in z)
    (tmp_path / "case.toml").write_text('model = "kelvin_voigt"\n[noise]\nF_m = 2e-3\n' + recordings)
    model, case = mg.open_case(tmp_path / "case.toml")
    found = {e.name: e.value for e in mg.fit(model, case).parameters}
    assert abs(found["k_D"] - 2.0) < 0.02 and abs(found["c_D"] - 0.05) < 0.01
    assert mg.diagnose(case, model).adequate
