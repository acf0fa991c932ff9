"""A constant added at a port: its derivative tells how the output feels the port."""

from modelgen.diagnose.hypotheses.addition import Addition
from modelgen.effects.effect import ANY, Effect, Strength, add
from modelgen.language import Port


def probe(port: Port) -> Addition:
    """An addition of a constant to the port's equation; never a hypothesis of its own."""
    effect = Effect(
        "port_probe",
        (port.kind,),
        "a constant",
        "",
        (Strength("x", "{port}", bounds=ANY),),
        add(lambda at, p: p["x"]),
    )
    return Addition(effect, port, {})
