"""Far from the recordings the base is looked for from many points."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import modelgen as mg


@pytest.mark.slow
def test_a_base_does_not_follow_a_resonance_that_is_not_its_own(tmp_path: Path) -> None:
    """A trap in the cable, just below the band: swarms agree on a coil that takes its place."""
    rng, text = np.random.default_rng(4), 'model = "electrodynamic_transducer"\n'
    for name, mass, n in (("light", 0.0667, 200), ("heavy", 0.1067, 400)):
        f = np.geomspace(179, 1795, n)
        s = 2j * np.pi * f
        trap = 53.4 / (1 + 29.3 * (s / 1075 + 1075 / s))
        Z = 18.4 + 0.0202 * s + 17.2**2 / (6.2 + mass * s + 8.1e5 / s) + trap
        Z *= 1 + 7e-4 * (rng.standard_normal(n) + 1j * rng.standard_normal(n))
        rows, head = np.column_stack([f, Z.real, Z.imag]), "f [Hz],Re Z [ohm],Im Z [ohm]"
        np.savetxt(tmp_path / f"{name}.csv", rows, delimiter=",", header=head, comments="")
        text += f'[[recording]]\nfile = "{name}.csv"\nconstants = {{ M_m = {mass} }}\n'
    (tmp_path / "case.toml").write_text(text)
    model, case = mg.open_case(tmp_path / "case.toml")
    assert mg.fit(model, case)["K_m"].value == pytest.approx(8.1e5, rel=0.02)
    verdict = mg.diagnose(case, model)
    assert (
        verdict.effects[0].id == "unknown_electrical" and "a resonance in series" in verdict.effects[0].says
    )
    found = {e.name: e.value for e in verdict.parameters}
    assert found["K_m"] == pytest.approx(8.1e5, rel=1e-3) and found["Bl"] == pytest.approx(17.2, rel=0.01)
