"""A tank that runs out through a valve: laminar entry and turbulent head in series, the first modelled."""

import numpy as np
from scipy.integrate import solve_ivp
from sympy import Symbol

from modelgen.diagnose import diagnose
from modelgen.language import Equation, Input, Model, Parameter, Port, State
from modelgen.recordings import Case, Recording

t, q = Input("t", "s"), Input("q", "m**3/s")
A = Parameter("A", "m**2", 0.5, (0.01, 10.0), "surface of the tank")
g = Parameter("g", "m**2/s", 1e-3, (1e-6, 0.1), "what the valve lets through")
h_0 = Parameter("h_0", "m", 0.5, (0.0, 10.0), "level at the start")
h = Symbol("h", real=True)
q_out = Equation("q_out", g * h, "m**3/s")
level = State("h", h_0, rate=(q - q_out.symbol) / A, unit="m", substeps=2)
tank = Model(
    "tank", (t, q), (A, g, h_0), (q_out, level), ("h",), (Port("valve", "force", "q_out", (("z", h),)),)
)


def test_a_valve_that_is_laminar_first_and_turbulent_later() -> None:
    rng, time = np.random.default_rng(6), np.arange(1500) * 2.0
    flow = np.interp(time, np.arange(0, 3200, 250.0), rng.uniform(0.2, 2.2, 13))

    def rate(at: float, x: np.ndarray) -> list[float]:
        head = max(x[0], 0.0)  # = 0.1 q + 0.5 q²
        return [1e-3 * (np.interp(at, time, flow) - (np.sqrt(0.01 + 2 * head) - 0.1)) / 0.4]

    x = solve_ivp(rate, (0, time[-1]), [0.5], t_eval=time, max_step=2.0, rtol=1e-8).y[0]
    x = x + rng.normal(0, 2e-3, time.size)
    found = diagnose(
        Case(None, "tank", (Recording("r", None, "fit", {"t": time, "q": 1e-3 * flow}, {"h": x}),)), tank
    )
    assert [e.id for e in found.effects] == ["power_law_stiffness"]
    assert found.after.fit_over_noise < 1.1
