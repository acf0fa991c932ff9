"""The inverse of a motion's model: the displacement it commands gives the force that was wanted."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

import modelgen.models as models
from modelgen.errors import InputError
from modelgen.export import arm
from modelgen.export.host import Compiled
from modelgen.export.inverse import inverse
from modelgen.export.routines import make_unit
from modelgen.export.text import facts_of, render, render_c
from modelgen.language import Equation, Input, Model, Parameter, acceleration_of, rate_of

ABSENT = arm.missing_tools()
needs_arm = pytest.mark.skipif(bool(ABSENT), reason=f"not installed: {', '.join(ABSENT)}")
STEP = 1e-3


def compiled(model: Model, real: str = "double") -> tuple[Compiled, list[float]]:
    unit = make_unit(model)
    values = {p.name: float(p.default or 0.0) for p in model.scalar_parameters}
    values |= {"z_min": -8.0, "z_max": 8.0, "z_0": 0.0}
    return Compiled(unit, real, render_c(unit, real)), [values[s.name] for s in unit.parameters]


def wanted_force(t: np.ndarray) -> np.ndarray:
    """Two tones: it turns often, and its rate jumps."""
    return 1.3 + 0.8 * np.sin(2 * np.pi * t) + 0.6 * np.sign(np.sin(2 * np.pi * 4.3 * t)) * (t > 0.2)


@pytest.mark.parametrize("real", ["double", "float"])
def test_the_forward_model_gives_back_the_wanted_force(real: str) -> None:
    forward, p = compiled(models.modified_dahl, real)
    backward, q = compiled(inverse(models.modified_dahl), real)
    worst, turns, z_before, z_last = 0.0, 0, 0.0, 0.0
    for k, f in enumerate(wanted_force(STEP * np.arange(2000))):
        status, (z, reached), _ = backward.call("step" if k else "start", q, (STEP, f) if k else (0.0, f))
        assert status == 0
        _, (force,), _ = forward.call("step" if k else "start", p, (z, (z - z_before) / STEP if k else 0.0))
        if k:
            worst = max(worst, abs(force - f), abs(reached - f))
            turns += (z - z_before) * (z_before - z_last) < 0
        z_last, z_before = z_before, z
    assert turns > 10
    # a rate formed from rounded displacements carries their rounding times c_D/h = 91 N/mm
    assert worst < {"double": 1e-12, "float": 2e-4}[real]


def test_a_force_that_no_displacement_gives_is_refused_and_changes_nothing() -> None:
    backward, q = compiled(inverse(models.modified_dahl))
    assert backward.call("start", q, (0.0, 1.3))[0] == 0
    before = backward.state.copy()
    status, out, _ = backward.call("step", q, (STEP, 1e6))
    assert status == 1 and np.isnan(out).all() and (backward.state == before).all()
    assert backward.call("step", q, (STEP, 1.3))[0] == 0
    names = [s.name for s in backward.unit.parameters]
    no_spring = [0.0 if n in ("k_D", "c_D") else v for n, v in zip(names, q, strict=True)]
    h, offset = q[names.index("h_D")], q[names.index("F_0")]
    assert backward.call("step", no_spring, (STEP, offset + 1.01 * h))[0] == 1  # friction saturates
    assert backward.call("step", no_spring, (STEP, offset + 0.9 * h))[0] == 0


def held(backward: Compiled, q: list[float], force: float) -> None:
    """Samples at the time of the one before leave the drive; the next step goes on as if they were not."""
    assert backward.call("start", q, (0.0, force))[0] == 0
    for _ in range(3):
        _, (z, _), _ = backward.call("step", q, (STEP, force))
    kept = backward.state.copy()
    for call in ("step", "step_jacobian", "step"):
        status, (same, _), jac = backward.call(call, q, (0.0, 3 * force))
        assert status == 0 and same == z and (call == "step" or np.isfinite(jac).all())
    assert backward.state == pytest.approx(kept, abs=1e-15)
    _, (there, _), _ = backward.call("step", q, (STEP, force))
    backward.state[:] = kept
    assert backward.call("step", q, (STEP, force))[1][0] == pytest.approx(there, abs=1e-12)


@pytest.mark.parametrize("start", [0.0, 1.5])
def test_where_no_time_passes_the_drive_stays(start: float) -> None:
    backward, q = compiled(inverse(models.modified_dahl))
    q[[s.name for s in backward.unit.parameters].index("z_0")] = start
    assert backward.call("start", q, (0.0, 9.0))[1][0] == start
    held(backward, q, 0.1)


def test_where_no_time_passes_the_speed_stays_for_the_next_acceleration() -> None:
    t, z, k, m = Input("t", "s"), Input("z", "m"), Parameter("k", "N/m", 900.0), Parameter("m", "kg", 2.0)
    v, a = rate_of(z, "v", "m/s"), acceleration_of(z, "a", "m/s**2")
    mass = Model("mass", (t, z, v, a), (k, m), (Equation("F", k * z + m * a, "N"),), ("F",))
    held(*compiled(inverse(mass)), 5.0)


def test_an_extended_model_is_inverted_too() -> None:
    model = models.modified_dahl.extend("k_f", lambda k: k * (1 + 0.02 * models.modified_dahl.inputs[1] ** 2))
    forward, p = compiled(model)
    backward, q = compiled(inverse(model))
    before = 0.0
    for k, f in enumerate(wanted_force(0.01 * np.arange(200))):
        _, (z, _), _ = backward.call("step" if k else "start", q, (0.01, f) if k else (0.0, f))
        _, (force,), _ = forward.call("step" if k else "start", p, (z, (z - before) / 0.01 if k else 0.0))
        before = z
        assert k == 0 or force == pytest.approx(f, abs=1e-12)


def test_what_has_no_motion_has_no_inverse() -> None:
    with pytest.raises(InputError, match="no motion in time"):
        inverse(models.electrodynamic_transducer)
    with pytest.raises(InputError, match="no output 'G'"):
        inverse(models.modified_dahl, output="G")


LOOP = """
#include <math.h>
#include <stdio.h>
#include "modified_dahl.h"
#include "modified_dahl_inverse.h"

int main(void)
{
    const modified_dahl_parameters p = MODIFIED_DAHL_DEFAULTS;
    modified_dahl_inverse_parameters q = MODIFIED_DAHL_INVERSE_DEFAULTS;
    modified_dahl_state x;
    modified_dahl_inverse_state y;
    modified_dahl_output f;
    modified_dahl_inverse_output c;
    float before = 0.0f, worst = 0.0f;
    int refused = 0;
    q.z_min = -8.0f;
    q.z_max = 8.0f;
    for (int k = 0; k < 2000; ++k) {
        const float phase = 0.00628318531f * (float)k;
        const modified_dahl_inverse_input want = { (k > 0) ? 0.001f : 0.0f, 1.3f + 0.8f * sinf(phase) };
        refused += (k > 0) ? modified_dahl_inverse_step(&q, &want, &y, &c)
                           : modified_dahl_inverse_start(&q, &want, &y, &c);
        const modified_dahl_input move = { c.z, (k > 0) ? (c.z - before) / 0.001f : 0.0f };
        refused += (k > 0) ? modified_dahl_step(&p, &move, &x, &f) : modified_dahl_start(&p, &move, &x, &f);
        if (k > 0) {
            worst = fmaxf(worst, fabsf(f.F - want.F_wanted));
        }
        before = c.z;
    }
    printf("worst %g refused %d\\n", (double)worst, refused);
    return 0;
}
"""


@needs_arm
@pytest.mark.parametrize("core", arm.CORES, ids=lambda c: c.name)
def test_closed_loop_on_a_microcontroller(core: arm.Core) -> None:
    files = {"loop.c": LOOP}
    for model in (models.modified_dahl, inverse(models.modified_dahl)):
        unit = make_unit(model)
        files |= render_c(unit, "float")
        files |= {n: render(f"arm/{n}", facts_of(unit, "float")) for n in ("startup.c", "board.ld")}
    with tempfile.TemporaryDirectory() as name:
        text, passed = arm.emulate(core, arm.link(core, files, Path(name)))
    words = text.split()
    assert passed and words[0] == "worst" and words[3] == "0", text
    assert 0 < float(words[1]) < 2e-4
