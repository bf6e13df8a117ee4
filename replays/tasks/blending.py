"""Motions of a character blended, and recorded gestures replayed on a scene.

Blends are written as glTF or video, and the methods compared; gestures are replayed by rotors and
by Euler angles side by side.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from motorcade.animation import Character, Clip
from motorcade.animation.authoring import (
    Scene,
    SceneEditor,
    Snapping,
    read_gestures,
    read_scene,
    replay,
)
from motorcade.animation.blend import (
    BlendMethod,
    RootMotion,
    blend_motions,
    closed,
    differences_m,
    grounded,
    in_step,
)
from motorcade.animation.blend.alignment import GroundedMotion, contacts
from motorcade.animation.formats import read_character, read_motion, write_gltf
from motorcade.animation.ik import fitted_legs
from motorcade.animation.retarget import facing_rad, legs_of
from motorcade.animation.retarget.transfer import retarget


@dataclass(frozen=True, eq=False)
class Authored:
    """A scene after gestures.

    Fields:
        scene: by the writing that was asked for.
        gestures: how many were replayed.
        apart: by object, how far the other writing of rotations ends from it: degrees and metres
            in the world.
    """

    scene: Scene
    gestures: int
    apart: dict[str, tuple[float, float]]

    def as_json(self) -> dict[str, Any]:
        """A JSON-ready tree, units in the keys."""
        differences = {
            name: {"rotation_deg": degrees, "position_m": metres}
            for name, (degrees, metres) in self.apart.items()
        }
        return {
            "gestures": self.gestures,
            "scene": self.scene.as_json(),
            "rotors_against_euler": differences,
        }


def author(
    scene: Path,
    gestures: Path,
    rotations: Literal["rotor", "euler"] = "rotor",
    snapping: Snapping | None = None,
) -> Authored:
    """Replay gestures on a scene.

    Raises ValueError: a file that cannot be read, a gesture that the scene refuses.
    """
    start, recorded = read_scene(scene), read_gestures(gestures)
    ends = {
        "rotor": replay(SceneEditor(start, snapping), recorded),
        "euler": replay(SceneEditor(start.on_euler_angles(), snapping), recorded),
    }
    apart = {}
    for name in ends[rotations].parents:  # what gestures added too
        first, other = (end.world_T_object(name) for end in ends.values())
        angle = float((first.rotor.inverse() @ other.rotor).angle())
        shift = float(np.linalg.norm(first.translation_m - other.translation_m))
        apart[name] = (float(np.degrees(angle)), shift)
    return Authored(ends[rotations], len(recorded), apart)


# Moments at which contacts are compared, and the share of alike ones below which it is said.
MOMENTS, TOGETHER = 200, 0.8
# Ways farther than this share of the height go somewhere; they may go so far apart unsaid.
FAR, SIDEWAYS_DEG = 0.3, 45.0


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
        way: where it goes, which its clip on the spot leaves out.
        notices: what could not be aligned.
    """

    character: Character
    clip: Clip
    in_phase: bool
    offset: float
    differences_m: Mapping[tuple[BlendMethod, BlendMethod], float]
    way: RootMotion
    notices: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """A JSON-ready tree, units in the keys."""
        return {
            "clip": self.clip.name,
            "seconds": self.clip.duration_s,
            "keys": len(self.clip.time_s),
            "in_phase": self.in_phase,
            "phase_offset": self.offset,
            "way_m": float(np.linalg.norm(self.way.start_T_now.translation_m[-1])),
            "speed_m_s": self.way.speed_m_s,
            "notices": list(self.notices),
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

    Raises FormatError: a file that cannot be read; ValueError: skeletons of which no joints pair,
    or clips of one name.
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
    """Blend two of a character's clips on the spot, aligned in heading and in step.

    What a clip travels is taken out first, and both are turned to face +x (see `grounded`). Two
    clips that then close are cycles, and are blended in phase, contacts of feet on contacts; others
    are blended by the clock, and how often their feet come down together is said. Feet of the
    blend stay on the ground under its own way, which is between the two.

    Raises ValueError: no such clip, a weight outside 0 to 1, a rate that is not positive.
    """
    skeleton = character.skeleton
    legs = fitted_legs(legs_of(skeleton), character)
    first, second = (_looped(grounded(character.clip(n), skeleton, legs)) for n in names)
    in_phase = first.clip.looped and second.clip.looped
    notes, offset = [], 0.0
    if in_phase and legs:
        second, offset, note = in_step(first, second, skeleton, legs)
        notes += [note] if note else []
    notes += _unaligned(character, (first, second), names)
    blended = blend_motions(first, second, weight, skeleton, legs, method=method, rate_hz=rate_hz)
    apart = differences_m(
        first.clip,
        second.clip,
        skeleton,
        joints=np.unique(character.joints[character.weights > 0.0]),
        in_phase=in_phase,
    )
    together = None
    if legs:
        clock = np.linspace(0.0, 1.0, MOMENTS)
        lengths = [motion.clip.duration_s for motion in (first, second)]
        spans = lengths if in_phase else [max(lengths)] * 2
        stand = [
            contacts(motion, skeleton, legs, motion.clip.time_s[0] + clock * span)
            for motion, span in zip((first, second), spans, strict=True)
        ]
        together = float(np.mean(stand[0] == stand[1]))
        if together < TOGETHER:
            notes.append(
                f"each foot of both does the same, standing or swinging, {together:.0%} of the time"
            )
    return Blend(character, blended.clip, in_phase, offset, apart, blended.way, tuple(notes))


def _unaligned(
    character: Character, motions: tuple[GroundedMotion, ...], names: tuple[str, str]
) -> list[str]:
    """What the two cannot share: one heading for how they go, or a heading at all."""
    ways = [motion.way.start_T_now for motion in motions]
    steps = [(way[:-1].inverse() @ way[1:]).translation_m for way in ways]
    ahead_m = [step.sum(axis=0)[:2] for step in steps]
    far_m = [float(np.linalg.norm(way)) for way in ahead_m]
    notes = []
    if facing_rad(character.skeleton, character.skeleton.rest_world.translation_m[None]) is None:
        notes.append("no thighs or arms tell where the figure faces: aligned by its root's turn")
    if min(far_m) > FAR * character.height_m:
        cosine = float(ahead_m[0] @ ahead_m[1]) / (far_m[0] * far_m[1])
        apart_deg = float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
        if apart_deg > SIDEWAYS_DEG:
            notes.append(
                f"facing one way, '{names[0]}' and '{names[1]}' go {apart_deg:.0f} degrees apart"
            )
    return notes


def write_blend(blend: Blend, path: Path, size: tuple[int, int] = (640, 640)) -> None:
    """Write a blend as `.glb` or, drawn on an empty stage, as `.mp4`.

    Raises ValueError: another ending; RenderUnavailable: a video where there is no OpenGL.
    """
    if path.suffix == ".glb":
        write_gltf(path, blend.character, [blend.clip])
        return
    if path.suffix != ".mp4":
        raise ValueError(f"--out {path}: expected a name ending in .glb or .mp4")
    from motorcade.render import show_clip
    from motorcade.render.video import write_video

    seconds = max(blend.clip.duration_s, 4.0) if blend.clip.looped else None
    frames = list(show_clip(blend.character, blend.clip, size, duration_s=seconds))
    write_video(path, frames, np.round(np.arange(len(frames)) * 1e9 / 30.0).astype(np.int64))


def _looped(motion: GroundedMotion) -> GroundedMotion:
    """A cycle closed to rounding; a motion that does not end where it began stays as it is."""
    if not motion.cycle:
        return replace(motion, clip=replace(motion.clip, looped=False))
    return replace(motion, clip=closed(motion.clip, np.inf))
