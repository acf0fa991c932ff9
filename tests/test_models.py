"""The models that ship, against 40-digit values, limits and invariants."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mpmath as mp
import pytest
from exact import close, evaluate, reference_table
from hypothesis import given, settings
from hypothesis import strategies as st

import modelgen.models as models
from modelgen.errors import InputError
from modelgen.language import Model

m = mp.mpf

TRANSDUCER = {"A": mp.pi * m("0.01") ** 2, "mu_0": 4 * mp.pi * m("1e-7")}
TRANSDUCER["M_t"] = (TRANSDUCER["A"] / (m("0.1") * m("2.547e-11")) + m("3e6")) / (2 * mp.pi * 1600) ** 2
GIVEN = {
    "H": "1.2e9",
    "F": m("1e7") * mp.pi * m("0.01") ** 2,
    "M": 1,
    "gamma": "1.5",
    "nu_1": "0.3",
    "nu_2": "0.3",
}
SURFACES = {
    "G-M": ("2.6167", "4.3788e-10", "30e9", "200e9"),
    "M-D": ("2.6214", "3.6296e-10", "200e9", "193e9"),
    "M-H": ("2.6167", "3.4991e-10", "200e9", "200e9"),
}


@pytest.fixture(scope="module")
def table() -> dict[str, Any]:
    return reference_table()


def variants() -> list[Model]:
    shipped = [getattr(models, name) for name in models.SHIPPED]
    transducer, contact, dahl = shipped[0], shipped[1], shipped[2]
    return [
        *shipped,
        *(
            transducer.variant(eddy=e, eddy_sign=s)
            for e in ("exact", "series", "none")
            for s in ("corrected", "printed")
        ),
        contact.variant(g_form="homogeneous"),
        contact.variant(surface="fractal"),
        dahl.variant(initial="steady"),
    ]


@pytest.mark.parametrize("model", variants(), ids=lambda x: "-".join([x.id, *(v for _, v in x.options)]))
def test_units_of_every_equation_agree(model: Model) -> None:
    replace(model, checked=False)


@pytest.mark.parametrize("model", variants()[: len(models.SHIPPED)], ids=lambda x: x.id)
def test_every_number_has_a_default_and_every_quantity_a_text(model: Model) -> None:
    assert all(p.default is not None and p.text and p.source for p in model.scalar_parameters)
    assert all(s.text or s.ref for s in model.statements)
    for port in model.ports:
        names = {q.name for q in (*model.inputs, *model.scalar_parameters, *model.statements)}
        assert port.equation in names and {v.name for _, v in port.variables} <= names


def test_names_that_others_rely_on() -> None:
    wanted = {
        "magnetostrictive_transducer": "mu33_re mu33_im S33_re S33_im d33_re d33_im R_0 N A l M_t K_spr R_d "
        "R_f f_c k_M2",
        "contact_damping": "R_q_1 R_q_2 L_m E_1 E_2 nu_1 nu_2 H F M gamma",
        "modified_dahl": "k_D c_D h_D rho F_0 b r_0",
        "complex_stiffness": "k_D c_D h_D rho A_z",
        "electrodynamic_transducer": "R_e L_e Bl M_m K_m R_m",
    }
    for name, parameters in wanted.items():
        assert set(parameters.split()) <= {p.name for p in getattr(models, name).scalar_parameters}


def test_a_wrong_option_is_named() -> None:
    with pytest.raises(InputError, match=r"option eddy: unknown value 'serie', did you mean 'series'"):
        models.magnetostrictive_transducer.variant(eddy="serie")
    with pytest.raises(InputError, match="has no option 'eddi', did you mean 'eddy'"):
        models.magnetostrictive_transducer.variant(eddi="exact")


def transducer(f: Any, **values: Any) -> dict[str, Any]:
    options = {k: values.pop(k) for k in ("eddy", "eddy_sign") if k in values}
    return evaluate(models.magnetostrictive_transducer.variant(**options), f=f, **(TRANSDUCER | values))


def test_impedance() -> None:
    assert close(transducer(1600)["Z"], mp.mpc("81.718900527243873783", "91.858874428104233166"))
    assert close(transducer(1000)["Z"], mp.mpc("6.4179929839673737745", "62.702907694400771476"))
    assert close(transducer(1600)["phase"], "48.343274663790177718")
    assert close(transducer(1600)["k_eff2"], mp.mpc("0.025138619978765927964", "-0.00015965252954586813406"))


@pytest.mark.parametrize("f", [1000, 1500, 1600, 1650, 2500])
def test_impedance_table(f: int, table: dict[str, Any]) -> None:
    found = transducer(f)
    names = {
        "Z": "Z", "absZ": "abs_Z", "P": "phase", "k2": "k33_2", "Rg1": "R_g1", "Lg": "L_g", "Ze": "Z_e",
        "KG": "K_G",
        "Kg": "K_g", "Rg2": "R_g2", "Zt": "Z_t", "Tem": "T_em", "keff2": "k_eff2", "mus": "mus",
    }  # fmt: skip
    for printed, name in names.items():
        if f"f={f}: {printed}" in table:
            assert close(found[name], table[f"f={f}: {printed}"]), name


def test_series_of_the_eddy_factor(table: dict[str, Any]) -> None:
    found = transducer(1600, eddy="series")["Z"]
    assert close(found, table["Z(1600) with truncated series (5)"])
    for p in ("0.1", "0.5", "1", "2"):
        shown = mp.nstr(m(p), 6)
        assert close(transducer(m(p) * 30000)["chi"], table[f"chi exact p={shown}"])
        assert close(transducer(m(p) * 30000, eddy="series")["chi"], table[f"chi series p={shown}"])


@given(
    f=st.floats(1, 2e5),
    R_f=st.floats(0, 1e3),
    mu=st.floats(-0.3, 0),
    S=st.floats(-1e-12, 0),
    share=st.floats(-1, 1),
)
@settings(max_examples=30, deadline=None)
def test_lossy_constants_make_a_passive_transducer(
    f: float, R_f: float, mu: float, S: float, share: float
) -> None:
    """Re Z > 0 whenever Im μ, Im S <= 0 and Im(d)² <= μ_0 Im μ Im S; (4) is (11)."""
    d = share * float(mp.sqrt(TRANSDUCER["mu_0"] * mu * S))
    e = transducer(f, R_f=R_f, mu33_im=mu, S33_im=S, d33_im=d)
    assert e["Z"].real > 0
    w, k2 = e["omega"], e["k33_2"]
    Z11 = (
        e["R_0"]
        + 1j * w * e["mus"] * (1 + k2 * (e["K_G"] / (1j * w * e["Z_t"]) - 1)) * e["N"] ** 2 * e["A"] / e["l"]
    )
    assert close(e["Z"], Z11, 30)


def test_eddy_currents_take_power_unless_printed() -> None:
    lossless = {"mu33_im": 0, "S33_im": 0, "d33_im": 0, "R_d": 0, "R_f": 0, "R_0": 0}
    assert (
        transducer(1000, **lossless)["Z"].real
        > 0
        > transducer(1000, eddy_sign="printed", **lossless)["Z"].real
    )
    assert abs(transducer(1000, eddy="none", **lossless)["Z"].real) < 1e-30


def contact(D: Any, G: Any, E_1: Any, E_2: Any, **values: Any) -> dict[str, Any]:
    """Both surfaces have D; the second is smooth, so that D_eq = D and G_eq = G."""
    fractal = models.contact_damping.variant(surface="fractal")
    return evaluate(
        fractal, **{**GIVEN, "D_1": D, "D_2": D, "G_1": G, "G_2": 0, "E_1": E_1, "E_2": E_2, **values}
    )


def test_contact() -> None:
    assert close(contact(*SURFACES["G-M"])["R_n"], "20213.123127502942816")
    assert close(contact(*SURFACES["M-H"])["R_n"], "25693.421958766803364")


@pytest.mark.parametrize("surface", SURFACES)
def test_contact_table(surface: str, table: dict[str, Any]) -> None:
    found = contact(*SURFACES[surface])
    rows = {k.removeprefix(f"{surface}: "): v for k, v in table.items() if k.startswith(f"{surface}: ")}
    assert len(rows) == 18
    for name, value in rows.items():
        assert close(found[name], value), name
    assert close(found["F_pl"] + found["F_ep"] + found["F_el"], GIVEN["F"], 35)
    assert close(found["R_l"], found["a_l"] ** ((found["D_eq"] - 1) / 2) / (
        2 ** (5 - found["D_eq"]) * mp.pi ** ((found["D_eq"] - 1) / 2)
        * found["G_eq"] ** (found["D_eq"] - 2) * mp.sqrt(mp.log(m("1.5")))
    ), 35)  # fmt: skip


@pytest.mark.parametrize(
    ("R_q", "name", "D", "G"),
    [("0.661e-6", "GMR", "2.574500114329080652", "2.2155689340473840514e-10"),
     ("0.347e-6", "column", "2.6166553651500002704", "2.8137420220353731347e-10"),
     ("0.323e-6", "plunger", "2.6214130081912470106", "2.8901388679861343207e-10")],
)  # fmt: skip
def test_roughness(R_q: str, name: str, D: str, G: str) -> None:
    found = evaluate(models.contact_damping, upto="G_1", R_q_1=R_q, L_m="2538.46e-6")
    assert close(found["D_1"], D) and close(found["G_1"], G)


def test_equivalent_surface_and_homogeneous_form(table: dict[str, Any]) -> None:
    fractal = models.contact_damping.variant(surface="fractal")
    found = evaluate(fractal, upto="G_eq", D_1="2.5747", G_1="2.2525e-10", D_2="2.6167", G_2="2.8175e-10")
    assert close(found["G_eq"], table["G_eq G-M from Table 2"])
    for name, D in (("GMR", "2.5747"), ("column", "2.6167"), ("plunger", "2.6214")):
        R_q = (m("1.548") / (m(D) - 1)) ** (1 / m("0.041")) * m("1e-6")
        rms = m({"GMR": "0.661e-6", "column": "0.347e-6", "plunger": "0.323e-6"}[name])
        for form, word in (("printed", "literal (18),"), ("homogeneous", "homogeneous,")):
            model = models.contact_damping.variant(g_form=form)
            G_1 = evaluate(model, upto="G_1", R_q_1=R_q, L_m="2538.46e-6")["G_1"]
            G = G_1 * (rms / R_q) ** (1 / (m(D) - 2))  # R_q stands in (18) itself, and in the D_s of it
            assert close(G, table[f"G({name}) {word} Table-2 D={D}"])


@pytest.mark.parametrize("D", ["2.1", "2.3", "2.7", "2.9"])
def test_domain_extension_factor(D: str, table: dict[str, Any]) -> None:
    assert close(contact(D, "4e-10", "30e9", "200e9", upto="psi")["psi"], table[f"psi(D={D})"])


@pytest.mark.parametrize("D", [m(5) / 2, m("2.26") / m("0.88"), m(8) / 3, m("1.82") / m("0.66")])
def test_nothing_is_singular_where_an_exponent_vanishes(D: Any) -> None:
    """2.5, 2.568…, 2.666… and 2.757…: the value is the mean of its neighbours' but for their curvature."""
    h = m("1e-4")
    low, here, high = (contact(x, "4e-10", "30e9", "200e9") for x in (D - h, D, D + h))
    for name in ("R_n", "A_r", "W_e", "F_ep", "F_el", "K_n"):
        assert close((low[name] + high[name]) / 2, here[name], 5), name


def test_the_unit_of_length_does_not_matter() -> None:
    """Holds only if every exponent is right: it fails with (A5), (A11) and (A12) as printed."""
    a, b = (contact(*SURFACES["M-D"], l_0=l) for l in (1, m("0.7")))
    for name in ("psi", "a1c", "a_l", "F_ep", "A_r", "K_el", "K_ep", "W_e", "W_p", "R_n"):
        assert close(a[name], b[name], 30), name


@given(D=st.floats(2.1, 2.95), G=st.floats(-12, -7), H=st.floats(8, 10), more=st.floats(1e-6, 20))
@settings(max_examples=15, deadline=None)
def test_contact_over_its_range(D: float, G: float, H: float, more: float) -> None:
    """Where some load is elastic, the brackets hold the roots (`evaluate` asserts it) and all is positive."""
    values = {"D_1": D, "D_2": D, "G_1": m(10) ** G, "G_2": m(10) ** -12, "H": m(10) ** H}
    fractal = models.contact_damping.variant(surface="fractal")
    F = evaluate(fractal, upto="F_1c", **values)["F_1c"] * mp.e**more
    e = evaluate(fractal, **values, F=F)
    assert all(e[n] > 0 for n in ("a_l", "F_pl", "F_ep", "F_el", "A_r", "K_el", "K_ep", "W_e", "W_p", "R_n"))


def test_moving_coil_at_its_resonance() -> None:
    e = models.electrodynamic_transducer
    f = mp.sqrt(m(2000) / m("0.015")) / (2 * mp.pi)
    found = evaluate(e, f=f, Bl=7, R_m=2, R_e=5, L_e=0, M_m="0.015", K_m=2000)
    assert close(found["Z"].real, 5 + m(49) / 2, 30) and abs(found["Z"].imag) < 1e-30
