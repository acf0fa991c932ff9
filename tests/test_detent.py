"""A force that is periodic in the position, as of the teeth of a motor: in no catalogue, but described."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from sympy import Symbol

from modelgen.diagnose import diagnose
from modelgen.language import Equation, Input, Model, Parameter, Port, State, acceleration_of, rate_of, tanh
from modelgen.recordings import Case, Noise, Recording

t, z = Input("t", "s"), Input("z", "m", "position of the slide")
v, a = rate_of(z, "v", "m/s"), acceleration_of(z, "a", "m/s**2")
M = Parameter("M", "kg", 2.0, (0.1, 20.0), "slide")
F_v = Parameter("F_v", "N*s/m", 10.0, (0.0, 1e3), "viscous friction")
F_c = Parameter("F_c", "N", 3.0, (0.0, 100.0), "dry friction")
v_s = Parameter("v_s", "m/s", 2e-3, (1e-5, 0.1), "where it has its full size", known=True)
level = Equation("F_h", F_c, "N")
F = Equation("F", M * a + F_v * v + level * tanh(v / v_s), "N")
slide = Model(
    "slide",
    (t, z, v, a),
    (M, F_v, F_c, v_s),
    (level, F),
    ("F",),
    (Port("thrust", "force", "F", (("z", z),)),),
)
TEETH = 2 * np.pi / 0.032


def driven(seed: int, stroke: float) -> Recording:
    rng, time = np.random.default_rng(seed), np.arange(0, 4, 2e-3)
    lines = rng.uniform(0.3, 1.5, 4)
    share, phase = rng.dirichlet(np.ones(4)), rng.uniform(0, 2 * np.pi, 4)
    angle = 2 * np.pi * lines * time[:, None] + phase
    where = stroke * np.sin(angle) @ share
    speed = stroke * np.cos(angle) @ (share * 2 * np.pi * lines)
    bent = -stroke * np.sin(angle) @ (share * (2 * np.pi * lines) ** 2)
    detent = 0.3 * np.sin(TEETH * where + 0.7) + 0.1 * np.sin(2 * TEETH * where)
    felt = 2.2 * bent + 11 * speed + 3.4 * np.tanh(speed / 2e-3) + detent
    shown = felt + rng.normal(0, 0.12, time.size)
    return Recording(f"r{seed}", None, "fit", {"t": time, "z": where}, {"F": shown})


u = Input("u", "N", "drive")
place, speed = Symbol("place", real=True), Symbol("speed", real=True)
loss = Equation("loss", F_v * speed + level * tanh(speed / v_s), "N")
states = (
    State("place", 0.0, rate=speed, unit="m", substeps=2),
    State("speed", 0.0, rate=(u - loss.symbol) / M, unit="m/s", substeps=2),
)
rail = Port("rail", "force", "loss", (("z", place), ("v", speed), ("t", t)))
pushed = Model("pushed", (t, u), (M, F_v, F_c, v_s), (level, loss, *states), ("place",), (rail,))


def pushed_along(seed: int) -> Recording:
    rng, time = np.random.default_rng(seed), np.arange(0, 6, 5e-3)
    drive = 9 * np.sin(2 * np.pi * np.outer(time, rng.uniform(0.3, 1.0, 3))).mean(axis=1)

    def rate(at: float, x: np.ndarray) -> list[float]:
        detent = 0.15 * np.sin(TEETH * x[0] + 0.7)
        lost = 11 * x[1] + 1.5 * np.tanh(x[1] / 2e-3) + detent
        return [x[1], (np.interp(at, time, drive) - lost) / 2.2]

    x = solve_ivp(rate, (0, time[-1]), [0.0, 0.0], t_eval=time, max_step=1e-3, rtol=1e-6).y[0]
    shown = x + rng.normal(0, 2e-4, time.size)
    return Recording(f"p{seed}", None, "fit", {"t": time, "u": drive}, {"place": shown})


@pytest.mark.slow  # a minute
def test_a_detent_where_the_place_follows_from_the_drive() -> None:
    case = Case(None, "pushed", (pushed_along(1), pushed_along(2)), noise=Noise({"place": 2e-4}))
    found = diagnose(case, pushed)
    assert [e.id for e in found.effects] == ["unknown_rail"]
    assert "wavelength" in found.effects[0].says


def test_one_wavelength_in_recordings_of_different_strokes() -> None:
    noise = Noise({"F": 0.12, "z": 0.0})
    found = diagnose(Case(None, "slide", (driven(1, 0.12), driven(2, 0.07)), noise=noise), slide)
    assert [e.id for e in found.effects] == ["unknown_thrust"]
    assert "position" in found.effects[0].says
    assert found.after.fit_over_noise == pytest.approx(1, abs=0.05)
    kappa = next(p for p in found.effects[0].parameters if p.name == "kappa")
    assert kappa.value == pytest.approx(TEETH, rel=0.01)
