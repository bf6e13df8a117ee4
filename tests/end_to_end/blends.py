"""`python -m tests.end_to_end.blends [--count N] [--seed S] [--sheet FILE]`: blends keep heading.

Pairs of motions, the files' own and drawn ones, on rigs of the folder that `MOTORCADE_DATA` names
and on the mannequin. Rests of the source are turned about the vertical by 0, 90 or 180 degrees, and
so are starts, which are moved aside as well. A row a blend: how far its hips face from those of
either motion at any time (degrees), how much more it turns from key to key of 1/60 s than either
does, how far its feet go on the ground in one contact (shares of the height), and what it says.
`--sheet` draws twelve moments of each row. Ends with 1 where a blend is beyond its bounds.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.spatial.transform import Rotation

from motorcade.animation import Character, Clip, Skeleton, mannequin
from motorcade.animation.blend import closed, grounded
from motorcade.animation.formats import read_motion
from motorcade.animation.ik import fitted_legs
from motorcade.animation.ik.feet import segments
from motorcade.animation.retarget import body_of, legs_of, retarget
from motorcade.animation.vectors import turn_z
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.tasks.blending import Blend, blend_character
from tests.end_to_end.rigs import MOTIONS, character, motion

RIGS = ("mannequin", "arnaud", "makehuman", "sinbad", "knight")
DRAWN = ("drawn walk", "drawn sway")
TURNS_DEG = (0.0, 90.0, 180.0)
HEADING_DEG, STEP_DEG, SLIDE = 5.0, 3.0, 0.01
LONGEST_S = 6.0
TOUCHES = 0.003


def turned(clip: Clip, skeleton: Skeleton, turn_deg: float, aside_m: FloatArray) -> Clip:
    """A motion that begins elsewhere and looks elsewhere."""
    start = Motor.from_rotor_translation(turn_z(np.radians(turn_deg)), aside_m)
    return replace(clip, poses=skeleton.moved(clip.poses, start))


def written(clip: Clip, skeleton: Skeleton, rest_deg: float, file: Path) -> None:
    """The motion as BVH, y up, centimetres, 60 frames a second, its rest turned about the vertical.

    Joints' frames lie along the world's axes at rest, as BVH has them; the motion is the same.
    """
    time_s = np.arange(clip.time_s[0], clip.time_s[-1] + 1e-9, 1.0 / 60.0)
    world, rest = skeleton.world(clip.at(time_s).rigid), skeleton.rest_world
    turn = turn_z(np.radians(rest_deg))
    moved = (world @ rest.inverse().reshape(1, -1)).rotor @ turn.inverse()
    up = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    parents, lines, columns = skeleton.parents, ["HIERARCHY"], []

    def put(joint: int, depth: int) -> None:
        above, indent = int(parents[joint]), "  " * depth
        at = rest[joint].translation_m - (rest[above].translation_m if above >= 0 else 0.0)
        offset = 100.0 * up @ turn.apply(at)
        lines.append(f"{indent}{'ROOT' if above < 0 else 'JOINT'} {skeleton.names[joint]}")
        lines.append(f"{indent}{{")
        lines.append(f"{indent}  OFFSET {offset[0]:.6f} {offset[1]:.6f} {offset[2]:.6f}")
        turns = "Zrotation Xrotation Yrotation"
        places = "" if above >= 0 else "Xposition Yposition Zposition "
        lines.append(f"{indent}  CHANNELS {6 if places else 3} {places}{turns}")
        local = moved[:, joint] if above < 0 else moved[:, above].inverse() @ moved[:, joint]
        if above < 0:
            columns.append(100.0 * world[:, joint].translation_m @ up.T)
        matrix = up @ local.as_matrix() @ up.T
        columns.append(Rotation.from_matrix(matrix).as_euler("ZXY", degrees=True))
        below = np.flatnonzero(parents == joint)
        for child in below:
            put(int(child), depth + 1)
        if not len(below):
            lines.append(
                f"{indent}  End Site\n{indent}  {{\n{indent}    OFFSET 0 0 0\n{indent}  }}"
            )
        lines.append(f"{indent}}}")

    for root in np.flatnonzero(parents < 0)[:1]:
        put(int(root), 0)
    lines += ["MOTION", f"Frames: {len(time_s)}", "Frame Time: 0.0166666667"]
    lines += [
        " ".join(f"{value:.5f}" for value in line) for line in np.concatenate(columns, axis=1)
    ]
    file.write_text("\n".join(lines) + "\n")


def drawn(name: str, rng: np.random.Generator) -> tuple[Clip, Skeleton]:
    """The mannequin's walk or idling, on an arc or with a spin that no file has."""
    who = mannequin()
    base = who.clip("walk" if name == "drawn walk" else "idle")
    time_s = np.linspace(0.0, rng.uniform(2.0, 5.0), 200)
    rate = rng.uniform(-0.8, 0.8) if name == "drawn walk" else 0.0
    heading = rate * time_s + rng.uniform(0.0, 1.5) * np.sin(rng.uniform(0.5, 1.5) * time_s)
    speed = 1.0 if name == "drawn walk" else 0.0
    step = speed * np.gradient(time_s)
    place = np.cumsum(step * np.exp(1j * heading))
    at = np.stack([place.real, place.imag, 0.0 * time_s], axis=-1)
    way = Motor.from_rotor_translation(turn_z(heading), at)
    poses = who.skeleton.moved(base.at(base.time_s[0] + time_s).rigid, way)
    return Clip(name, time_s, poses), who.skeleton


def lent(
    name: str,
    turns_deg: tuple[float, float],
    aside_m: FloatArray,
    who: Character,
    rng: np.random.Generator,
) -> Clip:
    """A motion on a rig; its first seconds, where it is long."""
    start_deg, rest_deg = turns_deg
    clip, skeleton = drawn(name, rng) if name in DRAWN else motion(name)
    late = np.searchsorted(clip.time_s, clip.time_s[0] + LONGEST_S)
    if late < len(clip.time_s):
        clip = replace(
            clip,
            time_s=clip.time_s[:late],
            poses=clip.poses[:late],
            looped=False,
            key_count=0,
            morphs=None,
        )
    legs = fitted_legs(legs_of(who.skeleton), who)
    if rest_deg or start_deg:
        with TemporaryDirectory() as folder:
            file = Path(folder) / "turned.bvh"
            written(turned(clip, skeleton, start_deg, aside_m), skeleton, rest_deg, file)
            read = read_motion(file)
        clip, skeleton = read.clips[0], read.skeleton
    return retarget(clip, skeleton, who.skeleton, legs=legs)


def headings_deg(who: Character, poses: Motor) -> FloatArray:
    """Where hips face ``(F,)``."""
    body, at = body_of(who.skeleton), who.skeleton.world(poses).translation_m
    across = at[:, body["left_thigh"]] - at[:, body["right_thigh"]]
    return np.unwrap(np.degrees(np.arctan2(-across[:, 0], across[:, 1])), period=360.0)


def apart_deg(a: FloatArray, b: FloatArray) -> float:
    """The farthest that two headings lie apart."""
    return float(np.abs((a - b + 180.0) % 360.0 - 180.0).max())


def slide(blend: Blend) -> float:
    """The farthest that a foot's ball goes in one contact with the ground, in heights."""
    who = blend.character
    world = blend.way.at(blend.clip.time_s).reshape(-1, 1) @ who.skeleton.world(blend.clip.poses)
    tall = float(np.max(who.skeleton.rest_world.translation_m[:, 2]))
    worst = 0.0
    for leg in legs_of(who.skeleton):
        ball = who.skeleton.index(leg.ball)
        at = world[:, ball].translation_m
        low = at[:, 2] <= who.skeleton.rest_world.translation_m[ball, 2] + TOUCHES * tall
        for start, end in segments(low):
            off = at[start:end, :2] - np.median(at[start:end, :2], axis=0)
            worst = max(worst, float(np.linalg.norm(off, axis=1).max()) / tall)
    return worst


def row(number: int, rng: np.random.Generator) -> tuple[str, bool, Blend]:
    """One blend: its figures in words, whether they are within bounds, and itself."""
    rig = RIGS[number % len(RIGS)]
    who = mannequin() if rig == "mannequin" else character(rig)
    names = [str(name) for name in rng.choice([*MOTIONS, *DRAWN, *DRAWN], 2, replace=False)]
    rests, starts = rng.choice(TURNS_DEG, 2), rng.choice(TURNS_DEG, 2)
    if number < 9:
        starts = np.array([0.0, TURNS_DEG[number % 3]])
        rests = np.array([0.0, TURNS_DEG[number // 3]])
    clips = []
    for k, name in enumerate(names):
        aside = np.append(rng.uniform(-2.0, 2.0, 2), 0.0)
        clip = lent(name, (float(starts[k]), float(rests[k])), aside, who, rng)
        clips.append(replace(clip, name=f"{k}"))
    who = replace(who, clips=tuple(clips))
    blend = blend_character(who, ("0", "1"), 0.5)
    heads = headings_deg(who, blend.clip.poses.rigid)
    legs = fitted_legs(legs_of(who.skeleton), who)
    share = (blend.clip.time_s - blend.clip.time_s[0]) / blend.clip.duration_s
    off, own = 0.0, 0.0
    for k, clip in enumerate(clips):
        alone = grounded(clip, who.skeleton, legs)
        source = closed(alone.clip, np.inf) if alone.cycle else alone.clip
        clock = share * source.duration_s if blend.in_phase else blend.clip.time_s
        facing = headings_deg(who, source.at(source.time_s[0] + clock).rigid)
        # Of what is in phase from elsewhere on, each moment lies between some of the other's.
        other = np.clip(heads, facing.min(), facing.max()) if blend.in_phase and k else facing
        off = max(off, apart_deg(heads, other))
        own = max(own, float(np.abs(np.diff(facing)).max()))
    step = float(np.abs(np.diff(heads)).max()) - own
    gone = slide(blend)
    fine = off <= HEADING_DEG and step <= STEP_DEG and gone <= SLIDE
    title = f"{rig}: " + " + ".join(
        f"{name} {start:.0f}/{rest:.0f}"
        for name, start, rest in zip(names, starts, rests, strict=True)
    )
    figures = f"heading {off:5.1f}  step {step:5.1f}  slide {gone:.4f}"
    said = "; ".join(blend.notices)
    print(f"{number:3d} {title:58s} {figures} {'' if fine else 'MISS'} {said}", flush=True)
    return title, fine, blend


def sheet(blends: list[tuple[str, Blend]], file: Path, moments: int = 12) -> None:
    """Moments of each blend side by side, from ahead and to the left."""
    from PIL import Image

    from motorcade.render.overlay import show_clip

    rows = []
    for _, blend in blends:
        clock = np.linspace(blend.clip.time_s[0], blend.clip.time_s[-1], moments)
        chosen = Clip("moments", np.arange(moments) / 30.0, blend.clip.at(clock).rigid)
        frames = list(show_clip(blend.character, chosen, (120, 160)))[:moments]
        rows.append(np.concatenate(frames, axis=1))
    Image.fromarray(np.concatenate(rows)[..., ::-1]).save(file)


def main() -> int:
    """Draw, blend, measure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--sheet", type=Path)
    arguments = parser.parse_args()
    missed, blends = 0, []
    for number in range(arguments.first, arguments.first + arguments.count):
        title, fine, blend = row(number, np.random.default_rng([arguments.seed, number]))
        missed += not fine
        blends.append((title, blend))
    print(f"{missed} of {arguments.count} beyond {HEADING_DEG}, {STEP_DEG} degrees or {SLIDE}")
    if arguments.sheet is not None:
        sheet(blends, arguments.sheet)
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
