"""The paper on magnetorheological elastomers: its tables, what stands beside them, and its figures."""

from modelgen.papers.mre.estimators import both_readings, side_by_side, spread
from modelgen.papers.mre.figures import FIGURES
from modelgen.papers.mre.material import conditions, figures
from modelgen.papers.mre.misprints import misprints
from modelgen.papers.mre.sweep import against_sweep, along_a_sweep
from modelgen.papers.mre.tables import TABLES
from modelgen.papers.paper import Paper, Study

PAPER = Paper(
    "mre",
    "Magnetorheological elastomers in tension: the modified Dahl model",
    tables=TABLES,
    studies=(
        Study("What is wrong in print besides the numbers", misprints),
        Study("Four stages and a direct fit: accuracy and time on synthetic truth", side_by_side),
        Study("J_es in both readings", both_readings),
        Study("What Tables 4 and 5 say of residual and spread", spread),
        Study("A recording's figures, with uncertainty", figures),
        Study("Equivalent stiffness along a frequency sweep", along_a_sweep),
        Study("Models against Table 3", against_sweep),
        Study("Field, iron and amplitude as conditions of a recording", conditions),
    ),
    figures=FIGURES,
)
