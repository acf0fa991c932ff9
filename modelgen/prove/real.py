"""Measured recordings: what is found in them, beside what the literature says of the device."""

from __future__ import annotations

import json
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import modelgen
from modelgen.prove.diagnoser import Diagnoser
from modelgen.prove.worker import VERDICT

Row = dict[str, Any]
EXAMPLE = Path(modelgen.__file__).parents[1] / "examples" / "mre_elastomer"
LIMIT = 300.0


@dataclass(frozen=True)
class Known:
    """A measured device: `literature` is one sentence with its source, `expects` the ids that it names, any
    of a group."""

    title: str
    literature: str
    expects: tuple[frozenset[str], ...]


VISCOELASTIC = frozenset({"power_law_viscoelasticity", "maxwell_branch", "structural_damping"})
EDDY = frozenset({"semi_inductance", "eddy_shunt", "permeability_relaxation", "coil_ac_resistance"})
HYSTERESIS = frozenset({"second_dahl_element", "dahl_exponent", "stribeck_friction"})
LAG = frozenset({"sensor_delay", "force_sensor_lag"})
KNOWN = {
    "mre_elastomer": Known(
        "MRE elastomer, Tab. 2 and 3 of the paper",
        "The stiffness rises by 45 % from 1 to 9 Hz along a power law: the matrix relaxes, which a spring "
        "and a dashpot can't follow (springpot fits of such elastomers: Li et al. 2010).",
        (VISCOELASTIC,),
    ),
    "loudspeaker_l16rnx": Known(
        "Woofer SEAS L16RNX, impedance in free air",
        "Eddy currents in the pole piece let the inductance fall with frequency like (jω)ⁿ (Vanderkooy "
        "1989), and the suspension creeps (Knudsen and Jensen 1993).",
        (EDDY, VISCOELASTIC),
    ),
    "friction_damper_36lb": Known(
        "Banded rotary friction damper",
        "Its authors built and modelled it as friction with backlash: the force lags through a clearance at "
        "each reversal (Downey et al.).",
        (frozenset({"backlash"}),),
    ),
    "mr_damper_0V": Known(
        "MR damper without current, on a shaking table",
        "Hysteresis beyond a single Dahl element (Spencer et al. 1997: a softer roll-off at low speed); a "
        "delay of the recording looks much the same at these speeds.",
        (HYSTERESIS | LAG | VISCOELASTIC | {"contact_compliance", "quadratic_damping"},),
    ),
    "silverbox": Known(
        "Silverbox, an electronic oscillator",
        "Built to obey m z̈ + d ż + (a + b z²) z = u: a moving mass and a hardening cubic spring (Wigren and "
        "Schoukens 2013).",
        (frozenset({"inertia"}), frozenset({"cubic_stiffness"})),
    ),
    "vhb4910_relaxation": Known(
        "VHB 4910 acrylic, stretched and held",
        "The stress relaxes over decades of time, described by several Maxwell branches (Hossain, Vu and "
        "Steinmann 2012) or a fractional one.",
        (VISCOELASTIC,),
    ),
}


def folders(data: Path) -> tuple[list[Path], list[str]]:
    """Folders of the recordings that are there, and the names of those that are not."""
    places = {name: EXAMPLE if name == EXAMPLE.name else data / name for name in KNOWN}
    there = [p for p in places.values() if (p / "case.toml").exists()]
    others = sorted(p.parent for p in data.glob("*/case.toml") if p.parent.name not in KNOWN)
    return [*there, *others], [n for n, p in places.items() if p not in there]


def diagnose_real(folder: Path, diagnoser: Diagnoser) -> Row:
    """What is found in a folder's case, beside what is known of it."""
    known = KNOWN.get(folder.name, Known(folder.name, "", ()))
    with tempfile.TemporaryDirectory(prefix="case-") as scratch:
        copy = Path(scratch) / folder.name  # nothing is written beside somebody's data
        shutil.copytree(folder, copy)
        answer = diagnoser.diagnose(copy / "case.toml")
        verdict = {} if answer.error else json.loads((copy / VERDICT).read_text(encoding="utf-8"))
    ids = [e["id"] for e in verdict.get("effects", [])]
    return {
        "name": folder.name,
        "title": known.title,
        "literature": known.literature,
        "error": answer.error,
        "seconds": answer.seconds,
        "effects": verdict.get("effects", []),
        "summary": verdict.get("summary", ""),
        "fit": verdict.get("fit"),
        "agrees": f"{sum(any(i in group for i in ids) for group in known.expects)} of {len(known.expects)}",
    }
