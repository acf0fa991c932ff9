"""What an effect must gain to be claimed: under the common noise, under each fit's own, in the recordings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modelgen.diagnose.hypotheses.evidence import effective
from modelgen.diagnose.hypotheses.refit import Fit, Judge, mean_square, misfit, plain_white
from modelgen.diagnose.hypotheses.setting import ALARM, Setting, nearest
from modelgen.diagnose.noise.follows import following
from modelgen.diagnose.noise.noise import FITS, correlation_length
from modelgen.diagnose.noise.recolour import own_noises
from modelgen.diagnose.noise.replica import motion_matters
from modelgen.diagnose.noise.slow import gain_in_slow_noise
from modelgen.diagnose.noise.smooth_error import smooth_error
from modelgen.diagnose.search.far import FAR, beyond_scatter
from modelgen.fit.series import Array

WORTH = 0.9
"""Where models stay far from the data, an effect must take away a tenth of the misfit to be named."""
IMPERFECT = 0.01
"""Share of the evidence so far that a law of the right family leaves, a tenth off: no second effect."""
INEXACT = {"time": (0.0, 0.08, 0.17), "sweep": (0.0, 0.03, 0.1)}
"""Of all that is explained, in rms, beside none, one, and two effects: so much may be wrong with laws of the
right kind, as other people's laws of the same physics differ from ours. In records of several simulators with
other laws, what was less than this was mostly no second effect, what was more mostly one; a third one, which
was named in eight of them, was there in none. Impedances have fewer laws, and less of them is wrong."""
MENDED, TO_NOISE, FROM = 0.25, 1.03, 1.15
"""Part of that which is asked of a second effect over time that leaves at most TO_NOISE times the noise where
the first left FROM times as much: what is wrong with a law is seldom another law to the last."""
KIN = 1.5
"""Times that, if the further effect is of the family of another: what is wrong with a law is likest to it."""
SEEN = 0.998
"""Where far more than noise is left, a further effect must be seen in the recordings as they are, and not
only in what a filter of that rest leaves of them."""
WORSE = 1.1
"""A claim may leave this many times the misfit of the recordings as they are, and no more: what smooths the
errors of a differentiated motion gains under a filter and is further from the data."""
PLAIN = 100.0
"""ΔBIC under the common noise by which a single effect over time is a reason to look for two, though a colour
of the noise may be all of it."""
CREDIBLE = 1.35
"""A stated noise is believed when the best hypothesis leaves 1/CREDIBLE to CREDIBLE times as much."""
TAKEN = 1 / 3
"""Part of the squares that are left, taken away in the first and in the last half of each recording: noise
of any colour has another shape in each."""
FOLLOWED, EACH, PARTS = 0.75, 0.5, 4
"""Of what functions of the motion explain of a residual: share that a law takes away in all, and in each of
so many parts of the recordings, at least, that hold their share. No law takes this from noise everywhere."""
MOSTLY = 0.25
"""Share of the evidence that coloured noise must leave: with less, it may be that, and more is asked."""


def gains(s: Setting, judge: Judge, base: Fit, old: Fit, new: Fit) -> bool:
    """Whether the evidence for `new` is enough: under the common noise, and with each fit's own colour of
    noise.

    The second is the likelihood in which smooth misfit may be coloured noise; it guards against colours that
    the richer hypothesis has taken for itself. What errors of the motion alone would give must be gained
    twice: replicas are made from a path that is smoothed already. A further effect must gain more than what a
    law that is not quite right would leave.
    """
    alarm = ALARM * (len(new.ids) - len(old.ids))
    sure = _beyond_noise(s, judge, old, new)
    if not s.model.is_time_model and any(w.ar is not None for w in judge.whiteners) and not sure:
        alarm *= 2  # a sweep is too short to tell a colour well
    # with no more numbers, or another law, it mends no law that is nearly right, but is another account
    other = set(old.ids) <= set(new.ids) and not old.hypothesis.key <= new.hypothesis.key
    mends = new.parameters > old.parameters and not other
    off = INEXACT["time" if s.model.is_time_model else "sweep"][len(old.ids)]
    off *= KIN if _of_one_kind(new) else MENDED if _to_noise(old, new) else 1.0
    inexact = off**2 * (misfit(nearest(s, base)) - misfit(new)) if old.ids and mends else -np.inf
    if judge.temper > 1.0:  # that something is missing is beyond doubt: the first effect is the best account
        seen = new.chi2 < WORTH * old.chi2 and misfit(old) - misfit(new) > inexact
        return seen and old.bic - new.bic > (alarm if old.ids else 0.0)
    undeserved = judge.excess.get(new.hypothesis.key, 0.0) - judge.excess.get(old.hypothesis.key, 0.0)
    imperfect = IMPERFECT * max(0.0, base.bic - old.bic) if mends else 0.0
    if old.bic - new.bic < alarm + max(0.0, undeserved) + imperfect:
        return False
    if worse(s, base, new) or worse(s, old, new):
        return False
    if misfit(old) - misfit(new) < inexact:
        return False
    if old.ids and _far(new) and misfit(new) > SEEN * misfit(old):
        return False
    if sure and s.model.is_time_model:  # a colour that makes up for it is no noise that was stated
        return True
    if s.model.is_time_model and (_everywhere(old, new, alarm) or _in_all_motions(s, old, new)):
        return True
    own = own_gain(s, judge, old, new)
    mostly = own < MOSTLY * (old.bic - new.bic) and not sure
    if s.model.is_time_model:
        return own > (3 * alarm if mostly else alarm)  # noise of 1/f has no order
    # what an effect does to sweeps is smooth, as coloured noise and errors of the instrument are
    return own > (2 * alarm if mostly else alarm if len(old.ids) != 1 else 0.0)


def _beyond_noise(s: Setting, judge: Judge, old: Fit, new: Fit) -> bool:
    """Whether `old` leaves more than a noise that is stated, whatever its colour, or in sweeps a smooth error
    of the instrument, and `new` does not: then something is missing, and an effect is the better account."""
    if not all(x.stated for x in s.series) or not _far(old):
        return False
    if s.model.is_time_model:
        return mean_square(plain_white(new)) < CREDIBLE**2
    return not _far(new) and smooth_error(judge, old)[2] is None


def _everywhere(old: Fit, new: Fit, alarm: float) -> bool:
    """Whether `new` takes away a third of what is left of `old` all along each recording, where that is far
    more than what scatters from sample to sample, and more than `alarm` in as many independent values as its
    correlation leaves: a filter that foretells what is smooth gains as much of either."""
    if beyond_scatter(old) < FAR:
        return False
    was, left = plain_white(old), plain_white(new)
    parts = zip(_parts(was, 2), _parts(left, 2), strict=True)
    if any(np.sum(b**2) > (1 - TAKEN) * np.sum(a**2) for a, b in parts):
        return False
    count = effective(was) / correlation_length(was)
    gain = count * float(np.log(misfit(old) / misfit(new)))
    return gain - (new.parameters - old.parameters) * float(np.log(max(count, 3.0))) > alarm


def _in_all_motions(s: Setting, old: Fit, new: Fit) -> bool:
    """Whether one law, the same in all recordings, takes away most of what functions of the motion explain of
    what `old` leaves, wherever it is: that is no noise, though a filter would foretell it."""
    added = [a for a in new.hypothesis.added if a.key not in old.hypothesis.key]
    if any(a.effect.each or a.effect.needs == ("t",) for a in added):
        return False
    was, left = (following(s.model, s.series, plain_white(f)) for f in (old, new))
    if was is None or left is None:
        return False
    pieces = 2 * max(1, -(-PARTS // (2 * len(was))))
    before, after = (np.array([np.sum(e**2) for e in _parts(x, pieces)]) for x in (was, left))
    heavy = before > np.mean(before) / 2
    if int(heavy.sum()) < PARTS or after.sum() > (1 - FOLLOWED) * before.sum():
        return False
    return bool(np.all(after[heavy] <= (1 - EACH) * before[heavy]))


def _parts(white: Sequence[Array], pieces: int) -> list[Array]:
    """Residuals of each recording in so many pieces, one after another."""
    return [part for e in white for part in np.array_split(e, pieces, axis=1)]


def _to_noise(old: Fit, new: Fit) -> bool:
    """Whether a second effect leaves but noise where the first left more."""
    level = TO_NOISE**2 * effective(new.white)
    return len(old.ids) == 1 and misfit(new) < min(level, misfit(old) / FROM**2)


def _of_one_kind(f: Fit) -> bool:
    """Whether two of the effects are of one family."""
    return len({a.family for a in f.hypothesis.added}) < len(f.ids)


def worse(s: Setting, old: Fit, new: Fit) -> bool:
    """Whether `new` is further from recordings over time, as they are, than `old`."""
    return s.model.is_time_model and misfit(new) > WORSE * misfit(old)


def own_gain(s: Setting, judge: Judge, old: Fit, new: Fit) -> float:
    """What `new` gains on `old`, each with its own colour of noise, over time also beside slow noise: but for
    one that is stated, beside errors of the motion."""
    before, after = own_noises(s, judge, (old, new))
    gain = before.bic - after.bic
    told = all(x.stated for x in s.series) and motion_matters(judge.whiteners)
    if not s.model.is_time_model or told:
        return gain
    was, left = plain_white(old), plain_white(new)
    slow = gain_in_slow_noise(before.whiteners, was, after.whiteners, left)
    return min(gain, slow - (new.parameters - old.parameters) * float(np.log(effective(new.white))))


def hidden(s: Setting, judge: Judge, best: Fit, winner: Fit, depth: int) -> bool:
    """Whether one effect more may show what is not claimed yet.

    A colour of the noise, or a smooth error that nobody stated, may forbid to claim `winner`, and two effects
    together be told from it; or what no single effect explains is far more than noise, and two together do.
    """
    if depth != len(best.ids) + 1:
        return False
    if depth == 1 and _far(winner):
        return True
    alarm = ALARM if not s.model.is_time_model else PLAIN if depth == 1 else np.inf
    return judge.temper == 1.0 and best.bic - winner.bic > alarm


def _far(fit: Fit) -> bool:
    """Whether residuals are larger than a noise that is wrong by a factor of two."""
    return any(float(np.mean(e[e != 0] ** 2)) > FITS**2 for e in plain_white(fit) if np.any(e))
