"""The modified Dahl model and its steady cycle, against 40-digit values, limits and invariants."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import pytest
from exact import close, dahl_step, evaluate, reference_table, run
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen.models as models

m = mp.mpf
DAHL = {
    "M0": {"k_D": "0.3834", "c_D": "0.0912", "h_D": "0.0353", "rho": "1.46"},
    "M1": {"k_D": "0.6797", "c_D": "0.1374", "h_D": "0.2309", "rho": "1.44"},
}
STAGE_2 = {
    "M0": {"k_D": "0.3494", "c_D": "0.0811", "h_D": "0.1972", "rho": "1.59"},
    "M1": {"k_D": "0.6602", "c_D": "0.1130", "h_D": "0.2906", "rho": "1.41"},
}
CYCLE = {"M0": ("3.01", "0.099"), "M1": ("2.99", "0.1")}


@pytest.fixture(scope="module")
def table() -> dict[str, Any]:
    return reference_table()


def path(z: list[Any], r_0: Any, **values: Any) -> list[Any]:
    """Friction state along displacements `z` (pairs: turning point, value), one sample each."""
    samples = [
        {"t": k, "z": x if not isinstance(x, tuple) else x[1], "v": 0, "a": 0} for k, x in enumerate(z)
    ]
    for sample, x in zip(samples, z, strict=True):
        if isinstance(x, tuple):
            sample["z_turn"] = x[0]
    return [e["r"] for e in run(models.modified_dahl, samples, r_0=r_0, **values)]


@pytest.mark.parametrize(
    ("r_0", "dz", "b", "wanted"),
    [("-1", "0.5", "1", "0.036182019819595146014"), ("-1", "0.5", "0.5", "-0.10084909946764061437"),
     ("-1", "0.5", "1.5", "0.1299906619562436793"), ("-1", "0.5", "2", "0.18699186991869918699"),
     ("-0.9", "1.3", "1", "0.71525069398409764268"), ("-0.9", "1.3", "2", "0.5875124831748512874"),
     ("0.6", "-0.8", "1", "-0.50241872592651505633"), ("0.6", "-0.8", "1.5", "-0.47074295552527033594")],
)  # fmt: skip
def test_exact_step(r_0: str, dz: str, b: str, wanted: str) -> None:
    assert close(path([0, m(dz)], r_0, rho="1.46", b=b)[-1], wanted)


unit = st.floats(-0.99, 0.99)


@given(r_0=unit, z=st.floats(-3, 3), part=st.floats(0, 1), rho=st.floats(0.1, 5), b=st.floats(0.3, 3))
@settings(max_examples=40, deadline=None)
def test_a_step_is_the_same_in_parts_and_stays_within_friction(
    r_0: float, z: float, part: float, rho: float, b: float
) -> None:
    whole = path([0, m(z)], r_0, rho=rho, b=b)[-1]
    assert abs(whole - path([0, m(z) * part, m(z)], r_0, rho=rho, b=b)[-1]) < 1e-28
    assert abs(whole) <= 1
    assert close(path([0, 0], r_0, rho=rho, b=b)[-1] + 1, m(r_0) + 1, 35)  # at rest nothing changes


@given(r_0=unit, top=st.floats(0, 3), end=st.floats(-3, 0), b=st.floats(0.3, 3))
@settings(max_examples=20, deadline=None)
def test_a_reversal_inside_a_step(r_0: float, top: float, end: float, b: float) -> None:
    assert abs(path([0, (top, end)], r_0, b=b)[-1] - path([0, top, end], r_0, b=b)[-1]) < 1e-28


def dahl_slopes(u: Any, x: Any, b: Any) -> tuple[Any, Any, Any]:
    """∂ dahl_step by u, x and b as the language states them."""
    w = x * u ** (b - 1)
    y = (b - 1) * w
    if y <= -1:
        return m(0), m(0), m(0)
    ratio = mp.log1p(y) / y if y else m(1)
    g = (1 / (1 + y) - ratio) / y if y else m(-1) / 2
    new = u * mp.exp(-w * ratio)
    return mp.exp(-b * w * ratio), -(new**b), -new * (w**2 * g + w * mp.log(u) / (1 + y))


@given(u=st.floats(1e-3, 2), x=st.floats(1e-3, 5), b=st.one_of(st.just(1), st.floats(0.3, 3)))
@settings(max_examples=60, deadline=None)
def test_the_slopes_of_a_step_also_where_the_exponent_passes_through_one(
    u: float, x: float, b: float
) -> None:
    at, h = [m(u), m(x), m(b)], m("1e-14")
    for k, slope in enumerate(dahl_slopes(*at)):
        high, low = (dahl_step(*(a + d if i == k else a for i, a in enumerate(at))) for d in (h, -h))
        assert abs((high - low) / (2 * h) - slope) < 1e-12


def loop(values: dict[str, str], A_z: Any, f: Any, n: int, **more: Any) -> list[dict[str, Any]]:
    """One cycle in n samples from r_0, or else from the steady cycle."""
    model = models.modified_dahl
    if "r_0" not in more:
        model, more = model.variant(initial="steady"), {"A_z": A_z}
    w = 2 * mp.pi * m(f)
    samples = [
        {"t": k / (n * m(f)), "z": -m(A_z) * mp.cos(x), "v": w * m(A_z) * mp.sin(x), "a": 0}
        for k, x in ((k, 2 * mp.pi * k / n) for k in range(n))
    ]
    return run(model, samples, **values, F_0=0, **more)


@pytest.mark.parametrize("case", DAHL)
def test_quality_factors(case: str, table: dict[str, Any]) -> None:
    """J_e and J_es of (14), (15) between the published sets of stages 2 and 4 (scaled error squared)."""
    n, (A_z, f) = 1000, CYCLE[case]
    a, b = (loop(s[case], A_z, f, n, r_0=-1) for s in (DAHL, STAGE_2))
    error = [x["F"] - y["F"] for x, y in zip(a, b, strict=True)]
    scaled = [e * (abs(mp.sin(2 * mp.pi * k / n)) + 1) / 2 for k, e in enumerate(error)]
    assert close(mp.sqrt(sum(e**2 for e in error) / n), table[f"{case} J_e (n=1000)"])
    assert close(
        mp.sqrt(sum(e**2 for e in scaled) / n), table[f"{case} J_es inside (s_c*err)^2 [recommended]"]
    )


def stiffness(values: dict[str, Any], A_z: Any, f: Any, **more: Any) -> dict[str, Any]:
    return evaluate(models.complex_stiffness, f=m(f), **values, A_z=A_z, **more)


def test_steady_cycle() -> None:
    found = stiffness(DAHL["M0"], *CYCLE["M0"])
    wanted = {
        "A_F": "1.2018872579396107428", "k_s": "0.39929809233874111056", "c_s": "0.64192187033206778192",
        "h_s": "0.20518482603477049268", "energy_per_cycle": "1.9430325589629810537",
    }  # fmt: skip
    for name, value in wanted.items():
        assert close(found[name], value), name


@pytest.mark.parametrize("case", DAHL)
def test_steady_cycle_table(case: str, table: dict[str, Any]) -> None:
    found = stiffness(DAHL[case], *CYCLE[case])
    for name in ("r_m", "A_F", "k_s", "c_s", "h_s", "energy_per_cycle"):
        assert close(found[name], table[f"{case} stage 4 steady cycle: {name}"]), name
    for f in (1, 3, 5, 7, 9):
        assert close(
            stiffness(DAHL[case], "0.4", f)["k_s"], table[f"{case} params at A=0.4 mm, f={f} Hz: k_s"]
        )


def test_published_stiffness_and_damping() -> None:
    """Table 2 to its rounding, from the parameters of Table 4."""
    m0, m1 = (stiffness(DAHL[c], *CYCLE[c]) for c in ("M0", "M1"))
    assert abs(m0["k_s"] - 0.40) < 0.005 and abs(m0["h_s"] - 0.205) < 0.005
    assert abs(m1["k_s"] - 0.77) < 0.01 and abs(m1["h_s"] - 0.475) < 0.01


@given(k=st.one_of(st.just(0), st.floats(1e-3, 5)), c=st.floats(1e-3, 5), f=st.floats(0.01, 50))
@settings(max_examples=30, deadline=None)
def test_without_friction_it_is_the_modulus_and_angle_of_a_complex_stiffness(
    k: float, c: float, f: float
) -> None:
    e = stiffness({"k_D": k, "c_D": c, "h_D": 0}, "0.4", f)
    assert close(e["k_s"], abs(e["K"]), 25)
    assert abs(e["loss_angle"] - mp.arg(e["K"]) * 180 / mp.pi) < 1e-10  # asin near 90° loses half the digits
    assert close(e["energy_per_cycle"], mp.pi * e["K"].imag * m("0.4") ** 2, 25)


def test_without_dashpot_the_peak_is_where_the_displacement_turns() -> None:
    e = stiffness({"k_D": "0.5", "c_D": 0, "h_D": "0.2", "rho": "1.5"}, 2, 1)
    assert close(e["theta_pk"], mp.pi, 30)
    assert close(e["k_s"], m("0.5") + m("0.2") * mp.tanh(3) / 2, 30)


def test_a_mass_in_place_of_a_spring() -> None:
    """Re K < 0 above resonance: the force peaks near the other end, and the bracket still holds it."""
    heavy = models.complex_stiffness.extend("K", lambda K: K - 2)
    e = evaluate(heavy, f=1, k_D=1, c_D="0.01", h_D=0)
    assert close(e["k_s"], abs(e["K"]), 25)
    assert evaluate(heavy, f=1, k_D=1, c_D="0.01", h_D="0.1")["theta_pk"] > e["theta_pk"]


@pytest.mark.parametrize("case", DAHL)
def test_the_steady_cycle_is_that_of_the_time_model(case: str) -> None:
    """Peak, width and area of the simulated loop, from a start on the steady cycle."""
    n, A_z, f = 64, m("0.8"), m(2)
    e = stiffness(DAHL[case], A_z, f)
    cycle = loop(DAHL[case], A_z, f, n)
    assert close(cycle[n // 2]["r"], e["r_m"], 30) and close(cycle[n // 4]["F"], e["h_s"], 30)
    assert close(cycle[n // 4]["F"], -cycle[3 * n // 4]["F"], 30)
    assert 0 <= e["A_F"] - max(x["F"] for x in cycle) < 2e-3 * e["A_F"]
    area = sum(x["F"] * x["v"] for x in cycle) / (n * f)
    assert abs(area - e["energy_per_cycle"]) < 2e-3 * e["energy_per_cycle"]
