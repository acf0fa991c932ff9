"""The concealed truths: their numerics against closed forms and reference values, their depth and silence."""

import ast
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from modelgen import truths
from modelgen.truths import drawing, force, friction, gmm, impedance, memory, stiffness
from modelgen.truths import elements as el
from modelgen.truths.drive import Motion
from modelgen.truths.scoring import score
from modelgen.truths.secret import DOMAINS, NOISES_OF, NotDetectable, Secret, seal, unseal
from modelgen.truths.solve import nearest

FOLDER = Path(truths.__file__).parent
W = 2 * np.pi * np.geomspace(1, 1e4, 60)
ORDER = np.linspace(0, 1, len(W))


def test_imports_nothing_of_the_rest():
    for path in FOLDER.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                top = (node.module or "").split(".")[0]
                assert node.level < 2, path
                allowed = node.level == 1 or top in {"numpy", "scipy", "mpmath"} | sys.stdlib_module_names
                assert allowed, f"{path.name} imports {node.module}"
            elif isinstance(node, ast.Import):
                for name in node.names:
                    assert name.name.split(".")[0] in {"numpy", "scipy", "mpmath"} | sys.stdlib_module_names


@pytest.mark.parametrize("alpha", [0.15, 0.5, 0.75])
def test_springpot_is_a_power_of_frequency(alpha):
    np.testing.assert_allclose(el.springpot(W, alpha, 300.0), (1j * W / 300) ** alpha, rtol=1e-8)


def test_relaxations_rods_and_shorted_turns_have_their_closed_forms():
    np.testing.assert_allclose(el.cole_cole(W, 1e-3, 0.7), 1 / (1 + (1j * W * 1e-3) ** 0.7), rtol=1e-7)
    K, m = 1e6 * (1 + 0.05j), 0.5
    kl = W * np.sqrt(m / K)
    low = 2 * np.pi * 1500 > W  # several modes of the rod
    np.testing.assert_allclose(el.rod_free(W, K, m)[low], (1j * np.sqrt(K * m) * np.tan(kl))[low], rtol=2e-3)
    np.testing.assert_allclose(
        el.rod_clamped(W, K, m)[low], (-1j * np.sqrt(K * m) / np.tan(kl))[low], rtol=2e-3
    )
    L, R = 1e-3, 4.0
    np.testing.assert_allclose(el.shorted_turn(W, L, 1.0, R / L), 1 / (1 / (1j * W * L) + 1 / R), rtol=1e-8)
    free = el.resonator(W, 0.01, 500.0, 20.0)
    np.testing.assert_allclose(free[0], 1j * W[0] * 0.01, rtol=1e-3)  # far below resonance a mass


def test_magnetostrictive_transducer_agrees_with_the_reference():
    p = {
        "mu33_re": 2.814, "mu33_im": -0.137, "S33_re": 2.547e-11, "S33_im": -2.178e-13, "d33_re": 1.587e-9,
        "d33_im": -5.588e-11, "R_0": 3.0, "N": 940.0, "A": np.pi * 1e-4, "l": 0.1, "M_t": 1.2501374082326546,
        "K_spr": 3e6, "R_d": 6.79, "R_f": 349.2303, "f_c": 3e4,
    }  # fmt: skip
    f = np.array([1000.0, 1600.0, 2500.0])
    scale = impedance.Scale(1.25, 1e4, 2 * np.pi * 2500)
    Z = gmm.impedance(2 * np.pi * f, p, {}, scale, np.zeros(3), gmm.flux(f / 3e4))
    wanted = [
        6.4179929839673737645 + 62.702907694400771476j,
        81.718900527243873783 + 91.858874428104233166j,
        11.79675045976055655 + 146.9389772466929365j,
    ]
    np.testing.assert_allclose(Z, wanted, rtol=1e-12)


def test_dahl_on_branches():
    """Reference values of the exact update, and the steady loop's tips at -tanh(ρA) and tanh(ρA)."""
    np.testing.assert_allclose(
        friction.dahl(np.array([0, 0.5]), 1.46, -1.0)[1], 1 - 2 * np.exp(-0.73), rtol=1e-14
    )
    x = -0.4 * np.cos(2 * np.pi * np.arange(12 * 200 + 1) / 200)
    r = friction.dahl(x, 1.46)
    np.testing.assert_allclose(r[-1], -np.tanh(1.46 * 0.4), rtol=1e-9)
    v = np.gradient(x, 1e-3)
    np.testing.assert_allclose(friction.rate_dahl(v, 1e-3, 1.46, np.ones_like(x), 0.0), r, atol=2e-3)


def test_stribeck_friction_falls_with_speed():
    """Sliding steadily, friction settles at the level that belongs to its speed."""
    fast, n = np.array([0.1, 1.0, 10.0]), 4000
    level = 1 + 0.5 * np.exp(-fast / 1.0)
    settled = [
        friction.rate_dahl(np.full(n, v), 10 / (v * n), 2.0, np.full(n, g), 0.0)[-1]
        for v, g in zip(fast, level, strict=True)
    ]
    np.testing.assert_allclose(settled, level, rtol=1e-5)
    relaxing = friction.rate_dahl(np.full(n, 1.0), 10 / n, 2.0, np.ones(n), 2.0)[-1]
    assert relaxing == pytest.approx(0.5, rel=1e-5)  # slip and relaxation share it


@pytest.mark.parametrize("b", [0.5, 1.0, 2.0])
def test_dahl_exponent_by_integration(b):
    x = np.concatenate([np.linspace(0, 0.9, 50), np.linspace(0.9, -0.4, 60)[1:]])
    r = friction.dahl_power(x, 1.46, b)

    def step(r0, dx):
        s, y = np.sign(dx), 1.46 * abs(dx)
        u = 1 - s * r0
        u = u * np.exp(-y) if b == 1 else np.maximum(u ** (1 - b) + (b - 1) * y, 0) ** (1 / (1 - b))
        return s * (1 - u)

    top = step(0.0, 0.9)
    np.testing.assert_allclose([r[49], r[-1]], [top, step(top, -1.3)], atol=2e-5)


def test_memories_agree_in_time_and_frequency():
    """A long sine through each convolution or filter gives what the element's complex gain says."""
    dt, w, n = 1e-3, 2 * np.pi * 2.0, 40_000
    t = dt * np.arange(n)
    z = np.sin(w * t)
    last = slice(n - 5000, n)
    basis = np.column_stack([np.sin(w * t[last]), np.cos(w * t[last])])

    def gain(y):
        a, b = np.linalg.lstsq(basis, y[last], rcond=None)[0]
        return a + 1j * b

    one = np.array([w])
    assert gain(memory.fractional(z, dt, 0.3)) == pytest.approx((1j * w) ** 0.3, rel=2e-3)
    assert gain(memory.relaxing(z, dt, 0.1, 1.0)) == pytest.approx(0.1j * w / (1 + 0.1j * w), rel=1e-3)
    assert gain(memory.relaxing(z, dt, 0.1, 0.5)) == pytest.approx(
        impedance.stretched(0.1 * one, 0.5)[0], rel=2e-3
    )
    assert gain(memory.low_pass(z, dt, 0.02)) == pytest.approx(1 / (1 + 0.02j * w), rel=1e-4)
    middle = memory.hysteretic(z)[n // 2 - 50 : n // 2 + 50]
    np.testing.assert_allclose(middle, np.cos(w * t[n // 2 - 50 : n // 2 + 50]), atol=1e-2)
    force_per_mass = gain(memory.appendage(-(w**2) * z, dt, 2 * np.pi * 3.0, 5.0))
    assert force_per_mass == pytest.approx(1j * w * el.resonator(one, 1.0, 2 * np.pi * 3.0, 5.0)[0], rel=1e-3)


@pytest.mark.parametrize("spec", [
    {"type": "steps", "steps": [0.5, 1.0, 3.0], "cycles": 2, "amplitude": 0.6},
    {"type": "sweep", "from": 0.3, "to": 10.0, "seconds": 8.0, "amplitude": 0.4},
    {"type": "random", "lines": [0.4, 1.7, 3.1], "phases": [0.1, 2.0, 4.0], "amplitude": 0.2},
])  # fmt: skip
def test_motions_have_their_derivatives_and_reversals(spec):
    m = Motion(spec, 500.0, 6.0, 0.0)
    z, v, a = m.zva
    dt = 1 / m.dense
    np.testing.assert_allclose(np.gradient(z, dt)[2:-2], v[2:-2], atol=1e-3 * np.abs(v).max())
    np.testing.assert_allclose(np.gradient(v, dt)[2:-2], a[2:-2], atol=1e-3 * np.abs(a).max())
    np.testing.assert_array_equal(m.path[m.keep], z)
    turns = friction.branches(m.path)[1:-1]
    assert np.abs(v).min() < 1 and len(turns) >= 5
    assert (np.diff(np.sign(np.diff(m.path[turns]))) != 0).all()  # maxima and minima take turns


def _forms():
    for domain in DOMAINS:
        for effect in drawing.catalogue(domain):
            yield domain, effect, ""
        for law, effect in drawing.variants(domain).items():
            yield domain, effect, law


def _concealed(domain, effect, law, d2):
    """A drawn secret; a force is recorded more briefly than usual."""
    if domain != "force":
        return drawing.draw(11, "variant" if law else None, domain, law or effect, d2=(d2, d2))
    plain = drawing.draw(11, "none", domain)
    loop = {"type": "steps", "steps": [0.2], "cycles": 2, "amplitude": 3.0}
    sweep = {"type": "sweep", "from": 0.4, "to": 8.0, "seconds": 5.0, "amplitude": 0.6}
    more = {"rate": 200.0, "pre": 0.0, "role": "fit"}
    records = [{"motion": loop, "seconds": 10.0, **more}, {"motion": sweep, "seconds": 5.0, **more}]
    setup = {"records": records, "constants": {"r_0": 0.0}, "per_recording": []}
    plain = replace(plain, setup=setup, effects=(effect,), variant=law)
    return drawing.conceal(np.random.default_rng(1), plain, (d2, d2))


@pytest.mark.parametrize(("domain", "effect", "law"), list(_forms()))
def test_concealed_to_depth_and_gone_at_null(domain, effect, law):
    secret = _concealed(domain, effect, law, 200.0)
    scene = drawing.scene_of(secret)
    y = scene.simulate(secret.strength)
    assert scene.refit(y).d2 == pytest.approx(200.0, rel=0.1)
    assert all(np.isfinite(a).all() for a in y)
    tiny = {effect: {**secret.strength[effect], "size": 1e-4 * secret.strength[effect]["size"]}}
    for with_it, without in zip(scene.simulate(tiny), scene.simulate({}), strict=True):
        np.testing.assert_allclose(with_it, without, atol=2e-4 * np.abs(without).max())


def test_depth_of_a_force_by_a_plain_fit():
    """d² from a general optimiser over all parameters, and simulations of the base alone."""
    secret = _concealed("force", "cubic_stiffness", "", 500.0)
    scene = drawing.scene_of(secret)
    y = scene.simulate(secret.strength)
    names = ["k_D", "c_D", "h_D", "rho", "F_0"]

    def miss(x):
        other = force.ForceScene(dict(zip(names, x, strict=True)), secret.setup, secret.levels).simulate({})
        return np.concatenate([scene.white(i, y[i][None] - other[i], y[i])[0] for i in range(2)])

    start = [secret.base[k] * 1.02 for k in names]
    assert 2 * least_squares(miss, start, x_scale=start, method="lm").cost == pytest.approx(500.0, rel=0.02)


def test_errors_of_the_displacement_reach_the_force_through_the_dashpot():
    """What spring, slip and dashpot make of them is white of size 1 in each octave, once whitened."""
    secret = drawing.draw(3, domain="force", effect="force_sensor_lag", noise="displacement")
    scene, levels, base = drawing.scene_of(secret), secret.levels, secret.base
    rng, n = np.random.default_rng(4), 2**14
    error = levels["z"] * rng.standard_normal(n)
    rate = np.gradient(error) * scene.motions[0].rate  # right at low frequencies alone
    slip = 0.5 * base["h_D"] * base["rho"]
    felt = (base["k_D"] + slip) * error + base["c_D"] * rate + levels["F_m"] * rng.standard_normal(n)
    power = np.abs(np.fft.rfft(scene.white(0, felt[None], felt)[0])) ** 2 / n
    for low in (2**4, 2**6, 2**8):
        assert power[low : 4 * low].mean() == pytest.approx(1, abs=5 / np.sqrt(3 * low) + 0.05), low


@pytest.mark.parametrize("domain", ["impedance", "gmm"])
def test_passive(domain):
    """What is concealed takes power, but for a delay, for hum and for a reference whose phase creeps."""
    active = {"sensor_delay", "novel:mains_hum", "novel:phase_creep"}
    for seed, effect in enumerate(e for e in drawing.catalogue(domain) if e not in active):
        secret = drawing.draw(seed, domain=domain, effect=effect, d2=(3000.0, 3000.0))
        for Z in drawing.scene_of(secret).simulate(secret.strength):
            assert Z.real.min() > 0, effect


BASE = {"R_e": 6.0, "L_e": 5e-4, "Bl": 6.0, "M_m": 0.015, "K_m": 2e3, "R_m": 1.0}
SCALE = impedance.Scale(0.015, float(np.sqrt(2e3 / 0.015)), float(W[-1]))


def _coil(effect, **form):
    return impedance.impedance(W, BASE, {effect: {"law": "", **form}} if effect else {}, SCALE, ORDER)


def test_directions_in_a_loudspeaker():
    Z, top, f0 = _coil(None), -1, int(np.argmax(_coil(None).real))
    assert _coil("eddy_shunt", size=1.0)[top].real > Z[top].real + 1  # loss
    assert _coil("eddy_shunt", size=1.0)[top].imag < Z[top].imag  # less inductance
    extra = _coil("semi_inductance", size=0.3, n=0.6) - Z
    np.testing.assert_allclose(np.degrees(np.angle(extra)), 54, atol=1e-3)
    assert abs(_coil("coil_capacitance", size=0.3)[top]) > abs(Z[top])  # towards self-resonance
    assert _coil("coil_ac_resistance", size=20.0)[top].real > Z[top].real
    assert _coil("coil_ac_resistance", size=20.0)[0].real == pytest.approx(Z[0].real, rel=1e-4)
    for loss in ("contact_damping", "structural_damping"):
        assert _coil(loss, size=0.3)[f0].real < Z[f0].real
    assert _coil("temperature_drift", size=0.05, tau=1.0)[top].real == pytest.approx(
        Z[top].real + 0.3, rel=1e-3
    )
    assert np.angle(_coil("sensor_delay", size=0.1)[top] / Z[top]) == pytest.approx(-0.1)
    drop = np.imag(_coil("permeability_relaxation", size=0.5, at=0.1, a=0.8)) / W
    assert drop[-1] < drop[-15]  # the added inductance relaxes
    stiffer = _coil("maxwell_branch", size=1.0, at=0.3).real
    assert np.argmax(stiffer) > f0


def test_stiffness_of_a_steady_cycle_agrees_with_the_reference():
    p = {"k_D": 0.3834, "c_D": 0.0912, "h_D": 0.0353, "rho": 1.46}
    F = stiffness.steady_cycle(2 * np.pi * np.array([0.099]), p, {}, 3.01, 3.01)
    k_s, angle = stiffness.measured(F, 3.01)[:, 0]
    assert k_s == pytest.approx(0.39929809233874111056, rel=1e-8)
    assert np.sin(np.radians(angle)) == pytest.approx(
        0.20518482603477049268 / 1.2018872579396107428, rel=1e-8
    )


def test_directions_in_complex_stiffness():
    p, w, A = {"k_D": 0.5, "c_D": 0.01, "h_D": 0.1, "rho": 1.5}, 2 * np.pi * np.array([0.5, 5.0]), 0.4

    def change(effect, **form):
        both = ({effect: {"law": "", **form}}, {})
        with_it, without = (stiffness.measured(stiffness.steady_cycle(w, p, e, A, 0.8), A) for e in both)
        return with_it - without

    assert change("power_law_viscoelasticity", size=0.3, alpha=0.3)[0].min() > 0
    assert np.diff(change("maxwell_branch", size=0.5, tau=0.1)[0])[0] > 0
    assert change("structural_damping", size=0.2)[1].min() > 0
    assert change("payne_softening", size=0.3, at=0.3)[0].max() < 0
    assert np.diff(change("inertia", size=0.3)[0])[0] < 0
    assert change("cubic_stiffness", size=0.3)[0].min() > 0
    assert change("contact_compliance", size=0.2)[0].max() < 0
    late = change("sensor_delay", size=1e-3)
    np.testing.assert_allclose(late[0], 0, atol=1e-4)  # the greatest force comes later, as great
    assert late[1].max() < 0 and late[1, 1] < late[1, 0]  # and at z = 0 it is less


def test_directions_in_time():
    secret = drawing.draw(3, "none", "force")
    scene = drawing.scene_of(secret)
    m = scene.motions[0]
    z, v, _ = (m.recorded(x) for x in m.zva)
    base = scene.simulate({})[0]

    def change(effect, **form):
        return scene.simulate({effect: {"law": "", **form}})[0] - base

    assert (np.sign(change("cubic_stiffness", size=0.1)) == np.sign(z)).mean() > 0.99
    assert change("asymmetric_stiffness", size=0.1).min() >= -1e-12
    assert (np.sign(change("magnetic_pull", size=0.1, gap=2.0)) == -np.sign(z)).mean() > 0.99
    assert (change("quadratic_damping", size=0.5) * v).min() >= -1e-9
    assert (change("payne_softening", size=0.3, at=0.3, smooth=0.3) * z).max() <= 1e-9
    stop = change("end_stop", size=1.0, at=0.8, side=1.0, power=1.0)
    assert stop.min() == 0 and (z[stop > 0] > 0.7 * np.abs(z).max()).all()
    for loss in (
        {"power_law_viscoelasticity": {"alpha": 0.3}},
        {"maxwell_branch": {"tau": 0.1}},
        {"structural_damping": {}},
    ):
        ((effect, form),) = loss.items()
        assert np.sum(change(effect, size=0.2, **form) * v) > 0  # work is taken up
    late = scene.simulate({"sensor_delay": {"size": 2 / m.rate, "law": ""}})[0]
    np.testing.assert_allclose(late[2:], base[:-2], atol=1e-6)


def test_absorbed_effects_are_not_drawn():
    for domain, effect in (("impedance", "leakage_inductance"), ("force", "contact_damping")):
        with pytest.raises(NotDetectable, match=effect):
            drawing.draw(1, domain=domain, effect=effect)
    with pytest.raises(ValueError, match="no case"):
        drawing.draw(1, domain="impedance", effect="backlash")


def test_a_pair_shows_both():
    secret = drawing.draw(2, "pair", "impedance")
    first, second = secret.effects
    assert secret.d2[first] >= drawing.PAIR_DEPTH and secret.d2[second] >= drawing.PAIR_DEPTH


def test_another_form_of_one_effect_is_no_second_one():
    """A Maxwell branch that is slower by a little: the base and its size alone can't follow, its form can."""
    one = drawing.draw(4, "single", "impedance", "maxwell_branch")
    form = one.strength["maxwell_branch"]
    scene = drawing.scene_of(one)
    slower = scene.simulate({"maxwell_branch": {**form, "at": 0.7 * float(form["at"])}})
    assert scene.refit(slower, one.strength).d2 > 10
    assert nearest(scene, slower, one.strength).d2 < 0.01


def test_a_longer_sweep_warms_the_coil_for_longer():
    """Every sample takes as long, so that a sweep's first samples drift as those of a shorter one."""
    order = impedance.in_order(400, 200)
    assert order[199] == 1.0 and order[-1] == pytest.approx(399 / 199)


@pytest.mark.parametrize("domain", DOMAINS)
def test_cases_keep_the_secret(domain, tmp_path):
    """The folder holds the recordings and what is known; the same secret gives the same bytes."""
    for i, noise in enumerate(NOISES_OF[domain][::2]):
        secret = drawing.draw(40 + i, "single", domain, noise=noise)
        case = truths.write_case(secret, tmp_path / noise / "a")
        again = truths.write_case(Secret.from_json(secret.to_json()), tmp_path / noise / "b")
        data = tomllib.loads(case.read_text())
        files = sorted(p.name for p in case.parent.iterdir())
        assert files == ["case.toml", *(f"rec_{k + 1}.csv" for k in range(len(data["recording"])))]
        assert {r["role"] for r in data["recording"]} == {"fit", "holdout"}
        words = [*secret.effects, "secret", "seed", "effect", "variant"]
        for name in files:
            text = (case.parent / name).read_text()
            assert not any(word in text for word in words)
            assert text == (again.parent / name).read_text()
        rows = sum(len((case.parent / n).read_text().splitlines()) - 1 for n in files[1:])
        assert rows <= 20_000


def test_noise_is_as_large_as_it_says(tmp_path):
    secret = drawing.draw(8, "none", "force", noise="coloured")
    clean = drawing.scene_of(secret).simulate({})
    case = truths.write_case(secret, tmp_path)
    e = np.loadtxt(case.parent / "rec_2.csv", delimiter=",", skiprows=1)[:, 2] - clean[1]
    rho = secret.levels["rho"]
    assert np.corrcoef(e[1:], e[:-1])[0, 1] == pytest.approx(rho, abs=0.05)
    innovation = np.std(e[1:] - rho * e[:-1]) / np.sqrt(1 - rho**2)
    assert innovation == pytest.approx(secret.levels["F_m"], rel=0.1)
    secret = drawing.draw(8, "none", "impedance", noise="white")
    clean = drawing.scene_of(secret).simulate({})
    case = truths.write_case(secret, tmp_path)
    z = np.loadtxt(case.parent / "rec_1.csv", delimiter=",", skiprows=1)
    relative = (z[:, 1] + 1j * z[:, 2] - clean[0]) / np.abs(clean[0])
    assert np.std(relative.imag) == pytest.approx(secret.levels["Z_relative"], rel=0.2)


def test_seal():
    secret = drawing.draw(4, "single", "stiffness")
    text, digest = seal(secret)
    assert unseal(text, digest) == secret
    assert seal(secret)[1] != digest  # a nonce
    with pytest.raises(ValueError, match="sealed"):
        unseal(text.replace("white", "black"), digest)


def _verdict(*ids, **more):
    effects = [{"id": i, "port": "mechanical", "probability": 0.9, "equivalents": []} for i in ids]
    return {"adequate": not ids, "effects": effects, **more}


def test_scores():
    lone = Secret("force", ("maxwell_branch",), {}, {"k_D": 0.5}, "white", 1, identifiable=("k_D",))
    right = score(lone, _verdict("maxwell_branch", parameters={"k_D": {"value": 0.51, "std": 0.01}}))
    assert (
        right["adequate"] and right["named"] and right["family"] and right["port"] and right["covered"] == 1
    )
    near = score(lone, _verdict("structural_damping"))
    assert near["family"] and not near["named"] and not near["in_set"]
    listed = _verdict("structural_damping")
    listed["effects"][0]["equivalents"] = ["maxwell_branch"]
    assert score(lone, listed)["in_set"] and score(lone, listed)["set_size"] == 2
    missed = score(lone, _verdict())
    assert not missed["adequate"] and missed["named"] is False and missed["alarm"] is None
    nothing = Secret("force", (), {}, {}, "white", 1)
    assert score(nothing, _verdict("inertia"))["alarm"] and not score(nothing, _verdict())["alarm"]
    novel = Secret("force", ("novel:mains_hum",), {}, {}, "white", 1)
    assert (
        score(novel, _verdict("unknown_force"))["unknown"] and score(novel, _verdict("backlash"))["misnamed"]
    )
    pair = Secret("force", ("inertia", "backlash"), {}, {}, "white", 1)
    assert (
        score(pair, _verdict("backlash", "inertia"))["both"] and not score(pair, _verdict("backlash"))["both"]
    )
    after = score(pair, {**_verdict("inertia"), "fit": {"after": {"holdout_rms_over_noise": 1.1}}})
    assert after["holdout_chi2"] == pytest.approx(1.21)


def test_a_port_is_right_where_the_effect_acts() -> None:
    """Of an impedance, heat changes the winding; elsewhere it changes a stiffness."""
    said = {"effects": [{"id": "temperature_drift", "port": "electrical", "equivalents": []}]}
    by_domain = {
        d: truths.score(truths.draw(3, domain=d, effect="temperature_drift", ratio=3.0), said)["port"]
        for d in ("impedance", "stiffness")
    }
    assert by_domain == {"impedance": True, "stiffness": False}


@pytest.mark.slow
def test_effects_that_run_away_together_are_drawn_again():
    """A spring that softens with the cube of a stroke to which its yielding joint adds has no equilibrium."""
    both = ("cubic_stiffness", "contact_compliance")
    secret = drawing.draw(203400164, "pair", "force", both, noise="coloured", ratio=20.0)
    assert all(np.all(np.isfinite(y)) for y in drawing.scene_of(secret).simulate(secret.strength))


@pytest.mark.slow
def test_a_mass_behind_a_soft_joint_does_not_diverge():
    secret = drawing.draw(250100011, "pair", "force", ("inertia", "contact_compliance"), noise="coloured")
    scene = drawing.scene_of(secret)
    sizes = [[np.ptp(y) for y in scene.simulate(s)] for s in (secret.strength, {})]
    assert np.all(np.array(sizes[0]) < 100 * np.array(sizes[1]))


def test_a_record_that_a_clearance_takes_up_has_no_share_in_what_is_explained() -> None:
    """Its force is rounding: what a base misses of it is as large as that, whatever else it explains."""
    pair = "backlash", "stress_softening"
    secret = truths.draw(420100079, "pair", "force", pair, noise="coloured", ratio=9.43)
    assert 0.9 < secret.r2 < 1
