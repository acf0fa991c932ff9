"""The language that physics is written in: quantities, equations, states, ports, models. All are values."""

from sympy import (
    I,
    Max,
    Min,
    Piecewise,
    Rational,
    Symbol,
    arg,
    asin,
    cos,
    cosh,
    exp,
    im,
    log,
    pi,
    re,
    sign,
    sin,
    sinh,
    sqrt,
    tan,
    tanh,
)
from sympy.codegen.cfunctions import expm1

from modelgen.language.functions import Abs, bouc_wen_step, dahl_step, eddy_factor, gamma, powdiff, powj
from modelgen.language.model import Model, Output, Port, check_name, check_option
from modelgen.language.quantities import (
    ComplexParameter,
    Condition,
    Equation,
    Implicit,
    Input,
    Parameter,
    State,
    Statement,
    Symbolic,
    acceleration_of,
    amplitude_of,
    complex_parameter,
    previous,
    quadrature_of,
    rate_of,
    turning_point_of,
)
from modelgen.language.varying import varying

j = I

__all__ = [
    "Abs", "ComplexParameter", "Condition", "Equation", "I", "Implicit", "Input", "Max", "Min", "Model",
    "Output", "Parameter", "Piecewise", "Port", "Rational", "State", "Statement", "Symbol", "Symbolic",
    "acceleration_of", "amplitude_of", "arg", "asin", "bouc_wen_step", "check_name", "check_option",
    "complex_parameter", "cos", "cosh", "dahl_step", "eddy_factor", "exp", "expm1", "gamma", "im", "j", "log",
    "pi", "powdiff", "powj", "previous", "quadrature_of", "rate_of", "re", "sign", "sin", "sinh", "sqrt",
    "tan", "tanh", "turning_point_of", "varying",
]  # fmt: skip
