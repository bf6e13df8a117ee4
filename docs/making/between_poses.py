"""A mesh between two whole poses, without its skeleton, beside a blend joint by joint.

``python -m docs.making.between_poses OUT`` draws both at three shares of the way, into
``gallery_between.jpg``, and prints how they compare: the volume that is kept on the way, the way of
a hand, and how evenly the vertices move.

Wareham and Lasenby (2008): some vertices know how they move from one pose to the other; every other
one takes the mean of their motors' logarithms by its nearness to them.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from docs.making.gallery import QUALITY, PosedPart, drawn
from motorcade.animation import Character, blend_poses, mannequin, skin
from motorcade.animation.blend import stacked
from motorcade.animation.skin import PoseField
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

SHARPNESS = 4.0
EVERY = 12
"""Of so many vertices one knows how it moves from pose to pose."""
SHARES = np.linspace(0.0, 1.0, 21)
SHOWN = (0.0, 0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True, eq=False)
class Way:
    """A mesh on its way between two poses.

    Attributes:
        vertices_m: (S, V, 3).
        normals: (S, V, 3).
    """

    vertices_m: FloatArray
    normals: FloatArray


def by_field(figure: Character, start: Motor, end: Motor, shares: FloatArray) -> Way:
    """The mesh in its first pose, carried by the motors of a twelfth of its vertices.

    Nearness is told in the rest pose, where arms are away from the body.

    Args:
        figure: whose mesh.
        start: pose ``(J,)``.
        end: pose ``(J,)``.
        shares: (S,) of the way.
    """
    skeleton = figure.skeleton
    joints = skeleton.world(end) @ skeleton.world(start).inverse()
    near = joints.log()[figure.joints]
    logs = np.sum(figure.weights[..., None] * near, axis=1)
    _, own = np.unique(figure.vertices.round(4), axis=0, return_index=True)
    own = own[::EVERY]
    field = PoseField(figure.vertices[own], Motor.exp(logs[own]), SHARPNESS)
    vertices, normals = skin(figure, start, "motor")
    made = []
    for share in shares:
        motion = field.at(figure.vertices, share)
        made.append((motion.apply(vertices), motion.rotor.apply(normals)))
    return Way(*(np.stack(part) for part in zip(*made, strict=True)))


def by_joints(figure: Character, start: Motor, end: Motor, shares: FloatArray) -> Way:
    """The mesh skinned in poses that are blended joint by joint; arguments as above."""
    pair = stacked([start, end])
    poses = [blend_poses(pair, [1.0 - share, share], "motor") for share in shares]
    made = [skin(figure, pose, "motor") for pose in poses]
    return Way(*(np.stack(part) for part in zip(*made, strict=True)))


def volumes_m3(figure: Character, way: Way) -> FloatArray:
    """Volumes (S,) of the closed meshes on the way."""
    corners = way.vertices_m[:, figure.triangles]
    a, b, c = (corners[:, :, k] for k in range(3))
    return np.asarray(np.sum(a * np.cross(b, c), axis=(1, 2)) / 6.0)


def measures(figure: Character, way: Way, vertex: int, ends_m3: FloatArray) -> dict[str, float]:
    """What a way costs: how far its volume is off, and the path of one vertex.

    Args:
        figure: whose mesh.
        way: at `SHARES`.
        vertex: whose path is told.
        ends_m3: (2,) volumes of the two poses.


    Returns:
        "volume off": largest share of the straight line between both poses' volumes;
        "way": length of the vertex's path, metres; "bend": its largest distance from the straight
        line, metres; "unevenness": largest step of any vertex over the mean of its steps.
    """
    expected = np.interp(SHARES, [0.0, 1.0], ends_m3)
    path = way.vertices_m[:, vertex]
    chord = path[-1] - path[0]
    off = np.cross(path - path[0], chord) / np.linalg.norm(chord)
    steps = np.linalg.norm(np.diff(way.vertices_m, axis=0), axis=-1)
    moving = steps.mean(axis=0) > 1e-3
    return {
        "volume off": float(np.max(np.abs(volumes_m3(figure, way) / expected - 1.0))),
        "way": float(np.linalg.norm(np.diff(path, axis=0), axis=-1).sum()),
        "bend": float(np.linalg.norm(off, axis=-1).max()),
        "unevenness": float((steps.max(axis=0) / steps.mean(axis=0))[moving].max()),
    }


def compared() -> tuple[Character, dict[str, Way], dict[str, dict[str, float]]]:
    """From standing to waving by both, and their measures."""
    figure = mannequin()
    start, end = figure.clip("idle").at(0.0), figure.clip("wave").at(1.7)
    assert isinstance(start, Motor)
    assert isinstance(end, Motor)
    hand = figure.skeleton.index("right_middle_3")
    vertex = int(np.argmax(figure.weights[:, 0] * (figure.joints[:, 0] == hand)))
    ways = {
        "field": by_field(figure, start, end, SHARES),
        "joints": by_joints(figure, start, end, SHARES),
    }
    ends_m3 = volumes_m3(figure, ways["joints"])[[0, -1]]
    found = {name: measures(figure, way, vertex, ends_m3) for name, way in ways.items()}
    return figure, ways, found


def main(out: Path) -> None:
    """Write the image and print the measures."""
    import cv2

    figure, ways, found = compared()
    for name, values in found.items():
        print(f"{name}: " + ", ".join(f"{key} {value:.4f}" for key, value in values.items()))
    rows = []
    for way in ways.values():
        shown = [int(np.argmin(np.abs(SHARES - share))) for share in SHOWN]
        parts = [
            PosedPart(figure, way.vertices_m[k] + [0.0, 0.95 * (number - 2.0), 0.0], way.normals[k])
            for number, k in enumerate(shown)
        ]
        rows.append(drawn(parts, size=(1500, 480)))
    image = np.ascontiguousarray(np.vstack(rows)[..., ::-1])
    out.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(out / "gallery_between.jpg"), image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m docs.making.between_poses OUT")
    main(Path(sys.argv[1]))
