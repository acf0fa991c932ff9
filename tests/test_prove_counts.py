"""modelgen prove: what is missing, late or not finite counts against the diagnosis, as does every claim."""

from __future__ import annotations

import json
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from modelgen.prove import baselines, dictionary, gallery, oracle, pictures, scores, studies
from modelgen.prove.keeper import told
from modelgen.prove.note import note
from modelgen.prove.page import page
from modelgen.prove.records import Record
from modelgen.truths import Secret, score

NOTHING = {"adequate": True, "effects": []}
FACTS = {"command": "modelgen prove", "drawn": "seed 1", "wanted": 9, "own": False, "code": "", "seed": 1,
         "versions": {}, "machine": ""}  # fmt: skip


def claimed(effect, port="force", **more):
    return {"adequate": False, "effects": [{"id": effect, "port": port, "equivalents": [], **more}]}


def secret(*effects, domain="force", kind="single", **more):
    return Secret(domain, effects, {}, {}, "white", 1, kind=kind, **more)


def trial(hidden, verdict, error="", index=0):
    """A scored row; without a verdict where there was an error."""
    row = {"index": index, "sha256": "0", "secret": hidden.to_json(), "error": error, "wall": 2.0, "cpu": 0.0,
           "foreign": []} | told(hidden)  # fmt: skip
    if error:
        return row
    whole = {"summary": "", "fit": {}, "effects": verdict["effects"]}
    return row | {"verdict": whole, "rivals": {}, "followed": None} | score(hidden, verdict)


def board(*rows):
    return {b["goal"].key: (b["share"].hits, b["share"].n) for b in scores.board(scores.usable(rows))}


@pytest.mark.parametrize("effect", ["inertia", "eddy_shunt"])
def test_no_claim_is_at_no_port(effect):
    assert score(secret(effect), NOTHING)["port"] is False


@pytest.mark.parametrize(
    ("hidden", "name", "port", "right"),
    [
        ("sensor_delay", "maxwell_branch", "force", False),
        ("sensor_delay", "force_sensor_lag", "force", True),  # by what it measures
        ("sensor_delay", "sensor_delay", "sensor", True),
        ("inertia", "sensor_delay", "force", False),
        ("inertia", "maxwell_branch", "force", True),
    ],
)
def test_a_force_is_a_place_of_mechanics_and_a_sensors_effect_is_at_the_channel(hidden, name, port, right):
    assert score(secret(hidden), claimed(name, port))["port"] is right


def test_a_delay_of_an_impedance_is_at_its_terminals():
    hidden = secret("sensor_delay", domain="impedance")
    assert score(hidden, claimed("sensor_delay", "electrical"))["port"]
    assert score(hidden, claimed("coil_capacitance", "electrical"))["port"]
    assert not score(hidden, claimed("inertia", "mechanical"))["port"]


def test_a_parameter_that_is_not_given_is_not_covered():
    hidden = replace(secret(kind="none"), base={"a": 1.0, "b": 2.0, "c": 1.0}, identifiable=("a", "b", "c"))
    found = score(hidden, NOTHING | {"parameters": {"a": {"value": 1.0, "std": 0.1}, "b": {"value": 2.0}}})
    assert found["covered"] == pytest.approx(1 / 3)
    s = scores.coverage([found | {"parameters": 3}])
    assert (s.hits, s.n) == (1, 3)


def test_a_trial_without_a_verdict_misses_every_goal_of_its_kind():
    why = "no verdict within 300 s"
    kinds = {
        "none": secret(kind="none"),
        "single": secret("inertia", d2={"inertia": 100.0}),
        "pair": secret("inertia", "backlash", kind="pair", d2={"inertia": 90.0, "backlash": 90.0}),
        "novel": secret("novel:mains_hum", kind="novel", d2={"novel:mains_hum": 90.0}),
    }
    found = {k: board(trial(s, NOTHING, why)) for k, s in kinds.items()}
    assert found["none"]["false alarm"] == (1, 1)
    assert all(f["seconds"] == (0, 1) for f in found.values())
    assert all(found[k]["power"] == (0, 1) for k in ("single", "pair", "novel"))
    for key in ("port", "family", "in set", "named, told", "hold-out"):
        assert found["single"][key] == found["pair"][key] == (0, 1), key
    assert found["pair"]["both"] == found["pair"]["both, told"] == (0, 1)
    assert (found["novel"]["unknown"], found["novel"]["misnamed"]) == ((0, 1), (1, 1))
    assert found["novel"]["unknown, new"] == (0, 0)


def test_a_page_and_a_note_show_what_gave_no_verdict():
    rows = [
        trial(secret("inertia", d2={"inertia": 100.0}), NOTHING, "ended", 3),
        trial(secret("inertia", d2={"inertia": 100.0}), claimed("inertia", probability=0.9), "", 4),
        trial(secret(kind="none"), NOTHING, "ended", 5),
    ]
    text = page(rows, [], [], FACTS)
    HTMLParser().feed(text)
    assert "no verdict" in text and "2 trials gave no verdict" in text
    assert "2 trials gave no verdict, which counts as a wrong one" in note(rows, [], [], FACTS)
    assert studies.to_json(rows, FACTS)["without_verdict"] == 2


def test_every_first_claim_is_in_the_calibration():
    rows = [
        trial(secret(kind="none"), claimed("inertia", probability=0.9)),
        trial(secret("novel:thermostat", kind="novel"), claimed("inertia", probability=0.9)),
        trial(secret("novel:thermostat", kind="novel"), claimed("unknown_force", probability=0.9)),
        trial(secret("inertia"), claimed("inertia", probability=0.9)),
        trial(secret("inertia"), claimed("unknown_force", probability=0.9)),
        trial(secret("inertia"), NOTHING),
        trial(secret(kind="none"), NOTHING),
    ]
    (bin_,) = studies.calibration(rows)
    assert (bin_["right"].hits, bin_["right"].n) == (2, 5)
    assert board(*rows)["nine in ten"] == (2, 5)


class Plain:
    """A scene with white noise of size 1."""

    def white(self, i, e, data):
        return e


def test_a_model_without_a_value_on_a_held_out_recording_is_a_miss():
    noise = np.ones((1, 100))
    gross = np.zeros(100, bool)
    truth = oracle.Reference(Plain(), [0], [0 * noise], [noise], [gross])
    rest = np.ones((1, 100))
    assert truth.ratio([rest]) == 1
    rest[0, 7] = np.nan
    assert truth.ratio([rest]) == np.inf
    assert not scores.holdout(
        {
            "kind": "single",
            "ratio": 3.0,
            "error": "",
            "rivals": {"diagnosis": {"holdout": truth.ratio([rest])}},
        }
    )
    assert json.loads(json.dumps(baselines._finite(truth.ratio([rest])), allow_nan=False)) > 1e9
    gross[7] = True  # the recording is at fault there, and no law
    assert oracle.Reference(Plain(), [0], [0 * noise], [noise], [gross]).ratio([rest]) == 1


def test_what_was_taken_for_an_outlier_tells_nothing_of_a_simpler_method():
    noise = np.ones((1, 50))
    truth = oracle.Reference(Plain(), [0], [0 * noise], [noise], [np.zeros(50, bool)])
    white = np.ones((1, 50))
    white[0, 3] = np.nan
    y = np.zeros(50)
    r = Record(True, white, {}, y, y, y, noise, noise, noise)
    assert baselines._over_truth(truth, [r], [white]) == 1
    lost = replace(r, before=np.where(np.arange(50) == 3, np.nan, 0.0))  # by the base, and by no outlier
    assert baselines._over_truth(truth, [lost], [white]) == baselines.WORST


@pytest.mark.skipif(not dictionary.available(), reason="extra `prove`")
@pytest.mark.parametrize("name", ["coil_ac_resistance", "semi_inductance", "coil_capacitance"])
def test_terms_are_weighted_as_the_residual_is(name):
    """A residual that is one term of the dictionary and noise, divided by Z as the diagnosis divides it."""
    rng, f, s = np.random.default_rng(0), np.geomspace(20, 2e4, 300), 1e-3
    w = 2 * np.pi * f
    Z = 6 + 5e-4j * w + 49 / (1.2 + 0.02j * w + 0.02 * (2 * np.pi * 50) ** 2 / (1j * w))
    x = 1j * w / w.max()
    term = {"coil_ac_resistance": -(x**2), "semi_inductance": x**0.5, "coil_capacitance": x * Z**2}[name]
    e = 10 * s * term / np.sqrt(np.mean(np.abs(term / Z) ** 2))
    e = e + s * np.abs(Z) * (rng.standard_normal(300) + 1j * rng.standard_normal(300))
    white, left = (np.array([v.real, v.imag]) for v in (e / Z / s, e))
    r = Record(False, white, {"f": f}, Z, Z, Z, np.array([Z.real, Z.imag]), left, white)
    found = dictionary.explain([r], [r], {})
    assert found["name"] == name
    assert np.mean(np.square(found["rest"][0])) < 1.1


def test_somebodys_own_cases_have_no_depth():
    kinds = [(("inertia",), "single"), ((), "none"), (("novel:x",), "novel")]
    hidden = [Secret("own", e, {}, {}, "own", 0, kind=k) for e, k in kinds]
    own = [trial(s, claimed("inertia", probability=0.9), "", i) | {"name": "a"} for i, s in enumerate(hidden)]
    assert {r["ratio"] for r in own} == {r["unexplained"] for r in own} == {None}
    facts = FACTS | {"own": True}
    text = page(own, [], [], facts)
    assert "variance" not in text.split("<h2>")[0] and "residual of the best base over the noise" not in text
    assert "in the noise</th>" not in text and "depth of concealment" not in text
    assert "over the depth" not in text and "noticed, over d²" not in text  # what its figures are called
    told_ = note(own, [], [], facts)
    assert "## By residual" not in told_ and "## Power" not in told_
    assert gallery.chosen([r | {"glance": {"x": [1]}} for r in own], bool) == []
    assert board(*own)["hold-out"] == (0, 0)
    assert "rms" in pictures.over_depth([trial(secret("inertia", d2={"inertia": 90.0}), NOTHING)])
