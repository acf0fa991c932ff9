"""Compiled C against 20-digit reference values, and the kernels of a model against each other."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen.models as models
from modelgen.codegen import Function, build, build_many
from modelgen.codegen.compiler import compile_library, find_compiler
from modelgen.codegen.emit import emit
from modelgen.codegen.program import build_program
from modelgen.codegen.tiers import Code, Tiers
from modelgen.codegen.unity import unite
from modelgen.errors import InputError, ToolError
from modelgen.language import Implicit, Input, Model, Parameter, Symbol

REFERENCE = Path(__file__).parents[2] / "shared" / "reference" / "reference_values.txt"
AREA = 0.00031415926535897932385
TRANSDUCER = {
    "R_0": 3, "K_spr": 3e6, "M_t": 1.2501374082326546115, "R_d": 6.79, "R_f": 349.2303, "mu33_re": 2.814,
    "mu33_im": -0.137, "S33_re": 2.547e-11, "S33_im": -2.178e-13, "d33_re": 1.587e-9, "d33_im": -5.588e-11,
    "f_c": 3e4, "N": 940, "l": 0.1, "A": AREA, "k_M2": 0.9205,
}  # fmt: skip
SURFACES = {
    "G-M": {"D_1": 2.6167, "G_1": 4.3788e-10, "E_1": 30e9, "E_2": 200e9},
    "M-D": {"D_1": 2.6214, "G_1": 3.6296e-10, "E_1": 200e9, "E_2": 193e9},
    "M-H": {"D_1": 2.6167, "G_1": 3.4991e-10, "E_1": 200e9, "E_2": 200e9},
}
DAHL = {
    "M0": {"k_D": 0.3834, "c_D": 0.0912, "h_D": 0.0353, "rho": 1.46},
    "M1": {"k_D": 0.6797, "c_D": 0.1374, "h_D": 0.2309, "rho": 1.44},
}
STAGE_2 = {
    "M0": {"k_D": 0.3494, "c_D": 0.0811, "h_D": 0.1972, "rho": 1.59},
    "M1": {"k_D": 0.6602, "c_D": 0.1130, "h_D": 0.2906, "rho": 1.41},
}
CYCLE = {"M0": (3.01, 0.099), "M1": (2.99, 0.1)}
ROUGH = {"GMR": 0.661e-6, "column": 0.347e-6, "plunger": 0.323e-6}


def transducer() -> Iterator[tuple[str, complex, float]]:
    F = build(models.magnetostrictive_transducer)
    for f in (1000, 1500, 1600, 1650, 2500):
        found = F.all(f=f, **TRANSDUCER)
        yield f"f={f}: Z", found["Z"], 1e-12
        yield f"f={f}: absZ", found["abs_Z"], 1e-12
        yield f"f={f}: P", found["phase"], 1e-12
    names = {
        "mus": "mus", "k2": "k33_2", "Rg1": "R_g1", "Lg": "L_g", "Ze": "Z_e", "KG": "K_G", "Rg2": "R_g2",
        "Kg": "K_g", "Zt": "Z_t", "Tem": "T_em", "keff2": "k_eff2",
    }  # fmt: skip
    found = F.all(f=1600, **TRANSDUCER)
    for name, own in names.items():
        yield f"f=1600: {name}", found[own], 1e-12
    series = build(models.magnetostrictive_transducer.variant(eddy="series"))
    yield "Z(1600) with truncated series (5)", series(f=1600, **TRANSDUCER), 1e-12
    for kind, function in (("exact  ", F), ("series ", series)):
        for p, f in (("0.0533333", 1600), ("0.1", 3e3), ("0.5", 15e3), ("1.0", 3e4), ("2.0", 6e4)):
            yield f"chi {kind} p={p}", function.all(f=f, **TRANSDUCER)["chi"], 1e-12


def contact() -> Iterator[tuple[str, complex, float]]:
    rough = build(models.contact_damping)
    for name, R_q in ROUGH.items():
        found = rough.all(R_q_1=R_q)
        yield f"D({name}) = D_s+1", found["D_1"], 1e-12
        yield f"G({name}) literal (18), unrounded D_s", found["G_1"], 1e-12
    fractal = build(models.contact_damping.variant(surface="fractal"))
    given = {"nu_1": 0.3, "nu_2": 0.3, "H": 1.2e9, "M": 1, "gamma": 1.5, "F": 1e7 * AREA}
    for pair, surface in SURFACES.items():
        found = fractal.all(**given, **surface, D_2=surface["D_1"], G_2=0.0)  # the other surface is smooth
        for name in (
            "psi", "k", "E", "a1c", "a2c", "H_G2", "a_l", "F_pl", "F_ep", "F_el", "K_el", "K_ep", "K_n",
            "W_e", "W_p", "eta", "R_n", "A_r",
        ):  # fmt: skip
            yield f"{pair}: {name}", found[name], 1e-9
    rod, column, plunger = (2.5747, 2.2525e-10), (2.6167, 2.8175e-10), (2.6214, 2.8890e-10)
    housing = (2.6167, 2.8175e-10)
    for pair, (one, other) in {
        "G-M": (rod, column),
        "M-D": (column, plunger),
        "M-H": (column, housing),
    }.items():
        found = fractal.all(D_1=one[0], G_1=one[1], D_2=other[0], G_2=other[1])
        yield f"G_eq {pair} from Table 2", found["G_eq"], 1e-12
    for D in (2.1, 2.3, 2.7, 2.9):
        yield f"psi(D={D})", fractal.all(D_1=D, D_2=D)["psi"], 1e-9


def stiffness() -> Iterator[tuple[str, complex, float]]:
    F = build(models.complex_stiffness)
    for case, values in DAHL.items():
        A_z, f = CYCLE[case]
        found = F.all(f=f, A_z=A_z, **values)
        for name in ("r_m", "A_F", "k_s", "c_s", "h_s", "energy_per_cycle"):
            yield f"{case} stage 4 steady cycle: {name}", found[name], 1e-12
        for at in (1, 3, 5, 7, 9):
            yield f"{case} params at A=0.4 mm, f={at} Hz: k_s", F(f=at, A_z=0.4, **values)[0], 1e-12


def dahl() -> Iterator[tuple[str, complex, float]]:
    F = build(models.modified_dahl)
    for r0, dz in ((-1, 0.5), (-0.9, 1.3), (0.6, -0.8)):
        for b in (1, 0.5, 1.5, 2):
            r = F(t=[0, 1], z=[0, dz], r_0=r0, rho=1.46, b=b, h_D=1, k_D=0, c_D=0, F_0=0)[1]
            yield f"r_update(r0={r0}, dz={dz}, rho=1.46, b={b})", r, 1e-12
    for case in DAHL:
        A_z, f = CYCLE[case]
        angle = 2 * np.pi * np.arange(1000) / 1000
        z, v = -A_z * np.cos(angle), 2 * np.pi * f * A_z * np.sin(angle)
        z_prev = np.concatenate([z[:1], z[:-1]])
        swing = {"t": angle / (2 * np.pi * f), "z": z, "z_prev": z_prev, "z_turn": z_prev, "v": v, "a": 0 * z}
        error = F(**swing, F_0=0, r_0=-1, **DAHL[case]) - F(**swing, F_0=0, r_0=-1, **STAGE_2[case])
        weight = (np.abs(np.sin(angle)) + 1) / 2
        yield f"{case} J_e (n=1000)", np.sqrt(np.mean(error**2)), 1e-12
        yield f"{case} J_es inside  (s_c*err)^2 [recommended]", np.sqrt(np.mean((weight * error) ** 2)), 1e-12
        yield f"{case} J_es outside s_c*err^2 [printed]", np.sqrt(np.mean(weight * error**2)), 1e-12


@pytest.fixture(scope="module")
def table() -> dict[str, complex]:
    """The values by what stands before them."""
    if not REFERENCE.exists():
        pytest.skip(f"no table of reference values at {REFERENCE}")
    values: dict[str, complex] = {}
    for line in REFERENCE.read_text().splitlines():
        name, rest = line[:46].strip(), line[46:].split()
        if rest and not line.startswith("#"):
            values[name] = float(rest[0]) + (1j * float(rest[1].rstrip("j")) if len(rest) > 1 else 0)
    return values


@pytest.mark.parametrize("lines", [transducer, contact, stiffness, dahl])
def test_every_reference_value_of_a_model(
    lines: Callable[[], Iterator[tuple[str, complex, float]]], table: dict[str, complex]
) -> None:
    count = 0
    for name, found, relative in lines():
        assert abs(complex(found) - table[name]) <= relative * abs(table[name]), name
        count += 1
    assert count >= 12


def test_a_handful_by_hand() -> None:
    """The same where the table is not at hand."""
    F = build(models.magnetostrictive_transducer)
    assert complex(F(f=1600, **TRANSDUCER)) == pytest.approx(
        81.718900527243873783 + 91.858874428104233166j, rel=1e-12
    )
    r = build(models.modified_dahl)(t=[0, 1], z=[0, 0.5], r_0=-1, rho=1.46, b=1.5, h_D=1, k_D=0, c_D=0, F_0=0)
    assert r[1] == pytest.approx(0.1299906619562436793, rel=1e-12)
    k_s, _ = build(models.complex_stiffness)(f=9, A_z=0.4, **DAHL["M0"])
    assert float(k_s) == pytest.approx(5.187991238274655953, rel=1e-12)


def sweep(model: Model, n: int, seed: int) -> dict[str, np.ndarray]:
    """Inputs of `model` at n samples."""
    rng = np.random.default_rng(seed)
    if model.axis == "f":
        return {"f": np.sort(rng.uniform(1, 5000, n))}
    t = np.arange(n) * 1e-3
    return {"t": t, "z": np.cumsum(rng.normal(0, 0.1, n))}


def varied(model: Model, shifts: list[float]) -> dict[str, float]:
    """Every parameter moved about its default, within its bounds."""
    values = {}
    for p, shift in zip(model.scalar_parameters, shifts, strict=False):
        assert p.default is not None
        values[p.name] = float(np.clip(p.default * (1 + 0.3 * shift), *p.bounds))
    return values


SAMPLED = [n for n in models.SHIPPED if n != "contact_damping"]


@pytest.mark.parametrize("name", SAMPLED)
@given(
    shifts=st.lists(st.floats(-1, 1), min_size=20, max_size=20), n=st.integers(2, 40), seed=st.integers(0, 99)
)
@settings(max_examples=25, deadline=None)
def test_the_kernels_agree(name: str, shifts: list[float], n: int, seed: int) -> None:
    model = getattr(models, name)
    F = build(model)
    values = varied(model, shifts)
    ready = F.prepare(**sweep(model, n, seed), **values)
    theta = np.array([values[w] for w in F.wrt])
    rng = np.random.default_rng(seed)
    for measure in F.code.source.measures:
        out, jac = ready.jacobian(theta, measure)
        assert np.array_equal(np.isfinite(out), np.full_like(out, True, dtype=bool))
        assert ready.values(theta, measure) == pytest.approx(out, rel=1e-11)  # asin near 90° loses digits
        data = out + rng.normal(0, 1, out.shape) * np.abs(out).max()
        weight = rng.uniform(0.5, 2, out.shape)
        padded = ready.pad(data), ready.pad(weight)
        e = weight * difference(out, data, measure)
        J = (weight[:, None, :] * jac).transpose(0, 2, 1).reshape(-1, len(theta))
        square = float(np.sum(e**2))
        assert ready.sumsq(np.stack([theta, theta]), measure, *padded) == pytest.approx(
            [square] * 2, rel=1e-12
        )
        f, g, A = ready.normal(theta, measure, *padded)
        size = np.maximum(np.linalg.norm(J, axis=0), 1e-100)
        assert f == pytest.approx(square, rel=1e-12)
        assert g / size == pytest.approx(J.T @ e.ravel() / size, rel=1e-10, abs=1e-12 * np.sqrt(square))
        assert A / np.outer(size, size) == pytest.approx(J.T @ J / np.outer(size, size), rel=1e-10, abs=1e-12)


def difference(out: np.ndarray, data: np.ndarray, measure: str) -> np.ndarray:
    e = out - data
    return e - 360 * np.floor(e / 360 + 0.5) if measure == "phase" else e


@pytest.mark.parametrize("name", ["magnetostrictive_transducer", "electrodynamic_transducer"])
def test_modulus_and_phase_are_those_of_the_complex_value(name: str) -> None:
    F = build(getattr(models, name))
    f = np.geomspace(1, 2e4, 50)
    ready = F.prepare(f=f)
    theta = ready.p[F.free]
    (re, im), d = ready.jacobian(theta, "complex")
    Z, dZ = re + 1j * im, d[0] + 1j * d[1]
    modulus, d_modulus = ready.jacobian(theta, "modulus")
    phase, d_phase = ready.jacobian(theta, "phase")
    assert modulus[0] == pytest.approx(np.abs(Z), rel=1e-14)
    assert phase[0] == pytest.approx(np.degrees(np.angle(Z)), rel=1e-12)
    size = np.abs(dZ).max(axis=1, keepdims=True) + 1e-300
    assert d_modulus[0] / size == pytest.approx((np.conj(Z) * dZ).real / np.abs(Z) / size, abs=1e-12)
    assert d_phase[0] / size == pytest.approx(np.degrees((dZ / Z).imag) / size, abs=1e-12)


def test_a_time_model_does_not_care_how_its_record_is_cut() -> None:
    """A record in two pieces, the state handed on, gives the record in one piece."""
    F = build(models.modified_dahl)
    z = np.cumsum(np.random.default_rng(1).normal(0, 0.3, 200))
    z_prev = np.concatenate([z[:1], z[:-1]])
    whole = {
        "t": np.arange(200.0),
        "z": z,
        "z_prev": z_prev,
        "z_turn": z_prev,
        "v": np.gradient(z),
        "a": 0 * z,
    }
    r = F.all(**whole)["r"]
    for cut in (1, 7, 8, 100, 198):
        rest = {k: v[cut:] for k, v in whole.items()}
        assert F.all(**rest, r_0=float(r[cut]))["F"] == pytest.approx(F(**whole)[cut:], rel=1e-12)


@pytest.mark.parametrize("n", [1, 2, 7, 8, 9, 401])
def test_any_number_of_samples(n: int) -> None:
    F = build(models.electrodynamic_transducer)
    f = np.linspace(20, 900, n)
    assert F(f=f) == pytest.approx(np.array([complex(F(f=x)) for x in f]), rel=1e-14)
    assert F.jacobian(f=f).shape == (n, 6)


def test_models_built_together_are_the_models_built_alone() -> None:
    pairs = [(models.electrodynamic_transducer, ("R_e", "Bl")), (models.modified_dahl, ("k_D",))]
    both = build_many(pairs)
    for F, (model, wrt) in zip(both, pairs, strict=True):
        at = sweep(model, 20, 0)
        measure = F.code.source.measures[0]
        alone = build(model, wrt)
        a, b = (g.prepare(**at).jacobian(g.prepare(**at).p[g.free], measure) for g in (F, alone))
        assert a[0] == pytest.approx(b[0], rel=1e-12) and a[1] == pytest.approx(b[1], rel=1e-12, abs=1e-15)


def test_equations_of_one_name_in_models_built_together_stay_apart() -> None:
    """y^k = a x by three solvers of the name solve_y, in one library that holds each shared function once."""
    x, a = Input("x", "1"), Parameter("a", "1", 2.0)
    roots = [
        Model("root", (x,), (a,), (Implicit("y", Symbol("y", real=True) ** k - a * x, (0, 9), "1"),), ("y",))
        for k in (1, 2, 3)
    ]
    built = build_many([(m, ("a",)) for m in roots], ("jacobian",))
    for k, F in enumerate(built, 1):
        values, _ = F.prepare(x=np.array([1.0, 4.0])).jacobian([2.0], "real")
        assert values[0] == pytest.approx([2 ** (1 / k), 8 ** (1 / k)], rel=1e-14)
    sources = [
        emit(build_program(models.modified_dahl, w), ("jacobian",), w[0]) for w in (("k_D",), ("c_D",))
    ]
    (text,) = (t for n, t in unite(sources).items() if n.endswith(".c"))
    assert text.count("double mg_exp(") == 1 and sources[1].source.count("double mg_exp(") == 1


def test_a_root_takes_few_evaluations_of_its_residual() -> None:
    """Steps that no longer shrink, at rounding, are no reason to halve a bracket from afar, which took 35."""
    model, f = models.complex_stiffness, np.geomspace(0.1, 50, 100)
    source = emit(build_program(model, ("k_D",)), ("values",))
    text = "long steps;\n" + source.source.replace("double slope;", "double slope; ++steps;")
    library = compile_library({f"{source.prefix}.h": source.header, f"{source.prefix}.c": text})
    counted = Function(model, ("k_D",), np.zeros(1, dtype=int), Tiers(lambda: Code(source, library)))
    for found, wanted in zip(counted(f=f), build(model)(f=f), strict=True):
        assert found == pytest.approx(wanted, rel=1e-12)
    assert 3 <= ctypes.c_long.in_dll(ctypes.CDLL(str(library)), "steps").value / len(f) <= 9


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"f": 100.0, "Re": 1.0}, "no parameter or input 'Re', did you mean 'R_e'"),
        ({}, "needs input 'f' \\[Hz\\]"),
        ({"f": []}, "are empty"),
        ({"f": "loud"}, "not numeric"),
        ({"f": "1000"}, "not numeric"),
        ({"f": 1000 + 0j}, "not numeric"),
        ({"f": 100.0, "R_e": [1.0, 2.0]}, "'R_e' .* must be one number"),
    ],
)
def test_wrong_calls(given: dict[str, Any], says: str) -> None:
    F: Function = build(models.electrodynamic_transducer)
    with pytest.raises(InputError, match=says):
        F(**given)


def test_a_compiler_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    find_compiler.cache_clear()
    try:
        with pytest.raises(ToolError, match="CC is set to 'no-such-compiler', which is not found"):
            find_compiler()
    finally:
        find_compiler.cache_clear()


def test_an_implicit_equation_without_a_change_of_sign_has_no_value() -> None:
    """y³ = a x between 0 and 2: a root at either end counts, none is NaN."""
    x, a = Input("x", "1"), Parameter("a", "1", 1.0)
    y = Implicit("y", Symbol("y", real=True) ** 3 - a * x, (0, 2), "1")
    cube = Model("cube_root", inputs=(x,), parameters=(a,), statements=(y,), outputs=("y",))
    found = build(cube)(x=np.array([-1.0, 0.0, 1.0, 8.0, 8.1, 27.0]))
    assert np.allclose(found, [np.nan, 0, 1, 2, np.nan, np.nan], rtol=1e-15, equal_nan=True)
