"""Records with gaps: what nobody recorded is no physics, and a memory does not go on through it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import modelgen as mg
from modelgen.models import load
from modelgen.recordings import Case, Noise, Recording
from modelgen.recordings.gaps import gaps

STEP, NOISE = 2e-3, 2e-3
TRUTH = {"k_D": 0.6, "c_D": 0.02, "h_D": 0.3, "rho": 2.5, "F_0": 0.1}


def rubbed(n: int = 6000, seed: int = 1) -> dict[str, np.ndarray]:
    """A spring, a dashpot and Dahl friction, its slip's law in closed form, in a motion of three tones."""
    t = STEP * np.arange(n)
    tones = [(0.9, 1.3, 0.2), (0.5, 2.9, 1.1), (0.3, 4.7, 2.3)]
    z = sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in tones)
    v = sum(2 * np.pi * f * a * np.cos(2 * np.pi * f * t + p) for a, f, p in tones)
    fine = STEP * np.arange((n - 1) * 16 + 1) / 16
    path = sum(a * np.sin(2 * np.pi * f * fine + p) for a, f, p in tones)
    w, out = 0.0, np.zeros(n)
    for k, x in enumerate(np.diff(path), 1):
        w = np.sign(x) + (w - np.sign(x)) * np.exp(-TRUTH["rho"] * abs(x))
        if k % 16 == 0:
            out[k // 16] = w
    noise = NOISE * np.random.default_rng(seed).standard_normal(n)
    F = TRUTH["k_D"] * z + TRUTH["c_D"] * v + TRUTH["h_D"] * out + TRUTH["F_0"] + noise
    return {"t": t, "z": z, "F": F}


def cut(first: int, last: int) -> Case:
    """The record without the samples between `first` and `last`."""
    x = {n: np.delete(y, slice(first, last)) for n, y in rubbed().items()}
    record = Recording("a", None, "fit", {"t": x["t"], "z": x["z"]}, {"F": x["F"]})
    held = {"b": 1.0, "r_0": 0.0}
    return Case(None, "modified_dahl", (record,), constants=held, noise=Noise(sigma={"F": NOISE}))


def test_a_record_with_a_gap_is_fitted_in_pieces() -> None:
    model = load("modified_dahl")
    found = mg.fit(model, cut(2000, 2350))
    assert found.rms_over_noise["fit"] == pytest.approx(1.0, abs=0.05)
    known = {e.name: e for e in found.parameters}
    for name in ("k_D", "c_D", "h_D", "rho"):
        assert known[name].value == pytest.approx(TRUTH[name], abs=5 * known[name].std)
    later = next(r.file for r in found.recordings if r.file != "a")
    assert later == "a from 4.7 s" and f"r_0[{later}]" in known
    assert any("'a' has a gap: 0.702 s after t = 3.998 s" in w for w in found.warnings)


def test_a_gap_is_no_physics() -> None:
    found = mg.diagnose(cut(2000, 2350), load("modified_dahl"))
    assert found.adequate and found.after.fit_over_noise < 1.05
    assert sum("has a gap" in n for n in found.notes) == 1


def test_pieces_of_a_whole_record_are_the_record() -> None:
    from modelgen.fit.pieces import in_pieces

    case = cut(0, 0)
    assert in_pieces(load("modified_dahl"), case).recordings == case.recordings


def test_too_little_after_a_gap_is_left_out() -> None:
    from modelgen.fit.pieces import in_pieces

    (whole,) = in_pieces(load("modified_dahl"), cut(5600, 5990)).recordings
    assert whole.n == 5600 and "10 samples in shorter pieces than 20 do not count" in whole.warnings[0]


def test_what_is_left_after_a_first_piece_too_short_begins_anywhere() -> None:
    from modelgen.fit.pieces import in_pieces

    case = in_pieces(load("modified_dahl"), cut(10, 400))
    (rest,) = case.recordings
    assert rest.inputs["t"][0] == pytest.approx(400 * STEP) and "r_0" not in rest.constants
    assert "r_0" not in case.constants and "r_0" in case.bounds


def test_steps_that_grow_and_a_motion_at_rest_are_no_gaps() -> None:
    t = np.geomspace(1e-3, 1e3, 400)
    assert gaps(t, [np.sin(t / 200)]) == []
    t = np.concatenate([np.arange(100.0), 1000 + np.arange(100.0)])
    assert gaps(t, [np.where(t < 500, np.minimum(t, 50.0), 50.0)]) == []
    assert gaps(t, [np.full(200, 0.1)]) == []


def test_times_that_are_none_are_left_to_who_refuses_them() -> None:
    t = np.concatenate([[0.0, 0.0], 100 + np.arange(50.0)])
    assert gaps(t, [np.sin(t)]) == []
    assert gaps(-np.arange(100.0), [np.sin(np.arange(100.0))]) == []


def test_a_state_that_begins_with_no_parameter_goes_on_through_a_gap() -> None:
    from modelgen.fit.pieces import in_pieces
    from modelgen.language import Equation, Input, Model, Parameter, State, Symbol

    t, P = Input("t", "s"), Input("P", "W")
    G, C = Parameter("G", "W/K", 0.5, (0.01, 5.0)), Parameter("C", "J/K", 20.0, (1.0, 100.0))
    T = State("T", 0, rate=(P - G * Symbol("T", real=True)) / C, unit="K")
    heater = Model("heater", (t, P), (G, C), (T, Equation("rise", T.symbol, "K")), ("rise",))
    x = np.delete(np.arange(400.0), slice(150, 200))
    record = Recording("a", None, "fit", {"t": x, "P": 10 + 5 * np.sin(x / 9)}, {"rise": np.sin(x)})
    (whole,) = in_pieces(heater, Case(None, "heater", (record,))).recordings
    assert whole.n == 350 and "left as it is" in whole.warnings[0]


def test_what_is_held_out_ends_at_a_gap_where_no_start_is_free() -> None:
    from modelgen.fit.pieces import in_pieces

    whole, gap = cut(0, 0), cut(2000, 2350)
    held = Recording("h", None, "holdout", gap.fit[0].inputs, gap.fit[0].outputs)
    case = in_pieces(load("modified_dahl"), replace(whole, recordings=(*whole.recordings, held)))
    assert [(r.name, r.n) for r in case.recordings] == [("a", 6000), ("h", 2000)]
    assert case.constants == whole.constants and "has a gap" in case.holdout[0].warnings[0]
    both = in_pieces(load("modified_dahl"), replace(gap, recordings=(*gap.recordings, held)))
    assert [r.name for r in both.holdout] == ["h", "h from 4.7 s"]


@given(st.integers(30, 300), st.integers(60, 400))
def test_a_gap_is_found_wherever_it_is(first: int, long: int) -> None:
    t = np.delete(1e-2 * np.arange(1000), slice(first, first + long))
    assert gaps(t, [np.sin(7 * t) + 0.4 * np.sin(17.3 * t)]) == [first - 1]
