"""Two motions of a character blended, written as glTF or video, and the methods compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Character, Clip
from motorcade.animation.blend import (
    BlendMethod,
    blend_clips,
    closed,
    differences_m,
    phase_between,
    split_root_motion,
)
from motorcade.animation.formats import read_character, read_motion, write_gltf
from motorcade.animation.ik import fitted_legs
from motorcade.animation.retarget import legs_of, retarget
from motorcade.animation.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class Blend:
    """A blended clip and what is to be known about it.

    Fields:
        character: who plays it.
        clip: the blend.
        in_phase: whether the clips were cycles and blended by phase; else by the clock.
        offset: phase of the second cycle at which it is like the start of the first.
        differences_m: by pairs of methods, the farthest that a joint which carries vertices lies
            apart at a quarter, a half and three quarters of the second clip.
    """

    character: Character
    clip: Clip
    in_phase: bool
    offset: float
    differences_m: Mapping[tuple[BlendMethod, BlendMethod], float]

    def as_json(self) -> dict[str, Any]:
        """A JSON-ready tree, units in the keys."""
        return {
            "clip": self.clip.name,
            "seconds": self.clip.duration_s,
            "keys": len(self.clip.time_s),
            "in_phase": self.in_phase,
            "phase_offset": self.offset,
            "differences_mm": {
                f"{a} - {b}": 1e3 * value for (a, b), value in self.differences_m.items()
            },
        }


def character_with(
    path: Path,
    motions: Sequence[Path] = (),
    *,
    up: str | None = None,
    front: str | None = None,
) -> Character:
    """A character read from a file, with the clips of further files retargeted to it.

    `up` and `front` are axes of the character's file, as `read_character` takes them.

    Raises:
        FormatError: a file that cannot be read.
        ValueError: skeletons of which no joints pair, or clips of one name.
    """
    character = read_character(path, up=up, front=front)
    clips, notices = list(character.clips), list(character.notices)
    legs = fitted_legs(legs_of(character.skeleton), character)
    for file in motions:
        motion = read_motion(file)
        notices += [f"{file.name}: {notice}" for notice in motion.notices]
        clips += [
            retarget(clip, motion.skeleton, character.skeleton, legs=legs) for clip in motion.clips
        ]
    return replace(character, clips=tuple(clips), notices=tuple(notices))


def blend_character(
    character: Character,
    names: tuple[str, str],
    weight: float,
    method: BlendMethod = "motor",
    *,
    rate_hz: float = 60.0,
) -> Blend:
    """Blend two of a character's clips on the spot.

    What a clip travels is taken out first. Two clips that then close are cycles, and are blended
    in phase, feet matched where there are legs that move in both; others are blended by the clock.

    Raises:
        ValueError: no such clip, a weight outside 0 to 1, a rate that is not positive.
    """
    skeleton = character.skeleton
    clips = [split_root_motion(character.clip(name), skeleton)[0] for name in names]
    cycles = [_cycle(clip) for clip in clips]
    first, second, offset = clips[0], clips[1], 0.0
    in_phase = cycles[0] is not None and cycles[1] is not None
    if cycles[0] is not None and cycles[1] is not None:
        first, second = cycles[0], cycles[1]
        offset = _offset(first, second, skeleton)
    blended = blend_clips(
        first, second, weight, method, in_phase=in_phase, offset=offset, rate_hz=rate_hz
    )
    apart = differences_m(
        first,
        second,
        skeleton,
        joints=np.unique(character.joints[character.weights > 0.0]),
        offset=offset,
        in_phase=in_phase,
    )
    return Blend(character, blended, in_phase, offset, apart)


def write_blend(blend: Blend, path: Path, size: tuple[int, int] = (640, 640)) -> None:
    """Write a blend as `.glb` or, drawn on an empty stage, as `.mp4`.

    Raises:
        ValueError: another ending.
        RenderUnavailable: a video where there is no OpenGL.
    """
    if path.suffix == ".glb":
        write_gltf(path, blend.character, [blend.clip])
        return
    if path.suffix != ".mp4":
        raise ValueError(f"--out {path}: expected a name ending in .glb or .mp4")
    from motorcade.render.showcase import show_clip
    from motorcade.render.video import write_video

    seconds = max(blend.clip.duration_s, 4.0) if blend.clip.looped else None
    frames = list(show_clip(blend.character, blend.clip, size, duration_s=seconds))
    write_video(path, frames, np.round(np.arange(len(frames)) * 1e9 / 30.0).astype(np.int64))


def _cycle(clip: Clip) -> Clip | None:
    try:
        return closed(clip)
    except ValueError:  # a motion that does not end where it began is no cycle
        return None


def _offset(first: Clip, second: Clip, skeleton: Skeleton) -> float:
    """The phase of the second cycle that is like the first's start; 0 where no feet tell."""
    feet = [leg.ankle for leg in legs_of(skeleton)]
    try:
        return phase_between(first, second, skeleton, feet) if feet else 0.0
    except ValueError:  # feet that stand still all the time have no phase
        return 0.0
