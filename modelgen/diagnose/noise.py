"""What in a residual is noise: outliers, level, and colour. Colour is taken from the best hypothesis, never
the base."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from modelgen.fit.series import Array, Series, input_noise
from modelgen.language import Model
from modelgen.recordings import Case, Recording

GROSS = 6.0
"""A sample this many robust standard deviations from its neighbours' median is an outlier."""


def outliers(white: Array) -> Array:
    """(n,) bool: samples that stand alone far off their neighbours in a whitened residual (channels, n)."""
    n = white.shape[1]
    if n < 15:
        return np.zeros(n, dtype=bool)
    far = np.zeros(n)
    for x in white:
        padded = np.pad(x, 3, mode="reflect")
        windows = np.lib.stride_tricks.sliding_window_view(padded, 7)
        alone = x - np.median(windows, axis=1)
        level = 1.4826 * np.median(np.abs(alone))
        # where the signal itself is rough (reversals), neighbours are far off as well: compare with the local
        # level
        local = 1.4826 * np.median(
            np.abs(np.lib.stride_tricks.sliding_window_view(np.pad(alone, 10, mode="reflect"), 21)), axis=1
        )
        scale = np.where(local > 2 * level, 1.5 * local, level)
        far += (alone / np.maximum(scale, 1e-12 * (np.abs(alone).max() or 1.0))) ** 2
    marked = far > GROSS**2
    return marked if marked.mean() < 0.1 else np.zeros(n, dtype=bool)


def masked(series: Sequence[Series], marks: Sequence[Array]) -> tuple[Series, ...]:
    """Series whose outliers weigh nothing."""
    return tuple(
        replace(s, whitener=s.whitener.masked(np.where(m, 0.0, 1.0))) if m.any() else s
        for s, m in zip(series, marks, strict=True)
    )


def correlation_length(white: Sequence[Array]) -> float:
    """Integrated autocorrelation time of residuals in samples, 1 for independent ones, the largest of the
    recordings."""
    longest = 1.0
    for x in white:
        n = x.shape[1]
        d = x - x.mean(axis=1, keepdims=True)
        power = float(np.sum(d**2)) or 1.0
        total = 1.0
        for lag in range(1, max(2, n // 8)):
            c = float(np.sum(d[:, lag:] * d[:, :-lag])) / power
            if c <= 0.05:
                break
            total += 2 * c
        longest = max(longest, total)
    return longest


ENDS = 4.0
"""How much worse a smoothed motion is near the ends of a record than its own estimate says."""


def errors_in_motion(
    model: Model, case: Case, recording: Recording, s: Series, force: Callable[[Series], Array]
) -> Series:
    """The series with the noise that errors of the smoothed displacement and of its rate make in the output.

    `force` evaluates the base at its fit on a series; errors of displacement are propagated through it,
    sample by sample, so that they count as noise and not as physics.
    """
    motion = {i.derived[0]: i.name for i in model.inputs if i.derived}
    moved = next((i.derived[1] for i in model.inputs if i.derived and i.derived[0] == "rate"), None)
    if moved is None:
        return s
    from modelgen.recordings.kinematics import kinematics

    k = kinematics(
        recording.inputs[model.axis], recording.inputs[moved], input_noise(model, case, recording)[moved]
    )
    n = np.arange(s.n)
    window = np.maximum(np.broadcast_to(k.window, s.n), 1)
    ends = np.where((n < window) | (s.n - 1 - n < window), ENDS, 1.2)
    base = force(s)
    off = np.zeros(s.n)
    places: dict[str, Any] = {motion["rate"]: k.sigma_v, moved: k.sigma_z * _left(window)}
    for name, std in places.items():
        std = np.broadcast_to(std, s.n) * ends
        if not (np.any(std > 0) and np.all(np.isfinite(std))):
            continue
        shifted = {name: s.inputs[name] + std}
        if name == moved:  # the whole path moves, so that no step of it changes
            before = np.concatenate([std[:1], std[:-1]])
            shifted |= {
                motion[m]: s.inputs[motion[m]] + d
                for m, d in (("turning", before), ("previous", before))
                if m in motion
            }
        off += (force(replace(s, inputs={**s.inputs, **shifted})) - base)[0] ** 2
    level = np.sqrt(1.0 + np.mean(np.abs(s.whitener.weight), axis=0) ** 2 * off)
    return replace(s, whitener=replace(s.whitener.masked(1.0 / level), smear=window))


def _left(half: Array) -> Array:
    """(n,) share of the noise that a local quintic over `half` samples to either side leaves in the value."""
    from scipy.signal import savgol_coeffs

    left = {
        h: 1.0 if h <= 4 else float(savgol_coeffs(2 * h + 1, 5)[h]) ** 0.5 for h in np.unique(half).tolist()
    }
    return np.array([left[h] for h in half.tolist()])


def local_level(white: Array) -> Array:
    """(n,) slowly varying level of a residual, 1 in the mean square; 1 everywhere when it is even."""
    n = white.shape[1]
    width = max(64, n // 24)
    if n < 6 * width:
        return np.ones(n)
    power = np.minimum(np.mean(white**2, axis=0), 9.0 * np.mean(white**2))
    used = (np.abs(white).sum(axis=0) > 0).astype(float)
    kernel = np.ones(width)
    smooth = np.convolve(power * used, kernel, "same") / np.maximum(np.convolve(used, kernel, "same"), 1.0)
    smooth = np.maximum(smooth, 0.2 * np.mean(smooth))
    even = float(smooth.max() / smooth.min()) < (1.0 + 6.0 * np.sqrt(2.0 / width)) ** 2
    return np.ones(n) if even else np.asarray(np.sqrt(smooth / np.mean(smooth)))
