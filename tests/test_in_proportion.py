"""Force records whose noise is stated in proportion to the force, which passes through zero."""

import numpy as np
import pytest

from modelgen.diagnose import diagnose
from modelgen.fit.fitting import fit
from modelgen.models import kelvin_voigt
from modelgen.recordings import Case, Noise, Recording

RATE, SHARE, FLOOR = 200.0, 0.01, 1e-3
TRUE = {"k_D": 2.0, "c_D": 5e-3, "F_0": 0.0}  # N/mm, N·s/mm, N


def pushed(floor: float) -> Recording:
    """Kelvin–Voigt from rest, its force exactly zero for a while and at the end."""
    t = np.arange(2000) / RATE
    z = np.where(t < 0.2, 0.0, np.sin(2 * np.pi * (t - 0.2)) * np.sin(3.1 * (t - 0.2)))
    F = TRUE["k_D"] * z + TRUE["c_D"] * np.gradient(z, t)
    rng = np.random.default_rng(8)
    F = F * (1 + SHARE * rng.standard_normal(t.size)) + floor * rng.standard_normal(t.size)
    return Recording("pushed", "pushed.csv", "fit", {"t": t, "z": z}, {"F": F})


@pytest.mark.parametrize(
    ("floor", "noise"),
    [(0.0, Noise(relative={"F": SHARE})), (FLOOR, Noise(sigma={"F": FLOOR}, relative={"F": SHARE}))],
)
def test_a_noise_in_proportion_is_that_alone_or_what_is_stated_beside_it(floor: float, noise: Noise) -> None:
    """No sample is exact because it reads zero, and both parts of a noise count."""
    result = fit(kelvin_voigt, Case(None, "kelvin_voigt", (pushed(floor),), noise=noise))
    assert result.rms_over_noise["fit"] == pytest.approx(1.0, abs=0.1)
    for e in result.parameters:
        assert abs(e.value - TRUE[e.name]) < 4 * e.std + 1e-3 * TRUE[e.name]


def test_it_raises_no_alarm() -> None:
    verdict = diagnose(
        Case(None, "kelvin_voigt", (pushed(0.0),), noise=Noise(relative={"F": SHARE})), kelvin_voigt
    )
    assert verdict.adequate


def test_what_is_left_of_nothing_named_is_no_part_of_a_misfit() -> None:
    """Where nobody states it, the noise is taken for what neighbours scatter by on the whole."""
    verdict = diagnose(Case(None, "kelvin_voigt", (pushed(FLOOR),)), kelvin_voigt)
    assert verdict.adequate and not any("named effects" in n for n in verdict.notes)


def test_a_handful_of_samples_can_be_judged_by_no_description() -> None:
    whole = pushed(0.0)
    few = Recording(
        "few", None, "fit", {n: x[50:55] for n, x in whole.inputs.items()}, {"F": whole.outputs["F"][50:55]}
    )
    verdict = diagnose(Case(None, "kelvin_voigt", (few,), noise=Noise(relative={"F": SHARE})), kelvin_voigt)
    assert not verdict.effects and "can't be judged" in verdict.summary
