"""From a model to compiled functions: lower → split → stage → emit → compile → load."""

from modelgen.codegen.build import build, build_many, generate, warm
from modelgen.codegen.function import Function, Prepared

__all__ = ["Function", "Prepared", "build", "build_many", "generate", "warm"]
