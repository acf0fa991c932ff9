"""Units at the border: Pint reads and converts them; inside, every number is in the unit of its
declaration."""

from __future__ import annotations

import re
from functools import cache
from hashlib import sha256
from typing import TYPE_CHECKING, Any
from unicodedata import normalize

from modelgen.errors import InputError
from modelgen.files import cache_folder, made_whole

if TYPE_CHECKING:
    import pint


PURE = ("", "1", "-", "dimensionless")
"""How people write the unit of a pure number."""
RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹"
LOWERED, LIFTED = str.maketrans(RAISED, "0123456789"), str.maketrans("0123456789-+.", RAISED + "⁻⁺·")
NAMED = {"ohm": "Ω", "deg": "°", "degC": "°C", "um": "µm", "uohm": "µΩ", "mohm": "mΩ", "kohm": "kΩ"}


@cache
def registry() -> pint.UnitRegistry[Any]:
    """The one Pint registry. Made on first use: importing Pint costs more than the rest of the start.

    Pint's cache holds paths of the Pint that made it: each has a folder of its own, as environments go. Pint
    writes it in place, so a second process would read half a file: it is made aside.
    """
    import pint

    own = sha256(f"{pint.__file__} {pint.__version__}".encode()).hexdigest()[:16]
    kept = made_whole(cache_folder() / f"pint-{own}", lambda aside: pint.UnitRegistry(cache_folder=aside))
    ureg: pint.UnitRegistry[Any] = pint.UnitRegistry(cache_folder=kept if kept.is_dir() else None)
    ureg.define("kip = 1000 * pound_force")
    return ureg


@cache
def parse(unit: str) -> pint.Unit:
    """Read a unit such as "N·s/mm", "m²/N", "ohm", "1" or "" (both dimensionless).

    Raises InputError when the unit is not known.
    """
    text = normalize("NFC", unit.strip())  # ohm, kelvin, ångström: each has a sign beside the letter
    text = re.sub(f"[{RAISED}]+", lambda p: "**" + p[0].translate(LOWERED), text)
    for a, b in (("·", "*"), ("Ω", "ohm"), ("µ", "u"), ("°", "deg")):
        text = text.replace(a, b)
    # "Ohms", "Deg", "kOhm", but not "MOhm"
    small = re.sub(r"\b[kmun]?[A-Z][a-z]{2,}\b", lambda p: p[0].lower(), text)
    units = registry()
    for spelling in ("dimensionless" if text in PURE else text, small):
        try:
            return units.Unit(spelling)
        except Exception as why:  # Pint raises half a dozen kinds
            last = why
    raise InputError(f"unknown unit '{unit}'") from last


@cache
def factor(found: str, wanted: str) -> float:
    """The number by which a value in unit `found` is multiplied to be in unit `wanted`.

    Raises InputError when either is unknown or they measure different things.
    """
    if found == wanted:
        return 1.0
    import pint

    try:
        return float(registry().Quantity(1.0, parse(found)).to(parse(wanted)).magnitude)
    except pint.DimensionalityError as why:
        raise InputError(f"unit '{found}' can't be read as '{wanted}'") from why


@cache
def converts(found: str, wanted: str) -> bool:
    """Whether a quantity in the unit `found` can be given in `wanted`."""
    try:
        factor(found, wanted)
    except InputError:
        return False
    return True


@cache
def electrical(unit: str) -> bool:
    """Whether a quantity in this unit is one of a circuit or a field: a voltage, a charge, a flux."""
    return "[current]" in parse(unit).dimensionality


@cache
def tidy(unit: str) -> str:
    """A unit as people write it, e.g. "(N)/((mm))**3" → "N/mm³"; "1" for none. It reads back by `parse`."""
    parsed = parse(unit)
    text = re.sub(r"\*\*(\d+)(?![.\d])", lambda p: p[1].translate(LIFTED), f"{parsed:~C}")
    return text.replace("**", "^").replace("*", "·").replace("Ω", "ohm") or "1"


def unit_text(unit: str) -> str:
    """A unit as it is printed: "N*s/mm**2" → "N·s/mm²"; a pure number has none."""
    if unit.strip() in PURE:
        return ""
    # a bracket ends a power where it began it: in "1/(s*V**0.5)" it does not
    raised = re.sub(r"(?:\*\*|\^)(\()?(-?\d+(?:\.\d+)?)(?(1)\))", lambda m: m[2].translate(LIFTED), unit)
    return re.sub(r"[A-Za-z]+", lambda m: NAMED.get(m[0], m[0]), raised).replace("*", "·")


def shown(unit: pint.Unit) -> str:
    """A unit that was computed, as it is printed; "1" for none."""
    return unit_text(f"{unit:~C}") or "1"


def change(unit: str) -> pint.Quantity[float]:
    """A change by one `unit`: of °C it is one by a kelvin, without an offset. Raises InputError."""
    units = registry()
    found = units.Quantity(1.0, "")
    for name, power in parse(unit)._units.items():
        offset = units.Quantity(0.0, name).to_base_units().magnitude != 0
        found = found * units.Quantity(1.0, f"delta_{name}" if offset else name) ** power
    return found


def bridge(found: pint.Unit, wanted: pint.Unit) -> tuple[float, str] | None:
    """How many `wanted` one `found` is, and the unit in which that number is 1, so that a product of it and
    something in `found` is in `wanted`: (1000, "mm/m") from m/s to mm/s.

    None where no product does it: another dimension, or another zero, as of °C.
    """
    units = registry()
    if found.dimensionality != wanted.dimensionality or units.Quantity(0.0, found).to(wanted).magnitude:
        return None
    ratio = float(units.Quantity(1.0, found).to(wanted).magnitude)
    simple = [u for name in (*found._units, *wanted._units) for u in _prefixed(name)]
    simple = [u for u in simple if abs(units.Quantity(ratio, u).to("").magnitude - 1) < 1e-9]
    simple.sort(key=lambda u: "kilogram" in u._units)  # rather m/mm than kg/g
    return ratio, tidy(f"{next(iter(simple), wanted / found):~C}")


def _prefixed(name: str) -> tuple[pint.Unit, ...]:
    """A unit with a prefix over the same without, and the other way round: mm/m, m/mm."""
    units = registry()
    prefix, plain, _ = units.parse_unit_name(name)[0]
    up = units.Unit(name) / units.Unit(plain)
    return (up, 1 / up) if prefix else ()
