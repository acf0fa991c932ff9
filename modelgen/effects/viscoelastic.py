"""Springs that lose energy and creep: springpot, Maxwell branch, hysteretic loss. Frequency and time domain.

In time, memories with many relaxation times are ladders of Maxwell arms (see `ladder`).
"""

from dataclasses import replace

from modelgen.effects.effect import (
    Apply,
    Effect,
    Shape,
    Strength,
    Values,
    add_stiffness,
    change,
    unit_of,
    unit_omega,
)
from modelgen.effects.ladder import MEMORY, Ladder, arm, first_foot, first_motion, past, z_rest
from modelgen.effects.motion import moved_input
from modelgen.language import Model, Port, j, log, pi, powj, quadrature_of, sign

SPRING = ("stiffness", "mechanical_impedance")
ALPHA = Shape("alpha", "1", "1", 0.03, 0.9, 7, log=False, text="0 for a spring, 1 for a dashpot")
SCOTT_BLAIR = "G. W. Scott Blair, J. Colloid Sci. 2 (1947) 21; F. Mainardi, Fractional Calculus (2010), ch. 3"
BIOT = "M. A. Biot, Proc. 3rd US Congr. Appl. Mech. (1958) 1"
BEFORE = past("power_law_viscoelasticity")


def _power_law(model: Model, port: Port, p: Values) -> Model:
    model = unit_omega(model)
    w = port["omega"] / model.parameter("unit_omega")
    return add_stiffness(lambda at, p: p["C"] * powj(w, p["alpha"]))(model, port, p)


power_law_viscoelasticity = Effect(
    "power_law_viscoelasticity",
    SPRING,
    "the material creeps by a power law: a springpot C(jω)^α in parallel, stiffer and lossier the faster "
    "it moves",
    SCOTT_BLAIR,
    (Strength("C", "{stiffness}", text="modulus at ω = 1 rad/s"),),
    _power_law,
    (ALPHA,),
    needs=("omega",),
    common=2.0,
)


def _log_creep(model: Model, port: Port, p: Values) -> Model:
    model = unit_omega(model)
    w = port["omega"] / model.parameter("unit_omega")
    return add_stiffness(lambda at, p: p["C_ln"] * (log(w) + j * pi / 2))(model, port, p)


LN = "growth of the stiffness per unit of ln ω; the spring's own is that at ω = 1 rad/s"

log_creep = Effect(
    "power_law_viscoelasticity",
    SPRING,
    "the material creeps by the logarithm of time, the limit of a small power: its stiffness grows with "
    "ln(jω)",
    BIOT,
    (Strength("C_ln", "{stiffness}", text=LN),),
    _log_creep,
    needs=("omega",),
    common=2.0,
)


def _relaxing_springpot(model: Model, port: Port, p: Values) -> Model:
    x = powj(port["omega"] * p["tau"], p["alpha_1"])
    return add_stiffness(lambda at, p: p["C_1"] * x / (1 + x))(model, port, p)


relaxing_springpot = Effect(
    "power_law_viscoelasticity",
    SPRING,
    "the material creeps with a spectrum of relaxation times: a springpot in series with a spring, a power "
    "law that ends where ωτ = 1",
    "R. L. Bagley, P. J. Torvik, J. Rheol. 27 (1983) 201; T. Pritz, J. Sound Vib. 195 (1996) 103",
    (Strength("C_1", "{stiffness}", text="stiffness of the branch at high frequency"),),
    _relaxing_springpot,
    (
        Shape("alpha_1", "1", "1", 0.2, 0.85, 3, log=False, text="1 for a dashpot in the springpot's place"),
        Shape("tau", "s", "time", 0.3, 3.0, text="relaxation time"),
    ),
    needs=("omega",),
)

maxwell_branch = Effect(
    "maxwell_branch",
    SPRING,
    "a spring in series with a dashpot relaxes with one time constant: stiffness steps up where ωτ = 1, "
    "with a peak of loss",
    "J. C. Maxwell, Phil. Trans. 157 (1867) 49",
    (Strength("k", "{stiffness}", text="stiffness of the branch"),),
    add_stiffness(lambda at, p: p["k"] * j * at["omega"] * p["tau"] / (1 + j * at["omega"] * p["tau"])),
    (Shape("tau", "s", "time", 1.0, 3.0, text="relaxation time"),),
    needs=("omega",),
)

structural_damping = Effect(
    "structural_damping",
    SPRING,
    "the spring loses the same share of its energy in each cycle, however fast: K + jH",
    "T. Theodorsen, I. E. Garrick, NACA Report 685 (1940); R. E. D. Bishop, J. R. Aeronaut. Soc. 59 "
    "(1955) 738",
    (Strength("H", "{stiffness}", text="loss stiffness, loss factor times stiffness"),),
    add_stiffness(lambda at, p: j * p["H"]),
    needs=("omega",),
    common=2.0,
)

CAUSAL = (
    "the material loses nearly the same share of its energy in each cycle, however fast, as relaxation times "
    "of all lengths alike make it: its stiffness must then grow with ln(jω)"
)
hysteretic = replace(log_creep, id="structural_damping", says=CAUSAL)

# -- time domain ---------------------------------------------------------------------------------------------


def _power_law_force(model: Model, port: Port, p: Values) -> Model:
    arms = Ladder("power_law_viscoelasticity", unit_omega(model), port, before=BEFORE)
    force = p["C"] * arms.power_law(p["alpha"])
    return arms.add(force, "force of the springpot")


power_law_force = Effect(
    "power_law_viscoelasticity",
    ("force",),
    power_law_viscoelasticity.says,
    SCOTT_BLAIR,
    (Strength("C", "{port}/{z}", text="modulus at ω = 1 rad/s"),),
    _power_law_force,
    (ALPHA,),
    needs=MEMORY,
    common=2.0,
)


def _maxwell_force(model: Model, port: Port, p: Values) -> Model:
    rest, before = z_rest(unit_of(model, port["z"])), past("maxwell_branch")
    rate = 1 / p["tau"]
    first = first_foot(first_motion(model, port), rate, rest, before)
    state = arm("maxwell_branch_z", rate, port, rest, first)
    return model.with_parameters(rest, *before).extend(
        port.equation, lambda F: F + p["k"] * (port["z"] - state), statements=(state,)
    )


maxwell_force = Effect(
    "maxwell_branch",
    ("force",),
    maxwell_branch.says,
    maxwell_branch.source,
    (Strength("k", "{port}/{z}", text="stiffness of the branch"),),
    _maxwell_force,
    (Shape("tau", "s", "time", 0.3, 1.0, 10, text="relaxation time"),),
    needs=MEMORY,
)


def _log_creep_force(id: str) -> Apply:
    before = past(id)

    def apply(model: Model, port: Port, p: Values) -> Model:
        arms = Ladder(f"{id}_log", unit_omega(model), port, before=before)
        return arms.add(p["C_ln"] * arms.logarithm(), "force of logarithmic creep")

    return apply


log_creep_force = Effect(
    "power_law_viscoelasticity",
    ("force",),
    log_creep.says,
    BIOT,
    (Strength("C_ln", "{port}/{z}", text=LN),),
    _log_creep_force("power_law_viscoelasticity"),
    needs=MEMORY,
    common=2.0,
)


hysteretic_force = replace(
    log_creep_force,
    id="structural_damping",
    says=CAUSAL,
    apply=_log_creep_force("structural_damping"),
)


def _relaxing_springpot_force(model: Model, port: Port, p: Values) -> Model:
    arms = Ladder("relaxing_springpot", unit_omega(model), port, before=BEFORE)
    return arms.add(p["C_1"] * arms.relaxation(p["alpha_1"], p["tau"]), "force of the relaxing springpot")


relaxing_springpot_force = Effect(
    "power_law_viscoelasticity",
    ("force",),
    relaxing_springpot.says,
    relaxing_springpot.source + "; K. S. Cole, R. H. Cole, J. Chem. Phys. 9 (1941) 341",
    (Strength("C_1", "{port}/{z}", text="stiffness of the branch at high frequency"),),
    _relaxing_springpot_force,
    (
        Shape("alpha_1", "1", "1", 0.2, 0.75, 2, log=False, text="spread of its relaxation times: none at 1"),
        Shape("tau", "s", "time", 0.3, 1.0, 6, text="relaxation time"),
    ),
    needs=MEMORY,
)

structural_spring = Effect(
    "structural_damping",
    ("spring",),
    "the spring is stiffer on its way out than on its way back, in a fixed ratio: it loses the same "
    "share of its energy "
    "in each cycle, however fast",
    "T. J. Reid, J. R. Aeronaut. Soc. 60 (1956) 283",
    (Strength("eta", "1", bounds=(0.0, 1.0), text="π/2 times the loss factor"),),
    change(lambda k, at, p: k * (1 + p["eta"] * sign(at["z"]) * sign(at["v"]))),
    needs=("z", "v"),
)


def _loss_in_quadrature(model: Model, port: Port, p: Values) -> Model:
    ahead = quadrature_of(moved_input(model, port))
    return model.extend(port.equation, lambda F: F + p["H"] * ahead, inputs=(ahead,))


structural_quadrature = Effect(
    "structural_damping",
    ("force",),
    structural_damping.says,
    structural_damping.source,
    (Strength("H", "{port}/{z}", text="loss stiffness"),),
    _loss_in_quadrature,
    needs=MEMORY,
    common=2.0,
)

EFFECTS = (
    structural_quadrature, hysteretic, hysteretic_force,
    power_law_viscoelasticity, log_creep,
    relaxing_springpot, maxwell_branch, structural_damping,
    power_law_force, maxwell_force, log_creep_force, relaxing_springpot_force, structural_spring,
)  # fmt: skip
