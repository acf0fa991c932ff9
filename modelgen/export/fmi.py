"""Functions of the FMI standards that a unit must have but has no use for, from their signatures."""

from __future__ import annotations

REFS = "const uint32_t *, size_t"
"""Value references and their number, as in most signatures."""

TYPES_3 = {
    "Float32": "float", "Int8": "int8_t", "UInt8": "uint8_t", "Int16": "int16_t", "UInt16": "uint16_t",
    "Int32": "int32_t", "UInt32": "uint32_t", "Int64": "int64_t", "UInt64": "uint64_t", "Boolean": "bool",
    "String": "const char *",
}  # fmt: skip

FMI2 = {
    **{
        f"Get{t}": f"{REFS}, {c} *"
        for t, c in (("Integer", "int"), ("Boolean", "int"), ("String", "const char *"))
    },
    **{
        f"Set{t}": f"{REFS}, const {c} *"
        for t, c in (("Integer", "int"), ("Boolean", "int"), ("String", "char *const"))
    },
    "SerializedFMUstateSize": "void *, size_t *",
    "SerializeFMUstate": "void *, char *, size_t",
    "DeSerializeFMUstate": "const char *, size_t, void **",
    "GetDirectionalDerivative": f"{REFS}, {REFS}, const double *, double *",
    "SetRealInputDerivatives": f"{REFS}, const int *, const double *",
    "GetRealOutputDerivatives": f"{REFS}, const int *, double *",
    "CancelStep": "",
    "GetStatus": "int, int *",
    "GetIntegerStatus": "int, int *",
    "GetBooleanStatus": "int, int *",
    "GetStringStatus": "int, const char **",
}
FMI3 = {
    **{f"Get{t}": f"{REFS}, {c} *, size_t" for t, c in TYPES_3.items()},
    **{f"Set{t}": f"{REFS}, const {c} *, size_t" for t, c in TYPES_3.items() if t != "String"},
    "SetString": f"{REFS}, const char *const *, size_t",
    "GetBinary": f"{REFS}, size_t *, const uint8_t **, size_t",
    "SetBinary": f"{REFS}, const size_t *, const uint8_t *const *, size_t",
    "GetClock": f"{REFS}, bool *",
    "SetClock": f"{REFS}, const bool *",
    "EnterEventMode": "",
    "EnterStepMode": "",
    "EnterConfigurationMode": "",
    "ExitConfigurationMode": "",
    "EnterContinuousTimeMode": "",
    "EvaluateDiscreteStates": "",
    "UpdateDiscreteStates": "bool *, bool *, bool *, bool *, bool *, double *",
    "GetNumberOfVariableDependencies": "uint32_t, size_t *",
    "GetVariableDependencies": "uint32_t, size_t *, uint32_t *, size_t *, int *, size_t",
    "SerializedFMUStateSize": "void *, size_t *",
    "SerializeFMUState": "void *, uint8_t *, size_t",
    "DeserializeFMUState": "const uint8_t *, size_t, void **",
    "GetDirectionalDerivative": f"{REFS}, {REFS}, const double *, size_t, double *, size_t",
    "GetAdjointDerivative": f"{REFS}, {REFS}, const double *, size_t, double *, size_t",
    "GetIntervalDecimal": f"{REFS}, double *, int *",
    "GetIntervalFraction": f"{REFS}, uint64_t *, uint64_t *, int *",
    "GetShiftDecimal": f"{REFS}, double *",
    "GetShiftFraction": f"{REFS}, uint64_t *, uint64_t *",
    "SetIntervalDecimal": f"{REFS}, const double *",
    "SetIntervalFraction": f"{REFS}, const uint64_t *, const uint64_t *",
    "SetShiftDecimal": f"{REFS}, const double *",
    "SetShiftFraction": f"{REFS}, const uint64_t *, const uint64_t *",
    "CompletedIntegratorStep": "bool, bool *, bool *",
    "SetTime": "double",
    "SetContinuousStates": "const double *, size_t",
    "GetContinuousStates": "double *, size_t",
    "GetContinuousStateDerivatives": "double *, size_t",
    "GetEventIndicators": "double *, size_t",
    "GetNominalsOfContinuousStates": "double *, size_t",
    "GetNumberOfEventIndicators": "size_t *",
    "GetNumberOfContinuousStates": "size_t *",
    "GetOutputDerivatives": f"{REFS}, const int32_t *, double *, size_t",
    "ActivateModelPartition": "uint32_t, double",
}
OTHER_KINDS_3 = {
    "InstantiateModelExchange": "const char *, const char *, const char *, bool, bool, void *, "
    "void (*)(void)",
    "InstantiateScheduledExecution": "const char *, const char *, const char *, bool, bool, void *, "
    + ", ".join(["void (*)(void)"] * 4),
}


def stubs(version: int) -> str:
    """C of these functions. Reading or writing no variable at all is right for a type that has none."""
    table = FMI2 if version == 2 else FMI3
    found = [
        _stub(f"fmi{version}{name}", "int", f"void *, {types}".rstrip(", "), _result(name, types))
        for name, types in table.items()
    ]
    if version == 3:
        found += [_stub(f"fmi3{name}", "void *", types, "NULL") for name, types in OTHER_KINDS_3.items()]
    return "\n".join(found)


def _result(name: str, types: str) -> str:
    plain = name.startswith(("Get", "Set")) and types.startswith(REFS) and types.count("size_t") <= 2
    return "(a2 == 0) ? OK : ERROR" if plain else "ERROR"


def _stub(name: str, gives: str, types: str, result: str) -> str:
    arguments = []
    for k, kind in enumerate(types.split(", ")):
        if "(*)" in kind:
            arguments.append(kind.replace("(*)", f"(*a{k})"))
        else:
            arguments.append(f"{kind}a{k}" if kind.endswith("*") else f"{kind} a{k}")
    ignored = " ".join(f"(void)a{k};" for k in range(len(arguments)))
    space = "" if gives.endswith("*") else " "
    return f"EXPORT {gives}{space}{name}({', '.join(arguments)}) {{ {ignored} return {result}; }}"
