"""A force and a voltage of one recorded motion, of different units and noise."""

import numpy as np
import pytest

from modelgen.diagnose import diagnose
from modelgen.fit.fitting import fit
from modelgen.language import Equation, Input, Model, Parameter, Port, rate_of
from modelgen.recordings import Case, Noise, Recording

t, z = Input("t", "s"), Input("z", "mm")
v = rate_of(z, "v", "mm/s")
k, c = Parameter("k", "N/mm", 2.0, (0, 100)), Parameter("c", "N*s/mm", 0.01, (0, 10))
g = Parameter("g", "V/mm", 1e-6, (0, 1))
at = Port("force", "force", "F", (("z", z.symbol), ("v", v.symbol), ("t", t.symbol)))
MODEL = Model(
    "two",
    (t, z, v),
    (k, c, g),
    (Equation("F", k * z + c * v, "N"), Equation("U", g * z, "V")),
    ("F", "U"),
    (at,),
)
SIGMA = {"F": 0.01, "U": 5e-9, "z": 1e-3}


def case(cubic: float) -> Case:
    rng, x = np.random.default_rng(3), np.arange(1500) / 200
    way = np.sin(2 * np.pi * x) + 0.4 * np.sin(2 * np.pi * 2.3 * x)
    F = 2 * way + 0.01 * np.gradient(way, x) + cubic * way**3 + SIGMA["F"] * rng.standard_normal(x.size)
    U = 1.5e-6 * way + SIGMA["U"] * rng.standard_normal(x.size)
    seen = way + SIGMA["z"] * rng.standard_normal(x.size)
    record = Recording("run", None, "fit", {"t": x, "z": seen}, {"F": F, "U": U})
    return Case(None, "two", (record,), noise=Noise(sigma=SIGMA))


@pytest.mark.parametrize(("cubic", "ids"), [(0.0, []), (0.3, ["cubic_stiffness"])])
def test_what_is_missing_of_one_of_two_outputs(cubic: float, ids: list[str]) -> None:
    assert [e.id for e in diagnose(case(cubic), MODEL).effects] == ids


def test_errors_of_the_motion_count_in_the_units_of_the_force() -> None:
    """Volts have other numbers than newtons: the force's noise is what is stated, not a million times it."""
    found = {e.name: e for e in fit(MODEL, case(0.0)).parameters}
    assert abs(found["k"].value - 2.0) < 4 * found["k"].std < 0.02
    assert abs(found["g"].value - 1.5e-6) < 4 * found["g"].std < 1e-8
