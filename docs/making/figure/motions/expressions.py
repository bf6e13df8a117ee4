"""Blinks while it stands, a smile while it waves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorcade.animation.clip import Clip, MorphTrack
from motorcade.ga.arrays import FloatArray

BLINK, SMILE = 0, 1
BLINKS_S = {"idle": (1.3, 4.3, 4.65), "wave": (2.7,)}
SHUT_S, OPEN_S = 0.07, 0.13


def with_expressions(clips: tuple[Clip, ...]) -> tuple[Clip, ...]:
    """The same clips, those of standing with a track of the targets "blink" and "smile"."""
    return tuple(
        replace(clip, morphs=_track(clip)) if clip.name in BLINKS_S else clip for clip in clips
    )


def _track(clip: Clip) -> MorphTrack:
    rows: dict[float, FloatArray] = {0.0: np.zeros(2), float(clip.time_s[-1]): np.zeros(2)}
    for at in BLINKS_S[clip.name]:
        for since, share in ((-SHUT_S, 0.0), (0.0, 1.0), (0.04, 1.0), (0.04 + OPEN_S, 0.0)):
            rows[at + since] = np.array([share, 0.0])
    times = np.array(sorted(rows))
    weights = np.stack([rows[time] for time in times])
    if clip.name == "wave":
        smile = np.array([0.35, 0.8, clip.duration_s - 0.8, clip.duration_s - 0.2])
        every = np.union1d(times, smile)
        blink = np.interp(every, times, weights[:, BLINK])
        times = every
        weights = np.stack([blink, np.interp(every, smile, [0.0, 1.0, 1.0, 0.0])], axis=1)
    return MorphTrack(times, weights)
