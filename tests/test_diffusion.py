"""Diffusion at the electrode of a cell."""

from dataclasses import replace

import numpy as np
import pytest

from modelgen.diagnose import diagnose
from modelgen.effects import CATALOGUE
from modelgen.language import Equation, Input, Model, Parameter, Port, j, pi
from modelgen.models import load
from modelgen.recordings import Case, Recording

f = Input("f", "Hz")
R_s, R_ct = Parameter("R_s", "ohm", 0.02, (1e-4, 10.0)), Parameter("R_ct", "ohm", 0.05, (1e-4, 10.0))
C_dl = Parameter("C_dl", "F", 0.5, (1e-4, 1e3))
omega = Equation("omega", 2 * pi * f, "rad/s")
Z_f = Equation("Z_f", R_ct, "ohm")
C_d = Equation("C_d", C_dl, "F")
Z = Equation("Z", R_s + 1 / (1 / Z_f + j * omega * C_d), "ohm")
at = (("omega", omega.symbol),)
cell = Model(
    "cell", (f,), (R_s, R_ct, C_dl), (omega, Z_f, C_d, Z), ("Z",),
    (Port("faradaic", "electrical_impedance", "Z_f", at), Port("double_layer", "capacitance", "C_d", at)),
)  # fmt: skip


@pytest.mark.parametrize("where", ["far", "through", "layer", "grains"])
def test_diffusion_is_named(where: str) -> None:
    rng, hertz = np.random.default_rng(2), np.geomspace(1e4, 1e-2, 61)
    s = 2j * np.pi * hertz
    x = np.sqrt(s * 3.0)
    diffusion = {
        "far": 0.01 / np.sqrt(s),
        "through": 0.03 * np.tanh(x) / x,
        "layer": 0.02 / (x * np.tanh(x)),
        "grains": 0.01 / (x / np.tanh(x) - 1),
    }[where]
    true = 0.018 + 1 / (1 / (0.045 + diffusion) + s * 0.4)
    true = true * (1 + 2e-3 * (rng.normal(size=61) + 1j * rng.normal(size=61)))
    found = diagnose(Case(None, "cell", (Recording("eis", None, "fit", {"f": hertz}, {"Z": true}),)), cell)
    assert [e.id for e in found.effects] == ["warburg_diffusion"]
    assert {"through": "layer that ends", "layer": "coth", "grains": "grains"}.get(
        where, ""
    ) in found.effects[0].says


def test_leads_of_a_cell_are_in_series_with_all_of_it() -> None:
    """Not with what the double layer shunts: no delay of the recording is named in their stead."""
    lying = Port("terminals", "terminals", "Z", at)
    wired = replace(cell, ports=(*cell.ports, lying))
    leads = [e for e in CATALOGUE if e.id == "leakage_inductance"]
    assert lying in {p for e in leads for p in e.fits(wired)}
    assert all(lying not in e.fits(replace(wired, ports=(cell.ports[0], lying))) for e in leads)
    rng, hertz = np.random.default_rng(2), np.geomspace(1e4, 1e-2, 61)
    s = 2j * np.pi * hertz
    true = 0.018 + 1 / (1 / 0.045 + s * 0.4) + s * 2e-7
    true = true * (1 + 2e-3 * (rng.normal(size=61) + 1j * rng.normal(size=61)))
    found = diagnose(Case(None, "cell", (Recording("eis", None, "fit", {"f": hertz}, {"Z": true}),)), wired)
    assert [(e.id, e.port) for e in found.effects] == [("leakage_inductance", "terminals")]


def test_what_moves_has_no_diffusion() -> None:
    laws = [e for e in CATALOGUE if e.id == "warburg_diffusion"]
    assert all(e.fits(cell) for e in laws) and len(laws) == 4
    for id in ("electrodynamic_transducer", "magnetostrictive_transducer", "piezoelectric_transducer"):
        assert not any(e.fits(load(id)) for e in laws)
