"""modelgen prove: nothing is lost or revealed by an interruption; what is given wrongly is told."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from test_prove import Listening, own_case

from modelgen.cli import main, proving
from modelgen.errors import InputError
from modelgen.prove import keeper
from modelgen.prove import run as running
from modelgen.prove.own import own_trials
from modelgen.prove.plan import plan
from modelgen.truths import draw


def test_a_line_that_was_cut_off_spoils_no_other(tmp_path):
    room = running.Room(tmp_path)
    room.add("trials.jsonl", json.dumps({"index": 0, "says": "a\u2028b"}, ensure_ascii=False))
    with open(tmp_path / "trials.jsonl", "ab") as file:
        file.write('{"index": 1, "says": "µ'.encode()[:-1])  # within a letter
    room.add("trials.jsonl", json.dumps({"index": 1}))
    room.add("trials.jsonl", json.dumps({"index": 2}))
    (tmp_path / "measured.jsonl").write_text('{"name": "x"}\n[3]\n"name"\n{"nam')
    room.add("measured.jsonl", json.dumps({"name": "y"}))
    assert sorted(room.rows()) == [0, 1, 2]
    assert room.rows()[0]["says"] == "a\u2028b"
    assert sorted(room.measured()) == ["x", "y"]
    (tmp_path / "sealed.txt").write_text("00000 ab")
    room.add("sealed.txt", "00001 cd")
    assert (tmp_path / "sealed.txt").read_text() == "00000 ab\n00001 cd\n"


class Killed(Listening):
    """A diagnoser that says, as one does that is killed when the run is at its end, that it ended."""

    def __init__(self, stop):
        super().__init__()
        self.stop = stop

    def diagnose(self, case):
        self.stop.set()
        return running.Answer("the diagnosing process ended", 0.1)


def test_an_interrupted_trial_reveals_nothing(tmp_path):
    stop, finished = threading.Event(), queue.SimpleQueue()
    todo = queue.SimpleQueue()
    todo.put(plan(1, 1, ["white"], ["impedance"])[0])
    with ThreadPoolExecutor(1) as pool:
        lane = running.Lane(todo, finished, pool, Killed(stop), running.Room(tmp_path), {}, stop)
        thread = threading.Thread(target=lane.work, daemon=True)
        thread.start()
        kind, row = finished.get(timeout=20)
        assert kind == "sealed"
        row["go"].set()
        thread.join(20)
    assert finished.empty() and not list(tmp_path.rglob("secret.json"))


def test_a_run_has_stopped_before_its_diagnosers_are_killed(tmp_path, monkeypatch):
    seen, lanes = [], []

    class Opened:
        def __init__(self, limit):
            pass

        def __enter__(self):
            return Listening()

        def __exit__(self, *why):
            seen.append(lanes[0].stop.is_set())

    work = running.Lane.work
    monkeypatch.setattr(running, "Diagnoser", Opened)
    monkeypatch.setattr(running, "_keepers", ThreadPoolExecutor)
    monkeypatch.setattr(running.Lane, "work", lambda lane: (lanes.append(lane), work(lane)))

    def interrupted(row):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        running.run(plan(1, 1, ["white"], ["impedance"]), running.Room(tmp_path), 1, 9.0, interrupted, print)
    assert seen == [True]


def test_settings_are_whole_and_told_where_they_are_not(tmp_path):
    room = running.Room(tmp_path)
    room.open({"seed": 1})
    (tmp_path / "settings.json").write_text('{"seed"')
    with pytest.raises(InputError, match=r"settings\.json: cannot be read"):
        room.open({"seed": 1})
    assert [p.name for p in tmp_path.iterdir()] == ["settings.json"]


def test_a_revealed_secret_of_wrong_types_is_told(tmp_path):
    good = json.loads(draw(1, "single", "impedance", "inertia").to_json())
    path = tmp_path / "revealed.json"

    def refused(message, **fields):
        path.write_text(json.dumps(good | fields))
        with pytest.raises(InputError, match=message):
            own_trials(path)

    refused("effects is 'inertia', a list of names", effects="inertia")
    refused("base is 3, a table of finite numbers", base=3)
    refused("d2 is .*, a table of finite numbers", d2={"inertia": None})
    refused("seed is 'x', a whole number", seed="x")
    refused("kind is 'odd', one of none", kind="odd")
    refused("strength is .*, a table", strength={"inertia": 3})
    refused("ratio is nan, a finite number", ratio=float("nan"))
    path.write_text(json.dumps(good | {"setup": {"sweeps": 3}}))
    (trial,) = own_trials(path)
    with pytest.raises(InputError, match="no case can be made of this secret"):
        keeper.conceal(trial, tmp_path / "case")


def test_an_answer_of_ones_own_is_of_the_cases_model(tmp_path):
    def refused(message, **secret):
        folder = tmp_path / f"case{len(list(tmp_path.iterdir()))}"
        own_case(folder, **secret)
        with pytest.raises(InputError, match=message):
            own_trials(folder)

    refused("names 'inertia' 2 times, once is wanted", effects=["inertia", "inertia"])
    refused("all finite", base={"R_e": float("inf")})
    refused("all finite", base={"R_e": True})
    refused("base has no 'k_D' in electrodynamic_transducer", base={"k_D": 1.0})


@pytest.mark.parametrize(
    "words",
    [["--html", "a.html"], ["--markdown", "a.md"], ["--trials", "100"], ["--seed", "1"], ["--jobs", "1"],
     ["--noise", "white"], ["--domain", "gmm"], ["--keep", "proof"], ["--real", "."], ["--quick"]],
)  # fmt: skip
def test_what_says_nothing_of_one_secret_is_refused(words, tmp_path, capsys):
    own_case(tmp_path / "a")
    secret = str(tmp_path / "a" / "secret.json")
    assert main(["prove", "--secret", secret, *words]) == 2
    said = capsys.readouterr().err
    assert f"{words[0]}: of no effect" in said and said.count("\n") == 1


@pytest.mark.parametrize("words", [["--trials", "3"], ["--seed", "1"], ["--domain", "gmm"], ["--quick"]])
def test_what_says_nothing_of_given_secrets_is_refused(words, tmp_path, capsys):
    own_case(tmp_path / "a")
    assert main(["prove", "--secret", str(tmp_path), *words]) == 2
    said = capsys.readouterr().err
    assert f"{words[0]}: of no effect with a folder" in said and said.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "trials", "real"),
    [
        ([], 100, proving.MEASURED_CASES),
        (["--quick"], proving.QUICK, None),
        (["--quick", "--trials", "100"], 100, None),
        (["--quick", "--trials", "3", "--real", "."], 3, Path(".")),
    ],
)
def test_quick_leaves_what_is_given(words, trials, real, monkeypatch):
    asked = []
    monkeypatch.setattr(proving, "prove", lambda wish: asked.append(wish) or 0)
    assert main(["prove", *words]) == 0
    assert (asked[0].trials, asked[0].real) == (trials, real)


def test_a_run_goes_on_when_nobody_reads_what_it_prints(tmp_path):
    """Its reader is gone before the first line; what is written at the end is there all the same."""
    script = (
        "import sys, time; from modelgen.cli import main, proving\n"
        "def work(wish, tasks, room, to):\n"
        "    for _ in range(3): to.print('x' * 100)\n"
        "    return 0\n"
        "proving._work = work\n"
        "status = main(sys.argv[1:])\n"
        "sys.stdout.flush(); sys.exit(status)"
    )
    told = tmp_path / "told.json"
    words = ["prove", "--quick", "--keep", str(tmp_path / "room"), "--json", str(told)]
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-c", script, *words], stdout=write, stderr=subprocess.PIPE, text=True
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(told.read_text())["schema"] == "modelgen.proof/1"
