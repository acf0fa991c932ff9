"""Laboratory testing and modelling of magnetorheological elastomers in tension mode."""

from modelgen.papers.paper import Paper

PAPER = Paper("mre", "Magnetorheological elastomers in tension: the modified Dahl model", tables=())
