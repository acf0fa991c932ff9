"""Drawing a secret: which device, which effect, how strong for the depth at which it is to be concealed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np

from . import force, force_draw, gmm, gmm_draw, impedance, impedance_draw, stiffness
from .noise import draw_levels
from .secret import DOMAINS, KINDS, NOISES, NOISES_OF, NotDetectable, Secret, family
from .solve import Refit, Scene, nearest, size_for

Rng = np.random.Generator
DRAWS: dict[str, ModuleType] = {
    "impedance": impedance_draw,
    "gmm": gmm_draw,
    "force": force_draw,
    "stiffness": stiffness,
}

# Exactly absorbed by the base parameters, so never drawn unless asked for.
ABSORBED = {
    "impedance": ("leakage_inductance",),
    "gmm": ("structural_damping",),
    "force": ("contact_damping",),
    "stiffness": (),
}
PAIR_DEPTH = 40.0  # each of a pair leaves at least this d² when the other is there, whatever its form


def sizes(domain: str) -> dict[str, tuple[float, float]]:
    """effect -> (first size tried, largest plausible size) of a domain."""
    return dict(DRAWS[domain].SIZES)


def variants(domain: str) -> dict[str, str]:
    """law -> effect that it is a law of."""
    return dict(DRAWS[domain].VARIANTS)


def scene_of(secret: Secret) -> Scene:
    """The device and the recordings of a secret."""
    kinds: dict[str, Any] = {
        "impedance": impedance.ImpedanceScene,
        "gmm": gmm.GmmScene,
        "force": force.ForceScene,
        "stiffness": stiffness.StiffnessScene,
    }
    made: Scene = kinds[secret.domain](secret.base, secret.setup, secret.levels)
    return made


def draw(
    seed: int,
    kind: str | None = None,
    domain: str | None = None,
    effect: str | tuple[str, ...] | None = None,
    d2: tuple[float, float] = (30.0, 1e4),
    noise: str = "white",
    ratio: float | None = None,
) -> Secret:
    """Draw a secret; what isn't given is drawn as well.

    kind    "none", "single", "variant", "pair" or "novel"
    effect  an id, a pair of ids, or with kind "variant" the law's name
    d2      range of the whitened squared misfit ||(y_true - y_base)/σ||² that the best base model leaves
            over the fit recordings; drawn log-uniform and met to 1 % (for each of a pair on its own)
    ratio   instead of d2: the rms of the best base model's residual over the noise's; where no plausible
            strength gives so much, the largest is taken if it leaves at least the lower of `d2`

    Raises NotDetectable where the base parameters absorb the asked-for effect; ValueError for unknown names.
    """
    rng = np.random.default_rng(seed)
    if kind is None:
        kind = str(rng.choice(KINDS, p=[0.15, 0.45, 0.15, 0.15, 0.1])) if effect is None else _kind_of(effect)
    places = [d for d in DOMAINS if noise in NOISES_OF[d] and (domain in (None, d)) and _can(d, kind, effect)]
    if kind not in KINDS or noise not in NOISES or not places:
        raise ValueError(f"no case of kind={kind!r}, domain={domain!r}, effect={effect!r}, noise={noise!r}")
    last = NotDetectable("no draw")
    for _ in range(8 if effect is not None else 60):
        try:
            return _attempt(rng, kind, str(rng.choice(places)), effect, d2, noise, seed, ratio)
        except NotDetectable as error:
            last = error
    raise last


def _kind_of(effect: str | tuple[str, ...]) -> str:
    if not isinstance(effect, str):
        return "pair" if len(effect) == 2 else "single"
    if effect.startswith("novel:"):
        return "novel"
    return "variant" if any(effect in variants(d) for d in DOMAINS) else "single"


def _can(domain: str, kind: str, effect: str | tuple[str, ...] | None) -> bool:
    """Whether a domain has an effect, or any of a kind."""
    if effect is None:
        return True
    names = (effect,) if isinstance(effect, str) else effect
    return set(names) <= set(variants(domain) if kind == "variant" else sizes(domain))


def _attempt(
    rng: Rng,
    kind: str,
    domain: str,
    effect: str | tuple[str, ...] | None,
    d2: tuple[float, float],
    noise: str,
    seed: int,
    ratio: float | None,
) -> Secret:
    effects, law = _choose(rng, kind, domain, effect)
    base = DRAWS[domain].draw_base(rng)
    setup = DRAWS[domain].draw_setup(rng, base, effects)
    levels = draw_levels(rng, domain, noise)
    plain = Secret(domain, effects, {}, base, noise, seed, law, kind, setup, levels)
    return conceal(rng, plain, d2, ratio)


def _choose(
    rng: Rng, kind: str, domain: str, effect: str | tuple[str, ...] | None
) -> tuple[tuple[str, ...], str]:
    """The effects of a case, and the law of one of them."""
    laws = variants(domain)
    if kind == "variant":
        law = str(rng.choice(sorted(laws))) if effect is None else str(effect)
        return (laws[law],), law
    if effect is not None:
        return ((effect,) if isinstance(effect, str) else tuple(effect)), ""
    listed = [e for e in sizes(domain) if not e.startswith("novel:") and e not in ABSORBED[domain]]
    if kind == "none":
        return (), ""
    if kind == "novel":
        return (str(rng.choice([e for e in sizes(domain) if e.startswith("novel:")])),), ""
    if kind == "single":
        return (str(rng.choice(listed)),), ""
    first = str(rng.choice(listed))
    others = [e for e in listed if family(e) != family(first)]
    return (first, str(rng.choice(others))), ""


def conceal(rng: Rng, plain: Secret, d2: tuple[float, float], ratio: float | None = None) -> Secret:
    """Give each effect its form, and the strength at which the base model hides it to a depth in `d2`, or to
    a `ratio`: see `draw`."""
    scene = scene_of(plain)
    former = DRAWS[plain.domain].draw_form
    strength: dict[str, dict[str, Any]] = {}
    depth: dict[str, float] = {}
    fit = scene.refit(scene.simulate({}))
    for effect in plain.effects:
        first, limit = sizes(plain.domain)[effect]
        if plain.variant == "log_creep":
            limit = 0.15  # beyond, the law's compliance turns negative within the band
        form = former(rng, effect, plain.variant, plain.base, plain.setup) | {"size": min(first, limit)}
        target, least = float(np.exp(rng.uniform(*np.log(d2)))), np.inf
        if ratio is not None:
            target, least = max(fit.data * (ratio**2 - 1), d2[0]), d2[0]
        form["size"], fit = size_for(scene, effect, form, target, limit, least)
        strength[effect], depth[effect] = form, fit.d2
    if len(plain.effects) > 1:
        depth, fit = _together(scene, strength)
    return replace(
        plain,
        strength=strength,
        d2=depth | {"all": fit.d2},
        bent=fit.bent,
        bent_std={n: v / max(fit.std[n], 1e-12) for n, v in fit.bent.items()},
        ratio=fit.ratio,
        r2=fit.r2,
        identifiable=fit.identifiable,
    )


RUNAWAY = 1e3
"""Times the base's response that two effects together have at most: a mass behind a soft joint diverges."""


def _together(scene: Scene, strength: Mapping[str, Mapping[str, Any]]) -> tuple[dict[str, float], Refit]:
    """d² of each effect with the others and all numbers of their forms refitted, and the base model nearest
    to all. (Tangents of the others won't do: a strong effect bends further than first order tells.)

    Raises NotDetectable where one hides the other, or both together run away.
    """
    with np.errstate(all="ignore"):
        y = scene.simulate(strength)
    if not all(
        np.abs(x).max() < RUNAWAY * np.abs(b).max() for x, b in zip(y, scene.simulate({}), strict=True)
    ):
        raise NotDetectable(f"{' and '.join(strength)} together run away")
    depth = {}
    for effect in strength:
        others = {o: form for o, form in strength.items() if o != effect}
        depth[effect] = nearest(scene, y, others).d2
        if depth[effect] < PAIR_DEPTH:
            raise NotDetectable(f"{effect}: hidden by {', '.join(o for o in strength if o != effect)}")
    return depth, scene.refit(y)


def catalogue(domain: str) -> Sequence[str]:
    """Effects that can be drawn in a domain, novel ones included."""
    return [e for e in sizes(domain) if e not in ABSORBED[domain]]
