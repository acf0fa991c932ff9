"""The package as others get it: a wheel, installed elsewhere, that still builds models."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def pip(*arguments: str) -> None:
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_a_wheel_installed_elsewhere_builds_models(tmp_path: Path) -> None:
    pip("wheel", "--no-deps", "--wheel-dir", str(tmp_path), str(ROOT))
    (wheel,) = tmp_path.glob("modelgen-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    for template in (ROOT / "templates").rglob("*.j2"):
        assert f"modelgen/templates/{template.relative_to(ROOT / 'templates').as_posix()}" in names
    assert not [n for n in names if n.startswith(("tests/", "generated/", "examples/"))]
    elsewhere = tmp_path / "site"
    pip("install", "--no-deps", "--target", str(elsewhere), str(wheel))
    env = {**os.environ, "PYTHONPATH": str(elsewhere), "MODELGEN_CACHE": str(tmp_path / "cache")}
    script = "import modelgen as m, modelgen.cli as c; print(m.__file__); raise SystemExit(c.main(['build']))"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env=env, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert str(elsewhere) in done.stdout
    for path in (ROOT / "generated").iterdir():
        assert (tmp_path / "generated" / path.name).read_bytes() == path.read_bytes()
