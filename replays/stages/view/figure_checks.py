"""The film looks at itself: for every figure what is seen of it, how it stands, and how it goes.

Pixels come from what was drawn (`render.visibility`); contacts and headings from the poses, on the
ground that each figure stands on.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.animation.ik.feet import segments
from motorcade.animation.retarget import body_of, facing_rad, legs_of
from motorcade.animation.vectors import wrapped
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render import Performer
from motorcade.render.visibility import FigureSeen
from motorcade.replays.stages.values.view import FigureCheck

# A foot is on the ground that is within this share of the height of how it rests.
TOUCHES = 0.003
# Whoever covers less than this share of its height in a second stands; the way is taken over this.
GOES, OVER_S = 0.3, 0.5
RATE_HZ = 60.0
# Ten minutes of one figure are enough to judge how it goes.
MOST = 36_000


def check_figure(
    name: str,
    performer: Performer,
    frames: Sequence[FigureSeen | None],
    time_ns: IntArray,
) -> FigureCheck:
    """What a film shows of a figure.

    Args:
        name: what it is called.
        performer: who does what.
        frames: of each frame what is seen of it; None without a pose.
        time_ns: ``(F,)`` stamps of these frames.
    """
    time_s = 1e-9 * (time_ns - time_ns[:1])
    there = np.array([performer.seen(float(second)) for second in time_s])
    rows = [
        (seen.visible_px, seen.drawn_px, seen.inside, seen.height_px, seen.bottom)
        if seen is not None and here
        else (np.nan,) * 5
        for seen, here in zip(frames, there, strict=True)
    ]
    visible, drawn, inside, height, bottom = np.array(rows).reshape(-1, 5).T
    slide, astray = _feet_and_way(performer, time_ns)
    return FigureCheck(name, visible, drawn, inside, height, bottom, astray, slide)


def _feet_and_way(performer: Performer, time_ns: IntArray) -> tuple[float, FloatArray]:
    """The worst slide of a foot in one contact, in heights, and how far it faces off its way.

    The second is ``(F,)`` radians; NaN where it stands, or nothing tells where it faces.
    """
    skeleton, clip = performer.character.skeleton, performer.clip
    nothing = np.full(len(time_ns), np.nan)
    if not len(time_ns):
        return 0.0, nothing
    lasts_s = 1e-9 * float(time_ns[-1] - time_ns[0])
    clock = np.arange(min(int(lasts_s * RATE_HZ) + 1, MOST)) / RATE_HZ
    body = body_of(skeleton)
    if "hips" not in body or len(clock) < 3:
        return 0.0, nothing
    world = Similarity.from_motor_scale(skeleton.world(clip.at(clock).rigid))
    if performer.motion is not None:
        stamps = time_ns[0] + np.rint(1e9 * clock).astype(np.int64)
        held = np.clip(stamps, performer.motion.time_ns[0], performer.motion.time_ns[-1])
        way = performer.motion.at(held)
        whole = way if isinstance(way, Similarity) else Similarity.from_motor_scale(way)
        world = whole.reshape(-1, 1) @ world
    at = world.translation_m / np.median(world.scale)
    tall = performer.character.height_m
    slide = 0.0
    for leg in legs_of(skeleton):
        ball = skeleton.index(leg.ball)
        low = at[:, ball, 2] <= skeleton.rest_world.translation_m[ball, 2] + TOUCHES * tall
        for start, end in segments(low):
            off = at[start:end, ball, :2] - np.median(at[start:end, ball, :2], axis=0)
            slide = max(slide, float(np.linalg.norm(off, axis=1).max()) / tall)
    facing = facing_rad(skeleton, at)
    if facing is None:
        return slide, nothing
    half = max(int(0.5 * OVER_S * RATE_HZ), 1)
    rows = np.arange(len(clock))
    first, last = np.maximum(rows - half, 0), np.minimum(rows + half, len(rows) - 1)
    step = at[last, body["hips"], :2] - at[first, body["hips"], :2]
    speed = np.linalg.norm(step, axis=1) / np.maximum(clock[last] - clock[first], 1e-9) / tall
    off_rad = np.abs(wrapped(np.arctan2(step[:, 1], step[:, 0]) - facing))
    off_rad = np.where(speed > GOES, off_rad, np.nan)
    nearest = np.rint(1e-9 * (time_ns - time_ns[0]) * RATE_HZ).astype(np.int64)
    return slide, off_rad[np.minimum(nearest, len(rows) - 1)]
