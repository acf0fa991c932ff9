"""The laws of the catalogue against other numerics: closed forms, networks solved node by node, simple
loops in time."""

from __future__ import annotations

from dataclasses import replace
from math import gamma
from typing import Any

import numpy as np
import pytest
import sympy as sp
from interpreter import Reading
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.special import iv, j1, jv, struve

from modelgen.effects import CATALOGUE, Effect
from modelgen.effects.effect import unit_omega
from modelgen.effects.ladder import ARMS, STEP, Ladder
from modelgen.effects.rod import xcotx
from modelgen.language import Equation, Input, Model, Parameter, Port, j, pi
from modelgen.models import load

Array = np.ndarray
f = np.geomspace(20, 8000, 81)
w = 2 * np.pi * f
COIL = {"R_e": 6.0, "L_e": 5e-4, "Bl": 6.0, "M_m": 0.015, "K_m": 2e3, "R_m": 1.0}
KNOWN = {"electrodynamic_transducer": COIL}
NOTHING = {"k_D": 0.0, "c_D": 0.0, "h_D": 0.0, "F_0": 0.0, "rho": 1.5, "r_0": 0.0}


def find(id: str, kind: str, name: str = "", needs: str = "") -> Effect:
    """The law of the catalogue for a kind of port; by its strength or a variable where there are several."""
    laws = [
        e for e in CATALOGUE if e.id == id and kind in e.kinds and (not name or e.strengths[0].name == name)
    ]
    return next(e for e in laws if not needs or needs in e.needs)


def extended(e: Effect, model: str) -> Reading:
    base = replace(load(model), checked=True)
    return Reading(e.extend(base, e.fits(base)[0]))


def at_port(e: Effect, model: str = "electrodynamic_transducer", **p: float) -> tuple[Array, Array]:
    """The quantity at the effect's port without and with the effect."""
    port = e.fits(load(model))[0]
    known = KNOWN.get(model, {})
    values = extended(e, model)({"f": f}, **known, **{f"{e.id}_{k}": v for k, v in p.items()})
    return values[f"{port.equation}_1"] * np.ones(len(f)), values[port.equation]


def record(t: Array, z: Any) -> dict[str, Array]:
    """A displacement z(t) with its derivatives by fine differences; turns of a path inside a step are
    found."""
    d = 1e-5
    x, v, a = z(t), (z(t + d) - z(t - d)) / (2 * d), (z(t + d) - 2 * z(t) + z(t - d)) / d**2
    before = np.concatenate([x[:1], x[:-1]])
    turn = before.copy()
    for k in np.flatnonzero(v[1:] * v[:-1] < 0):
        fine = z(np.linspace(t[k], t[k + 1], 200))
        turn[k + 1] = fine.max() if v[k] > 0 else fine.min()
    return {
        "t": t,
        "z": x,
        "t_prev": np.concatenate([t[:1], t[:-1]]),
        "z_prev": before,
        "z_turn": turn,
        "v": v,
        "a": a,
    }


def force(e: Effect, motion: dict[str, Array], base: dict[str, float] | None = None, **p: float) -> Array:
    """Force of the modified Dahl model (by default of nothing) with the effect."""
    given = {f"{e.id}_{k}": v for k, v in p.items()}
    return np.asarray(extended(e, "modified_dahl")(motion, **(NOTHING | (base or {})), **given)["F"])


def wobble(t: Array) -> Array:
    return np.sin(2 * np.pi * t) + 0.4 * np.sin(2 * np.pi * 2.7 * t + 0.5) - 0.4 * np.sin(0.5)


# -- electrical ----------------------------------------------------------------------------------------------


def test_skin_effect_is_a_round_wire() -> None:
    old, new = at_port(find("coil_ac_resistance", "electrical_impedance"), R=2.0, omega_s=3e3)
    x = np.sqrt(1j * w / 3e3)
    wire = x * iv(0, x) / (2 * iv(1, x)) - 1
    assert np.allclose(new - old, 2.0 * wire, rtol=1e-9)
    old, new = at_port(find("coil_ac_resistance", "electrical_impedance", "tau_s"), tau_s=1 / 3e3)
    assert np.allclose(new - old, COIL["R_e"] * wire, rtol=1e-9)


def test_a_resistance_that_grows_leaves_the_inductance_alone() -> None:
    old, new = at_port(find("coil_ac_resistance", "electrical_impedance", "K_r"), K_r=1e-3, X_r=0.7)
    assert np.allclose(new - old, 1e-3 * w**0.7, rtol=1e-12)
    e = find("coil_ac_resistance", "electrical_impedance", "R_c")
    old, new = at_port(e, R_c=0.8, omega_c=3e3, X_c=0.5)
    assert np.allclose(new - old, 0.8 * ((1 + (w / 3e3) ** 2) ** 0.25 - 1), rtol=1e-9)


def test_shunts_are_resistances_in_parallel() -> None:
    old, new = at_port(find("eddy_shunt", "inductance"), G=1 / 20.0)
    assert np.allclose(1 / (1j * w * new), 1 / (1j * w * old) + 1 / 20.0)
    old, new = at_port(find("eddy_shunt", "electrical_impedance"), L_2=1e-3, omega_2=5e3)
    assert np.allclose(1 / (new - old), 1 / (1j * w * 1e-3) + 1 / 5.0)
    law = find("eddy_shunt", "electrical_impedance", "L_4")
    old, new = at_port(law, L_4=1e-3, L_5=2e-4, omega_4=5e3, ratio=10.0)
    cells = [1 / (1 / (1j * w * L) + 1 / R) for L, R in ((1e-3, 5.0), (2e-4, 10.0))]
    assert np.allclose(new - old, sum(cells))
    old, new = at_port(find("eddy_shunt", "terminals"), G_0=1 / 50.0)
    wire = COIL["R_e"]
    assert np.allclose(1 / (new - wire), 1 / (old - wire) + 1 / 50.0)


@pytest.mark.parametrize(("id", "corner"), [("semi_inductance", "omega_c"), ("eddy_shunt", "omega_s")])
def test_a_share_of_an_inductance_is_a_part_of_it_beside_the_rest(id: str, corner: str) -> None:
    """L_e of which 0.3 is by the flux in the core is 0.7 L_e beside a part of 0.3 L_e."""
    law = next(e for e in CATALOGUE if e.id == id and e.strengths[0].name == "share")
    part = {"omega_c": ("L_3", "omega_3"), "omega_s": ("L_2", "omega_2")}[corner]
    beside = find(id, "electrical_impedance", part[0])
    given = {f"{id}_{part[0]}": 0.3 * COIL["L_e"], f"{id}_{part[1]}": 5e3}
    less = COIL | {"L_e": 0.7 * COIL["L_e"]}
    wanted = extended(beside, "electrodynamic_transducer")({"f": f}, **less, **given)["Z"]
    given = {f"{id}_share": 0.3, f"{id}_{corner}": 5e3}
    assert np.allclose(extended(law, "electrodynamic_transducer")({"f": f}, **COIL, **given)["Z"], wanted)


def test_semi_inductance_and_cole_cole() -> None:
    old, new = at_port(find("semi_inductance", "electrical_impedance"), K=0.02, n=0.6)
    assert np.allclose(np.angle(new - old), 0.3 * np.pi)
    assert np.allclose(np.abs(new - old), 0.02 * w**0.6)
    old, new = at_port(find("permeability_relaxation", "inductance"), L_s=0.3, tau=1e-3, a=0.7)
    assert np.allclose(new - old, 0.3 / (1 + (1j * w * 1e-3) ** 0.7))


def test_leach_s_coil_is_an_inductance_in_parallel_with_a_semi_inductance() -> None:
    """1/(jωL') = 1/(jωL) + 1/(K(jω)^n)"""
    old, new = at_port(find("semi_inductance", "inductance", "Y"), Y=1 / 0.03, n_p=0.6)
    assert np.allclose(1 / (1j * w * new), 1 / (1j * w * old) + 1 / (0.03 * (1j * w) ** 0.6))


def test_dielectrics() -> None:
    def at_capacitance(e: Effect, **p: float) -> tuple[Array, Array]:
        return at_port(e, "piezoelectric_transducer", **p)

    old, new = at_capacitance(find("dielectric_loss", "capacitance", "n"), n=0.1)
    assert np.allclose(np.tan(-np.angle(new)), np.tan(0.05 * np.pi))
    assert np.allclose(np.abs(new), old.real * w**-0.1)
    old, new = at_capacitance(find("dielectric_loss", "capacitance", "tan_delta"), tan_delta=0.02)
    assert np.allclose(new, old * (1 - 0.02j))
    old, new = at_capacitance(find("dielectric_relaxation", "capacitance"), C_s=1e-9, tau=1e-3, a=0.7)
    assert np.allclose(new - old, 1e-9 / (1 + (1j * w * 1e-3) ** 0.7))
    old, new = at_capacitance(find("leakage_conductance", "capacitance"), G=1e-6)
    assert np.allclose(1j * w * new, 1j * w * old + 1e-6)


def test_what_lies_across_a_device_is_a_leak_where_there_are_capacitances() -> None:
    """Of a coil it is eddy currents; a crystal has none."""
    hertz = Input("f", "Hz")
    R, C = Parameter("R", "ohm", 1e3, (1.0, 1e6)), Parameter("C", "F", 1e-9, (1e-12, 1e-6))
    omega = Equation("omega", 2 * pi * hertz, "rad/s")
    Z = Equation("Z", R + 1 / (j * omega * C), "ohm")
    port = Port("electrical", "terminals", "Z", (("omega", omega.symbol),))
    crystal = Model("crystal", (hertz,), (R, C), (omega, Z), ("Z",), (port,))
    leak = find("leakage_conductance", "terminals")
    assert leak.fits(crystal) and not find("eddy_shunt", "terminals").fits(crystal)
    coil = load("electrodynamic_transducer")
    assert find("eddy_shunt", "terminals").fits(coil) and not leak.fits(coil)
    found = Reading(leak.extend(replace(crystal, checked=True), port))
    values = found({"f": f}, R=1e3, C=1e-9, leakage_conductance_G_0=1e-5)
    assert np.allclose(1 / values["Z"], 1 / values["Z_1"] + 1e-5)


def test_transduction_loses_energy_by_one_angle() -> None:
    old, new = at_port(find("transduction_loss", "transduction"), "piezoelectric_transducer", tan_theta=0.02)
    assert np.allclose(new, old * (1 - 0.02j))


def test_flux_is_screened_as_by_a_shorted_turn() -> None:
    """The turn's current jωΦ/(R + jωL) takes its share of the flux away."""
    old, new = at_port(find("flux_shielding", "transduction", "g"), g=0.3, tau=2e-4)
    R, L = 5e-3, 1e-6
    assert np.isclose(L / R, 2e-4)
    assert np.allclose(new / old, 1 - 0.3 * 1j * w * L / (R + 1j * w * L))
    assert np.all(np.diff(np.abs(new)) < 0) and np.all(np.abs(new) > 0.7 * np.abs(old))


def test_flux_enters_thick_metal_through_a_skin() -> None:
    """Of a half-space beside the gap: its surface impedance, jωμδ/(1 + j), over that and the gap's own."""
    old, new = at_port(find("flux_shielding", "transduction", "g_d"), g_d=0.3, tau_d=2e-4)
    mu, sigma, own = 4e-7 * np.pi, 1e6, 2e-4
    depth = np.sqrt(2 / (w * mu * sigma))
    skin = 1j * w * mu * depth / (1 + 1j)
    gap = np.sqrt(mu / (sigma * own))
    assert np.allclose(new / old, 1 - 0.3 * skin / (skin + gap))


def test_insulation_across_a_coil_has_one_loss_angle() -> None:
    old, new = at_port(find("coil_capacitance", "terminals", "C_n"), C_n=1e-8, n_C=0.1)
    Y = 1 / new - 1 / old
    assert np.allclose(np.angle(Y), 0.9 * np.pi / 2)
    assert np.allclose(np.abs(Y), 1e-8 * w**0.9)


def test_a_capacitor_is_no_coil() -> None:
    """Across a capacitance there is no other one to be found, and no eddy current."""
    ids = {e.id for e in CATALOGUE if e.fits(load("piezoelectric_transducer"))}
    assert {"dielectric_loss", "lead_resistance", "structural_damping", "second_mode"} <= ids
    assert not ids & {"eddy_shunt", "coil_capacitance", "semi_inductance", "coil_ac_resistance"}


# -- mechanical ----------------------------------------------------------------------------------------------


def test_second_mode_is_a_mass_on_a_spring() -> None:
    M, w2, Q = 0.004, 2e3, 8.0
    old, new = at_port(find("second_mode", "mechanical_impedance"), M_2=M, omega_2=w2, Q=Q)
    link = M * w2**2 / (1j * w) + M * w2 / Q
    assert np.allclose(new - old, 1 / (1 / (1j * w * M) + 1 / link))


def test_a_joint_splits_the_moving_side() -> None:
    """A mass m in front, the rest behind a spring: a resonance where both swing against each other."""
    m, s = 0.005, 1e-6
    old, new = at_port(find("contact_compliance", "mechanical_impedance"), m=m, s=s)
    peak = np.sqrt((1 / m + 1 / (COIL["M_m"] - m)) / s)
    assert w[np.argmin(np.abs(new / old))] == pytest.approx(peak, rel=0.05)
    assert new[0] == pytest.approx(old[0], rel=0.01)
    old, new = at_port(find("contact_compliance", "mechanical_impedance"), m=0.0, s=s)
    assert np.allclose(1 / new, 1 / old + 1j * w * s)


def test_a_joint_that_rubs_beside_the_spring() -> None:
    """Node by node: drive, mass m and spring K_m on one side of a lossy spring, the rest on the other."""
    m, s, eta = 0.005, 1e-6, 0.1
    old, new = at_port(
        find("contact_compliance", "mechanical_impedance", "s_k_eta"), m_k_eta=m, s_k_eta=s, eta_k=eta
    )
    near = 1j * w * m + COIL["K_m"] / (1j * w)
    link, rest = (1 + 1j * eta) / (1j * w * s), old - near
    nodes = np.array([[near + link, -link], [-link, link + rest]])
    speed = np.linalg.solve(np.moveaxis(nodes, 2, 0), np.array([[1.0], [0.0]]))[:, 0, 0]
    assert np.allclose(new, 1 / speed)


def test_a_viscous_fluid_is_a_ladder_of_thin_layers() -> None:
    """Layers of mass ρ dx S on each other, sheared by η S/dx, the wall at the first; √(jωρη) S in the end."""
    old, new = at_port(find("viscous_load", "mechanical_impedance"), R_v=0.01)
    mass, shear = 1e-3 * 0.01, 0.01 / 1e-3  # ρ dx S and η S/dx, with √(ρη) S = 0.01
    load = np.sqrt(1j * w) * 0.0
    for _ in range(4000):
        load = 1 / (1 / shear + 1 / (load + 1j * w * mass))
    low = w < 1e3  # where the layers are thin beside the wave
    assert np.allclose((new - old)[low], load[low], rtol=0.05)


def test_a_film_between_walls_is_a_ladder_of_few_thin_layers() -> None:
    R, tau, layers = 0.3, 2e-3, 2000
    old, new = at_port(find("viscous_load", "mechanical_impedance", "R_h"), R_h=R, tau=tau)
    shear, mass = R * layers, R * tau / layers  # η S/dx and ρ dx S
    load = np.full_like(old, 1e9)  # the far wall stands still
    for _ in range(layers):
        load = 1j * w * mass + 1 / (1 / shear + 1 / load)
    assert np.allclose((new - old)[w < 1e4], load[w < 1e4], rtol=0.02)


@pytest.mark.parametrize("q", [1e-12, 0.3, 2.0, -7.0, 9.0 + 1e-3j, 20 - 5j, 85 + 0.5j, 158 + 1j])
def test_xcotx(q: complex) -> None:
    x = np.sqrt(complex(q))
    exact = x / np.tan(x) if abs(q) > 1e-6 else 1 - q / 3
    assert abs(xcotx(q) - exact) < 1e-6 * max(1, abs(exact))
    if abs(q) < 90:
        assert abs(xcotx(q) - exact) < 1e-11 * max(1, abs(exact))


@pytest.mark.parametrize("held", [True, False])
def test_rods_are_chains_of_small_masses_and_springs(held: bool) -> None:
    """The rod as 400 lumps, solved as a ladder from the far end."""
    n, m, K = 400, 0.02, 2e3
    x = np.geomspace(20, 500, 30)
    s = 1j * x
    Z = np.full(len(x), 1e30 + 0j) if held else np.zeros(len(x), complex)
    for _ in range(n):
        Z = 1 / (1 / (Z + s * m / n / 2) + s / (K * n)) + s * m / n / 2
    q = x**2 * m / K
    law = K * xcotx(q) / s if held else s * m / xcotx(q)
    assert np.allclose(law, Z, rtol=2e-3)


def test_a_rod_that_loses_energy_has_a_mass_that_does_not() -> None:
    """K complex, m real: kl = ω √(m/K), and far below its resonances the rod is K − ω² m/3."""
    rod, model = find("distributed_rod", "stiffness", "tau2", needs="l"), "magnetostrictive_transducer"
    K, _ = at_port(rod, model, tau2=0.0)
    assert np.all(K.imag > 0.005 * K.real)
    for top in (0.02, 3.0):
        _, new = at_port(rod, model, tau2=(top / w.max()) ** 2)
        m = K.real * (top / w.max()) ** 2
        kl = w * np.sqrt(m / K)
        assert np.allclose(new, K * kl / np.tan(kl), rtol=1e-9)
    _, new = at_port(rod, model, tau2=(0.02 / w.max()) ** 2)
    assert np.all(np.abs((new - K).imag) < 1e-5 * np.abs((new - K).real))


def test_a_rod_of_which_a_third_is_counted_differs_by_its_waves_alone() -> None:
    """K (kl cot kl + (kl)²/3) = K − ω⁴ m²/(45 K) − …"""
    whole, counted = (find("distributed_rod", "stiffness", n, needs="l") for n in ("tau2", "tau2_third"))
    tau2 = (0.1 / w.max()) ** 2
    K, rest = at_port(counted, "magnetostrictive_transducer", tau2_third=tau2)
    m = K.real * tau2
    assert np.allclose(rest, K - w**4 * m**2 / (45 * K), rtol=1e-8)
    _, full = at_port(whole, "magnetostrictive_transducer", tau2=tau2)
    assert np.allclose(rest - full, w**2 * m / 3, rtol=1e-5)


def test_radiation_is_a_mass_below_and_a_resistance_above() -> None:
    e = find("radiation_load", "mechanical_impedance")
    old, new = at_port(e, R=3.0, tau=1e-7)
    assert np.allclose((new - old).imag, w * 3e-7, rtol=1e-3)
    old, new = at_port(e, R=3.0, tau=10.0)
    assert np.allclose(new - old, 3.0, rtol=1e-2)
    old, new = at_port(find("radiation_load", "mechanical_impedance", "R_w"), R_w=1e-6)
    assert np.allclose(new - old, 1e-6 * w**2)


@pytest.mark.parametrize("tau", [1e-7, 1e-5, 1e-4, 1e-3, 1e-2])
def test_a_piston_radiates_by_bessels_and_struves_functions(tau: float) -> None:
    old, new = at_port(find("radiation_load", "mechanical_impedance", "R_p"), R_p=3.0, tau_p=tau)
    ka = w * tau
    exact = 3.0 * (1 - j1(2 * ka) / ka + 1j * struve(1, 2 * ka) / ka)
    assert np.all(np.abs(new - old - exact) < 0.024 * np.abs(exact))
    assert np.all((new - old).real > 0)


def test_a_piston_whose_air_is_in_its_mass_radiates_without_that_mass() -> None:
    e = find("radiation_load", "mechanical_impedance", "R_m")
    old, new = at_port(e, R_m=3.0, tau_m=1e-7)  # ka² /2 of ρcS, and what is left of the mass is far less
    assert np.allclose((new - old).real, 3.0 * (w * 1e-7) ** 2 / 2, rtol=0.03)
    assert np.all(np.abs((new - old).imag) < 0.01 * 3.0 * w * 1e-7)
    ka, (old, new) = w * 1e-3, at_port(e, R_m=3.0, tau_m=1e-3)
    exact = 3.0 * (1 - j1(2 * ka) / ka + 1j * struve(1, 2 * ka) / ka)
    assert np.allclose(new - old, exact - 3.0j * 8 / (3 * np.pi) * ka, rtol=0.03)


@pytest.mark.parametrize(
    ("id", "strength", "size"), [("cubic_stiffness", "kappa", 3e7), ("quadratic_damping", "delta", 2.0)]
)
def test_amplitude_at_constant_force(id: str, strength: str, size: float) -> None:
    old, new = at_port(find(id, "mechanical_impedance"), **{strength: size})
    a = 1 / (w * np.abs(new))  # the amplitude that the impedance makes makes the impedance
    added = size * a**2 / (1j * w) if id == "cubic_stiffness" else size * a * w
    assert np.allclose(new, old + added, rtol=1e-8)
    assert np.abs(new - old).max() > 0.01 * np.abs(old).min()


@pytest.mark.parametrize(
    ("id", "strength", "size"), [("cubic_stiffness", "kappa_v", 3e7), ("quadratic_damping", "delta_v", 2.0)]
)
def test_amplitude_at_constant_voltage(id: str, strength: str, size: float) -> None:
    e = find(id, "mechanical_impedance", strength)
    old, new = at_port(e, **{strength: size, "R_v_v": 4.0, "tau_v_v": 1e-4})
    a = 1 / (w * np.abs(new + 4 / (1 + 1e-4j * w)))
    added = size * a**2 / (1j * w) if id == "cubic_stiffness" else size * a * w
    assert np.allclose(new, old + added, rtol=1e-8)
    assert np.abs(new - old).max() > 0.01 * np.abs(old).min()


def lossy(x: Array, kind: str) -> Array:
    """What takes power with its real part: impedance, admittance, stiffness turned by a right angle."""
    return x * (1j * w if kind in ("inductance", "capacitance") else 1 / 1j if kind == "stiffness" else 1)


COIL_KINDS = ("electrical_impedance", "inductance", "terminals", "mechanical_impedance", "stiffness")


@pytest.mark.parametrize(
    "name, kind",
    [
        *(("electrodynamic_transducer", k) for k in COIL_KINDS),
        ("piezoelectric_transducer", "capacitance"),
        ("piezoelectric_transducer", "terminals"),
    ],
)
def test_positive_strengths_take_power(name: str, kind: str) -> None:
    model = load(name)
    known = KNOWN.get(name, {})
    shapes = {
        "omega": 3e3,
        "time": 3e-4,
        "1/max(omega)": 1e-5,
        "1/(omega*port)": 1e-5,
        "median(port/omega)": 5e-3,
        "samples": 100.0,
        "port": 8.0,
        "min(port)": 8.0,
    }
    for e in CATALOGUE:
        if not e.fits(model) or e.fits(model)[0].kind != kind or e.strengths[0].bounds[0] < 0:
            continue
        p = {q.name: (q.low * q.high) ** 0.5 if q.scale == "1" else shapes[q.scale] for q in e.shapes}
        for size in (1e-6, 1e-3, 0.3):
            for port in e.fits(model):
                values = extended(e, model.id)(
                    {"f": f},
                    **known,
                    **{f"{e.id}_{k}": v for k, v in p.items()},
                    **{f"{e.id}_{e.strengths[0].name}": size},
                )
                assert (values["Z"].real > 0).all(), (e.id, size)
                loss, old = (lossy(values[n], kind) for n in (port.equation, f"{port.equation}_1"))
                if kind != "terminals" and e.id not in ("contact_compliance",):
                    assert (np.real(loss) >= np.real(old) - 1e-9 * np.abs(old)).all(), (e.id, size)


# -- memory in time ------------------------------------------------------------------------------------------


def ladder(expr_of: Any, x: Array) -> Array:
    """Frequency response of a ladder's force over displacement: arm i's foot is s_i/(jω + s_i)."""
    base = unit_omega(load("modified_dahl"))
    port = next(p for p in base.ports if p.kind == "force")
    arms = Ladder("L", base, port)
    expr = expr_of(arms)
    s_0 = arms.rate.default
    feet = {
        sp.Symbol(f"L_z{i}", real=True): s_0 * np.exp(STEP * i) / (1j * x + s_0 * np.exp(STEP * i))
        for i in range(ARMS)
    }
    rest = {"z_rest": 0.0, "unit_omega": 1.0, "L_s_0": s_0, "z_D": 1.0, "v_D": 1j * x}
    symbols = sorted(expr.free_symbols, key=str)
    return np.asarray(sp.lambdify(symbols, expr, "numpy")(*(feet.get(q, rest.get(q.name)) for q in symbols)))


@pytest.mark.parametrize("alpha", [0.03, 0.1, 0.25, 0.5, 0.75, 0.9, 0.97])
def test_springpot_ladder_is_within_its_bound(alpha: float) -> None:
    x = np.geomspace(1.2e-3, 3e-4 * np.exp(STEP * (ARMS - 1)) / 4, 400)
    assert x[-1] / x[0] > 10**7.2
    error = np.abs(ladder(lambda arms: arms.power_law(sp.Float(alpha)), x) / (1j * x) ** alpha - 1)
    assert error.max() < 0.003
    assert error[40:-40].max() < 2 * np.sin(np.pi * alpha) * np.exp(-(np.pi**2) / STEP) + 1e-4


def test_logarithmic_creep_ladder() -> None:
    x = np.geomspace(1.5e-3, 1.7e4, 400)
    assert np.abs(ladder(lambda arms: arms.logarithm(), x) - np.log(1j * x)).max() < 0.013


@pytest.mark.parametrize(("alpha", "error"), [(0.2, 6e-3), (0.3, 4e-3), (0.6, 0.01), (0.75, 0.06)])
def test_relaxing_springpot_ladder_has_cole_and_coles_response(alpha: float, error: float) -> None:
    x = np.geomspace(0.1, 1e3, 200)
    exact = 1 / (1 + (1j * x * 0.05) ** -alpha)
    found = ladder(lambda arms: arms.relaxation(sp.Float(alpha), sp.Float(0.05)), x)
    assert np.abs(found / exact - 1).max() < error


def test_springpot_in_time_creeps_by_its_power() -> None:
    """Ramp and hold: D^α z = V (t^(1−α) − (t − T)^(1−α))/Γ(2 − α), exact for z linear between samples."""
    t = np.concatenate([np.linspace(0, 1, 101), np.geomspace(1.01, 300, 200)])
    motion = record(t, lambda x: np.clip(x, 0, 1))
    motion["v"] = np.where(t < 1, 1.0, 0.0)
    alpha = 0.3
    exact = (t ** (1 - alpha) - np.clip(t - 1, 0, None) ** (1 - alpha)) / gamma(2 - alpha)
    F = force(find("power_law_viscoelasticity", "force"), motion, C=2.0, alpha=alpha)
    assert np.abs(F / 2 - exact)[5:].max() < 0.005 * exact.max()
    assert np.abs(F / 2 / np.maximum(exact, 1e-9) - 1)[150:].max() < 0.01


def test_maxwell_branch_in_time() -> None:
    t = np.linspace(0, 3, 1501)
    F = force(find("maxwell_branch", "force"), record(t, wobble), k=0.7, tau=0.2)
    d = 1e-6
    q = solve_ivp(
        lambda x, q: (wobble(x + d) - wobble(x - d)) / (2 * d) - q / 0.2,
        (0, 3),
        [0.0],
        t_eval=t,
        rtol=1e-9,
        atol=1e-11,
    ).y[0]
    assert np.abs(F - 0.7 * q).max() < 1e-4


def test_a_maxwell_branch_may_have_moved_before_the_record() -> None:
    t, tau, omega = np.linspace(0, 3, 3001), 0.4, 2 * np.pi
    motion = record(t, lambda x: np.sin(omega * x + 0.7))
    steady = 0.7 * np.imag(1j * omega * tau / (1 + 1j * omega * tau) * np.exp(1j * (omega * t + 0.7)))
    F = force(find("maxwell_branch", "force"), motion, k=0.7, tau=tau, past=1 / omega**2)
    assert np.abs(F - steady).max() < 1e-4


@pytest.mark.parametrize(
    ("id", "values"),
    [("maxwell_branch", {"k": 0.7, "tau": 0.2}), ("power_law_viscoelasticity", {"C": 0.7, "alpha": 0.4})],
)
def test_a_strained_sample_may_have_rested_where_the_record_begins(id: str, values: dict[str, float]) -> None:
    """The same motion from another place makes the same force, but for a spring's at rest."""
    t = np.linspace(0, 3, 1501)
    e = find(id, "force")
    zero, away = (record(t, lambda x, to=to: wobble(x) - wobble(0) + to) for to in (0.0, 1.5))
    from_zero, strained, not_held = (
        force(e, motion, **values, held=held) for motion, held in ((zero, 1.0), (away, 1.0), (away, 0.0))
    )
    offset = strained - from_zero
    assert np.ptp(offset) < 1e-6 < 0.1 < np.ptp(not_held - from_zero)


@pytest.mark.parametrize("alpha", [0.15, 0.5, 0.8])
def test_a_springpot_may_have_moved_before_the_record(alpha: float) -> None:
    """In mid-motion its force is C (jω)^α z from the first sample on; from rest it is not."""
    t, omega = np.linspace(0, 3, 3001), 2 * np.pi
    motion = record(t, lambda x: np.sin(omega * x + 0.7))
    steady = 2.0 * np.imag((1j * omega) ** alpha * np.exp(1j * (omega * t + 0.7)))
    e = find("power_law_viscoelasticity", "force")
    moved, rested = (force(e, motion, C=2.0, alpha=alpha, past=x) for x in (1 / omega**2, 0.0))
    error = np.abs(moved - steady).max()
    assert error < 0.01 * np.abs(steady).max() and error < 0.1 * np.abs(rested - steady).max()


def test_friction_that_relaxes() -> None:
    t, d = np.linspace(0, 4, 2001), 1e-6

    def slope(x: float, r: Array) -> Array:
        v = (wobble(np.array(x + d)) - wobble(np.array(x - d))) / (2 * d)
        return 1.5 * (v - np.abs(v) * r) - 3.0 * r

    F = force(find("maxwell_branch", "friction"), record(t, wobble), {"h_D": 0.4}, lambda_r=3.0)
    r = solve_ivp(slope, (0, 4), [0.0], t_eval=t, rtol=1e-8, atol=1e-10, max_step=0.01).y[0]
    assert np.abs(F - 0.4 * r).max() < 1e-4


def test_hysteretic_losses_do_not_depend_on_rate() -> None:
    for kind, name in (("force", "H"), ("spring", "eta")):
        e, loss = find("structural_damping", kind), []
        for hz in (0.2, 5.0):
            t = np.arange(0, 6 / hz, 1 / hz / 400)
            motion = record(t, lambda x, hz=hz: np.sin(2 * np.pi * hz * x))
            F = force(e, motion, {"k_D": 1.0}, **{name: 0.1})
            last = slice(-401, None)
            loss.append(np.trapezoid(F[last], motion["z"][last]))
        assert loss[0] == pytest.approx(loss[1], rel=0.02) and loss[0] > 0
    assert loss[0] == pytest.approx(2 * 0.1, rel=0.01)  # Reid: area 2 η k A²


def test_swinging_mass_is_the_second_mode() -> None:
    e, hz = find("second_mode", "force"), 2.0
    t = np.arange(0, 12, 1 / hz / 200)
    motion = record(t, lambda x: np.sin(2 * np.pi * hz * x))
    for w2, Q in ((20.0, 6.0), (9.0, 1.0)):
        F = force(e, motion, M_2=0.003, omega_2=w2, Q=Q)
        u = 2 * np.pi * hz / w2
        K = -0.003 * (2 * np.pi * hz) ** 2 * (1 + 1j * u / Q) / (1 + 1j * u / Q - u**2)
        last = t > 10
        assert np.abs(F - (K * np.exp(2j * np.pi * hz * t)).imag)[last].max() < 1e-3 * abs(K)


# -- paths ---------------------------------------------------------------------------------------------------


GAPS = (0.06, 0.08, 0.1, 0.12, 0.14)


def test_play_of_a_linkage() -> None:
    t, g = np.linspace(0, 4, 2001), 0.15
    motion = record(t, wobble)
    F = force(find("backlash", "displacement", "g"), motion, {"k_D": 1.0}, g=g)
    fine = np.linspace(0, 4, 200001)
    p, lag = [], -g * np.sign(motion["v"][0])
    for a, b in zip(
        wobble(fine[:1]).tolist() + wobble(fine[:-1]).tolist(), wobble(fine).tolist(), strict=True
    ):
        lag = min(max(lag - (b - a), -g), g)
        p.append(b + lag)
    assert np.abs(F - np.array(p)[::100]).max() < 1e-5
    one = {k: np.array(force(find("backlash", "displacement", "g"), motion, {"k_D": 1.0}, g=k)) for k in GAPS}
    F = force(find("backlash", "displacement", "g_m"), motion, {"k_D": 1.0}, g_m=0.1, w=0.5)
    assert np.allclose(F, np.mean(list(one.values()), axis=0), atol=1e-12)
    gap = force(find("backlash", "displacement", "g_0"), motion, {"k_D": 1.0}, g_0=g)
    assert np.allclose(gap, np.sign(motion["z"]) * np.maximum(np.abs(motion["z"]) - g, 0), atol=1e-12)
    free = force(find("backlash", "displacement", "g_f"), motion, {"k_D": 1.0, "c_D": 0.1}, g_f=g)
    assert np.allclose(free, gap + 0.1 * motion["v"] * (np.abs(motion["z"]) >= g), atol=1e-12)


def test_friction_behind_a_clearance() -> None:
    """Across the gap no force; slip at h_g; the loop has a slider's area, and knows no rate."""
    t = np.linspace(0, 4, 4001)
    h, w, share = 2.0, 0.3, 0.4
    given = {"h_g": h, "w_f": w, "share": share, "away": 1.0}
    law = find("backlash", "force", "h_g")
    slow = record(t, lambda x: np.sin(2 * np.pi * x))
    fast = record(0.1 * t, lambda x: np.sin(20 * np.pi * x))
    F = force(law, slow, **given)
    assert np.abs(F).max() == pytest.approx(h, rel=1e-9)
    assert np.allclose(F, force(law, fast, **given), atol=1e-4)
    z, down = slow["z"], (t > 1.26) & (t < 1.74)  # from the top: unloading, gap, loading, slip
    gap = down & (z < 1 - w * (1 - share)) & (z > 1 - w * (1 + share))
    assert np.allclose(F[gap], 0, atol=1e-9) and gap.sum() > 20
    unloading = down & (z > 1 - w * (1 - share) + 1e-9)
    assert np.allclose(np.diff(F[unloading]), h / (w * (1 - share)) * np.diff(z[unloading]), atol=1e-4)
    cycle = (t >= 2) & (t < 3)
    assert np.trapezoid(F[cycle], z[cycle]) == pytest.approx(4 * h * (1 - w), rel=1e-2)


def test_a_sample_held_with_play() -> None:
    """Spring and dashpot between two sides of a gap: pushed by one or the other, or springing back alone."""
    t, K, c, g = np.linspace(0, 3, 30001), 2.0, 0.1, 0.05
    motion = record(t, lambda x: np.sin(2 * np.pi * x) + 0.3 * np.sin(7 * x))
    base = {"k_D": K, "c_D": c}
    law = find("backlash", "force", "d")
    dt, z, v = t[1] - t[0], motion["z"], motion["v"]
    x, F = np.empty_like(z), np.empty_like(z)
    last = z[0] - g if z[0] > 0 else z[0] + g
    for i in range(len(z)):
        free = last * np.exp(-dt * K / c)
        x[i] = last = min(max(free, z[i] - g), z[i] + g)
        F[i] = 0.0 if x[i] == free else K * x[i] + c * v[i]
    found = force(law, motion, base, d=K * g, T=c / K)
    let_go = (F == 0) & (t > 0.1)
    assert 0.02 < np.mean(let_go) < 0.2
    off = np.abs(found - F)[t > 0.1]
    assert np.median(off) < 1e-12 and np.mean(off > 2e-3) < 1e-3  # contact is made a sample sooner or later
    assert np.allclose(force(law, motion, base, d=0.0, T=0.05), K * z + c * v, atol=1e-12)
    shown = force(law, motion, base | {"F_0": 5.0}, d=K * g, T=c / K)  # the sensor's, with the sample let go
    assert np.allclose(shown, found + 5.0, atol=1e-12)
    slow = force(law, motion, {"k_D": K}, d=K * g, T=1e-9)  # no dashpot: a dead zone of the force
    assert np.allclose(slow, np.sign(z) * np.maximum(K * np.abs(z) - K * g, 0), atol=1e-9)


def test_drag_in_a_smooth_channel() -> None:
    motion = record(np.linspace(0, 2, 400), wobble)
    F = force(find("quadratic_damping", "force", "c_b"), motion, c_b=0.3)
    assert np.allclose(F, 0.3 * np.sign(motion["v"]) * np.abs(motion["v"]) ** 1.75)


def test_damping_along_the_stroke() -> None:
    motion = record(np.linspace(0, 2, 400), wobble)
    F = force(find("position_dependent_damping", "force", "c_z"), motion, c_z=0.3)
    assert np.allclose(F, 0.3 * motion["z"] * motion["v"])
    F = force(find("position_dependent_damping", "force", "c_z1"), motion, c_z1=0.3, c_z2=0.2)
    assert np.allclose(F, (0.3 * motion["z"] + 0.2 * motion["z"] ** 2) * motion["v"])
    F = force(find("position_dependent_damping", "force", "d_lower"), motion, d_lower=0.3, z_lower=-0.2)
    assert np.allclose(F, 0.3 * np.maximum(-0.2 - motion["z"], 0) * motion["v"])


def test_friction_along_the_stroke() -> None:
    motion, base = record(np.linspace(0, 2, 400), wobble), {"h_D": 0.4, "r_0": -1.0}
    F = force(find("position_dependent_friction", "friction"), motion, base, kappa=0.3)
    same = force(find("inertia", "force"), motion, base, M=0.0)
    assert np.allclose(F, same * (1 + 0.3 * motion["z"]))


def bristles(motion: dict[str, Array], z: Any, level: Any) -> Array:
    """Force of bristles that slip at `level`(t): F' = h ρ (v − |v| F/level), h = 0.4, ρ = 12, F(0) = −0.4."""
    t, d = motion["t"], 1e-5

    def rate(x: float, F: Array) -> Array:
        v = (z(x + d) - z(x - d)) / (2 * d)
        return np.asarray(0.4 * 12.0 * (v - np.abs(v) * F / level(x)))

    return np.asarray(solve_ivp(rate, (t[0], t[-1]), [-0.4], t_eval=t, max_step=0.005, rtol=1e-8).y[0])


def test_friction_of_a_wedge_keeps_its_stiffness() -> None:
    t, base = np.linspace(0, 2, 8001), {"h_D": 0.4, "rho": 12.0, "r_0": -1.0}
    law = find("position_dependent_friction", "friction", "kappa_1")
    F = force(law, record(t, wobble), base, kappa_1=0.3, kappa_2=0.5)

    def level(x: float) -> Any:
        return 0.4 * (1 + 0.3 * wobble(x) + 0.5 * wobble(x) ** 2)

    F_0 = level(0.0) / 0.4  # the state that a record begins with is a share of the level there
    wanted = bristles(record(t, wobble), wobble, level)
    late = t > 0.5
    assert F[0] == pytest.approx(-0.4 * F_0)
    assert np.abs(F - wanted)[late].max() < 2e-3


@pytest.mark.parametrize("stays", [False, True])
def test_surfaces_run_in_with_the_way_that_they_slide(stays: bool) -> None:
    t, base = np.linspace(0, 8, 8001), {"h_D": 0.4, "rho": 12.0, "r_0": -1.0}
    way = np.r_[0.0, np.cumsum(np.abs(np.diff(np.sin(3 * t))))]
    level = 0.4 * (1 + 0.8 * np.exp(-way / 5.0))
    motion = record(t, lambda x: np.sin(3 * x))
    given = {"rise": 0.8, "s_r": 5.0} if stays else {"rise_h": 0.8, "s_h": 5.0}
    F = force(find("running_in", "friction", next(iter(given))), motion, base, **given)
    slips = (np.abs(np.sin(3 * t)) > 0.97) & (motion["z"] * motion["v"] > 0)  # at the end of each stroke
    assert np.abs(np.abs(F[slips]) / level[slips] - 1).max() < 0.02
    if stays:
        wanted = bristles(motion, lambda x: np.sin(3 * x), lambda x: np.interp(x, t, level))
        assert np.abs(F - wanted)[t > 1].max() < 5e-3


def test_a_sample_warms_up_by_its_own_friction() -> None:
    """At a steady mean speed v the way whose heat is still there grows as v τ (1 − e^(−t/τ))."""
    t = np.linspace(0, 10, 4001)
    motion = record(t, lambda x: np.sin(40 * x))
    F = force(find("temperature_drift", "spring", "beta_h"), motion, {"k_D": 2.0}, beta_h=-0.005, tau_h=2.0)
    at = np.abs(motion["z"]) > 0.9
    warmth = 80 / np.pi * 2.0 * (1 - np.exp(-t / 2.0))
    assert np.allclose((F[at] / (2 * motion["z"][at]) - 1) / -0.005, warmth[at], atol=2.0)


def test_a_dashpot_warms_up_by_its_power() -> None:
    """At a steady mean square speed the heat that is still there grows as <v²> τ (1 − e^(−t/τ))."""
    t = np.linspace(0, 10, 4001)
    motion, base = record(t, lambda x: np.sin(40 * x)), {"k_D": 2.0, "c_D": 0.05}
    law = find("temperature_drift", "force", "beta_v")
    cold = force(law, motion, base, beta_v=0.0, d_v=0.0, tau_v=2.0)
    F = force(law, motion, base, beta_v=-1e-4, d_v=0.0, tau_v=2.0)
    at = np.abs(cold) > 1.5
    warmth = 800 * 2.0 * (1 - np.exp(-t / 2.0))
    assert np.allclose((F[at] / cold[at] - 1) / -1e-4, warmth[at], atol=25.0)


def test_what_is_constant_in_a_force_stays_as_a_sample_warms_up() -> None:
    """Spring, friction and dashpot by (1 + β s), s from 0 to τ; a load of 1.5 N by nothing."""
    t = np.linspace(0, 10, 2001)
    motion, base = record(t, lambda x: np.sin(5 * x)), {"k_D": 2.0, "c_D": 0.05, "h_D": 0.3}
    cold = force(find("inertia", "force"), motion, base, M=0.0)
    law = find("temperature_drift", "force", "beta_s")
    F = force(law, motion, base | {"F_0": 1.5}, beta_s=-0.02, d_s=0.03, tau_s=2.0)
    assert np.allclose(F - 1.5, cold * (1 - 0.04 * (1 - np.exp(-t / 2.0))), rtol=1e-9)


def test_friction_and_spring_warm_up_alike() -> None:
    motion, base = record(np.linspace(0, 5, 2001), lambda x: np.sin(20 * x)), {"k_D": 2.0, "h_D": 0.3}
    beside = find("temperature_drift", "spring", "beta_h")
    warm = force(beside, motion, {"k_D": 2.0}, beta_h=-0.005, tau_h=2.0)
    factor = warm[1:] / (2 * motion["z"][1:])
    F = force(find("temperature_drift", "spring", "beta_m"), motion, base, beta_m=-0.005, tau_m=2.0)
    cold = force(find("inertia", "force"), motion, base, M=0.0)
    assert np.allclose(F[1:], factor * cold[1:], atol=1e-3)  # warmth of this sample, or of the one before


def test_friction_by_direction() -> None:
    motion, base = record(np.linspace(0, 2, 400), wobble), {"h_D": 0.4, "r_0": -1.0}
    F = force(find("asymmetric_friction", "friction"), motion, base, delta=-0.3)
    same = force(find("inertia", "force"), motion, base, M=0.0)
    assert np.allclose(F, np.where(same > 0, 0.7, 1.3) * same)


@pytest.mark.slow
def test_friction_that_grows_with_speed() -> None:
    """By a times ln(1 + v/v_a) in slip; its slope after a reversal grows as well or stays."""
    t, base = np.linspace(0, 4, 40001), {"h_D": 0.4, "rho": 40.0, "r_0": -1.0}
    shape: dict[str, dict[str, float]] = {"a_h": {"v_h": 0.5}, "a": {"v_a": 0.5}}
    for speed in (0.2, 2.0):
        turns = record(t, lambda x, v=speed: 4 * v * np.abs(x / 4 - np.floor(x / 4 + 0.5)))  # type: ignore[misc]
        level = 1 + 0.3 * np.log(1 + speed / 0.5)
        after = (t > 2.0005) & (t < 2.0005 + 0.002 / speed)
        for name, given in shape.items():
            F = force(find("rate_dependent_friction", "friction", name), turns, base, **{name: 0.3}, **given)
            assert F[t < 1.9].max() == pytest.approx(0.4 * level, rel=1e-3)
            slope = np.polyfit(turns["z"][after], F[after], 1)[0]
            there = 0.4 * (level if name == "a_h" else 1.0) * 40.0 * 2
            assert slope == pytest.approx(there, rel=0.12)


@pytest.mark.parametrize(("n", "q", "rho"), [(2.0, 0.0, 5.0), (1.0, 0.0, 5.0), (1.5, 0.3, 15.0)])
def test_friction_by_bouc_and_wen_is_their_differential_equation(n: float, q: float, rho: float) -> None:
    def moves(t: float, y: Array) -> Array:
        v = (wobble(np.array(t + 1e-6)) - wobble(np.array(t - 1e-6))) / 2e-6
        share = (1 + q) / 2 * np.sign(v * y) + (1 - q) / 2
        return np.asarray(rho * v * (1 - np.abs(y) ** n * share))

    t = np.linspace(0, 2, 161)
    r = solve_ivp(moves, (0, 2), [0.2], "LSODA", t, rtol=1e-8, atol=1e-10, max_step=1e-3).y[0]
    base = {"k_D": 0.3, "h_D": 0.4, "rho": rho, "r_0": 0.2}
    F = force(find("dahl_exponent", "friction"), record(t, wobble), base, n=n, q=q)
    assert np.allclose(F, 0.3 * wobble(t) + 0.4 * r, atol=5e-4)


@pytest.mark.parametrize(
    ("law", "joint", "rho"),
    [
        ("c", {"c": 0.4}, 2.0),
        ("c", {"c": 0.3}, 12.0),
        ("c_f", {"c_f": 0.3}, 12.0),
        ("c_k", {"c_k": 0.3, "tau": 0.05}, 12.0),
    ],
)
def test_a_joint_gives_way_to_the_force_behind_it(law: str, joint: dict[str, float], rho: float) -> None:
    """Against the same balance, d + τ d' = c F, solved as a differential equation in the sample's position
    and friction: from the first sample on, with an offset of the force, which is the sensor's or a load, and
    where friction slips within few samples."""
    c, tau, load = joint[law], joint.get("tau", 0.0), 0.7 if law == "c_f" else 0.0
    base = {"k_D": 0.5, "c_D": 0.05, "h_D": 0.4, "rho": rho, "F_0": 0.7}

    def begun(t: Array) -> Array:
        return np.where(t < 1, t**3 * (10 - 15 * t + 6 * t**2), 1.0) * np.sin(2 * np.pi * t)

    def force_of(x: Array, rate: Array, r: Array) -> Array:
        return 0.5 * x + 0.05 * rate + 0.4 * r + 0.7

    def moves(t: float, y: Array) -> Array:
        x, r = y
        v = (begun(np.array(t + 1e-6)) - begun(np.array(t - 1e-6))) / 2e-6
        balance = c * (force_of(x, 0.0, r) - 0.7 + load)
        rate = (begun(np.array(t)) - x + tau * v - balance) / (tau + c * 0.05)
        return np.array([rate, rho * (rate - r * abs(rate))])

    t = np.linspace(0, 3, 241)
    at_rest = -c * load / (1 + c * 0.5)
    x, r = solve_ivp(moves, (0, 3), [at_rest, 0.0], "LSODA", t, rtol=1e-9, atol=1e-11, max_step=2e-3).y
    exact = force_of(x, np.array([moves(*at)[0] for at in zip(t, np.stack([x, r]).T, strict=True)]), r)
    F = force(find("contact_compliance", "displacement", law), record(t, begun), base, **joint)
    assert np.abs(F - exact).max() < 0.01 * np.std(exact)
    assert np.sqrt(np.mean((F - exact) ** 2)) < 2e-3 * np.std(exact)


def test_a_dashpot_behind_a_joint_is_a_maxwell_element() -> None:
    """F = Re[jωη e^{jωt}/(1 + jωτ)] with τ = c η, in cycles of 42 samples, τ being 2.4 of them: as little of
    it is missed as tells a joint from a low-pass filter in front of the sensor."""
    omega, dt, eta, c = 1500.0, 1e-4, 0.08, 0.003

    def cycles(t: Array) -> Array:
        return np.sin(omega * t)

    t = np.arange(0, 0.05, dt)
    exact = np.imag(1j * omega * eta * np.exp(1j * omega * t) / (1 + 1j * omega * c * eta))
    F = force(find("contact_compliance", "displacement", "c"), record(t, cycles), {"c_D": eta}, c=c)
    assert np.abs(F - exact)[200:].max() < 1.5e-3 * exact.max()


@pytest.mark.parametrize("law", ["c", "c_f", "c_k"])
def test_a_memory_begins_behind_a_joint(law: str) -> None:
    """A sample that rests under a force, behind a joint that gives: none of a springpot's arms is stretched,
    and nothing moves."""
    t = np.linspace(0, 1, 101)
    still = record(t, np.zeros_like)
    memory, joint = (
        find("power_law_viscoelasticity", "force"),
        find("contact_compliance", "displacement", law),
    )
    model = replace(load("modified_dahl"), checked=True)
    for e in (memory, joint):
        model = e.extend(model, e.fits(model)[0])
    given = {"power_law_viscoelasticity_C": 0.3, "power_law_viscoelasticity_alpha": 0.4}
    given |= {"power_law_viscoelasticity_held": 1.0, f"contact_compliance_{law}": 0.2}
    given |= {"contact_compliance_tau": 0.02} if law == "c_k" else {}
    F = Reading(model)(still, **(NOTHING | {"k_D": 0.5, "F_0": 0.7}), **given)["F"]
    assert np.allclose(F, F[-1], rtol=5e-3)


def test_payne_softening_follows_the_amplitude() -> None:
    t = np.arange(0, 6, 0.005)
    motion = record(t, lambda x: np.where(x < 3, 1.0, 0.3) * np.sin(2 * np.pi * x))
    F = force(find("payne_softening", "spring"), motion, k_0=1.0, A_c=0.5, n_0=1.2)
    A = np.where(t < 3, 1.0, 0.3)
    steady = ((t > 1) & (t < 2.4)) | ((t > 4) & (t < 5))
    assert np.allclose(F[steady], (motion["z"] / (1 + (A / 0.5) ** 1.2))[steady], atol=5e-3)
    F = force(find("payne_softening", "spring", "k_n"), motion, k_n=1.0, A_n=0.5, n=2.0, tau=0.3)
    followed = np.where(t < 3, 1.0, 0.3 + 0.7 * np.exp(-np.clip(t - 3, 0, None) / 0.3))
    assert np.allclose(F[120:1100], (motion["z"] / (1 + (followed / 0.5) ** 2))[120:1100], atol=0.03)


def test_a_sensor_without_a_sign() -> None:
    motion = record(np.linspace(0, 2, 400), wobble)
    law = find("rectified_sensor", "sensor")
    plain, half, whole = (force(law, motion, {"k_D": 2.0}, share=x) for x in (0.0, 0.5, 1.0))
    assert np.allclose(plain, 2 * motion["z"]) and np.allclose(whole, np.abs(plain))
    assert np.allclose(half, (plain + whole) / 2)


def test_a_load_cell_that_creeps() -> None:
    t = np.arange(0, 6, 0.002)
    motion = record(t, lambda x: np.clip(x - 1, 0, 0.2))  # a ramp, held from 1.2 s on
    F = force(find("sensor_creep", "sensor"), motion, {"k_D": 2.0}, c=0.1, tau=0.8)
    assert np.allclose(F[t < 1], 0, atol=1e-9)
    held = t > 1.21
    ramped = 1 - 0.8 / 0.2 * (np.exp(0.2 / 0.8) - 1) * np.exp(-(t[held] - 1) / 0.8)
    assert np.allclose(F[held], 0.4 * (1 + 0.1 * ramped), rtol=1e-3)


def test_a_network_of_filler_breaks_faster_than_it_mends() -> None:
    t = np.arange(0, 12, 0.005)
    size = np.where((t > 4) & (t < 8), 1.0, 0.2)
    motion = record(t, lambda x: size * np.sin(2 * np.pi * x))
    law = find("payne_softening", "spring", "k_b")
    F = force(law, motion, k_b=1.0, A_b=0.5, n_b=2.0, tau_b=1.5)
    whole = [1 / (1 + (a / 0.5) ** 2) for a in (0.2, 1.0)]
    after = np.clip(t - 8, 0, None) * (1 + 0.2**2 / 0.5**2) / 1.5
    mended = whole[0] + (whole[1] - whole[0]) * np.exp(-after)
    N = np.where(t < 4, whole[0], np.where(t < 8, whole[1], mended))
    seen = (t < 3.7) | ((t > 5.5) & (t < 7.7)) | (t > 8.3)
    assert np.allclose(F[seen], (N * motion["z"])[seen], atol=0.02)


def test_stress_softening_by_path_and_by_peak() -> None:
    t = np.arange(0, 4, 0.005)
    motion = record(t, lambda x: np.sin(2 * np.pi * x))
    F = force(find("stress_softening", "spring", "k_0"), motion, k_0=1.0, s_c=3.0)
    assert F[650] / motion["z"][650] == pytest.approx(np.exp(-13 / 3), rel=1e-3)  # 3.25 cycles of length 4
    F = force(find("stress_softening", "spring", "k_p"), motion, k_p=1.0, z_c=0.5)
    assert F[650] / motion["z"][650] == pytest.approx(np.exp(-2), rel=1e-6)


def test_a_material_softened_below_its_peak_is_itself_again_at_the_peak() -> None:
    t = np.arange(0, 3, 0.005)
    motion = record(t, lambda x: np.where(x < 1, 1.0, 0.5) * np.sin(2 * np.pi * x))
    law = find("stress_softening", "spring", "q")
    F, z = force(law, motion, {"k_D": 1.0}, q=0.4, w=0.3), motion["z"]
    assert np.allclose(F[:50], z[:50])  # as it is loaded for the first time
    assert F[250] / z[250] == pytest.approx(1 - 0.4 * np.tanh((1 - 0.25) / 0.09), rel=1e-6)
    assert np.allclose(force(law, motion, {"k_D": 1.0}, q=0.0, w=0.3), z)


def test_payne_softening_by_the_greatest_deflection_of_late() -> None:
    t = np.linspace(0, 60, 6001)
    motion = record(t, lambda x: np.where(x < 30, 2.0, 0.5) * np.sin(5 * x))
    law = find("payne_softening", "spring", "k_l")
    F = force(law, motion, k_l=3.0, A_l=1.0, n_l=1.6, tau_l=200.0)
    late = (np.abs(np.sin(5 * t)) > 0.9) & ((t > 2) & (t < 29))
    assert np.allclose(F[late] / motion["z"][late], 3 / (1 + 2.0**1.6), rtol=5e-3)
    F = force(law, motion, k_l=3.0, A_l=1.0, n_l=1.6, tau_l=2.0)  # it mends: 2 e^(−20/2) is far below 0.5
    late = (np.abs(np.sin(5 * t)) > 0.9) & (t > 50)
    assert np.allclose(F[late] / motion["z"][late], 3 / (1 + 0.5**1.6), rtol=0.1)


def test_stress_softening_that_gets_ever_slower() -> None:
    t = np.linspace(0, 10, 2001)
    motion = record(t, lambda x: np.sin(5 * x))
    way = np.cumsum(np.abs(motion["z_turn"] - motion["z_prev"]) + np.abs(motion["z"] - motion["z_turn"]))
    F = force(find("stress_softening", "spring", "k_m"), motion, k_m=3.0, s_m=4.0, m=0.6)
    assert np.allclose(F, 3 * motion["z"] * np.exp(-((way / 4) ** 0.6)), atol=1e-6)


def test_payne_softening_in_a_cycle_has_its_loss_where_the_network_breaks() -> None:
    """Kraus 1984: half of the stiffness is gone at A_n, where the loss is greatest, whatever the exponent."""
    law = find("payne_softening", "stiffness", "k_n")
    model, values = load("complex_stiffness"), {"c_D": 0.0, "h_D": 0.0, "rho": 1.0, "k_D": 1.0}
    extended = Reading(law.extend(model, law.fits(model)[0]))
    own = {"k_n": 1.0, "H_n": 0.1, "A_n": 0.4, "n": 1.2}

    def stiffness(A: float) -> complex:
        numbers = values | {"A_z": A} | {f"payne_softening_{k}": x for k, x in own.items()}
        return complex(extended({"f": np.array([1.0])}, **numbers)["K"][0]) - 1.0

    assert stiffness(0.4) == pytest.approx(0.5 + 0.1j)
    assert stiffness(0.4 * 2**5) == pytest.approx((1 + 0.2j * 8) / 65)
    assert stiffness(0.39).imag < 0.1 and stiffness(0.41).imag < 0.1


def test_springs_that_harden_by_more_than_a_square() -> None:
    motion = record(np.linspace(0, 3, 301), wobble)
    z = motion["z"]
    F = force(find("cubic_stiffness", "force", "k_30"), motion, k_30=-0.2, k_5=0.5)
    assert np.allclose(F, -0.2 * z**3 + 0.5 * z**5)
    for end, side in (("out", 1), ("in", -1)):  # stiffness k (e^x − 1) towards one side, from 0 at rest
        F = force(
            find("asymmetric_stiffness", "force", f"k_{end}"), motion, **{f"k_{end}": 0.3, f"z_{end}": 0.4}
        )
        x = np.linspace(0, 1, 2001)
        exact = [np.trapezoid(0.3 * np.expm1(side * x * end_z / 0.4), x * end_z) for end_z in z]
        assert np.allclose(F, exact, rtol=1e-4, atol=1e-6)


def test_a_quintic_spring_in_a_cycle_is_a_cubic_one_without_its_quintic_term() -> None:
    model, values = load("complex_stiffness"), {"k_D": 1.0, "c_D": 0.01, "h_D": 0.2, "rho": 3.0, "A_z": 0.5}
    got = []
    for name, own in (
        ("k_3", {"k_3": 0.7}),
        ("k_30", {"k_30": 0.7, "k_5": 0.0}),
        ("k_30", {"k_30": 0, "k_5": 1}),
    ):
        law = find("cubic_stiffness", "cycle", name)
        extended = Reading(law.extend(model, law.fits(model)[0]))
        numbers = values | {f"cubic_stiffness_{k}": x for k, x in own.items()}
        found = extended({"f": np.array([1.0])}, **numbers)
        got.append((found["k_s"][0], found["loss_angle"][0]))
    assert got[1] == pytest.approx(got[0], rel=1e-9)
    plain = Reading(model)({"f": np.array([1.0])}, **values)["k_s"][0]
    assert got[2][0] - plain == pytest.approx(
        0.5**4, rel=0.01
    )  # the peak is nearly at the greatest deflection


def test_second_dahl_element_is_another_dahl_model() -> None:
    motion = record(np.linspace(0, 3, 301), wobble)
    F = force(find("second_dahl_element", "force"), motion, h_2=0.4, z_2=1 / 3.0)
    dahl = Reading(load("modified_dahl"))(motion, **(NOTHING | {"h_D": 0.4, "rho": 3.0}))
    assert np.allclose(F, dahl["F"])


def test_many_sliders_slip_bit_by_bit() -> None:
    """As an array of forty of the same spread: in a large swing, and in small ones within it."""
    t = np.linspace(0, 3, 6001)
    motion = record(t, lambda x: (1.0 - 0.7 * (x > 1)) * np.sin(2 * np.pi * x))
    h, z_i, q = 0.4, 0.6, 0.7
    F = force(find("second_dahl_element", "force", "h_i"), motion, h_i=h, z_i=z_i, q=q)
    slip = z_i * 10 ** np.linspace(-1.425, 0.075, 40)  # each of ten stands for its part of a decade
    share = slip**q / np.sum(slip**q)
    r, whole = np.zeros(40), np.empty_like(t)
    for i, dz in enumerate(np.diff(motion["z"], prepend=motion["z"][0])):
        r = np.clip(r + dz / slip, -1, 1)
        whole[i] = h * share @ r
    assert np.abs(F).max() == pytest.approx(h, rel=1e-3)
    assert np.abs(F - whole)[t > 0.3].max() < 0.06 * h
    # from the other end, as far as half of the longest way: the shorter ones have slipped
    came = force(find("second_dahl_element", "force", "h_i"), motion, h_i=h, z_i=z_i, q=q, past=-0.5)
    slip = z_i * 10 ** np.linspace(-1.35, 0, 10)
    assert came[0] == pytest.approx(h * np.clip(-0.5 * z_i / slip, -1, 1) @ slip**q / np.sum(slip**q))


def test_a_second_slider_slips_all_at_once() -> None:
    """A spring that goes as far as ±z_j and is dragged beyond, step by small step."""
    motion = record(np.linspace(0, 2, 4001), wobble)
    h, w, r, states = 0.7, 0.4, 0.0, []
    for dz in np.diff(motion["z"], prepend=motion["z"][0]):
        r = min(1.0, max(-1.0, r + dz / w))
        states.append(r)
    F = force(find("second_dahl_element", "force", "h_j"), motion, h_j=h, z_j=w)
    assert np.allclose(F, h * np.array(states), atol=2e-3 * h) and np.ptp(states) == 2


def test_a_contact_of_its_own_sticks_and_gets_lubricated() -> None:
    """LuGre's law dx/dt = v − σ |v| x/g(v), F = σ x, integrated to 1e-10."""
    t = np.linspace(0, 2, 4001)
    motion = record(t, wobble)
    F_l, v_l, z_l, s_l = 0.4, 2.5, 0.05, 0.3
    fine = CubicSpline(t, motion["z"]).derivative()

    def rate(at: float, x: np.ndarray) -> np.ndarray:
        v = fine(at)
        g = F_l * (s_l + (1 - s_l) * np.exp(-abs(v) / v_l))
        return v - F_l / z_l * abs(v) * x / g

    x = solve_ivp(rate, (0, 2), [0.0], t_eval=t, rtol=1e-10, atol=1e-12, max_step=1e-3).y[0]
    F = force(find("stribeck_friction", "force", "F_l"), motion, F_l=F_l, v_l=v_l, z_l=z_l, s_l=s_l)
    assert np.allclose(F, F_l / z_l * x, atol=5e-3 * F_l) and np.abs(F).max() > 0.5 * F_l
    came = force(
        find("stribeck_friction", "force", "F_l"), motion, F_l=F_l, v_l=v_l, z_l=z_l, s_l=s_l, past=-0.5
    )
    assert came[0] == pytest.approx(-0.5 * F_l, abs=1e-3) and np.allclose(came[2000:], F[2000:], atol=1e-6)


def test_friction_falls_with_speed_and_stops_push_one_way() -> None:
    motion = record(np.linspace(0, 3, 301), wobble)
    z, v = motion["z"], motion["v"]
    base = {"h_D": 0.4}
    F = force(find("stribeck_friction", "friction", "beta_h"), motion, base, beta_h=0.5, v_h=2.0)
    plain = force(find("stribeck_friction", "friction", "beta_h"), motion, base, beta_h=0.0, v_h=2.0)
    assert np.allclose(F, plain * (1 + 0.5 * np.exp(-np.abs(v) / 2)))
    slide = record(np.linspace(0, 2, 401), lambda x: 5 * x)
    F = force(find("stribeck_friction", "friction", "beta_2"), slide, base, beta_2=0.5, v_2=4.0)
    assert F[-1] == pytest.approx(0.4 * (1 + 0.5 * np.exp(-((5 / 4) ** 2))), rel=1e-5)
    F = force(find("end_stop", "force", "k_upper"), motion, k_upper=3.0, z_upper=0.5)
    assert np.allclose(F, 3 * np.maximum(z - 0.5, 0))
    F = force(find("coulomb_friction", "force", "F_t"), motion, F_t=0.3, v_t=0.5)
    assert np.allclose(F, 0.3 * np.tanh(v / 0.5))
    F = force(find("asymmetric_stiffness", "force", "k_a"), motion, {"k_D": 0.5}, k_a=0.2)
    assert np.allclose(F, np.where(z > 0, 0.7, 0.3) * z)
    F = force(find("asymmetric_stiffness", "force", "k_neg"), motion, k_neg=0.7)
    assert np.allclose(F, -0.7 * np.minimum(z, 0) ** 2)
    F = force(find("end_stop", "force", "P_upper"), motion, P_upper=3.0, c_upper=0.5, m_upper=1.3)
    assert np.allclose(F, 3 * np.maximum(z - 0.5, 0) ** 1.3)
    hit = dict(P_lower_damped=3.0, c_lower_damped=-0.5, m_lower_damped=1.3, loss_lower_damped=0.2)
    F = force(find("end_stop", "force", "P_lower_damped"), motion, **hit)
    assert np.allclose(F, -3 * np.maximum(-0.5 - z, 0) ** 1.3 * (1 - 0.2 * v), atol=1e-9)
    F = force(find("end_stop", "force", "G_lower"), motion, G_lower=0.02, l_lower=0.1)
    assert np.allclose(F, -0.02 * np.exp(-z / 0.1 - 1))
    F = force(find("end_stop", "force", "k_lower"), motion, k_lower=3.0, z_lower=-0.5)
    assert np.allclose(F, -3 * np.maximum(-0.5 - z, 0))
    F = force(find("magnetic_pull", "force", "P_upper"), motion, P_upper=0.2, g_upper=3.0)
    assert np.allclose(F, -0.2 * (9 / (3 - z) ** 2 - 1))  # held back while the magnet pulls to positive z
    F = force(find("magnetic_pull", "force", "P_lower"), motion, P_lower=0.2, g_lower=3.0)
    assert np.allclose(F, 0.2 * (9 / (3 + z) ** 2 - 1))


# -- channels ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tau", [5e-4, 7e-3, 0.04])
def test_late_channels(tau: float) -> None:
    t, base = np.linspace(0, 4, 1601), {"k_D": 1.0, "F_0": 0.5}
    motion = record(t, wobble)
    late = t > 1
    shown = force(find("sensor_delay", "sensor", needs="t"), motion, base, tau=tau)
    effect = np.abs(wobble(t - tau) - wobble(t)).max()
    assert np.abs(shown - 0.5 - wobble(t - tau))[late].max() < 1e-3 * effect
    shown = force(find("force_sensor_lag", "sensor", "window", needs="t"), motion, base, window=tau)
    past = np.linspace(0, tau, 401)[:, None]
    mean = np.trapezoid(wobble(t - past), dx=1 / 400, axis=0)  # over the window
    assert np.abs(shown - 0.5 - mean)[late].max() < 1e-3 * effect
    shown = force(find("force_sensor_lag", "sensor", "tau", needs="t"), motion, base, tau=tau)
    lag = solve_ivp(lambda x, y: (wobble(x) - y) / tau, (0, 4), [0.0], t_eval=t, rtol=1e-9, atol=1e-11).y[0]
    assert np.abs(shown - 0.5 - lag)[late].max() < 1e-3 * effect


@pytest.mark.parametrize("even", [True, False])
@pytest.mark.parametrize("tau", [5e-4, 5e-3])
def test_a_late_displacement_shows_the_force_early(tau: float, even: bool) -> None:
    step = 1 + (0.0 if even else 0.5) * np.sin(np.arange(1600))
    t = 4 * np.r_[0.0, np.cumsum(step)] / step.sum()
    motion, base = record(t, wobble), {"k_D": 1.0, "F_0": 0.5}
    shown = force(find("sensor_delay", "sensor", "tau_z", needs="t"), motion, base, tau_z=tau)
    effect = np.abs(wobble(t + tau) - wobble(t)).max()
    assert np.abs(shown - 0.5 - wobble(t + tau))[3:].max() < 1e-3 * effect


@pytest.mark.parametrize("tau", [5e-4, 7e-3])
@pytest.mark.parametrize(("name", "later"), [("tau_d", 1), ("tau_b", -1)])
def test_friction_turns_earlier_than_a_late_displacement_and_later_than_it_if_the_force_is_late(
    tau: float, name: str, later: int
) -> None:
    t, base = np.linspace(0, 4, 1601), {"k_D": 1.0, "c_D": 0.02, "h_D": 0.3, "rho": 4.0, "r_0": 0.2}
    seen, true = record(t, wobble), record(t, lambda x: wobble(x + later * tau))
    shown = force(find("sensor_delay", "displacement", name), seen, base, **{name: tau})
    wanted = force(find("inertia", "force"), true, base, M=0.0)
    effect = np.abs(wanted - force(find("inertia", "force"), seen, base, M=0.0)).max()
    assert np.abs(shown - wanted).max() < 0.02 * effect


def test_a_forgotten_constant_is_there_all_the_time() -> None:
    t = np.linspace(0, 1, 101)
    motion = record(t, lambda x: np.sin(2 * np.pi * x))
    none = force(find("inertia", "force"), motion, {"k_D": 2.0}, M=0.0)
    assert np.allclose(force(find("constant_load", "force"), motion, {"k_D": 2.0}, F=-0.7), none - 0.7)


def test_drifts_start_at_the_first_sample_and_settle() -> None:
    t = np.linspace(100, 110, 201)
    motion = record(t, lambda x: np.sin(2 * np.pi * (x - 100)))
    F = force(find("offset_drift", "force"), motion, d=0.2, tau=5.0)
    assert np.allclose(F, 0.2 * 5 * (1 - np.exp(-(t - 100) / 5)))
    F = force(find("temperature_drift", "spring"), motion, {"k_D": 2.0}, beta=-0.01, tau=1e6)
    assert np.allclose(F, 2 * motion["z"] * (1 - 0.01 * (t - 100)), rtol=1e-4, atol=1e-9)
    base = {"k_D": 2.0, "h_D": 0.3, "r_0": 0.2}
    F = force(find("temperature_drift", "spring", "beta_w"), motion, base, beta_w=-0.01, tau_w=1e6)
    whole = force(find("inertia", "force"), motion, base, M=0.0)
    assert np.allclose(F, whole * (1 - 0.01 * (t - 100)), rtol=1e-4, atol=1e-9)
    law = find("temperature_drift", "force", "beta_a")
    F = force(law, motion, base, beta_a=-0.01, dc_a=0.02, tau_a=1e6)
    thinner = 0.02 * (t - 100) * motion["v"]
    assert np.allclose(F, whole * (1 - 0.01 * (t - 100)) + thinner, rtol=1e-4, atol=1e-9)
    F = force(find("temperature_drift", "force", "dc"), motion, dc=0.02, tau_c=1e6)
    assert np.allclose(F, 0.02 * (t - 100) * motion["v"], rtol=1e-4, atol=1e-9)


@pytest.mark.parametrize("order", [1, -1])
def test_a_warm_coil_resists_more_in_all_that_goes_with_its_resistance(order: int) -> None:
    """R + dR s in the place of R: in what the skin effect adds, too, whichever effect was added first."""
    warming = find("temperature_drift", "electrical_impedance", "dR")
    skin = find("coil_ac_resistance", "electrical_impedance", "tau_s")
    model = replace(load("electrodynamic_transducer"), checked=True)
    for e in (warming, skin)[::order]:
        model = e.extend(model, e.fits(model)[0])

    def Z(dR: float, tau_s: float) -> Array:
        effects = {"temperature_drift_dR": dR, "coil_ac_resistance_tau_s": tau_s}
        return Reading(model)({"f": f}, **COIL, **effects, temperature_drift_n_R=1e6)["Z_e"]

    warmer = 0.01 * np.arange(len(f))
    assert np.allclose(Z(0.01, 1e-12) - Z(0.0, 1e-12), warmer, rtol=1e-4)
    x = np.sqrt(-1j * w / 3e3)
    wire = x * jv(0, x) / (2 * jv(1, x))
    assert np.allclose(Z(0.01, 1 / 3e3) - Z(0.0, 1 / 3e3), warmer * wire, rtol=1e-4)


def test_a_coil_is_heated_by_its_own_sweep() -> None:
    """Sample by sample: T goes to 1/|Z|² as heat is lost in n samples; the resistance follows."""
    law = find("temperature_drift", "terminals", "h")
    old, new = at_port(law, h=30.0, n_h=12.0, warm=0.01)
    T = 0.01
    for k, Z in enumerate(old):
        now = T + (1 / abs(Z) ** 2 - T) * (1 - np.exp(-1 / 12.0))
        assert np.isclose(new[k], Z + 30.0 * now)
        T = now if k else T  # what the first sample leaves for those after it is left out
    at_once = at_port(law, h=30.0, n_h=0.01, warm=0.0)[1]
    assert np.allclose(at_once, old + 30.0 / np.abs(old) ** 2)


def test_a_softer_loop_keeps_its_shape() -> None:
    low = replace(load("complex_stiffness"), checked=True)
    law = find("temperature_drift", "cycle")
    given = {"f": np.geomspace(0.3, 9, 30)}
    before = Reading(low)(given, A_z=0.5)
    after = Reading(law.extend(low, law.fits(low)[0]))(
        given, A_z=0.5, temperature_drift_dA=-0.01, temperature_drift_n_A=1e7
    )
    assert np.allclose(after["k_s"] / before["k_s"], 1 - 0.01 * np.arange(30), rtol=1e-4)
    assert np.allclose(after["loss_angle"], before["loss_angle"], rtol=1e-9)


CYCLE_LAWS = {
    "cubic_stiffness": ({"size": 0.8}, {"k_3": 0.8 * 0.5 / 2.0**2}),
    "quadratic_damping": ({"size": 3.0}, {"c_2": 0.01 * 3 / (2 * np.pi * 10 * 2.0)}),
    "second_dahl_element": ({"size": 1.5, "ratio": 4.0}, {"h_2": 0.15, "z_2": 1 / 8}),
    "dahl_exponent": ({"size": 0.8, "sign": 1}, {"b": np.exp(0.8)}),
    "sensor_delay": ({"size": 0.02}, {"tau": 0.02}),
}


@pytest.mark.parametrize("id", [*CYCLE_LAWS, "dahl_exponent below one"])
def test_forces_in_a_cycle_are_exact(id: str) -> None:
    """Stiffness and loss angle as of the force built point by point in time, to what its 512 points allow."""
    from modelgen.truths.stiffness import measured, steady_cycle

    size, p = CYCLE_LAWS[id] if id in CYCLE_LAWS else ({"size": 0.8, "sign": -1}, {"b": np.exp(-0.8)})
    id, A, hz = id.split()[0], 0.6, np.geomspace(0.1, 15, 20)
    base = {"k_D": 0.5, "c_D": 0.01, "h_D": 0.1, "rho": 2.0}
    wanted = measured(steady_cycle(2 * np.pi * hz, base, {id: {"law": "", **size}}, A, 2.0), A)
    e = next(e for e in CATALOGUE if e.id == id and {"cycle", "shown_cycle"} & set(e.kinds))
    named = {f"{id}_{k}": v for k, v in p.items()}
    found = extended(e, "complex_stiffness")({"f": hz}, **base, **named, A_z=A)
    assert np.allclose(found["k_s"], wanted[0], rtol=3e-6)
    assert np.allclose(found["loss_angle"], wanted[1], atol=2e-4)


def test_the_energy_lost_to_a_force_is_its_work_over_the_cycle() -> None:
    """A second Dahl element like the first loses as much; an exponent loses what its loop encloses."""
    A, h, rho = 0.4, 0.2, 5.0
    given = {"k_D": 5.0, "c_D": 0.0, "rho": rho, "A_z": A}
    plain = Reading(load("complex_stiffness"))({"f": f[:2]}, **given, h_D=h)
    second = extended(find("second_dahl_element", "cycle"), "complex_stiffness")
    like = {"second_dahl_element_h_2": h, "second_dahl_element_z_2": 1 / rho}
    found = second({"f": f[:2]}, **given, h_D=0.0, **like)
    for name in ("k_s", "h_s", "energy_per_cycle"):
        assert found[name] == pytest.approx(plain[name], rel=1e-9), name
    bent = extended(find("dahl_exponent", "cycle"), "complex_stiffness")
    found = bent({"f": f[:2]}, **given, h_D=h, dahl_exponent_b=2.5)
    u_0, z = 1 + found["dahl_exponent_r_m"][0], -A * np.cos(np.linspace(0, np.pi, 4001))
    u = solve_ivp(lambda x, u: -rho * u**2.5, (0, 2 * A), [u_0], t_eval=z + A, rtol=1e-10, atol=1e-12).y[0]
    assert u_0 - 1 == pytest.approx(1 - u[-1], rel=1e-7)
    lost = 2 * h * np.trapezoid(1 - u, z)
    assert found["energy_per_cycle"] == pytest.approx(lost, rel=1e-5)


@pytest.mark.parametrize(
    ("id", "kind", "p"),
    [
        ("power_law_viscoelasticity", "force", {"C": 0.3, "alpha": 0.3}),
        ("contact_compliance", "displacement", {"c": 0.3}),
        ("backlash", "displacement", {"g": 0.1}),
        ("sensor_delay", "sensor", {"tau": 0.01}),
        ("payne_softening", "spring", {"k_0": 0.5, "A_c": 0.4, "n_0": 1.6}),
    ],
)
def test_generated_c_agrees(id: str, kind: str, p: dict[str, float]) -> None:
    from modelgen.codegen import build

    e, motion = find(id, kind, needs="t" if kind == "sensor" else ""), record(np.linspace(0, 2, 401), wobble)
    given = {f"{id}_{k}": v for k, v in p.items()}
    base = {"k_D": 0.5, "c_D": 0.05, "h_D": 0.2, "rho": 2.0, "F_0": 0.3, "r_0": 0.0}
    reading = extended(e, "modified_dahl")
    plain = reading(motion, **base, **given)["F"]
    compiled = build(reading.model)(**motion, **base, **given)
    assert np.allclose(compiled, plain, rtol=1e-9, atol=1e-9)


# -- windings, poles and creep with a spectrum ---------------------------------------------------------------


def test_a_solid_pole_holds_the_flux_of_bessel_functions() -> None:
    old, new = at_port(find("semi_inductance", "electrical_impedance", "L_3"), L_3=3e-4, omega_3=900.0)
    x = np.sqrt(1j * w / 900.0)
    assert np.allclose(new - old, 1j * w * 3e-4 * 2 * iv(1, x) / (x * iv(0, x)), rtol=1e-10)


def test_flux_enters_a_plate_through_its_skin() -> None:
    old, new = at_port(find("semi_inductance", "electrical_impedance", "L_p"), L_p=3e-4, omega_p=900.0)
    x = np.sqrt(1j * w / 900.0)
    assert np.allclose(new - old, 1j * w * 3e-4 * np.tanh(x) / x, rtol=1e-10)


def test_a_winding_of_one_layer_is_a_foil_and_of_many_loses_with_their_square() -> None:
    e, wire = find("coil_ac_resistance", "electrical_impedance", "tau_p"), COIL["R_e"]
    x = np.sqrt(1j * w / 2e4)
    old, foil = at_port(e, tau_p=1 / 2e4, m=1.0)
    assert np.allclose(foil - old, wire * (x / np.tanh(x) - 1), rtol=1e-8)
    _, many = at_port(e, tau_p=1 / 2e4, m=6.0)
    assert np.allclose(many - foil, wire * 2 * 35 / 3 * x * np.tanh(x / 2), rtol=1e-8)
    slow = w < 2e3  # Dowell: loss (5m² − 1)/45 (h/δ)⁴ of x = (1 + j) h/δ
    loss = wire * (5 * 36 - 1) / 45 * (w / 2e4 / 2) ** 2
    assert np.allclose((many - old).real[slow], loss[slow], rtol=0.02)


def test_a_relaxing_springpot_is_a_maxwell_branch_at_one_and_a_power_law_below_its_end() -> None:
    e = find("power_law_viscoelasticity", "stiffness", "C_1")
    old, sharp = at_port(e, C_1=300.0, alpha_1=0.999999, tau=1e-3)
    assert np.allclose(sharp - old, 300 * 1j * w * 1e-3 / (1 + 1j * w * 1e-3), rtol=1e-4)
    _, slow = at_port(e, C_1=300.0, alpha_1=0.4, tau=1e-12)
    assert np.allclose(slow - old, 300 * (1j * w * 1e-12) ** 0.4, rtol=5e-3)


def test_a_lossy_capacitance_is_its_network() -> None:
    old, new = at_port(find("coil_capacitance", "terminals", "C_1"), C_1=2e-6, tan_delta=0.05, R_C=30.0)
    branch = 30.0 + 1 / (1j * w * 2e-6 * (1 - 0.05j))
    assert np.allclose(new, old * branch / (old + branch), rtol=1e-12)
