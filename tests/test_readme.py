"""What README shows is what there is: its Python runs, its commands are those of `modelgen`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from modelgen.cli import main
from modelgen.codegen import build
from modelgen.effects import load_effects
from modelgen.models import load

ROOT = Path(__file__).parents[1]
BLOCKS = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.MULTILINE | re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the files that README asks the reader to write."""
    for block in BLOCKS:
        if name := re.match(r"# (\w+\.py)\n", block):
            (tmp_path / name[1]).write_text(block)
    return tmp_path


def test_the_tour_in_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    names: dict[str, Any] = {}
    exec(BLOCKS[0], names)
    assert names["Z"].shape == (2,) and names["dZ"].shape == (2, len(names["f"].wrt))
    fitted, named = capsys.readouterr().out.splitlines()
    value, std, over = map(float, fitted.split())
    assert value == pytest.approx(2.06, abs=0.02) and 0 < std < 0.1 and over > 8
    assert "power_law_viscoelasticity" in named and (tmp_path / "report.html").stat().st_size > 10_000


def test_the_model_of_ten_lines(folder: Path) -> None:
    quartz = load("quartz.py:quartz", folder)
    w = 2 * np.pi * 1e7
    Y = 1j * w * 5e-12 + 1 / (20 + 1j * w * 8e-3 + 1 / (1j * w * 3e-14))
    assert build(quartz)(f=1e7) == pytest.approx(1 / Y, rel=1e-12)


def test_the_mount_that_needs_no_speed(folder: Path) -> None:
    t = np.linspace(0, 2, 401)
    F = build(load("mount.py:mount", folder))(t=t, z=np.sin(3 * t), k=7.0, c=0.2, F_0=1.0)
    assert np.allclose(F, 7 * np.sin(3 * t) + 0.2 * 3 * np.cos(3 * t) + 1, atol=1e-3)


def test_the_pendulum_with_two_states(folder: Path) -> None:
    def rates(s: float, y: Any) -> list[float]:
        phi, w = 0.2 * np.sin(5 * s), np.cos(5 * s)
        return [y[1], -(0.4 * (y[0] - phi) + 0.006 * (y[1] - w) + 0.6 * np.sin(y[0])) / 0.02]

    t = np.linspace(0, 4, 801)
    wanted = solve_ivp(rates, (0, 4), [0.3, -1.0], t_eval=t, rtol=1e-9, atol=1e-9).y[0]
    theta = build(load("pendulum.py:pendulum", folder))(
        t=t, phi=0.2 * np.sin(5 * t), theta_0=0.3, omega_0=-1.0
    )
    assert np.allclose(theta, wanted, atol=1e-3)


def test_the_effect_of_ten_lines(folder: Path) -> None:
    (leak,) = load_effects("my_effects.py", folder)
    quartz = load("quartz.py:quartz", folder)
    (port,) = leak.fits(quartz)
    leaky = build(leak.extend(quartz, port))
    Z = build(quartz)(f=1e7)
    assert leaky(f=1e7) == pytest.approx(Z, rel=1e-14)
    assert leaky(f=1e7, insulation_leak_G=1e-4) == pytest.approx(Z / (1 + 1e-4 * Z), rel=1e-12)


def test_the_output_of_a_fit(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The table in README is the one that the command prints."""
    monkeypatch.chdir(ROOT)
    assert main(["fit", "examples/mre_elastomer/case.toml"]) == 0
    readme = (ROOT / "README.md").read_text()
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    for line in lines[:12]:
        assert line in readme, line


def test_the_output_of_a_diagnosis(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """README shows what the command prints; the page writes the law as people do."""
    monkeypatch.chdir(ROOT)
    page = tmp_path / "report.html"
    case = "examples/mre_elastomer/case.toml"
    assert main(["diagnose", case, "--report", str(page), "--out", str(tmp_path)]) == 0
    readme = " ".join((ROOT / "README.md").read_text().split())
    printed = capsys.readouterr().out.split("Extended model")[0]
    assert " ".join(printed.split()) in readme
    law = re.sub("<.*?>", "", page.read_text().split("The law")[1].split("</p>")[0])
    assert "C·(j·ω)α" in law, law


def test_a_model_by_field_and_the_output_of_its_fit_and_loops(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    assert load("by_field.py:model", folder) == load("by_field.py:model", ROOT / "examples" / "mre_field")
    monkeypatch.chdir(ROOT)
    readme = [line.rstrip() for line in (ROOT / "README.md").read_text().splitlines()]
    recording = ["examples/mre_field/s1_m1.csv", "--length", "43", "--area", "256"]
    for command, count in ((["loops", *recording], 15), (["fit", "examples/mre_field/case.toml"], 11)):
        assert main(command) == 0
        for line in capsys.readouterr().out.splitlines()[:count]:
            assert line.rstrip() in readme, line


def test_the_datasheet_of_a_controller(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """The table in README is the one that is measured, with the tools that it names."""
    monkeypatch.chdir(tmp_path)
    readme = (ROOT / "README.md").read_text()
    (command,) = re.findall(r"^\$ modelgen (export modified_dahl --target c99 .*)$", readme, re.MULTILINE)
    assert main(command.split()) == 0
    sheet = (tmp_path / "firmware" / "DATASHEET.md").read_text()
    (tools,) = re.findall(r"^arm-none-eabi-gcc .*$", readme, re.MULTILINE)
    if tools not in sheet:
        pytest.skip("README's table is of other tools")
    table = readme.split(tools)[1].split("| self-test |")[0].split("| | ")[1]
    for line in table.splitlines():
        assert line in sheet, line


def test_the_count_of_published_numbers() -> None:
    """The counts of papers' numbers in README are those that there are to judge."""
    from modelgen.papers import papers

    readme = (ROOT / "README.md").read_text()
    for paper in papers():
        (row,) = re.findall(rf"^{paper.id} +(\d+) +(\d+) +(\d+) +(\d+) +(\d+)$", readme, re.MULTILINE)
        *verdicts, whole = map(int, row)
        assert sum(verdicts) == whole == sum(len(t.numbers) for t in paper.tables)
