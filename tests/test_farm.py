"""Executors: the same results on threads, processes and a Dask cluster, one worker of which is killed."""

from __future__ import annotations

import json
import os
import pickle
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import modelgen.models as models
from modelgen.api import open_case
from modelgen.cli import main
from modelgen.codegen import build
from modelgen.errors import InputError, ToolError
from modelgen.fit import PSO, MultiStart, farm, fit_cases, profile, profiles
from modelgen.fit.experiment import experiment
from modelgen.fit.fitting import fit
from modelgen.fit.montecarlo import propagate
from modelgen.fit.series import make_series
from modelgen.language import Equation, Model, Parameter
from modelgen.recordings import Case, Recording

ROOT = Path(__file__).parents[1]


def speaker(seed: int) -> tuple[Model, Case]:
    """A moving coil's impedance with a little noise."""
    model = models.electrodynamic_transducer
    rng = np.random.default_rng(seed)
    f = np.geomspace(20, 2000, 40)
    Z = np.asarray(build(model)(f=f, Bl=6.0 + 0.1 * seed))
    Z = Z + 1e-3 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    return model, Case(None, model.id, (Recording("sweep", None, "fit", {"f": f}, {"Z": Z}),))


def values(result: Any) -> list[float]:
    return [e.value for e in result.parameters]


def test_starts_on_an_executor_end_where_they_end_here() -> None:
    model, case = speaker(0)
    for method in (None, MultiStart(starts=6), MultiStart(PSO(8, iterations=10), 3)):
        found = []
        for workers in (1, 3):
            with ThreadPoolExecutor(workers) as pool:
                found.append(fit(model, case, method, seed=3, executor=pool))
        assert values(found[0]) == values(found[1])
        if not isinstance(method, MultiStart) or not isinstance(method.inner, PSO):
            assert values(found[0]) == pytest.approx(values(fit(model, case, method, seed=3)), rel=1e-6)


def test_a_method_of_one_start_has_nothing_to_spread(capsys: pytest.CaptureFixture[str]) -> None:
    case = ROOT / "examples" / "mre_elastomer" / "case.toml"
    assert main(["fit", str(case), "--method", "ipopt", "--dask", "tcp://127.0.0.1:9"]) == 2
    assert "and 'ipopt' is none" in capsys.readouterr().err
    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match="of one start"):
        fit(*speaker(0), PSO(4), executor=pool)


def exits(code: int) -> None:
    os._exit(code)


def test_a_process_that_dies_is_told_in_one_line() -> None:
    with pytest.raises(ToolError, match="a worker process died"), farm.process_executor(1) as pool:
        pool.submit(exits, 9).result()


def test_profiles_on_an_executor_are_those_of_one_problem() -> None:
    model, case = speaker(1)
    result = fit(model, case)
    problem = experiment(model, case, [make_series(model, case, r) for r in case.fit]).problem()
    with ThreadPoolExecutor(2) as pool:
        found = profiles(model, case, result, ("Bl", "R_m"), executor=pool)
    for p in found:
        alone = profile(problem, p.name, values(result), estimate_noise=True)  # none is stated
        assert (p.low, p.high) == (alone.low, alone.high)


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed", reason="Dask is not installed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as made:
        yield made


def half_square() -> Model:
    a, b = Parameter("a", "1", 2.0), Parameter("b", "1", 1.0)
    return Model("half_square", (), (a, b), (Equation("y", a * a / 2 + b),), ("y",))


def test_a_cluster_loses_nothing_when_a_worker_is_killed(cluster: Any) -> None:
    distributed = pytest.importorskip("distributed", reason="Dask is not installed")
    cases = [speaker(k) for k in range(12)]
    wanted = [values(fit(*c)) for c in cases]
    shot: list[tuple[int, int]] = []

    def shoot(watcher: Any) -> None:
        """Kill the first worker that holds a result and is busy with the next task."""
        pids = {w: watcher.submit(os.getpid, workers=[w], pure=False).result() for w in watcher.nthreads()}
        armed.set()
        while not shot:
            holds, busy = watcher.has_what(), watcher.processing()
            for worker, pid in pids.items():
                if holds.get(worker) and busy.get(worker):
                    shot.append((pid, len(holds[worker])))
                    os.kill(pid, signal.SIGKILL)
                    return

    armed = threading.Event()
    with (
        distributed.Client(cluster.scheduler_address, set_as_default=False) as watcher,
        farm.dask_executor(cluster.scheduler_address) as executor,
    ):
        hunter = threading.Thread(target=shoot, args=(watcher,), daemon=True)
        hunter.start()
        assert armed.wait(10)
        found = fit_cases(cases, executor=executor)
        hunter.join(10)
        ((pid, lost),) = shot
        assert lost >= 1 and pid not in watcher.run(os.getpid).values()
    assert [values(r) for r in found] == wanted


def test_monte_carlo_on_a_cluster(cluster: Any) -> None:
    draws = {"a": np.random.default_rng(0).normal(2.0, 0.1, 120_000)}
    function = build(half_square())
    with farm.dask_executor(cluster.scheduler_address) as executor:
        found = propagate(function, draws, executor)
    assert np.array_equal(found, propagate(function, draws))


def test_the_command_line_on_a_cluster(
    cluster: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    address = cluster.scheduler_address
    folder = ROOT / "examples" / "mre_elastomer"
    assert main(["fit", str(folder), "--dask", address, "--json", str(tmp_path / "all.json")]) == 0
    there = json.loads((tmp_path / "all.json").read_text())["cases"]
    model, case = open_case(folder / "s2_m1.toml")
    assert sorted(there) == ["case", "s1_m1", "s2_m0", "s2_m1"]
    here = fit(model, case)
    assert {n: p["value"] for n, p in there["s2_m1"]["parameters"].items()} == {
        e.name: e.value for e in here.parameters
    }
    assert "s1_m1" in capsys.readouterr().out


@pytest.mark.slow
def test_cases_are_diagnosed_on_a_cluster(cluster: Any, tmp_path: Path) -> None:
    case = ROOT / "examples" / "mre_elastomer" / "case.toml"
    out, file = tmp_path / "out", tmp_path / "all.json"
    words = ["diagnose", str(case), "--dask", cluster.scheduler_address, "--out", str(out)]
    assert main([*words, "--json", str(file)]) == 0
    verdict = json.loads(file.read_text())["cases"]["case"]
    assert verdict["schema"] == "modelgen.verdict/1"
    if verdict["extended_model"]:
        assert Path(verdict["extended_model"]).is_file()


def test_a_case_that_is_wrong_stops_no_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # processes take seconds to start
    monkeypatch.setattr("modelgen.cli.folders.process_executor", ThreadPoolExecutor)
    recording = '[[recording]]\nfile = "z.csv"\nrole = "fit"\n'
    (tmp_path / "bad.toml").write_text(f'model = "modified_dal"\n{recording}')
    f = np.geomspace(20, 2000, 40)
    Z = np.asarray(build(models.electrodynamic_transducer)(f=f))
    rows = "\n".join(f"{a:.9g},{z.real:.9g},{z.imag:.9g}" for a, z in zip(f, Z, strict=True))
    (tmp_path / "z.csv").write_text("f [Hz],Re Z [ohm],Im Z [ohm]\n" + rows + "\n")
    (tmp_path / "good.toml").write_text(f'model = "electrodynamic_transducer"\n{recording}')
    assert main(["fit", str(tmp_path), "--json", str(tmp_path / "all.json")]) == 2
    found = json.loads((tmp_path / "all.json").read_text())["cases"]
    assert found["good"]["parameters"]["R_e"]["value"] == pytest.approx(6.0, rel=1e-6)
    assert "did you mean 'modified_dahl'" in found["bad"]["error"]
    assert "did you mean 'modified_dahl'" in capsys.readouterr().err


def test_no_scheduler_and_no_case_are_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed")
    monkeypatch.setattr(farm, "TIMEOUT", "1s")
    case = str(ROOT / "examples" / "mre_elastomer" / "case.toml")
    assert main(["fit", case, "--dask", "tcp://127.0.0.1:9"]) == 2
    assert "--dask tcp://127.0.0.1:9: no scheduler answers" in capsys.readouterr().err
    assert main(["fit", str(tmp_path)]) == 2
    assert "holds no case" in capsys.readouterr().err


def test_a_model_travels_without_its_builder() -> None:
    _, case = speaker(0)
    there, back = pickle.loads(farm.packed(models.modified_dahl, case))
    assert there == models.modified_dahl and there.builder is None
    assert np.array_equal(back.fit[0].outputs["Z"], case.fit[0].outputs["Z"])
