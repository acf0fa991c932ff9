"""What is concealed: the secret, its seal, and which names count as right."""

from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

DOMAINS = ("impedance", "gmm", "force", "stiffness")
KINDS = ("none", "single", "variant", "pair", "novel")
NOISES = ("white", "clean", "coloured", "calibration", "displacement", "outliers", "quantised", "misstated")

# A displacement error needs a displacement, a calibration error over ln f needs an f. With a force, "clean"
# has an exact displacement, "white" the paper's 2.88e-4 mm, "displacement" up to 5e-3 mm.
NOISES_OF = {
    "impedance": ("white", "coloured", "calibration", "outliers", "quantised", "misstated"),
    "gmm": ("white", "coloured", "calibration", "outliers", "quantised", "misstated"),
    "force": ("white", "clean", "coloured", "displacement", "outliers", "quantised", "misstated"),
    "stiffness": ("white", "coloured", "outliers", "quantised", "misstated"),
}

FAMILIES: dict[str, tuple[str, ...]] = {
    "eddy": ("semi_inductance", "eddy_shunt", "permeability_relaxation"),
    "viscoelastic": ("power_law_viscoelasticity", "maxwell_branch", "structural_damping"),
    "lag": ("sensor_delay", "force_sensor_lag"),
    "second resonance": ("second_mode", "contact_compliance"),
    "friction shape": ("second_dahl_element", "dahl_exponent"),
}

FORESEEN = (
    "novel:cable_trap",
    "novel:cavity_comb",
    "novel:clipped_sensor",
    "novel:echo",
    "novel:echoing_line",
    "novel:ferroresonance",
    "novel:log_ripple",
    "novel:loose_clamp",
    "novel:mains_hum",
    "novel:mount_modes",
    "novel:phase_creep",
    "novel:position_periodic",
    "novel:pulled_oscillator",
    "novel:pumped_stiffness",
    "novel:thermostat",
)
"""Physics of no catalogue that was in mind when the diagnosis was written, or that has been looked at
since: it has words for it."""

# Which kind of place an effect acts at, in words that the name of a port may contain.
PORTS: dict[str, tuple[str, ...]] = {
    "electrical": (
        "semi_inductance",
        "eddy_shunt",
        "coil_capacitance",
        "coil_ac_resistance",
        "leakage_inductance",
        "permeability_relaxation",
    ),
    "channel": ("sensor_delay", "force_sensor_lag"),
}


class NotDetectable(ValueError):
    """The base parameters absorb the effect, or no plausible strength of it shows as much as wanted."""


@dataclass(frozen=True)
class Secret:
    """A concealed case. Everything in it is plain data, and `write_case` needs nothing else.

    domain    "impedance", "gmm", "force" or "stiffness"
    effects   ids of the contract; () means nothing is missing; "novel:<name>" is physics in no catalogue
    strength  effect -> its parameters; "size" is the strength (0 is no effect), the others give its form
    base      true values of the model's parameters, in the model's units
    noise     kind of noise, `levels` its standard deviations and other figures
    seed      of the noise
    variant   a law of the effect that differs from the textbook one, "" otherwise
    setup     what was recorded and what the case states as known
    d2        effect -> whitened squared misfit that the best base model leaves (for pairs: beside the other
              effect, whatever its form); "all" -> of everything that is concealed
    bent      parameter -> ln of its value in the best base model over its true one
    bent_std  the same in standard deviations that the noise alone would give
    ratio     rms of the best base model's residual over that of the noise
    r2        share of the variance of the noise-free recordings that the best base model explains
    """

    domain: str
    effects: tuple[str, ...]
    strength: Mapping[str, Mapping[str, Any]]
    base: Mapping[str, float]
    noise: str
    seed: int
    variant: str = ""
    kind: str = "none"
    setup: Mapping[str, Any] = field(default_factory=dict)
    levels: Mapping[str, float] = field(default_factory=dict)
    d2: Mapping[str, float] = field(default_factory=dict)
    bent: Mapping[str, float] = field(default_factory=dict)
    bent_std: Mapping[str, float] = field(default_factory=dict)
    ratio: float = 1.0
    r2: float = 1.0
    identifiable: tuple[str, ...] = ()

    def to_json(self) -> str:
        """The secret as canonical JSON."""
        return json.dumps(asdict(self), sort_keys=True, separators=(",", ":"))

    @classmethod
    def from_json(cls, text: str) -> Secret:
        """The inverse of `to_json`; what `seal` added is left out."""
        data = json.loads(text)
        data.pop("nonce", None)
        for name in ("effects", "identifiable"):
            data[name] = tuple(data[name])
        return cls(**data)


def seal(secret: Secret) -> tuple[str, str]:
    """Return (text, SHA-256 of the text): print the digest before a diagnosis, reveal the text after it.

    The text holds a nonce, so that nobody finds the secret by trying them all.
    """
    data = json.loads(secret.to_json()) | {"nonce": secrets.token_hex(16)}
    text = json.dumps(data, sort_keys=True, separators=(",", ":"))
    return text, hashlib.sha256(text.encode()).hexdigest()


def unseal(text: str, digest: str) -> Secret:
    """Check a revealed text against its digest and return the secret. Raises ValueError where they differ."""
    if hashlib.sha256(text.encode()).hexdigest() != digest:
        raise ValueError("the revealed secret isn't the one that was sealed")
    return Secret.from_json(text)


def family(effect: str) -> str:
    """The family of an effect id; an effect that stands alone is a family of its own."""
    if effect.startswith("novel:") or effect.startswith("unknown"):
        return "unknown"
    return next((name for name, members in FAMILIES.items() if effect in members), effect)


def ports(effect: str, domain: str) -> set[str]:
    """Where an effect acts: "electrical", "channel" or "mechanical".

    Of an impedance, what drifts with the temperature is the winding, and a channel is that of the terminals,
    which may be called electrical.
    """
    found = {next((name for name, members in PORTS.items() if effect in members), "mechanical")}
    if domain in ("impedance", "gmm") and (effect == "temperature_drift" or found == {"channel"}):
        found = {"electrical"} | (found & {"channel"})
    return found
