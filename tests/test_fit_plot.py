"""The plot of a fit: what is drawn, in every format, whole or not at all."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import modelgen as mg
from modelgen.cli import main
from modelgen.errors import InputError
from modelgen.fit import FitResult
from modelgen.report import svg
from modelgen.report.fits import MOST, draw, write_plot

CASE = 'model = "modified_dahl"\n[noise]\nF = 0.01\n[[recording]]\nfile = "a.csv"\n'


@pytest.fixture(scope="module")
def loops(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, FitResult]:
    """A case of two recordings, one held out, and its fit."""
    folder, rng = tmp_path_factory.mktemp("loops"), np.random.default_rng(0)
    f = mg.build(mg.models.modified_dahl)
    for name, hz in (("a", 1.0), ("b", 2.0)):
        t = np.arange(1200) / 200.0
        z = -2 * np.cos(2 * np.pi * hz * t)
        F = f(t=t, z=z, k_D=0.4, c_D=0.02, h_D=0.3, rho=1.5) + 0.01 * rng.standard_normal(t.size)
        table = np.column_stack([t, z, F])
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header="t [s],z [mm],F [N]", comments="")
    (folder / "case.toml").write_text(CASE + '[[recording]]\nfile = "b.csv"\nrole = "holdout"\n')
    model, case = mg.open_case(folder / "case.toml")
    return folder / "case.toml", mg.fit(model, case, method=mg.GaussNewton())


def test_what_is_drawn(loops: tuple[Path, FitResult]) -> None:
    """For each recording the time record, the loop and the residual over its noise band, with units."""
    with svg.style(svg.PAPER):
        figure = draw(loops[1])
    axes = figure.get_axes()
    assert [a.get_xlabel() for a in axes] == ["t [s]", "z [mm]", "t [s]"] * 2
    assert axes[0].get_title("left") == "force [N]" and "residual" in axes[2].get_title("left")
    trace = loops[1].traces[0]
    loop = axes[1].lines[0].get_xydata()
    places = {tuple(p) for p in np.column_stack([trace.inputs["z"], trace.data])}
    assert {tuple(p) for p in np.asarray(loop)} <= places
    assert np.sqrt(np.mean(trace.white_after**2)) == pytest.approx(1.0, abs=0.06)
    assert max(np.ptp(line.get_xdata()) for line in axes[2].lines if len(line.get_xdata())) == pytest.approx(
        np.ptp(trace.x), rel=0.01
    )


@pytest.mark.parametrize(("name", "begin"), [("p.svg", b"<?xml"), ("p.png", b"\x89PNG"), ("p.pdf", b"%PDF")])
def test_formats(name: str, begin: bytes, loops: tuple[Path, FitResult], tmp_path: Path) -> None:
    loops[1].plot(tmp_path / name)
    first = (tmp_path / name).read_bytes()
    assert first.startswith(begin) and 5_000 < len(first) < 1_000_000
    if name == "p.svg":
        text = "".join(ET.fromstring(first).itertext())
        assert all(says in text for says in ("a: 1200 points", "b, held out", "noise", "force [N]"))
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_refused(loops: tuple[Path, FitResult], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must end in one of \.svg, \.png, \.pdf"):
        write_plot(loops[1], tmp_path / "fit.jpg")
    with pytest.raises(InputError, match="does not exist"):
        loops[1].plot(tmp_path / "no" / "fit.svg")
    assert not list(tmp_path.iterdir())


def test_by_the_command(loops: tuple[Path, FitResult], tmp_path: Path) -> None:
    assert main(["fit", str(loops[0]), "--method", "gauss-newton", "--plot", str(tmp_path / "f.svg")]) == 0
    assert ET.parse(tmp_path / "f.svg").getroot().tag.endswith("svg")
    assert main(["fit", str(loops[0]), "--plot", str(tmp_path / "f.jpg")]) == 2
    assert not (tmp_path / "f.jpg").exists()


def test_many_recordings_and_single_points_are_drawn(loops: tuple[Path, FitResult], tmp_path: Path) -> None:
    from dataclasses import replace

    trace = loops[1].traces[0]
    one = {k: getattr(trace, k)[:1] for k in ("x", "data", "before", "after", "outliers")}
    white = {k: getattr(trace, k)[:, :1] for k in ("white_before", "white_after")}
    short = replace(trace, name="short", inputs={}, **one, **white)
    with svg.style(svg.PAPER):
        figure = draw(replace(loops[1], traces=(short,) * 3 + loops[1].traces * MOST))
    assert len(figure.subfigs) == MOST + 1
    replace(loops[1], traces=(short,)).plot(tmp_path / "short.png")
