"""Cases and tables: what is read, in which unit, and what is said when something is wrong."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modelgen.errors import InputError
from modelgen.fit.series import signature_of
from modelgen.models import load
from modelgen.recordings import Case, Channel, Recording, Signature, load_case, read_case_file
from modelgen.recordings.convert import affine
from modelgen.recordings.table import read_table

SHARED = Path(__file__).parents[2] / "shared" / "data"

DAHL = Signature(
    model="modified_dahl",
    inputs=(Channel("t", "s"), Channel("z", "mm")),
    outputs=(Channel("F", "N", measured_as=("F_m",)),),
    parameters={"k_D": "N/mm", "c_D": "N*s/mm", "h_D": "N", "F_0": "N", "rho": "1/mm"},
    axis="t",
)
COIL = Signature(
    model="electrodynamic_transducer",
    inputs=(Channel("f", "Hz"),),
    outputs=(Channel("Z", "ohm", complex=True),),
    parameters={"R_e": "ohm", "L_e": "H", "M_m": "kg"},
    axis="f",
)
STIFFNESS = Signature(
    model="complex_stiffness",
    inputs=(Channel("f", "Hz"),),
    outputs=(Channel("k_s", "N/mm"), Channel("loss_angle", "deg")),
    parameters={"k_D": "N/mm"},
    axis="f",
)
MOTION = "t [s],z [mm],F_m [N]\n0,0,1\n0.1,0.5,2\n0.2,1,3\n"


def case(
    folder: Path, table: str | bytes, signature: Signature = DAHL, toml: str = "", head: str = ""
) -> Case:
    """A case of one recording, `a.csv`."""
    (folder / "a.csv").write_bytes(table if isinstance(table, bytes) else table.encode())
    text = f'model = "{signature.model}"\n{head}\n[[recording]]\nfile = "a.csv"\nrole = "fit"\n{toml}'
    (folder / "case.toml").write_text(text)
    return load_case(read_case_file(folder / "case.toml"), signature)


def record(folder: Path, table: str | bytes, signature: Signature = DAHL) -> Recording:
    return case(folder, table, signature).fit[0]


def complaint(folder: Path, table: str | bytes, signature: Signature = DAHL, **more: str) -> str:
    with pytest.raises(InputError) as why:
        case(folder, table, signature, **more)
    assert "\n" not in str(why.value)
    return str(why.value)


ROWS = "  20.0  +7.5  +30.0\n  10.0  +7.1  +25.0\n  40.0  +6.0  -15.0\n"


def test_empty_rows_that_a_spreadsheet_left(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(MOTION + ",,\n\n,,\n")
    assert len(read_table(tmp_path / "a.csv").rows) == 3


def test_columns_apart_by_blanks_below_comments(tmp_path: Path) -> None:
    r = record(tmp_path, f"* a sweep\n* of a woofer\nf [Hz]  |Z| [Ohms]   phase [Deg]\n{ROWS}", COIL)
    np.testing.assert_array_equal(r.inputs["f"], [10, 20, 40])
    np.testing.assert_allclose(r.outputs["Z"], [7.1, 7.5, 6.0] * np.exp(1j * np.deg2rad([25, 30, -15])))
    assert "no header of 'name [unit]'" in complaint(tmp_path, f"* a sweep\n{ROWS}", COIL)


def test_an_impedance_as_loudspeaker_programs_exchange_it(tmp_path: Path) -> None:
    (tmp_path / "woofer.zma").write_text(f"* Impedance (ohms), Phase (degrees)\n{ROWS}")
    (tmp_path / "case.toml").write_text(
        f'model = "{COIL.model}"\n[[recording]]\nfile = "woofer.zma"\nrole = "fit"\n'
    )
    r = load_case(read_case_file(tmp_path / "case.toml"), COIL).fit[0]
    np.testing.assert_allclose(r.outputs["Z"], [7.1, 7.5, 6.0] * np.exp(1j * np.deg2rad([25, 30, -15])))


def test_capital_letters_make_no_other_unit() -> None:
    assert affine("Ohms", "ohm") == (1.0, 0.0) and affine("Mohm", "ohm") == (1e6, 0.0)
    assert affine("kOhm", "ohm") == (1e3, 0.0) and affine("mOhm", "ohm") == (1e-3, 0.0)
    with pytest.raises(InputError, match="MOhm"):  # milli or mega: not guessed
        affine("MOhm", "ohm")


def test_arrays_are_contiguous_read_only_and_named_by_the_model(tmp_path: Path) -> None:
    r = record(tmp_path, MOTION)
    assert (r.name, r.role, r.n, dict(r.kinds)) == ("a", "fit", 3, {"F": "real"})
    np.testing.assert_array_equal(r.outputs["F"], [1, 2, 3])
    for array in (*r.inputs.values(), *r.outputs.values()):
        assert array.dtype == np.float64 and array.flags.c_contiguous and not array.flags.writeable


@pytest.mark.parametrize(
    ("found", "wanted", "scale"),
    [
        ("kHz", "Hz", 1e3),
        ("um", "mm", 1e-3),
        ("µm", "mm", 1e-3),
        ("mohm", "ohm", 1e-3),
        ("rad", "deg", 180 / np.pi),
        ("kip", "N", 4448.2216152605),
        ("in", "mm", 25.4),
        ("ms", "s", 1e-3),
        ("rad/s", "Hz", 1 / (2 * np.pi)),
        ("rpm", "Hz", 1 / 60),
        ("%", "1", 0.01),
    ],
)
def test_units_are_converted(found: str, wanted: str, scale: float) -> None:
    a, b = affine(found, wanted)
    assert a == pytest.approx(scale, rel=1e-12) and b == 0


def test_offset_units_are_converted_and_logarithmic_ones_refused() -> None:
    assert affine("degC", "K") == pytest.approx((1, 273.15))
    assert affine("degF", "degC") == pytest.approx((5 / 9, -160 / 9))
    for found, wanted in (("dBm", "W"), ("1", "deg"), ("mm", "s"), ("florp", "mm")):
        with pytest.raises(InputError):
            affine(found, wanted)


@pytest.mark.parametrize(("found", "wanted"), [("rad/s", "1/s"), ("1/s", "rad/s"), ("rpm", "1/min")])
def test_what_counts_neither_radians_nor_turns_is_not_taken_for_either(found: str, wanted: str) -> None:
    with pytest.raises(InputError, match="neither radians nor turns"):
        affine(found, wanted)


def test_columns_in_other_units(tmp_path: Path) -> None:
    r = record(tmp_path, "F_m [kN], t [ms], z [um]\n1,0,5\n2,10,7\n")
    np.testing.assert_allclose(r.inputs["t"], [0, 0.01])
    np.testing.assert_allclose(r.inputs["z"], [0.005, 0.007])
    np.testing.assert_allclose(r.outputs["F"], [1000, 2000])


@pytest.mark.parametrize(
    ("table", "kind", "wanted"),
    [
        ("f [Hz],Re Z [ohm],Im Z [ohm]\n1,3,4\n2,1,-1\n", "complex", [3 + 4j, 1 - 1j]),
        ("f [kHz],|Z| [mohm],phase [deg]\n1,2000,90\n2,1000,-180\n", "complex", [2j, -1]),
        ("f [Hz],|Z| [ohm],phase Z [rad]\n1,2,0\n2,1,3.141592653589793\n", "complex", [2, -1]),
        ("f [Hz],|Z| [ohm]\n1,2\n2,3\n", "modulus", [2, 3]),
        ("f [Hz],phase [rad]\n1,3.141592653589793\n2,0\n", "phase", [180, 0]),
        ("f [Hz],Re Z [ohm],Im Z [ohm],|Z| [ohm]\n1,3,4,5\n2,1,-1,1.41\n", "complex", [3 + 4j, 1 - 1j]),
    ],
)
def test_complex_outputs(tmp_path: Path, table: str, kind: str, wanted: list[complex]) -> None:
    r = record(tmp_path, table, COIL)
    assert r.kinds == {"Z": kind}
    assert r.outputs["Z"].dtype == (np.complex128 if kind == "complex" else np.float64)
    np.testing.assert_allclose(r.outputs["Z"], wanted, atol=1e-12)


@pytest.mark.parametrize(
    ("table", "kinds"),
    [
        ("f [Hz],|V| [V],phase [deg]\n1,2,30\n2,3,40\n", {"V": "complex"}),
        ("f [Hz],|Z| [ohm],phase [deg],|V| [V]\n1,2,30,1\n2,3,40,2\n", {"Z": "complex", "V": "modulus"}),
        ("f [Hz],phase [deg],|V| [V]\n1,30,1\n2,40,2\n", {"V": "complex"}),
        ("f [Hz],|V| [V],|Z| [ohm],phase [deg]\n1,1,2,30\n2,2,3,40\n", {"Z": "complex", "V": "modulus"}),
        ("f [Hz],phase [deg]\n1,30\n2,40\n", {"Z": "phase"}),
    ],
)
def test_a_phase_of_nothing_named_is_that_of_the_modulus_beside_it(
    tmp_path: Path, table: str, kinds: dict[str, str]
) -> None:
    both = replace(COIL, outputs=(*COIL.outputs, Channel("V", "V", complex=True)))
    assert record(tmp_path, table, both).kinds == kinds


def test_several_real_outputs_any_of_which_may_be_missing(tmp_path: Path) -> None:
    both = record(tmp_path, "f [Hz],k_s [N/m],loss_angle [rad]\n1,500,0.1\n2,600,0.2\n", STIFFNESS)
    np.testing.assert_allclose(both.outputs["k_s"], [0.5, 0.6])
    np.testing.assert_allclose(both.outputs["loss_angle"], np.rad2deg([0.1, 0.2]))
    assert set(record(tmp_path, "f [Hz],k_s [N/mm]\n1,5\n", STIFFNESS).outputs) == {"k_s"}


@pytest.mark.parametrize(
    "table",
    [
        "\ufeff" + MOTION,
        MOTION.replace("\n", "\r\n"),
        MOTION + "\n\n  \n",
        "# rig 3\n# 4 kHz\n" + MOTION,
        MOTION.replace(",", " ,  "),
        '"t [s]","z [mm]","F_m [N]"\n"0","0","1"\n0.1,0.5,2\n0.2,1,3',
    ],
)
def test_harmless_differences_of_form(tmp_path: Path, table: str) -> None:
    r = record(tmp_path, table)
    np.testing.assert_array_equal(r.inputs["t"], [0, 0.1, 0.2])
    np.testing.assert_array_equal(r.outputs["F"], [1, 2, 3])


def test_a_column_of_another_quantity_is_ignored_with_a_warning(tmp_path: Path) -> None:
    r = record(tmp_path, "t [s],note,z [mm],F [N]\n0,start,0,1\n0.1,,0.5,2\n")
    assert len(r.warnings) == 1 and "'note'" in r.warnings[0]
    np.testing.assert_array_equal(r.outputs["F"], [1, 2])


def test_unsorted_frequencies_are_sorted_with_a_warning(tmp_path: Path) -> None:
    r = record(tmp_path, "f [Hz],|Z| [ohm]\n3,30\n1,10\n2,20\n", COIL)
    np.testing.assert_array_equal(r.inputs["f"], [1, 2, 3])
    np.testing.assert_array_equal(r.outputs["Z"], [10, 20, 30])
    assert "line 3" in r.warnings[0] and "sorted" in r.warnings[0]


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("", ["empty"]),
        ("# only\n\n", ["empty"]),
        ("t [s],z [mm],F_m [N]\n", ["line 1", "no data"]),
        ("0,0,1\n1,2,3\n", ["line 1", "header"]),
        (MOTION.replace("0.5", "nan"), ["line 3", "'z [mm]'", "'nan'"]),
        (MOTION.replace("0.5", "inf"), ["line 3", "'z [mm]'", "'inf'"]),
        (MOTION.replace("0.5", "abc"), ["line 3", "'z [mm]'", "'abc'"]),
        (MOTION.replace("0.5", "1_0"), ["line 3", "'1_0'"]),
        (MOTION.replace("0.5", ""), ["line 3", "'z [mm]'", "empty"]),
        (MOTION.replace("0.5,", ""), ["line 3", "2 cells", "3 columns"]),
        (MOTION.replace("0.5", "0,5"), ["line 3", "4 cells"]),
        ("# a\n" + MOTION.replace("0.5", "x"), ["line 4", "'x'"]),
        (MOTION.replace("[mm]", "[N]"), ["line 1", "'z [N]'", "'mm'"]),
        (MOTION.replace("z [mm]", "z"), ["'z'", "no unit", "'z [mm]'"]),
        (MOTION.replace("z [mm]", "z (mm)"), ["'z (mm)'", "no unit"]),
        (MOTION.replace("[mm]", "[]"), ["'z []'", "no unit"]),
        (MOTION.replace("[mm]", "[florp]"), ["'z [florp]'", "unknown unit"]),
        (MOTION.replace("z [mm]", "Z [mm]"), ["'z [mm]'", "did you mean 'Z'"]),
        (MOTION.replace("F_m", "F_n"), ["no output", "did you mean 'F_n'"]),
        (MOTION.replace("F_m [N]", "z [um]"), ["'z [um]'", "same quantity", "'z [mm]'"]),
        (MOTION.replace("0.2,", "0.1,"), ["lines 3 and 4", "'t [s]'", "0.1"]),
        (MOTION.replace("0.2,", "0.05,"), ["line 4", "'t [s]'", "back"]),
        (MOTION.replace("0.5", "1e400"), ["line 3", "'1e400'"]),
        (b"\xff\xfet\x00", ["UTF-16", "save it as UTF-8"]),
        ("t [s],z [mm],phase [\xb0]\n".encode("latin-1"), ["line 1", "0xb0", "save it as UTF-8"]),
        (b"\x1f\x8b\x08\x00", ["gzip", "unpack"]),
        (b"PK\x03\x04\x14\x00", ["spreadsheet", "as CSV"]),
        (MOTION + "0.0,0,0\n", ["line 5", "'t [s]'", "back"]),
        (MOTION.encode() + b"\x00\x01", ["line 5", "binary"]),
    ],
)
def test_wrong_tables(tmp_path: Path, table: str | bytes, says: list[str]) -> None:
    message = complaint(tmp_path, table)
    assert "a.csv" in message
    for part in says:
        assert part in message


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("f [Hz],|Z| [ohm]\n1,2\n0,3\n", ["line 3", "'f [Hz]'", "above zero"]),
        ("f [Hz],|Z| [ohm]\n1,2\n-5,3\n", ["line 3", "-5"]),
        ("f [Hz],|Z| [ohm]\n1,2\n2,-3\n", ["line 3", "'|Z| [ohm]'", "-3"]),
        ("f [Hz],|Z| [ohm]\n1,2\n2,3\n1,4\n", ["lines 2 and 4", "twice"]),
        ("f [Hz],Re Z [ohm]\n1,2\n", ["'Re Z [ohm]'", "'Im Z' is missing"]),
        ("f [Hz],phase [1]\n1,2\n", ["'phase [1]'", "'deg'"]),
        ("f [Hz],Zmag [kOhm],phase [deg]\n1,2,90\n", ["'Zmag [kOhm]'", "'|Z| [ohm]'"]),
    ],
)
def test_wrong_spectra(tmp_path: Path, table: str, says: list[str]) -> None:
    message = complaint(tmp_path, table, COIL)
    for part in says:
        assert part in message


def test_case_tables_are_read(tmp_path: Path) -> None:
    head = """per_recording = ["F_0"]
[options]
r_0 = "steady"
[constants]
h_D = 2
[bounds]
k_D = [0, 5.5]
[noise]
F_m = 1.85e-3
z = 2.88e-4
"""
    c = case(tmp_path, MOTION, head=head, toml="constants = { rho = 1.5 }")
    assert (c.per_recording, c.constants, c.bounds) == (("F_0",), {"h_D": 2.0}, {"k_D": (0.0, 5.5)})
    assert c.noise.sigma == {"F": 1.85e-3, "z": 2.88e-4} and c.options == {"r_0": "steady"}
    assert c.fit[0].constants == {"rho": 1.5} and c.holdout == ()
    c = case(
        tmp_path, "f [Hz],|Z| [ohm]\n1,2\n", COIL, head="[noise]\nZ_relative=2e-4\nZ_calibration=[1e-3,0.7]"
    )
    assert c.noise.relative == {"Z": 2e-4} and c.noise.calibration == {"Z": (1e-3, 0.7)}


@pytest.mark.parametrize(
    ("head", "toml", "says"),
    [
        ("[constants]\nk_d = 1", "", ["[constants]", "'k_d'", "did you mean 'k_D'"]),
        ("[bounds]\nk_d = [1, 2]", "", ["[bounds]", "did you mean 'k_D'"]),
        ("[noise]\nF_n = 1", "", ["[noise]", "F_n", "did you mean"]),
        ("[noise]\nF_m = -1", "", ["F_m", "-1", "negative"]),
        ("[noise]\nF_m = 1\nF = 1", "", ["twice"]),
        ("[noise]\nF_m = [1, 2]", "", ["F_m", "one number"]),
        ('per_recording = ["F0"]', "", ["per_recording", "did you mean 'F_0'"]),
        ('per_recording = "F_0"', "", ["per_recording", "list"]),
        ('per_recording = ["F_0"]\n[constants]\nF_0 = 1', "", ["'F_0'", "constant"]),
        ("[bounds]\nk_D = [2, 1]", "", ["k_D", "[2, 1]", "low below high"]),
        ("[bounds]\nk_D = [0, inf]", "", ["k_D", "inf", "finite"]),
        ("[bounds]\nk_D = 3", "", ["k_D", "[low, high]"]),
        ("[bounds]\nk_D = [0, 1]\n[constants]\nk_D = 1", "", ["k_D", "a bound and a constant"]),
        ("[bounds]\nk_D = [0, 1]", "constants = {k_D = 1}", ["k_D", "a bound and a constant"]),
        ("[constants]\nk_D = nan", "", ["k_D", "finite"]),
        ("[constants]\nk_D = true", "", ["k_D = true", "wanted a number"]),
        ('[constants]\nk_D = "steady"', "", ["k_D", "'steady'", "[options]"]),
        ("[constants]\nk_D = 1" + "0" * 400, "", ["k_D", "finite"]),
        ("[bound]\nk_D = [0, 1]", "", ["'bound'", "did you mean 'bounds'"]),
        ("", "rolle = 3", ["recording 1", "'rolle'", "did you mean 'role'"]),
        ("", "constants = {kD = 1}", ["a.csv", "did you mean 'k_D'"]),
        ("", '[[recording]]\nfile = "./a.csv"', ["recording 2", "twice"]),
        ("", '[[recording]]\nfile = "gone.csv"', ["gone.csv", "no such file"]),
        ("", '[[recording]]\nfile = "."', ["not a regular file"]),
        ("", '[[recording]]\nfile = "b.csv"\nrole = "test"', ["'test'", "holdout"]),
        ("[constants\n", "", ["case.toml", "line 2"]),
    ],
)
def test_wrong_cases(tmp_path: Path, head: str, toml: str, says: list[str]) -> None:
    message = complaint(tmp_path, MOTION, head=head, toml=toml)
    for part in says:
        assert part in message


def test_what_drops_out_of_a_model_may_be_stated(tmp_path: Path) -> None:
    """b, r_0 and F_0 are quantities of the sample: in its steady cycle they change nothing, b = 1 alone."""
    table = "f [Hz],k_s [N/mm]\n1,0.4\n2,0.41\n3,0.42\n"
    signature = signature_of(load("complex_stiffness"))
    head = 'per_recording = ["F_0"]\n[constants]\nb = 1\nr_0 = -0.3\nh_D = 0\n'
    c = case(tmp_path, table, signature, head=head)
    assert (c.per_recording, c.constants) == ((), {"h_D": 0.0})
    for head, found in (("[constants]\nb = 1.4", "1.4"), ("[bounds]\nb = [0.5, 2]", "[0.5, 2.0]")):
        said = complaint(tmp_path, table, signature, head=head)
        assert f"complex_stiffness holds for b = 1 alone, found {found}" in said


def test_the_amplitude_of_a_recorded_motion_may_be_stated(tmp_path: Path) -> None:
    c = case(tmp_path, MOTION, signature_of(load("modified_dahl")), toml="constants = {A_z = 1, b = 1}")
    assert c.recordings[0].constants == {"b": 1.0}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "recording"),
        ('model = "m"', "no [[recording]]"),
        (
            'model = "m"\n[recording]\nfile = "a.csv"',
            "[recording] stands in single brackets, wanted [[recording]]",
        ),
        ('model = "m"\nrecording = "a.csv"', "recording = 'a.csv', wanted [[recording]]"),
        ('[[recording]]\nfile = "a.csv"', "model: missing"),
        ('model = 3\n[[recording]]\nfile = "a.csv"', "model: 3"),
        ('model = "m"\n[[recording]]\nrole = "fit"', "file: missing"),
        ('model = "m"\n[[recording]]\nfile = "a.csv"\nrole = "holdout"', "nothing to fit"),
    ],
)
def test_case_files_without_the_essential(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(InputError, match=r"case\.toml") as why:
        read_case_file(tmp_path / "case.toml")
    assert says in str(why.value) or text == ""


def test_missing_case_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_case_file(tmp_path / "case.toml")


def test_a_misspelt_file_is_told_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "loop_3mm.csv").write_text("")
    with pytest.raises(InputError, match=r"loop_3mm\.cvs: no such file, did you mean 'loop_3mm\.csv'\?"):
        read_table(tmp_path / "loop_3mm.cvs")


@pytest.mark.skipif(sys.platform == "win32", reason="links are POSIX")
@pytest.mark.parametrize("target", ["case.toml", "gone.toml"])
def test_a_link_that_leads_nowhere_is_said_to_be_one(tmp_path: Path, target: str) -> None:
    (tmp_path / "case.toml").symlink_to(target)
    with pytest.raises(InputError, match=r"case\.toml: it is a link that leads nowhere$"):
        read_case_file(tmp_path / "case.toml")


def test_names_of_files_that_share_a_stem(tmp_path: Path) -> None:
    for folder in ("up", "down"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "a.csv").write_text(MOTION.replace("1,3", f"1,{len(folder)}"))
    toml = '[[recording]]\nfile = "up/a.csv"\nrole = "holdout"\n[[recording]]\nfile = "down/a.csv"'
    c = case(tmp_path, MOTION, toml=toml)
    assert [r.name for r in c.recordings] == ["a.csv", "up/a.csv", "down/a.csv"]
    assert len(c.fit) == 2 and len(c.holdout) == 1


def test_long_tables_are_read_and_their_bad_cell_is_found(tmp_path: Path) -> None:
    n = 200_000
    rows = [f"{k * 0.25!r},{k % 7}.5,{k % 11}.25" for k in range(n)]
    r = record(tmp_path, "t [ms],z [um],F [N]\n" + "\n".join(rows))
    assert r.n == n and r.inputs["t"][-1] == pytest.approx((n - 1) * 0.25e-3)
    rows[n - 2] += "x"
    assert f"line {n}," in complaint(tmp_path, "t [ms],z [um],F [N]\n" + "\n".join(rows))


@pytest.mark.skipif(not SHARED.is_dir(), reason="no ../shared/data beside this repository")
def test_the_shared_measured_cases_are_read() -> None:
    for path in sorted(SHARED.glob("*/case.toml")):
        file = read_case_file(path)
        c = load_case(file, COIL if file.model == COIL.model else DAHL)
        assert c.fit and all(r.n > 100 and not r.warnings for r in c.recordings)
    damper = load_case(read_case_file(SHARED / "friction_damper_36lb" / "case.toml"), DAHL).fit[0]
    assert damper.outputs["F"][0] == pytest.approx(-0.13374695 * 4448.2216152605)
    assert np.ptp(damper.inputs["z"]) == pytest.approx(51.1, abs=0.1)  # 1 inch amplitude


def test_noise_of_the_axis_is_said_to_count_for_nothing(tmp_path: Path) -> None:
    made = case(tmp_path, MOTION, head="[noise]\nt = 1e-4\n")
    assert any("t counts for nothing" in w for w in made.warnings)


def test_a_copy_of_a_recording_does_not_count_twice(tmp_path: Path) -> None:
    for name, table in (("a", MOTION), ("b", MOTION), ("c", MOTION.replace("0.5,2", "0.5,2.1"))):
        (tmp_path / f"{name}.csv").write_text(table)

    def read(*specs: tuple[str, str]) -> Case:
        files = "".join(f'[[recording]]\nfile = "{n}.csv"\nrole = "{role}"\n' for n, role in specs)
        (tmp_path / "case.toml").write_text(f'model = "modified_dahl"\n{files}')
        return load_case(read_case_file(tmp_path / "case.toml"), DAHL)

    found = read(("a", "fit"), ("b", "fit"), ("c", "fit"))
    assert [r.name for r in found.recordings] == ["a", "c"]
    assert found.warnings == ("'b' holds the same samples as 'a': left out",)
    assert [r.name for r in read(("a", "fit"), ("b", "holdout")).recordings] == ["a", "b"]


@pytest.mark.parametrize("pair", ["Re(Z) [ohm],Im(Z) [ohm]", "Z_re [ohm],Z_im [ohm]"])
def test_a_complex_quantity_in_other_words(tmp_path: Path, pair: str) -> None:
    rows = "10,6,1\n20,6,2\n30,6,3\n"
    r = record(tmp_path, f"f [Hz],{pair}\n{rows}", COIL)
    assert r.outputs["Z"].tolist() == [6 + 1j, 6 + 2j, 6 + 3j]
    beside = "10,6,1,7\n20,6,2,7\n30,6,3,7\n"  # what stands there as it should goes before
    r = record(tmp_path, f"f [Hz],Re Z [ohm],Im Z [ohm],Z_re [ohm]\n{beside}", COIL)
    assert r.outputs["Z"].tolist() == [6 + 1j, 6 + 2j, 6 + 3j] and "Z_re" in r.warnings[0]
    assert "found 'Z_re' without 'Z_im'" in complaint(tmp_path, "f [Hz],Z_re [ohm]\n1,2\n", COIL)
    assert "wanted 'Re Z' or 'Im Z' or '|Z|'" in complaint(tmp_path, "f [Hz],Q [ohm]\n1,2\n", COIL)
