"""`modelgen list`."""

from __future__ import annotations

from modelgen.cli.console import console
from modelgen.effects import CATALOGUE, family
from modelgen.models import SHIPPED, load
from modelgen.report.table import table

ONE_LINE = 1000
"""Width at which each row is one line, to be searched in where no one reads it on a terminal."""


def show_all() -> None:
    """The models that ship, and the effects of the catalogue with the ports that they fit."""
    to = console(ONE_LINE)
    models = table("model", "inputs → outputs", "source", "what it is")
    for id in SHIPPED:
        m = load(id)
        inputs = ", ".join(i.name for i in m.inputs if i.derived is None) or "–"
        models.add_row(id, f"{inputs} → {', '.join(o.name for o in m.outputs)}", m.source, m.text)
    effects = table("effect", "family", "ports", "what it says")
    rows: dict[str, tuple[str, list[str], str]] = {}
    for e in CATALOGUE:
        _, kinds, _ = rows.setdefault(e.id, (family(e), [], e.says))
        kinds += [k for k in e.kinds if k not in kinds]
    for id, (group, kinds, says) in rows.items():
        effects.add_row(id, group if group != id else "", ", ".join(kinds), says)
    for shown in (models, effects):
        for column in shown.columns:
            column.justify = "left"
        to.print(shown)
        to.print()
