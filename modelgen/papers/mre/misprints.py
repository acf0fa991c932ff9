"""Equations and sentences of the MRE paper that are wrong in print, and what they would do."""

from __future__ import annotations

import numpy as np

from modelgen.papers.mre.tables import A_SWEEP, ESTIMATES
from modelgen.papers.mre.truth import STAGE_4
from modelgen.papers.paper import Found


def misprints() -> Found:
    """Where, as printed, right, and how that shows."""
    rho = STAGE_4["M0"]["rho"]
    steady, kept = -float(np.tanh(rho * A_SWEEP)), float(np.exp(-4 * rho * A_SWEEP))
    J_e, J_es = ([ESTIMATES["M1"][stage][k] for stage in (2, 3)] for k in (-2, -1))
    rows = (
        ("(2)", "z + max z", "z − min z", "the same for a displacement about 0, as in the tests"),
        (
            "sec. 3.4", "k_s following (3)", "following (4)", "(3) is the stress",
        ),
        (
            "(5)", "A_F/A_z, as (4)", "A_F over the amplitude of ż",
            "the dot is lost. As it then is k_s/(2πf), Table 2's c_s says nothing of damping, and the "
            "range of c_D chosen by it is ten times too wide",
        ),
        ("(9)", "ρ in s/mm", "1/mm", "r has no unit. Table 5 has /mm once"),
        ("(12)", "ρ(v_D − r|v_D|", "ρ(v_D − r|v_D|)", "a bracket"),
        (
            "(13)", "n = 1/(f t_pr)", "a whole number",
            "f = 0.099 Hz and 0.25 ms make 40404.04; the mean over a cycle is by equal parts of it here",
        ),
        (
            "sec. 4", "r(0) = −1", "−tanh(ρA)",
            f"as good at 3 mm, where it is −0.9997; at 0.4 mm it is −{-steady:.3f}, and {100 * kept:.1f} % "
            "of the error is left after a cycle. modelgen fit estimates r(0)",
        ),
        (
            "(15)", "s_c beside the square", "inside", "the printed J_es follow with s_c inside alone "
            "(below)",
        ),
        (
            "stage 4, step 2", "skipped if J_es of step 1 is smaller", "if it is greater", "the better set "
            "is kept",
        ),
        (
            "sec. 4.2", "J_e and J_es less at each stage", "J_es alone",
            f"J_e of M1 rises from {J_e[0]} to {J_e[1]} N while J_es falls from {J_es[0]} to "
            f"{J_es[1]}: stage 4 minimised the weighted error",
        ),
        (
            "Table 3, text", "k_d depends on the field, slightly on CIP", "k_d is what CIP does",
            "it is the difference of the samples; the field's effect is the difference of M1 and M0",
        ),
        ("sec. 3.1", "magnets N38", "simulated as N30", "Table 1's points 2 and 3 are off by up to 49 mT"),
    )  # fmt: skip
    return Found((), ("where", "as printed", "right", "how it shows"), rows, prose=True)
