"""Characterization of giant magnetostrictive materials by three complex parameters and particle swarms."""

from modelgen.papers.gmm.roughness import SURFACES
from modelgen.papers.paper import Paper

PAPER = Paper(
    "gmm",
    "Giant magnetostrictive transducer: three complex parameters by particle swarms",
    tables=(SURFACES,),
)
