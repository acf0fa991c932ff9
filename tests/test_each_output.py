"""A model of two outputs: what is odd in either is said of that one, at its own port."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from outcomes import outcome_of

from modelgen.diagnose import Verdict, diagnose
from modelgen.diagnose.search.swap import better_of
from modelgen.effects import CATALOGUE
from modelgen.language import Equation, Input, Model, Output, Parameter, Port
from modelgen.recordings import Case, Noise, Recording

SIGMA = 0.01
T = np.arange(800) * 0.01
Z = np.sin(2 * np.pi * 0.7 * T) + 0.4 * np.sin(2 * np.pi * 1.9 * T)


def two() -> Model:
    """Two springs on one rod, each with its load cell."""
    t, z = Input("t", "s", "time"), Input("z", "mm", "displacement")
    k, k_2 = (Parameter(n, "N/mm", x, (0.0, 100.0)) for n, x in (("k", 2.0), ("k_2", 3.0)))
    springs = Equation("F", k * z, "N"), Equation("G", k_2 * z, "N")
    at = (("z", z.symbol),)
    ports = Port("left", "force", "F", at), Port("right", "force", "G", at)
    outputs = Output("F"), Output("G")
    return Model("two", inputs=(t, z), parameters=(k, k_2), statements=springs, outputs=outputs, ports=ports)


def case(F: np.ndarray, G: np.ndarray, seed: int = 0) -> Case:
    rng = np.random.default_rng(seed)
    noisy = {n: x + SIGMA * rng.standard_normal(T.size) for n, x in (("F", F), ("G", G))}
    record = Recording("a", None, "fit", {"t": T, "z": Z}, noisy)
    return Case(None, "two", (record,), noise=Noise({"F": SIGMA, "G": SIGMA, "z": 0.0}))


def recorded(F: np.ndarray, G: np.ndarray) -> Verdict:
    return diagnose(case(F, G), two())


@pytest.mark.parametrize("output", ["F", "G"])
@pytest.mark.slow
def test_a_line_is_of_the_output_that_has_it(output: str) -> None:
    hum = {"F": 0.0 * T, "G": 0.0 * T, output: 0.05 * np.sin(2 * np.pi * 11.3 * T)}
    verdict = recorded(2 * Z + hum["F"], 3 * Z + hum["G"])
    (found,) = verdict.effects
    assert found.id == f"unknown_sensor_{output}" and found.port == f"sensor_{output}"
    assert "11.3 Hz" in found.says and verdict.after.fit_over_noise < 1.1  # and is modelled


@pytest.mark.parametrize(("output", "port"), [("F", "left"), ("G", "right")])
def test_a_channel_that_clips_is_said_where_it_does(output: str, port: str) -> None:
    limit = {"F": np.inf, "G": np.inf, output: 1.9}
    (found,) = recorded(np.minimum(2 * Z, limit["F"]), np.minimum(3 * Z, limit["G"])).effects
    assert found.port == port
    assert float(found.says.partition("ends at ")[2].split()[0]) == pytest.approx(1.9, rel=2e-3)


@pytest.mark.parametrize(("output", "port"), [("F", "left"), ("G", "right")])
def test_one_law_at_two_ports_is_two_hypotheses(output: str, port: str) -> None:
    cubic = {"F": 0.0, "G": 0.0, output: 0.15}
    made = case(2 * Z + cubic["F"] * Z**3, 3 * Z + cubic["G"] * Z**3)
    laws = [e for e in CATALOGUE if e.id in ("cubic_stiffness", "quadratic_damping")]
    _, outcome = outcome_of(two(), made, laws)
    places = {f.hypothesis.added[0].port.name for f in outcome.tried if f.ids == ("cubic_stiffness",)}
    assert places == {"left", "right"} and outcome.best.hypothesis.added[0].port.name == port
    kept = better_of(list(outcome.tried), [])
    assert any(f.hypothesis.key == outcome.best.hypothesis.key for f in kept)


@pytest.mark.slow
def test_ports_are_told_apart_in_any_order() -> None:
    made = case(2 * Z + 0.15 * Z**3, 3 * Z)
    model = two()
    turned = replace(model, ports=model.ports[::-1])
    found = [diagnose(made, m).effects[0] for m in (model, turned)]
    assert {(e.id, e.port) for e in found} == {("cubic_stiffness", "left")}
