"""The paper on giant magnetostrictive transducers: its tables, what stands beside them, and its figures."""

from modelgen.papers.gmm.agreement import AGREEMENT, published_sets, variances
from modelgen.papers.gmm.contact import CONTACT, monte_carlo
from modelgen.papers.gmm.damping import STATED, STRUCTURAL, hammer_test
from modelgen.papers.gmm.equations import SERIES
from modelgen.papers.gmm.figures import FIGURES
from modelgen.papers.gmm.fractal import FRACTAL
from modelgen.papers.gmm.misprints import misprints
from modelgen.papers.gmm.roughness import SURFACES
from modelgen.papers.gmm.runs import MEANS, accuracy, coefficients_of_variation
from modelgen.papers.gmm.sensitivity import BASINS, compared
from modelgen.papers.gmm.uncertainty import SPREADS, damping_known_or_not, ways
from modelgen.papers.paper import Paper, Study

PAPER = Paper(
    "gmm",
    "Giant magnetostrictive transducer: three complex parameters by particle swarms",
    tables=(SERIES, STRUCTURAL, SURFACES, FRACTAL, CONTACT, STATED, BASINS, AGREEMENT, MEANS, SPREADS),
    studies=(
        Study("What is wrong in print besides the numbers", misprints),
        Study("Time and accuracy of each Method on synthetic truth", accuracy),
        Study("Ten random runs of each Method and their cv", coefficients_of_variation),
        Study("S'' with the damping known, wrong and unknown", damping_known_or_not),
        Study("Table 7's constants: passivity, coupling, distance", published_sets),
        Study("Three measures of sensitivity", compared),
        Study("Three ways to an uncertainty", ways),
        Study("Contact damping by 1e6 draws", monte_carlo),
        Study("The modal fit on simulated hammer tests", hammer_test),
        Study("What Table 6 says of one recording, three times", variances),
    ),
    figures=FIGURES,
)
