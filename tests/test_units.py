"""Units at the border: a cache that other environments have written to, and spellings as people use them."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from modelgen.errors import InputError
from modelgen.language import Equation, Model, Parameter
from modelgen.units import factor, parse, tidy


def _told(home: Path, code: str) -> str:
    """What `code` prints in a process of its own, with its caches in `home`."""
    env = {**os.environ, "HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")}
    env.pop("MODELGEN_CACHE", None)
    made = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    return made.stdout.strip()


def test_a_cache_of_units_that_another_environment_has_written_is_not_read(tmp_path: Path) -> None:
    """Pint's cache names the files that it was read from; that environment may be gone by now."""
    folder = "from modelgen.units import registry; print(registry()._diskcache.cache_folder)"
    here = Path(_told(tmp_path, folder))
    assert here.is_relative_to(tmp_path) and here.is_dir()
    elsewhere = "import pint; pint.__file__ = '/elsewhere/pint/__init__.py'; "
    assert Path(_told(tmp_path, elsewhere + folder)) != here


def test_processes_that_begin_at_once_read_no_half_written_cache(tmp_path: Path) -> None:
    code = "from modelgen.units import factor; print(factor('kN', 'N'))"
    with ThreadPoolExecutor(6) as pool:
        told = list(pool.map(lambda _: _told(tmp_path, code), range(6)))
    assert set(told) == {"1000.0"}
    assert not [p for p in (tmp_path / "cache" / "modelgen").iterdir() if p.name.startswith(".")]


def test_units_are_known_where_nothing_can_be_kept() -> None:
    code = "from modelgen.units import factor; print(factor('kN', 'N'))"
    assert float(_told(Path("/proc/self/nowhere"), code)) == 1000


@pytest.mark.parametrize(
    ("found", "wanted", "times"), [("kN/mm", "N/m", 1e6), ("Ohms", "ohm", 1.0), ("°", "rad", 0.0174532925)]
)
def test_units_are_read_as_people_write_them(found: str, wanted: str, times: float) -> None:
    assert factor(found, wanted) == pytest.approx(times)


@pytest.mark.parametrize(
    ("sign", "letter"), [("k\u2126", "k\u03a9"), ("\u212a", "K"), ("\u00b5m", "\u03bcm")]
)
def test_signs_of_two_codes_are_one_unit(sign: str, letter: str) -> None:
    assert sign != letter and factor(sign, letter) == 1.0


def test_what_is_tidied_reads_back() -> None:
    for unit in ("(N)/((mm))**3", "N·s/mm", "m²/N", "1", "ohm*s**0.5"):
        assert parse(tidy(unit)) == parse(unit)


def test_an_unknown_unit_is_said_to_be_one() -> None:
    with pytest.raises(InputError, match="unknown unit 'furlongs per'"):
        parse("furlongs per")


SCALES = [
    ("m/s", "mm/s", "mm/m", 1000.0),
    ("kg*mm/s**2", "N", "m/mm", 0.001),
    ("1/mohm", "F*rad/s", "mohm/ohm", 1000.0),
    ("N", "N*m/mm", "m/mm", 0.001),
    ("min", "s", "s/min", 60.0),
    ("N*m/deg", "N*m", "deg", 57.2957795130823),
]


@pytest.mark.parametrize(("found", "wanted", "per", "times"), SCALES)
def test_another_scale_of_one_dimension_is_told_with_its_cure(
    found: str, wanted: str, per: str, times: float
) -> None:
    a, b = Parameter("a", found, 1.0), Parameter("b", wanted, 1.0)
    cure = f'Parameter("per", "{per}", {times:.15g}, known=True)'
    for expr in (1000 * a, a + b):
        with pytest.raises(InputError) as told:
            Model("m", (), (a, b), (Equation("v", expr, wanted),), ("v",))
        said = str(told.value)
        assert f"differ by a factor of {max(times, 1 / times):.6g}" in said and cure in said
        assert " / " not in said and "**" not in said
    factor_of = Parameter("per", per, times, known=True)
    Model("m", (), (a, b, factor_of), (Equation("v", factor_of * a + b, wanted),), ("v",))


def test_units_in_messages_are_written_as_in_tables() -> None:
    a = Parameter("a", "kg*mm/s**2", 1.0)
    with pytest.raises(InputError, match=r"right-hand side is in kg·mm/s², 'v' in Ω·s⁰·⁵$"):
        Model("m", (), (a,), (Equation("v", a, "ohm*s**0.5"),), ("v",))


def test_temperatures_differ_by_more_than_a_factor() -> None:
    a = Parameter("a", "degC", 1.0)
    with pytest.raises(InputError, match="is in °C, 'T' in K; they have not the same zero: write all in one"):
        Model("m", (), (a,), (Equation("T", a, "K"),), ("T",))
