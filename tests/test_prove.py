"""modelgen prove: fair draws, sealed before the diagnosis, scored rightly, nothing lost."""

import hashlib
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from modelgen.cli import main
from modelgen.errors import InputError
from modelgen.prove import dictionary, discrepancy, followup, gallery, keeper, oracle, scores, studies
from modelgen.prove import run as running
from modelgen.prove.diagnoser import Answer, Diagnoser
from modelgen.prove.leave_out import leave_one_out
from modelgen.prove.own import opened, own_trials
from modelgen.prove.plan import KIND_DECK, plan
from modelgen.prove.real import EXAMPLE
from modelgen.prove.records import Record, records, write_records
from modelgen.truths import Secret, draw, drawing, write_case
from modelgen.truths.further import further
from modelgen.truths.secret import DOMAINS, NOISES

CONTRACT = [
    "contact_damping",
    "structural_damping",
    "power_law_viscoelasticity",
    "maxwell_branch",
    "cubic_stiffness",
    "asymmetric_stiffness",
    "payne_softening",
    "stress_softening",
    "quadratic_damping",
    "inertia",
    "second_dahl_element",
    "stribeck_friction",
    "dahl_exponent",
    "backlash",
    "end_stop",
    "magnetic_pull",
    "offset_drift",
    "temperature_drift",
    "sensor_delay",
    "force_sensor_lag",
    "semi_inductance",
    "eddy_shunt",
    "coil_capacitance",
    "coil_ac_resistance",
    "leakage_inductance",
    "permeability_relaxation",
    "second_mode",
    "distributed_rod",
    "radiation_load",
    "contact_compliance",
]


def test_every_effect_and_noise_has_its_turn():
    tasks = plan(600, 3)
    assert tasks[:50] == plan(50, 3)
    single = {t.effects[0] for t in tasks if t.kind == "single"}
    assert single == set(CONTRACT)
    novel = {t.effects[0] for t in tasks if t.kind == "novel"}
    assert {"novel:position_periodic", "novel:mains_hum", "novel:cavity_comb", "novel:cable_trap",
            "novel:clipped_sensor"} <= novel  # fmt: skip
    assert {t.noise for t in tasks} == set(NOISES)
    assert {t.kind for t in tasks[: len(KIND_DECK)]} == set(KIND_DECK)
    with pytest.raises(InputError, match="did you mean 'coloured'"):
        plan(1, 1, ["colored"])
    with pytest.raises(InputError, match="stiffness has no noise of kind calibration"):
        plan(1, 1, ["calibration"], ["stiffness"])


@pytest.mark.parametrize("domain", DOMAINS)
def test_drawn_to_an_rms_ratio(domain):
    secret = draw(5, "single", domain, "inertia", ratio=3.0)
    assert secret.ratio == pytest.approx(3.0, rel=0.01)
    assert 0.9 < secret.r2 < 1
    assert set(secret.bent_std) == set(secret.bent)


class Listening:
    """A diagnoser that notes what it is told and shown, and says that nothing is missing."""

    def __init__(self):
        self.told, self.shown = [], []

    def diagnose(self, case):
        self.told.append(case)
        self.shown.append({p.name: p.read_text() for p in case.parent.iterdir()})
        verdict = {"adequate": True, "effects": [], "parameters": {}, "fit": {}}
        (case.parent / "verdict.json").write_text(json.dumps(verdict))
        write_records(case.parent / "residuals.npz", [])
        return Answer("", 0.1, 0.1)


def test_a_diagnosing_process_that_hangs_or_dies_is_replaced(tmp_path):
    with Diagnoser(limit=0.05) as slow:
        answer = slow.diagnose(tmp_path / "case.toml")  # it can't even start in so short a time
    assert answer.error == "no verdict within 0.05 s"
    with Diagnoser(limit=60.0) as diagnoser:
        diagnoser._process.kill()
        assert diagnoser.diagnose(tmp_path / "case.toml").error == "the diagnosing process ended"
        assert "case.toml" in diagnoser.diagnose(tmp_path / "case.toml").error  # a new one says what is wrong


def run_listening(folder, monkeypatch, tasks=None, after=lambda row: None):
    monkeypatch.setattr(keeper, "rivals", lambda *_: {"diagnosis": {"before": 1.0, "holdout": 1.0}})
    ears = Listening()

    class Opened:
        def __init__(self, limit):
            pass

        def __enter__(self):
            return ears

        def __exit__(self, *why):
            pass

    monkeypatch.setattr(running, "Diagnoser", Opened)
    monkeypatch.setattr(running, "_keepers", ThreadPoolExecutor)
    events = []

    def sealed(row):
        assert len(ears.told) == len([e for e in events if e[0] == "sealed"])  # the digest comes first
        events.append(("sealed", row["sha256"]))

    def done(row):
        events.append(("done", row["sha256"]))
        after(row)

    tasks = tasks or plan(2, 1, ["white"], ["impedance"])
    rows = running.run(tasks, running.Room(folder), 1, 9.0, sealed, done)
    return rows, ears, events


def test_sealed_before_a_diagnosis_that_sees_the_recordings_alone(tmp_path, monkeypatch):
    rows, ears, events = run_listening(tmp_path, monkeypatch)
    assert [k for k, _ in events] == ["sealed", "done"] * 2
    for row, shown in zip(rows, ears.shown, strict=True):
        assert hashlib.sha256(row["secret"].encode()).hexdigest() == row["sha256"]
        assert set(shown) == {"case.toml", *(f"rec_{i}.csv" for i in range(1, len(shown)))}
        nonce = json.loads(row["secret"])["nonce"]
        assert not any(nonce in text or e in text for text in shown.values() for e in row["effects"])
    assert [line.split()[1] for line in (tmp_path / "sealed.txt").read_text().splitlines()] == [
        r["sha256"] for r in rows
    ]


def test_interrupted_and_gone_on(tmp_path, monkeypatch):
    def stop(row):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_listening(tmp_path, monkeypatch, after=stop)
    with open(tmp_path / "trials.jsonl", "a") as file:
        file.write('{"index": 1, "sha')  # cut off
    rows, ears, _ = run_listening(tmp_path, monkeypatch)
    assert len(ears.told) == 1
    assert [r["index"] for r in rows] == [0, 1]
    room = running.Room(tmp_path)
    room.open({"seed": 1, "noise": NOISES})
    room.open({"seed": 1, "noise": NOISES})
    with pytest.raises(InputError, match="another seed"):
        room.open({"seed": 2, "noise": NOISES})
    with pytest.raises(InputError, match="no folder to write in"):
        running.Room(tmp_path / "trials.jsonl").open({"seed": 1})


def row(**marks):
    base = {
        "effects": ["inertia"],
        "kind": "single",
        "d2": {"inertia": 100.0},
        "first": "inertia",
        "error": "",
        "named": True,
        "extra": 0,
        "family": True,
        "set_size": 1,
        "wall": 1.0,
        "cpu": 1.0,
        "ratio": 1.5,
        "rivals": {},
    }
    return base | marks


def test_shares_have_exact_intervals():
    s = scores.share([True] * 57 + [False] * 3 + [None] * 9)
    assert (s.hits, s.n) == (57, 60)
    assert (s.low, s.high) == pytest.approx((0.8608, 0.9896), abs=1e-4)  # Clopper and Pearson
    none = scores.share([False] * 50)
    assert none.high == pytest.approx(1 - 0.025 ** (1 / 50))


def test_goals_count_what_they_say():
    rows = [row(), row(named=False, first="second_mode", set_size=2), row(d2={"inertia": 35.0}, first="")]
    told = {b["goal"].key: b["share"] for b in scores.board(rows)}
    assert (told["power"].hits, told["power"].n) == (2, 2)  # d² of 35 asks for nothing
    assert (told["named, told"].hits, told["named, told"].n) == (2, 2)
    pair = row(effects=["inertia", "backlash"], first="backlash")
    assert studies.confusion([pair, row(first="unknown_force")]) == {
        ("backlash", "backlash"): 1, ("inertia", "unknown"): 1,
    }  # fmt: skip
    bins = studies.calibration(
        [row(claimed=0.9), row(claimed=0.88, named=False), row(claimed=0.3, named=False)]
    )
    assert [(round(b["stated"], 2), b["right"].hits, b["right"].n) for b in bins] == [
        (0.3, 0, 1),
        (0.89, 1, 2),
    ]
    assert studies.expected_error(bins) == pytest.approx((0.3 + 2 * 0.39) / 3)


def test_power_is_counted_over_d2_and_faint_effects_in_no_score():
    faint = row(d2={"inertia": 10.0}, first="", named=False, family=False, rivals={"gp": {"found": True}})
    rows = [faint, row(rivals={"gp": {"found": False}}), row(rivals={"gp": {"found": True}})]
    assert scores.by_depth(faint) == scores.FAINT
    assert {b["goal"].key: b["share"] for b in scores.board(rows)}["family"].n == 2
    curve = studies.power(rows)
    assert [(round(p["d2"]), p["found"].hits, p["found"].n) for p in curve["modelgen"]] == [
        (10, 0, 1),
        (100, 2, 2),
    ]
    assert [(p["found"].hits, p["found"].n) for p in curve["gp"]] == [(1, 1), (1, 2)]


def test_a_wrong_name_counts_however_well_it_predicts_and_new_kinds_have_rows_of_their_own():
    marks = {"unknown": False, "misnamed": True, "named": None, "family": None}
    novel = row(effects=["novel:cavity_comb"], kind="novel", first="second_mode") | marks
    as_good, worse = ({"rivals": {"diagnosis": {"holdout": x}}} for x in (1.01, 4.0))
    right = novel | as_good | {"unknown": True, "misnamed": False, "first": "unknown_force"}
    rows = [novel | as_good, novel | worse, right, right | {"effects": ["novel:knock"]}]
    told = {b["goal"].key: (b["share"].hits, b["share"].n) for b in scores.board(rows)}
    assert (told["unknown"], told["misnamed"]) == ((1, 3), (2, 3))
    assert (told["unknown, new"], told["misnamed, new"]) == ((1, 1), (0, 1))
    old, new, tied = studies.strangers(rows)
    assert ((old.hits, old.n), (new.hits, new.n), tied) == ((1, 3), (1, 1), 1)


def test_a_tie_that_the_verdict_admits_is_told_from_an_error():
    wrong = {"named": False, "first": "second_mode", "noise": "white", "index": 3}
    rows = [row(**wrong, in_set=True), row(**wrong, in_set=False), row()]
    (mixed,) = studies.mixed_up(rows)
    assert (mixed["concealed"], mixed["named"], mixed["n"], mixed["said"]) == ("inertia", "second_mode", 2, 1)


def test_a_file_that_the_diagnosis_should_not_read_is_noticed(tmp_path):
    """In a process of its own, as an audit hook is there to stay."""
    case = tmp_path / "case"
    case.mkdir()
    cache = tmp_path / "kernels"
    cache.mkdir()
    for path in (case / "rec_1.csv", cache / "kernel.c", tmp_path / "secret.json"):
        path.write_text("f [Hz]")
    script = (
        "import sys; from pathlib import Path; from modelgen.prove.watch import Watch\n"
        "watch, folder = Watch(), Path(sys.argv[1])\n"
        "with watch.on(folder) as foreign:\n"
        "    (folder / 'rec_1.csv').read_text(); (folder / 'own.txt').write_text('x')\n"
        "    import decimal; open(sys.executable, 'rb').close()\n"
        "    (folder.parent / 'kernels' / 'kernel.c').read_text()\n"
        "    own = set(foreign)\n"
        "    (folder.parent / 'secret.json').read_text()\n"
        "print('\\n'.join(foreign))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(case)], capture_output=True, text=True, check=True,
        env={**os.environ, "MODELGEN_CACHE": str(cache)},
    )  # fmt: skip
    assert done.stdout.split() == [str(tmp_path / "secret.json")]


def trace(t, z, white, holdout=False):
    inputs = {"t": t, "z": z}
    white = np.atleast_2d(white)
    return Record(holdout, white, inputs, z, z, z, white, white, white)


def test_simpler_methods_find_what_they_can_and_nothing_in_noise():
    rng, t = np.random.default_rng(1), np.arange(0, 20, 0.02)
    z = np.sin(2 * np.pi * 0.3 * t)
    noise = rng.standard_normal(len(t))
    for holdout, cubic in ((trace(t, z, noise + 4 * z**3, True), trace(t, z, noise + 4 * z**3)),):
        if dictionary.available():
            found = dictionary.explain([cubic], [holdout], {})
            assert found["found"]
            assert np.mean(found["rest"][0] ** 2) < 1.1
        gp = discrepancy.explain([cubic], [holdout])
        assert gp["found"] and np.mean(gp["rest"][0] ** 2) < 1.2
    assert not discrepancy.explain([trace(t, z, noise)], [])["found"]


@pytest.mark.parametrize("domain", ["impedance", "force", "stiffness"])
def test_the_true_law_is_as_good_as_can_be(domain, tmp_path):
    """Against recordings as they are written, the noise-free truth has a hold-out ratio of one, but for what
    the true law's numbers are off when they are fitted to the noise."""
    secret = draw(2, "single", domain, "inertia", noise="outliers")
    write_case(secret, tmp_path)
    scene = drawing.scene_of(secret)
    clean = scene.simulate(secret.strength)
    made = []
    for i, e in enumerate(secret.setup.get("sweeps", secret.setup.get("records"))):
        x = np.loadtxt(tmp_path / f"rec_{i + 1}.csv", delimiter=",", skiprows=1).T
        data = x[1] + 1j * x[2] if domain == "impedance" else x[2] if domain == "force" else x[1]
        truth = rows(clean[i])
        size = np.abs(data) if domain == "impedance" else np.ones(x.shape[1])
        channels = rows(data) if domain == "impedance" else x[2:3] if domain == "force" else x[1:3]
        left = truth - channels
        inputs = {"f": x[0]}
        if domain == "force":  # the law is evaluated on the motion as it was
            inputs = dict(zip("zv", map(scene.motions[i].recorded, scene.motions[i].zva), strict=False))
        far = (1.02 * truth - channels) / size
        made.append(
            Record(e["role"] == "holdout", far, inputs, data, data, data, channels, left, left / size)
        )
    fit, held = [r for r in made if not r.holdout], [r for r in made if r.holdout]
    reference = oracle.of_truth(secret, fit, held)
    count = 9 * len(held) / sum(r.channels.size for r in fit) * (domain != "force")  # numbers, over samples
    assert reference.ratio([r.left for r in held]) == pytest.approx(1.0, abs=1e-6 + 2 * count)
    assert reference.ratio([oracle.in_units(r, r.white) for r in held]) > 2


def rows(x):
    return np.array([x.real, x.imag]) if np.iscomplexobj(x) else np.atleast_2d(x)


def test_records_are_read_as_written(tmp_path):
    f, Z = np.arange(3.0), np.array([1 + 1j, 2, 3])
    white = np.ones((2, 3))
    wrote = SimpleNamespace(role="holdout", white_before=white, outliers=np.array([False, True, False]),
                            data=Z, before=Z + 1, after=Z, channels=rows(Z), left=0 * rows(Z),
                            white_after=0 * white, inputs={"f": f})  # fmt: skip
    write_records(tmp_path / "r.npz", [wrote])
    (read,) = records(tmp_path / "r.npz")
    assert read.holdout and np.isnan(read.white[:, 1]).all() and read.white[0, 0] == 1
    np.testing.assert_array_equal(read.inputs["f"], f)


def test_a_picture_keeps_the_spike_and_leaves_out_the_outlier(tmp_path):
    t = np.arange(3000.0)
    off = np.where(t == 777, 9.0, 0.5) * 1e-3
    outliers = t == 1500
    wrote = SimpleNamespace(role="fit", white_before=off[None] / 1e-3, outliers=outliers, data=np.sin(t),
                            before=np.sin(t) + off, after=np.sin(t), channels=np.sin(t)[None],
                            left=0 * off[None], white_after=0 * off[None], inputs={"t": t})  # fmt: skip
    write_records(tmp_path / "residuals.npz", [wrote])
    shown = gallery.glance(tmp_path)
    assert len(shown["x"]) == gallery.POINTS
    assert max(shown["before"]) == pytest.approx(9.0) and shown["x"][np.argmax(shown["before"])] == 777
    assert max(map(abs, shown["after"])) == 0 and 1500 not in shown["x"]


SENTENCES = {
    "impedance": ["a sweep from 4 Hz to 100 kHz", "the same sweep averaged 16 times",
                  "a second sweep with 50% more mass (M_m = 0.241 kg)",
                  "the same sweep with the moving side blocked"],
    "stiffness": ["a sweep from 0.02 Hz to 15 Hz", "the same sweep at A_z = 1.2 mm",
                  "the same sweep in the other direction"],
    "force": ["the same motion 5 times as fast", "the same motion 5 times as slow",
              "the same motion at 1.5 times the amplitude (± 0.8 mm now)",
              "the same motion at a third of the amplitude (± 0.8 mm now)",
              "the same motion about a mean that is higher by 0.8 mm",
              "a step from end to end of the stroke, held for 11 s",
              "the same motion three times over, 36 s in one record"],
}  # fmt: skip


@pytest.mark.parametrize(("domain", "sentence"), [(d, s) for d, group in SENTENCES.items() for s in group])
def test_a_proposed_recording_is_added_and_the_others_stay(domain, sentence, tmp_path):
    secret = draw(4, "single", domain, "second_mode", noise="coloured")
    more = further(secret, sentence + " would separate a from b by 20 (chi-square)")
    assert more is not None
    assert further(secret, "no recording of this menu would tell them apart") is None
    for name, s in (("before", secret), ("after", more)):
        write_case(s, tmp_path / name)
    old = sorted(p.name for p in (tmp_path / "before").glob("*.csv"))
    for name in old:
        assert (tmp_path / "before" / name).read_bytes() == (tmp_path / "after" / name).read_bytes()
    new = np.loadtxt(tmp_path / "after" / f"rec_{len(old) + 1}.csv", delimiter=",", skiprows=1)
    assert np.isfinite(new).all() and len(new) > 20
    assert (tmp_path / "after" / "case.toml").read_text().count("[[recording]]") == len(old) + 1


def test_a_secret_of_ones_own_is_checked(tmp_path, capsys):
    def refused(message, **fields):
        path = tmp_path / "secret.json"
        path.write_text(
            json.dumps({"schema": "modelgen.secret/1", "effects": [], "case": "case.toml"} | fields)
        )
        with pytest.raises(InputError, match=message):
            own_trials(path)

    refused("case is 'case.toml', the path")
    (tmp_path / "case.toml").write_text("")
    refused("effects is 'inertia', a list", effects="inertia")
    refused("no field 'efects', did you mean 'effects'", efects=[])
    refused("a table of true parameter values", base=3)
    refused("no effect 'inertai', did you mean 'inertia'", effects=["inertai"])
    assert main(["prove", "--secret", str(tmp_path / "none.json")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    revealed = tmp_path / "revealed.json"
    revealed.write_text(draw(1, "single", "impedance", "inertia").to_json())
    (trial,) = own_trials(revealed)
    assert (opened(trial.text, trial.sha256).effects, trial.case) == (("inertia",), None)


def test_leave_one_out_of_the_papers_table():
    """A spring and a dashpot miss a left-out frequency by 10 to 11.5 %, a springpot by 0.15 to 1.75 %."""
    found = leave_one_out(EXAMPLE)
    assert len(found) == 4
    assert all(0.09 < t.before < 0.115 and t.after < 0.018 for t in found)
    assert sorted(round(t.exponent, 2) for t in found) == [0.14, 0.15, 0.17, 0.17]


def own_case(folder, **secret):
    folder.mkdir()
    for path in (EXAMPLE.parent / "concealed").iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    text = json.dumps(json.loads((folder / "secret.json").read_text()) | secret)
    (folder / "secret.json").write_text(text)
    return hashlib.sha256(text.encode()).hexdigest()


def test_trials_of_ones_own_are_scored_when_their_secret_is_laid_open(tmp_path, monkeypatch):
    """Three folders, one of them with the digest in the secret's place: diagnosed once, and scored later."""
    mine = tmp_path / "mine"
    mine.mkdir()
    (tmp_path / "room" / "nothing").mkdir(parents=True)
    digest = own_case(mine / "a")
    own_case(mine / "b", effects=[])
    assert own_case(mine / "c") == digest  # which the name tells apart
    text = (mine / "c" / "secret.json").read_text()
    (mine / "c" / "secret.json").unlink()
    (mine / "c" / "secret.sha256").write_text(f"{digest}  secret.json\n")

    def rows():
        return run_listening(tmp_path / "room", monkeypatch, tasks=own_trials(mine))

    first, ears, _ = rows()
    assert [r["name"] for r in first] == ["a", "b", "c"]
    assert all("secret.json" not in shown and "secret.sha256" not in shown for shown in ears.shown)
    assert [r.get("withheld", False) for r in first] == [False, False, True]
    assert [r.get("named") for r in scores.usable(first)] == [False, None]
    assert first[1]["alarm"] is False
    (mine / "c" / "secret.json").write_text(text)
    then, ears, _ = rows()
    assert not ears.told  # no verdict is given twice
    assert then[2]["sha256"] == digest and then[2]["named"] is False
    (mine / "c" / "secret.json").write_text(text + " ")
    with pytest.raises(InputError, match="its SHA-256 is"):
        own_trials(mine)
    with pytest.raises(InputError, match=r"no folder in it holds a secret\.json"):
        own_trials(tmp_path / "room" / "nothing")


@pytest.mark.slow
def test_the_shipped_secret_is_found(capsys, tmp_path):
    told = tmp_path / "told.json"
    assert (
        main(["prove", "--secret", str(EXAMPLE.parent / "concealed" / "secret.json"), "--json", str(told)])
        == 0
    )
    said = capsys.readouterr().out
    assert said.index("sealed") < said.index("diagnosed") < said.index("revealed")
    row = json.loads(told.read_text())
    assert row["effects"] == ["quadratic_damping"] and row["family"] and row["port"]


@pytest.mark.slow
def test_trials_from_end_to_end(tmp_path, capsys):
    """Three trials through the command: sealed, diagnosed elsewhere, revealed, scored, shown, resumable."""
    files = {k: tmp_path / f"proof.{k}" for k in ("html", "json", "markdown")}
    words = ["prove", "--trials", "3", "--seed", "5", "--jobs", "1", "--domain", "impedance", "--noise",
             "white", "--keep", str(tmp_path / "room"), "--real", str(tmp_path)]  # fmt: skip
    assert main([*words, *(w for k, f in files.items() for w in (f"--{k}", str(f)))]) == 0
    said = capsys.readouterr().out
    whole = json.loads(files["json"].read_text())
    assert whole["schema"] == "modelgen.proof/1"
    assert whole["trials"] == 3
    for r in whole["rows"]:
        assert said.index(r["sha256"]) < said.index(f"{r['index']:5d} revealed")
        assert hashlib.sha256(r["secret"].encode()).hexdigest() == r["sha256"]
        assert Secret.from_json(r["secret"]).domain == "impedance"
    html = files["html"].read_text()
    assert "<script" not in html and "http://" not in html.replace("http://www.w3.org", "")
    assert all(r["sha256"] in html for r in whole["rows"])
    assert main(words) == 0  # nothing left to do
    assert "sealed" not in capsys.readouterr().out
    shown = tmp_path / "shown.md"
    room = ["--keep", str(tmp_path / "room"), "--real", str(tmp_path), "--markdown", str(shown)]
    assert main(["prove", "--trials", "0", *room]) == 0
    assert "modelgen prove --trials 3 --seed 5 --noise white --domain impedance" in shown.read_text()
    assert Path(tmp_path / "room" / "trials.jsonl").read_text().count("\n") == 3


@pytest.mark.parametrize(
    ("effect", "equivalents", "open_"),
    [
        ("log_creep", ["structural_damping"], False),  # it lies between the two: both names are right
        ("log_creep", ["maxwell_branch"], True),
        ("cubic_stiffness", [], False),
    ],
)
def test_a_further_recording_has_wrong_names_to_exclude(effect, equivalents, open_):
    domain = "impedance" if effect == "log_creep" else "force"
    secret = draw(5, "variant" if effect == "log_creep" else "single", domain, effect)
    first = {"id": secret.effects[0], "equivalents": equivalents}
    row = {
        "named": True,
        "set_size": 1 + len(equivalents),
        "domain": domain,
        "secret": secret.to_json(),
        "verdict": {"effects": [first]},
    }
    assert followup.ambiguous(row) == open_
