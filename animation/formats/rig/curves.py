"""Keys into values between them: steps, lines, great arcs and cubic splines, many at a time."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.classical.quaternion import quaternion_slerp

JUMP_S = 1e-6
"""How long before a step its old value is sampled last."""


def between(keys: FloatArray, times: FloatArray) -> tuple[np.ndarray, np.ndarray, FloatArray]:
    """The keys (n,) at or before each time and after it, and the fraction (n,) of the way.

    Times outside are held at the ends.
    """
    if len(keys) == 1:
        alone = np.zeros(len(times), dtype=np.int64)
        return alone, alone, np.zeros(len(times))
    before = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 2)
    fraction = (times - keys[before]) / (keys[before + 1] - keys[before])
    return before, before + 1, np.clip(fraction, 0.0, 1.0)


def with_times(keys: FloatArray, values: FloatArray, times: FloatArray) -> FloatArray:
    """Values (n, ...) at times on straight lines between keys (K,) with values (K, ...)."""
    if len(keys) == len(times) and np.array_equal(keys, times):
        return values
    before, after, fraction = between(keys, times)
    share = fraction.reshape(-1, *[1] * (values.ndim - 1))
    made: FloatArray = values[before] + share * (values[after] - values[before])
    return made


def great_arc(keys: FloatArray, wxyz: FloatArray, times: FloatArray) -> FloatArray:
    """Unit quaternions (n, ..., 4) at times, turning evenly and the short way between keys."""
    if len(keys) == len(times) and np.array_equal(keys, times):
        return wxyz
    before, after, fraction = between(keys, times)
    share = fraction.reshape(-1, *[1] * (wxyz.ndim - 2))
    return quaternion_slerp(wxyz[before], wxyz[after], share)


def stepped(keys: FloatArray, values: FloatArray, times: FloatArray) -> FloatArray:
    """Values of the last key at or before each time; of the first key before it."""
    return values[np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 1)]


def hermite(
    keys: FloatArray, values: FloatArray, into: FloatArray, out: FloatArray, times: FloatArray
) -> FloatArray:
    """Values (n, ...) on cubics with slopes a second `into` and `out` of the keys (K, ...)."""
    before, after, fraction = between(keys, times)
    shape = (-1, *[1] * (values.ndim - 1))
    u = fraction.reshape(shape)
    step = (keys[after] - keys[before]).reshape(shape)
    made: FloatArray = (
        (1.0 + 2.0 * u) * (1.0 - u) ** 2 * values[before]
        + u * (1.0 - u) ** 2 * step * out[before]
        + u**2 * (3.0 - 2.0 * u) * values[after]
        + u**2 * (u - 1.0) * step * into[after]
    )
    return made


def key_times(keys: list[FloatArray], stepped: list[bool]) -> FloatArray:
    """All times of curves' keys (K,), and times just before the steps of those that step."""
    jumps = [one[1:] - JUMP_S for one in keys]
    kept = [
        jump[jump > one[:-1]]
        for jump, one, steps in zip(jumps, keys, stepped, strict=True)
        if steps
    ]
    return np.unique(np.concatenate([*keys, *kept]))
