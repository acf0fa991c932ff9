"""What a search of recordings over time passes by when it goes from one effect to the next."""

from pathlib import Path

import pytest

from modelgen.api import read_case
from modelgen.diagnose import diagnose
from modelgen.models import load
from modelgen.truths import draw, write_case


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "effects", "noise", "ratio"),
    [
        pytest.param(
            203100021, ("inertia", "sensor_delay"), "quantised", 20.0,
            id="spring and dashpot take up either, but not both",
        ),
        pytest.param(
            720100199, ("power_law_viscoelasticity", "second_mode"), "white", 6.0,
            id="beside the bent creep a mass does more than a resonator elsewhere",
        ),
        pytest.param(
            203300215, ("maxwell_branch", "second_mode"), "clean", 20.0,
            id="where the base is bent far, it seems to resonate elsewhere",
        ),
        pytest.param(
            204900095, ("stribeck_friction", "power_law_viscoelasticity"), "misstated", 20.0,
            id="beside the bent creep friction falls with speed, alone it would rise",
        ),
    ],
)  # fmt: skip
def test_both_of_a_pair_are_named(
    tmp_path: Path, seed: int, effects: tuple[str, str], noise: str, ratio: float
) -> None:
    write_case(draw(seed, "pair", "force", effects, (30.0, 1e4), noise, ratio), tmp_path)
    found = diagnose(read_case(tmp_path / "case.toml"), load("modified_dahl"))
    assert {e.id for e in found.effects} == set(effects)
