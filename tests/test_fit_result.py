"""The fit result keeps the contract's schema, and its file is whole or absent."""

import json
import os
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from fit_problems import T, problem

from modelgen.errors import InputError, ToolError
from modelgen.files import write_atomically
from modelgen.fit import Estimate, FitResult, GaussNewton, RecordingFit, assess, estimates


@pytest.fixture
def result() -> FitResult:
    P = problem("k_D N A", 0, 10, 1, lambda x: (x[0] + x[1] * x[2] * T - 3 - 2 * T) / 0.1)
    found = GaussNewton().run(P)
    known = assess(P, found.theta)
    return FitResult(
        model="modified_dahl",
        parameters=estimates(P, found.theta, known),
        correlation=known.correlation,
        rank=known.rank,
        undetermined=known.undetermined,
        rms={"N": {"fit": 0.02, "holdout": 0.03}, "deg": {"fit": 1.0}},
        rms_over_noise={"fit": 1.01},
        seconds=0.1,
        reason=found.reason.value,
        method=GaussNewton().text,
        recordings=(RecordingFit("a.csv", "fit", 40, 0.02, "N", 1.01),),
    )


def test_json_has_the_contract_and_no_nan(result: FitResult) -> None:
    read = json.loads(result.to_json(), parse_constant=lambda name: pytest.fail(f"{name} in the JSON"))
    assert read["schema"] == "modelgen.fit/1" and read["model"] == "modified_dahl"
    assert read["parameters"]["k_D"]["value"] == pytest.approx(3)
    assert read["parameters"]["k_D"]["std"] > 0 and read["parameters"]["k_D"]["unit"] == "1"
    assert read["parameters"]["N"]["std"] is None and read["parameters"]["N"]["determined"] is False
    assert read["rms"] == {"fit": 0.02, "holdout": 0.03, "unit": "N"}
    assert read["rms_over_noise"] == {"fit": 1.01, "holdout": None}
    assert read["rms_by_unit"]["deg"] == {"fit": 1.0, "holdout": None}
    assert read["correlation"][0][1] is None and read["rank"] == 2
    assert read["recordings"][0]["file"] == "a.csv"
    assert isinstance(read["seconds"], float)


def test_parameters_are_found_by_name(result: FitResult) -> None:
    assert isinstance(result["k_D"], Estimate) and result.values["k_D"] == result["k_D"].value
    with pytest.raises(InputError, match="did you mean 'k_D'"):
        result["k_d"]


def test_writing_replaces_the_whole_file(result: FitResult, tmp_path) -> None:
    path = tmp_path / "fit.json"
    path.write_text("old")
    result.write_json(path)
    assert json.loads(path.read_text())["rank"] == 2
    assert os.listdir(tmp_path) == ["fit.json"]


def test_a_refused_file_is_one_line_and_leaves_nothing(result: FitResult, tmp_path, monkeypatch) -> None:
    with pytest.raises(InputError, match="does not exist"):
        result.write_json(tmp_path / "no" / "fit.json")
    with pytest.raises(InputError, match="is a folder"):
        result.write_json(tmp_path)
    (tmp_path / "fit.json").write_text("old")

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ToolError, match="No space left on device") as error:
        result.write_json(tmp_path / "fit.json")
    assert "\n" not in str(error.value)
    assert (tmp_path / "fit.json").read_text() == "old" and os.listdir(tmp_path) == ["fit.json"]


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs a folder that refuses even root")
def test_an_unwritable_folder_is_one_line() -> None:
    with pytest.raises(ToolError, match="cannot write /proc/nothing"):
        write_atomically("/proc/nothing.json", "x")


@pytest.mark.skipif(sys.platform == "win32", reason="links and FIFOs are POSIX")
def test_what_is_no_plain_file_stays_what_it_is(tmp_path) -> None:
    link, loop, pipe = tmp_path / "link.json", tmp_path / "loop.json", tmp_path / "pipe.json"
    link.symlink_to("real.json")
    for text in ("1", "2"):
        write_atomically(link, text)
        assert link.is_symlink() and (tmp_path / "real.json").read_text() == text
    os.mkfifo(pipe)
    with ThreadPoolExecutor(1) as pool:
        told = pool.submit(pipe.read_text)
        write_atomically(pipe, "3")
        assert told.result(10) == "3"
    assert pipe.is_fifo()
    loop.symlink_to("loop.json")
    with pytest.raises(InputError, match=r"loop.json: it is a link that leads nowhere"):
        write_atomically(loop, "4")
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "link.json", "loop.json", "pipe.json", "real.json"
    ]  # fmt: skip


def test_text_is_utf8_and_numbers_survive(tmp_path) -> None:
    path = tmp_path / "x.json"
    write_atomically(path, json.dumps({"µ": 0.1 + 0.2}, ensure_ascii=False))
    assert json.loads(path.read_bytes().decode("utf-8"))["µ"] == 0.1 + 0.2
