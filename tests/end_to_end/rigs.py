"""`python -m tests.end_to_end.rigs [--rig R] [--motion M]`: rigs stand, and lend their motions.

Two tables. Of each character of `rigs` and `looks` in the folder that `MOTORCADE_DATA` names: how
far its feet point from +x and how high its lowest sole lies at rest, skinned, as shares of its
height; how many of its clips stand (`standing_height_m`), how many of these do so beyond the bound
as their author left them, and how far the worst is off once put on its soles, by the median over
moments in which the lowest sole is at rest. `--clips` lists them. Of each motion on each rig: how
far limbs point from where the source's do, how much farther knees and elbows bend beside their
hinges, as these lie at rest, than the source's do, in what share of moments shins are crossed that
are not in the source, and how high the lowest sole lies where the source stands. `--sheet FILE`
draws the pairs. Ends with 1 where a figure is beyond its bound.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from motorcade.animation import Character, Clip, Skeleton
from motorcade.animation.formats import NoMeshError, read_character, read_motion
from motorcade.animation.ik import fitted_legs
from motorcade.animation.place import on_its_soles
from motorcade.animation.place.anchors import standing_height_m
from motorcade.animation.retarget import body_of, legs_of, retarget
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from tests.bench.data import data_folder

RIGS = {
    "arnaud": "rigs/arnaud/arnaud_fbx.glb",
    "astroboy": "rigs/astroboy/astro_max.dae",
    "knight": "rigs/kaykit/Knight.glb",
    "makehuman": "rigs/makehuman/mh_male_ge53_27k.glb",
    "bob": "rigs/md5/Bob.md5mesh",
    "sinbad": "rigs/sinbad/sinbad.glb",
    "mannequiny": "rigs/zoo/mannequiny-0.3.0.glb",
    "cesium": "looks/models/CesiumMan/CesiumMan.glb",
    "fox": "looks/models/Fox/Fox.glb",
}
TARGETS = [name for name in RIGS if name != "fox"]
MOTIONS = {
    "walk": ("rigs/arnaud/walk_fbx.glb", 0),
    "jog": ("rigs/arnaud/jog_fbx.glb", 0),
    "run": ("rigs/arnaud/run_fbx.glb", 0),
    "cmu": ("rigs/bvh/01_01.bvh", 0),
    "dab": ("rigs/bvh/fair_dab.bvh", 0),
    "jacks": ("rigs/bvh/jumping_jacks.bvh", 0),
    "dance": ("rigs/zoo/jesse_dance.bvh", 0),
    "astro walk": ("rigs/astroboy/astro_max.dae", 0),
    "knight walk": ("rigs/kaykit/Knight.glb", "Walking_A"),
    "mannequiny run": ("rigs/zoo/mannequiny-0.3.0.glb", "run"),
    "sinbad run": ("rigs/sinbad/sinbad.glb", "RunBase"),
    "bob": ("rigs/md5/Bob.md5mesh", 0),
    "cesium walk": ("looks/models/CesiumMan/CesiumMan.glb", 0),
}
STRIDING = ("walk", "jog", "run", "dance")
"""Motions whose rest pose is a moment of them: it does not tell hinges."""
MOMENTS = 60
# Bounds: degrees of feet from +x, of limbs and of twists; shares of the height and of moments.
FACING_DEG, LIMBS_DEG, TWIST_DEG, GROUND, CROSSED = 20.0, 15.0, 25.0, 0.01, 0.02
LOW_SHARE = 0.2
# Soles are at rest that go up or down slower than this, in heights a second.
AT_REST = 0.1
# Limbs bent by less have no plane.
BENT_RAD = np.radians(25.0)
SIDES = ("left", "right")
LIMBS = (("thigh", "calf", "foot"), ("upper_arm", "forearm", "hand"))


@lru_cache(maxsize=32)
def character(name: str) -> Character:
    """One of the rigs."""
    return read_character(data_folder() / RIGS[name])


@lru_cache(maxsize=32)
def motion(name: str) -> tuple[Clip, Skeleton]:
    """One of the motions, and whose it is."""
    file, which = MOTIONS[name]
    path = data_folder() / file
    try:
        found = read_character(path)
    except NoMeshError:
        made = read_motion(path)
        return made.clips[0], made.skeleton
    clips = {clip.name: clip for clip in found.clips}
    clip = found.clips[which] if isinstance(which, int) else clips.get(which, found.clips[0])
    return clip, found.skeleton


def moments(clip: Clip) -> FloatArray:
    """Times spread over a clip."""
    return np.linspace(clip.time_s[0], clip.time_s[-1], MOMENTS)


def soles(who: Character) -> FloatArray:
    """Vertices that mostly follow feet or what hangs on them; all where there are no feet."""
    heaviest = who.joints[np.arange(len(who.joints)), np.argmax(who.weights, axis=1)]
    feet = [who.skeleton.index(leg.ankle) for leg in legs_of(who.skeleton)]
    below = np.isin(np.arange(len(who.skeleton)), feet)
    for joint, parent in enumerate(who.skeleton.parents):
        below[joint] |= parent >= 0 and below[parent]
    rows = np.flatnonzero(below[heaviest])
    return rows if len(rows) else np.arange(len(who.vertices))


def lowest(who: Character, poses: Motor) -> FloatArray:
    """Height of the lowest sole as a share of the figure's, ``(F,)``, skinned by matrices."""
    rows = soles(who)
    rows = rows[np.argsort(who.vertices[rows, 2])[:400]]
    moved = who.skeleton.world(poses).as_matrix() @ who.skeleton.rest_world_inverse.as_matrix()
    each = moved[:, who.joints[rows]][..., 2, :]
    places = np.concatenate([who.vertices[rows], np.ones((len(rows), 1))], axis=1)
    heights = np.einsum("fvki,vi,vk->fv", each, places, who.weights[rows])
    return np.asarray(heights.min(axis=1) / who.height_m)


@dataclass
class Row:
    """Figures of one rig, or of one motion on it, and which are beyond their bounds."""

    name: str
    figures: dict[str, float] = field(default_factory=dict)
    missed: list[str] = field(default_factory=list)

    def put(self, name: str, value: float, bound: float) -> None:
        """One figure."""
        self.figures[name] = value
        if not abs(value) <= bound:
            self.missed.append(name)

    def __str__(self) -> str:
        told = "  ".join(f"{name} {value:7.3f}" for name, value in self.figures.items())
        return f"{self.name:28s} {told}  {'MISS: ' + ', '.join(self.missed) if self.missed else ''}"


def standing(name: str) -> Row:
    """How a rig faces and stands."""
    who, row = character(name), Row(name)
    rows, rest = soles(who), who.skeleton.rest_world.translation_m
    legs = legs_of(who.skeleton)
    ankles = rest[[who.skeleton.index(leg.ankle) for leg in legs]].mean(axis=0)
    feet = who.vertices[rows]
    ahead = 0.5 * (feet[:, 0].max() + feet[:, 0].min()) - ankles[0]
    aside = 0.5 * (feet[:, 1].max() + feet[:, 1].min()) - ankles[1]
    row.put("facing_deg", float(np.degrees(np.arctan2(aside, ahead))), FACING_DEG)
    body = body_of(who.skeleton)
    wrong = [
        side
        for side, sign in zip(SIDES, (1, -1), strict=True)
        if sign * rest[body[f"{side}_thigh"], 1] <= 0.0
    ]
    row.put("sides_wrong", float(len(wrong)), 0.0)
    row.put("rest", float(feet[:, 2].min() / who.height_m), GROUND)
    heights = clip_heights(name)
    stand = [one for one in heights.values() if one is not None]
    row.figures |= {"clips": len(heights), "standing": len(stand)}
    row.figures["authored_beyond"] = sum(abs(authored) > GROUND for authored, _ in stand)
    row.put("placed", max((abs(placed) for _, placed in stand), default=0.0), GROUND)
    return row


def clip_heights(name: str) -> dict[str, tuple[float, float] | None]:
    """By clip how high its lowest sole is while at rest, skinned: as authored, and once placed.

    None for clips that do not stand.
    """
    who = character(name)
    legs, found = fitted_legs(legs_of(who.skeleton), who), {}
    for clip in who.clips:
        stands = standing_height_m(who, legs, clip) is not None
        both = (clip, on_its_soles(who, legs, clip)[0])
        found[clip.name] = tuple(_level(who, one) for one in both) if stands else None
    return found


def _level(who: Character, clip: Clip) -> float:
    step_s = min(0.01, clip.duration_s)
    first = np.linspace(clip.time_s[0], clip.time_s[-1] - step_s, MOMENTS)
    low, after = (lowest(who, clip.at(at).rigid) for at in (first, first + step_s))
    return float(np.median(low[np.abs(after - low) <= AT_REST * step_s]))


def played(clip: Clip, source: Skeleton, who: Character) -> Clip:
    """A motion as a rig plays it, on its own soles."""
    legs = fitted_legs(legs_of(who.skeleton), who)
    return retarget(clip, source, who.skeleton, legs=legs)


def on_rig(name: str, rig: str) -> Row:
    """One motion on one rig."""
    (clip, source), who = motion(name), character(rig)
    row, target = Row(f"{name} on {rig}"), who.skeleton
    made = played(clip, source, who)
    times = moments(clip)
    theirs, ours = (s.world(c.at(times).rigid) for s, c in ((source, clip), (target, made)))
    row.put("limbs_deg", _limbs_deg(source, theirs, target, ours), LIMBS_DEG)
    own = _hinges_deg(source, theirs) if name not in STRIDING else 0.0
    row.put("twist_deg", max(0.0, _hinges_deg(target, ours) - own), TWIST_DEG)
    crossed = _crossed(target, ours) & ~_crossed(source, theirs)
    row.put("crossed", float(np.mean(crossed)), CROSSED)
    heights = lowest(who, made.at(times).rigid)
    row.put("ground", float(np.quantile(heights, LOW_SHARE)), GROUND)
    row.put("sunk", float(min(np.quantile(heights, 0.02), 0.0)), 2.0 * GROUND)
    return row


def _limbs(skeleton: Skeleton, world: Motor) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    body, at = body_of(skeleton), world.translation_m
    for side in SIDES:
        for limb in LIMBS:
            joints = [body[f"{side}_{part}"] for part in limb]
            bones = np.diff(at[:, joints], axis=1)
            bones /= np.linalg.norm(bones, axis=-1, keepdims=True)
            yield f"{side}_{limb[0]}", bones[:, 0], bones[:, 1]


def _limbs_deg(source: Skeleton, theirs: Motor, target: Skeleton, ours: Motor) -> float:
    """The 95th percentile of angles between bones of limbs, over limbs and moments."""
    pairs = zip(_limbs(source, theirs), _limbs(target, ours), strict=True)
    off = [
        np.arccos(np.clip(np.sum(a * b, axis=-1), -1.0, 1.0))
        for one, other in pairs
        for a, b in zip(one[1:], other[1:], strict=True)
    ]
    return float(np.degrees(np.quantile(off, 0.95)))


def _hinges_deg(target: Skeleton, ours: Motor) -> float:
    """How far bent knees and elbows bend beside the hinges that the rest pose has, 90th percentile.

    A hinge at rest lies across the upper bone and the way in which a limb bends: knees back,
    elbows forward. It is carried by the upper bone's joint.
    """
    body, rest = body_of(target), target.rest_world
    off = []
    at_rest = {one[0]: one[1:] for one in _limbs(target, rest.reshape(1, -1))}
    for role, upper, lower in _limbs(target, ours):
        joint = body[role]
        way = np.array([-1.0, 0.0, 0.0]) if "thigh" in role else np.array([1.0, 0.0, 0.0])
        hinge = np.cross(at_rest[role][0][0], way)
        hinge = ours[:, joint].rotor.apply(rest[joint].rotor.inverse().apply(hinge))
        plane = np.cross(upper, lower)
        bent = np.arcsin(np.clip(np.linalg.norm(plane, axis=-1), 0.0, 1.0)) > BENT_RAD
        if np.any(bent):
            cosine = np.sum(plane * hinge, axis=-1)[bent]
            size = np.linalg.norm(plane, axis=-1) * np.linalg.norm(hinge, axis=-1)
            off.append(np.arccos(np.clip(cosine / size[bent], -1.0, 1.0)))
    return float(np.degrees(np.quantile(np.concatenate(off), 0.9))) if off else 0.0


def _crossed(skeleton: Skeleton, world: Motor) -> FloatArray:
    """Whether the left ankle is to the right of the right one by more than half the hips' width."""
    body, at = body_of(skeleton), world.translation_m
    hips = at[:, body["left_thigh"]] - at[:, body["right_thigh"]]
    width = np.linalg.norm(hips, axis=-1)
    feet = at[:, body["left_foot"]] - at[:, body["right_foot"]]
    return np.asarray(np.sum(feet * hips, axis=-1) / width < -0.5 * width)


def main(arguments: list[str] | None = None) -> int:
    """Print the tables; 1 where something is beyond its bound."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.rigs")
    parser.add_argument("--rig", choices=list(RIGS), help="this one alone")
    parser.add_argument("--motion", choices=list(MOTIONS), help="this one alone")
    parser.add_argument("--sheet", type=Path, help="draw motions on rigs into this image")
    parser.add_argument("--clips", action="store_true", help="list which clips stand, and how high")
    given = parser.parse_args(arguments)
    rigs = [given.rig] if given.rig else list(RIGS)
    rows = [] if given.motion else [standing(name) for name in rigs]
    for row in rows:
        print(row, flush=True)
        for clip, heights in clip_heights(row.name).items() if given.clips else ():
            told = (
                "does not stand" if heights is None else "{:7.4f}, placed {:7.4f}".format(*heights)
            )
            print(f"    {clip:32s} {told}")
    targets = [name for name in rigs if name in TARGETS]
    for name in [given.motion] if given.motion else list(MOTIONS):
        for rig in targets:
            rows.append(on_rig(name, rig))
            print(rows[-1], flush=True)
    missed = sum(bool(row.missed) for row in rows)
    print(f"{len(rows) - missed} of {len(rows)} within their bounds")
    if given.sheet:
        _draw(given.sheet, targets, [given.motion] if given.motion else list(MOTIONS))
    return int(missed > 0)


def _draw(path: Path, rigs: list[str], motions: list[str]) -> None:
    """Each motion on each rig at one moment, sides red and blue, seen from the front left."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(
        len(motions),
        len(rigs) + 1,
        figsize=(1.6 * len(rigs) + 1.6, 2.0 * len(motions)),
        squeeze=False,
    )
    for line, name in zip(axes, motions, strict=True):
        clip, source = motion(name)
        time_s = clip.time_s[0] + 0.4 * clip.duration_s
        shown = [("source", source, clip)] + [
            (rig, character(rig).skeleton, played(clip, source, character(rig))) for rig in rigs
        ]
        for ax, (title, skeleton, one) in zip(line, shown, strict=True):
            _figure(ax, skeleton, skeleton.world(one.at(time_s).rigid).translation_m)
            ax.set_title(f"{name}: {title}", fontsize=6)
    figure.tight_layout()
    figure.savefig(path, dpi=70)


def _figure(ax, skeleton: Skeleton, at: FloatArray) -> None:  # type: ignore[no-untyped-def]
    roles = {joint: role for role, joint in body_of(skeleton).items()}
    for joint, parent in enumerate(skeleton.parents):
        if parent < 0 or joint not in roles:
            continue
        while parent >= 0 and parent not in roles:
            parent = skeleton.parents[parent]
        if parent < 0:
            continue
        side = roles[joint].partition("_")[0]
        ends = at[[parent, joint]]
        flat = 0.6 * ends[:, 0] + 0.8 * ends[:, 1]
        ax.plot(flat, ends[:, 2], {"left": "r", "right": "b"}.get(side, "0.4"), lw=1.0)
    ax.axhline(0.0, color="g", lw=0.5)
    ax.set_aspect("equal")
    ax.axis("off")


if __name__ == "__main__":
    sys.exit(main())
