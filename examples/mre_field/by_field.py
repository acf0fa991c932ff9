"""The modified Dahl model whose parameters depend on the magnets: k_D + k_D_M·M, and so on."""

from modelgen.language import Parameter, varying
from modelgen.models import modified_dahl

M = Parameter("M", "1", 0.0, text="magnets on", known=True)
model = varying(modified_dahl, ("k_D", "c_D", "h_D", "F_0"), M)
