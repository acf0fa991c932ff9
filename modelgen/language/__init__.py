"""The language in which physics is written: quantities, equations, states, ports, models. Everything is a value."""

from sympy import Abs, I, Max, Min, Piecewise, arg, cos, cosh, exp, im, log, pi, re, sign, sin, sinh, sqrt, tan, tanh

from modelgen.language.functions import eddy_factor, gamma, powj
from modelgen.language.model import Model, Output, Port, check_name
from modelgen.language.quantities import (
    ComplexParameter,
    Equation,
    Implicit,
    Input,
    Parameter,
    State,
    Statement,
    Symbolic,
    acceleration_of,
    complex_parameter,
    previous,
    rate_of,
    turning_point_of,
)

j = I

__all__ = [
    "Abs", "ComplexParameter", "Equation", "I", "Implicit", "Input", "Max", "Min", "Model", "Output",
    "Parameter", "Piecewise", "Port", "State", "Statement", "Symbolic", "acceleration_of", "arg", "check_name",
    "complex_parameter", "cos", "cosh", "eddy_factor", "exp", "gamma", "im", "j", "log", "pi", "powj", "previous",
    "rate_of", "re", "sign", "sin", "sinh", "sqrt", "tan", "tanh", "turning_point_of",
]  # fmt: skip
