"""Images of what characters can do, drawn of the mannequin: `docs/gallery.md` shows them.

``python -m docs.making.gallery OUT`` writes them all into a folder, and prints the
figures that stand beneath them.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from motorcade.animation import (
    BlendSpace,
    Chain,
    Character,
    Clip,
    GroundPath,
    Skeleton,
    legs_of,
    mannequin,
    reach_with,
    skin,
    walk_along,
)
from motorcade.animation.appearance import Appearance, Material, MaterialPart, to_linear
from motorcade.animation.authoring import EulerObjectPose, ObjectPose, VersorObjectPose
from motorcade.animation.blend import BlendMethod, blend_clips, differences_m
from motorcade.animation.place import on_the_spot
from motorcade.animation.skin import SKIN_METHODS
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.render.scene import ImageArray

__all__ = ["ELBOW", "QUALITY", "SHOULDER", "PosedPart", "bent", "drawn", "images", "volumes_l"]

T = TypeVar("T")

QUALITY = 88
ORANGE = (0.95, 0.45, 0.1)
BLENDED: tuple[BlendMethod, ...] = ("motor", "motor_linear", "quaternion", "euler")
# Turns in the joint's own axes, radians: the forearm about its bone, the arm up and about itself.
ELBOW = ("left_forearm", (0.0, 0.0, 2.6))
SHOULDER = ("left_upper_arm", (1.7, 0.0, 1.2))


def bent(figure: Character, joint: str, turn_rad: Sequence[float]) -> Motor:
    """The rest pose ``(J,)`` with one joint turned by a rotation vector in its own axes."""
    number = figure.skeleton.index(joint)
    poses = figure.skeleton.rest.coefficients.copy()
    turn = Motor.from_rotor_translation(Rotor.from_rotation_vector(np.array(turn_rad)), np.zeros(3))
    poses[number] = (figure.skeleton.rest[number] @ turn).coefficients
    return Motor.normalize(poses)


def volumes_l(figure: Character, pose: Motor) -> dict[str, float]:
    """Litres that the closed mesh holds in a pose by each method, and at "rest"."""
    found = {"rest": _volume_l(figure, figure.vertices)}
    return found | {name: _volume_l(figure, skin(figure, pose, name)[0]) for name in SKIN_METHODS}


def _volume_l(figure: Character, vertices: FloatArray) -> float:
    a, b, c = np.moveaxis(vertices[figure.triangles], 1, 0)
    return float(1e3 * np.sum(a * np.cross(b, c)) / 6.0)


def images() -> dict[str, ImageArray]:
    """All images by name; figures are printed on the way."""
    figure = mannequin()
    return {
        "blend": _blends(figure),
        "elbow": _skinned(figure, ELBOW),
        "shoulder": _skinned(figure, SHOULDER),
        "blend_space": _blend_space(figure),
        "reach": _reaches(figure),
        "path": _path(figure),
        "gesture": _gesture(figure),
    }


def _gaits(figure: Character, *names: str) -> list[tuple[Clip, float]]:
    legs = legs_of(figure.skeleton)
    return [on_the_spot(figure.clip(name), figure.skeleton, legs) for name in names]


def _blends(figure: Character) -> ImageArray:
    """Halfway from walk to run where the methods lie farthest apart."""
    (walk, _), (run, _) = _gaits(figure, "walk", "run")
    for (a, b), apart in differences_m(walk, run, figure.skeleton, methods=BLENDED).items():
        print(f"walk to run, {a} - {b}: {1e3 * apart:.2f} mm")
    made = {name: blend_clips(walk, run, 0.5, name).poses for name in BLENDED}
    world = {name: figure.skeleton.world(poses).translation_m for name, poses in made.items()}
    frame = int(np.argmax(np.linalg.norm(world["motor"] - world["euler"], axis=-1).max(axis=-1)))
    poses = [made[name][frame] for name in BLENDED]
    return drawn([_standing(figure, pose, (0.0, 0.95 * k)) for k, pose in _spread(poses)])


def _skinned(figure: Character, joint: tuple[str, Sequence[float]]) -> ImageArray:
    """One joint turned far, by every method, seen near."""
    pose = bent(figure, *joint)
    for name, volume in volumes_l(figure, pose).items():
        print(f"{joint[0]} turned by {joint[1]}, {name}: {volume:.3f} l")
    tiles = []
    for name in SKIN_METHODS:
        vertices, normals = skin(figure, pose, name)
        at = figure.skeleton.world(pose).translation_m[figure.skeleton.index(joint[0])]
        tiles.append(_near(PosedPart(figure, vertices, normals), at))
    return np.hstack(tiles)


def _blend_space(figure: Character) -> ImageArray:
    """A walk that becomes a jog and a run, at one phase."""
    gaits = _gaits(figure, "walk", "jog", "run")
    speeds = np.array([speed for _, speed in gaits])
    space = BlendSpace(speeds, tuple(clip for clip, _ in gaits))
    values = np.linspace(speeds[0], speeds[-1], 6)
    poses = [space.pose(value, 0.15) for value in values]
    print("speeds in the blend space, m/s:", *(f"{value:.2f}" for value in values))
    return drawn([_standing(figure, pose, (0.0, 0.8 * k)) for k, pose in _spread(poses)])


def _reaches(figure: Character) -> ImageArray:
    """An arm that reaches for a ball."""
    chain = Chain(("left_upper_arm", "left_forearm", "left_hand"))
    targets = np.array([[0.2, 0.25, 1.36], [0.33, 0.2, 1.1], [0.22, 0.3, 0.92], [0.05, 0.47, 1.26]])
    parts, idle = [], figure.clip("idle").at(0.0)
    assert isinstance(idle, Motor)
    for k, target in _spread(list(targets)):
        pose, error_m = reach_with(figure.skeleton, idle, chain, target)
        print(f"reach for {target}: {1e3 * float(error_m):.4f} mm off")
        parts += [
            _standing(figure, pose, (0.0, 1.1 * k)),
            _ball(target + np.array([0.0, 1.1 * k, 0.0])),
        ]
    return drawn(parts)


def _path(figure: Character) -> ImageArray:
    """One walk along a bend, as it is every 0.8 s."""
    walk, speed_m_s = _gaits(figure, "walk")[0]
    path = GroundPath(np.array([[-0.6, -2.6], [0.6, -1.3], [-0.3, 0.2], [0.5, 1.5], [0.2, 2.7]]))
    legs = legs_of(figure.skeleton)
    made = walk_along(path, walk, figure.skeleton, legs, speed_m_s)
    print(f"path of {path.length_m:.2f} m at {speed_m_s:.2f} m/s")
    parts = []
    for frame in range(0, len(made.time_s), 48):
        vertices, normals = skin(figure, made.poses[frame], "motor")
        at = made.plane_T_character[frame]
        parts.append(PosedPart(figure, at.apply(vertices), at.rotor.apply(normals)))
    return drawn(parts, azimuth_rad=0.35)


def _gesture(figure: Character) -> ImageArray:
    """The same four drags on the same rings, by rotors above and by Euler angles below."""
    axes = np.eye(3)
    drags = [(axes[2], 0.9), (axes[1], 1.3), (axes[2], 0.9), (axes[0], 0.8)]
    rows = []
    start = Similarity.from_motor_scale(Motor.identity())
    writings: tuple[ObjectPose, ...] = (
        VersorObjectPose(start),
        EulerObjectPose(np.zeros(3), np.zeros(3)),
    )
    for pose in writings:
        states = [pose.as_similarity()]
        for axis, angle in drags:
            pose = pose.rotated(axis, angle, "local", start)
            states.append(pose.as_similarity())
        parts = []
        middle = 0.5 * figure.height_m
        for k, state in _spread(states):
            up = np.array([0.0, 1.5 * k, middle])
            turned = state.rotor.apply(figure.vertices - [0, 0, middle]) + up
            parts.append(PosedPart(figure, turned, state.rotor.apply(figure.normals)))
        rows.append(drawn(parts, size=(1500, 420), azimuth_rad=0.0))
        print("last state:", np.degrees(states[-1].rotor.as_rotation_vector()).round(1))
    return np.vstack(rows)


class PosedPart:
    """A posed mesh as its character looks, or of one colour."""

    def __init__(self, figure: Character, vertices: FloatArray, normals: FloatArray) -> None:
        self.vertices, self.normals = vertices, normals
        self.triangles, self.colors = figure.triangles, figure.colors
        self.look = figure.appearance


def _standing(figure: Character, pose: Motor | Similarity, at_m: tuple[float, float]) -> PosedPart:
    vertices, normals = skin(figure, pose, "motor")
    return PosedPart(figure, vertices + np.array([*at_m, 0.0]), normals)


def _spread(items: Sequence[T]) -> list[tuple[float, T]]:
    """Places from right to left as the camera sees them, around 0, and what stands there."""
    middle = 0.5 * (len(items) - 1)
    return [(k - middle, item) for k, item in enumerate(items)]


def _ball(at_m: FloatArray, radius_m: float = 0.075) -> PosedPart:
    """A small orange ball."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 25)[:-1], np.linspace(0, np.pi, 13))
    normals = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], -1).reshape(-1, 3)
    a = (np.arange(12)[:, None] * 24 + np.arange(24)).ravel()
    b = (np.arange(12)[:, None] * 24 + (np.arange(24) + 1) % 24).ravel()
    part = PosedPart.__new__(PosedPart)
    part.vertices, part.normals = at_m + radius_m * normals, normals
    part.triangles = np.concatenate([np.stack([a, a + 24, b], 1), np.stack([b, a + 24, b + 24], 1)])
    part.colors, part.look = np.tile(ORANGE, (len(normals), 1)), None
    return part


def _statue(parts: Sequence[PosedPart]) -> Character:
    """All parts as one rigid character."""
    counts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    vertices = np.concatenate([part.vertices for part in parts])
    normals = np.concatenate([part.normals for part in parts])
    one = np.zeros((len(vertices), 4))
    one[:, 0] = 1.0
    still = Motor.identity((1,))
    return Character(
        Skeleton(("all",), np.array([-1]), still),
        vertices,
        normals / np.linalg.norm(normals, axis=1, keepdims=True),
        np.concatenate([part.triangles + n for part, n in zip(parts, counts, strict=False)]),
        np.concatenate([part.colors for part in parts]),
        np.zeros((len(vertices), 4), dtype=np.int64),
        one,
        (Clip("still", np.zeros(1), Motor.stack([still])),),
        appearance=_looks(parts),
    )


def _looks(parts: Sequence[PosedPart]) -> Appearance:
    """The materials of all parts, one after the other."""
    orange = Material("ball", (*to_linear(np.array(ORANGE)).tolist(), 1.0), 0.0, 0.5)
    made: list[MaterialPart] = []
    coordinates, first = [], 0
    for part in parts:
        count = len(part.triangles)
        if part.look is None:
            made.append(MaterialPart(orange, first, first + count))
            coordinates.append(np.zeros((1, len(part.vertices), 2), dtype=np.float32))
        else:
            made += [
                replace(one, first=first + one.first, stop=first + one.stop)
                for one in part.look.parts
            ]
            coordinates.append(part.look.coordinates)
        first += count
    return Appearance(tuple(made), np.concatenate(coordinates, axis=1))


def drawn(
    parts: Sequence[PosedPart], size: tuple[int, int] = (1500, 560), azimuth_rad: float = 0.25
) -> ImageArray:
    """All parts on the stage."""
    from motorcade.render.overlay import show_clip

    statue = _statue(parts)
    return next(iter(show_clip(statue, statue.clips[0], size, azimuth_rad=azimuth_rad)))


def _near(part: PosedPart, at_m: FloatArray, size: int = 360, whole: int = 1500) -> ImageArray:
    """The part of a large image around a point, seen from the front."""
    image = drawn([part], (whole, whole), azimuth_rad=0.0)
    # What `show_clip` looks at lies in the middle; a figure's height is about 0.56 of the image.
    tall = float(part.vertices[:, 2].max())
    scale = 1.35 * whole / (2.3 * tall)
    column = int(0.5 * whole + scale * at_m[1])
    row = int(0.5 * whole - scale * (at_m[2] - 0.48 * tall))
    row, column = (int(np.clip(x, size // 2, whole - size // 2)) for x in (row, column))
    half = size // 2
    return image[row - half : row + half, column - half : column + half]


def main(out: Path) -> None:
    """Write all images as ``gallery_NAME.jpg``."""
    import cv2

    out.mkdir(parents=True, exist_ok=True)
    for name, image in images().items():
        file = out / f"gallery_{name}.jpg"
        bgr = np.ascontiguousarray(image[..., ::-1])
        if not cv2.imwrite(str(file), bgr, [cv2.IMWRITE_JPEG_QUALITY, QUALITY]):
            raise OSError(f"{file}: could not be written")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m docs.making.gallery OUT")
    main(Path(sys.argv[1]))
