"""Maps as SLAM would give them, of scenes whose up is known; and a table of what is stood on.

    python -m tests.tracking.planes.drawn_stands [SEED]

A scene has points with noise and outliers, the path of a hand that films it, and what of it is
right to stand on. Nothing is rendered: lines in images tell nothing here.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses, PoseOrigin
from motorcade.replays.stages.view.anchored import Grounds
from motorcade.replays.stages.view.ground import Ground
from motorcade.tracking import Checkerboard, PoseMeasurements
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.corner_stream import CornerStream

CAMERA = Camera(640, 480, 560.0, 560.0, 319.5, 239.5)
UP = np.array([0.0, 0.0, 1.0])
RIGHT_DEG = 5.0
TILTS_DEG = (10, 25, 40, 55, 70, 85)
NOISE = 0.004
BOARD = Checkerboard(columns=8, rows=6, square_m=0.03)


@dataclass(frozen=True)
class DrawnScene:
    """A map, the camera's path, and at which heights there is something to stand on."""

    name: str
    points: FloatArray
    path: Trajectory
    heights: tuple[float, ...]
    board: Motor | None = None
    upright: bool = False


@dataclass(frozen=True)
class Outcome:
    """What was stood on: how far its up is off, how far its height, and whether it is doubted."""

    name: str
    ground: Ground
    off_deg: float
    off_height: float

    @property
    def right(self) -> bool:
        """Upright within 5 degrees, on something."""
        return self.off_deg <= RIGHT_DEG and self.off_height <= 1.0


def looking(eye: FloatArray, at: FloatArray, roll_deg: float = 0.0) -> Motor:
    """A camera at `eye` that looks at a point, upright but for its roll."""
    z = at - eye
    z /= np.linalg.norm(z)
    x = np.cross(z, UP)
    x /= np.linalg.norm(x)
    turn = Rotor.from_matrix(np.stack([x, np.cross(z, x), z], axis=-1))
    return Motor.from_rotor_translation(
        turn @ Rotor.from_rotation_vector([0.0, 0.0, np.deg2rad(roll_deg)]), eye
    )


def by_hand(
    rng: np.random.Generator, eye: FloatArray, at: FloatArray, walk: FloatArray | None = None
) -> Trajectory:
    """Two seconds: a hand that sways about a place and rolls by a few degrees, or that walks."""
    count = 60
    time_ns = np.arange(count) * 33_333_333
    sway = np.cumsum(rng.normal(0.0, 0.01, (count, 3)), axis=0) * min(1.0, np.linalg.norm(at - eye))
    roll = rng.normal(0.0, 2.0) + np.cumsum(rng.normal(0.0, 0.2, count))
    go = np.zeros(3) if walk is None else walk
    along = np.linspace(0.0, 1.0, count)[:, None] * go
    poses = [looking(eye + s + a, at + a, r) for s, a, r in zip(sway, along, roll, strict=True)]
    return Trajectory(time_ns, Motor.stack(poses))


def seen(points: FloatArray, path: Trajectory, rng: np.random.Generator) -> FloatArray:
    """Points that are in the image at some time, with noise along the ray, and outliers."""
    kept = np.zeros(len(points), dtype=bool)
    for k in (0, len(path) // 2, -1):
        local = path.motors[k].inverse().apply(points)
        px = CAMERA.project(np.where(local[:, 2:] > 0.05, local, [0.0, 0.0, 1.0]))
        inside = np.all((px > 0) & (px < [CAMERA.width, CAMERA.height]), axis=1)
        kept |= inside & (local[:, 2] > 0.05)
    points, eye = points[kept], path.motors.translation_m.mean(axis=0)
    away = points - eye
    noise = 1.0 + rng.normal(0.0, NOISE, (len(points), 1)) * rng.exponential(1.0, (len(points), 1))
    strays = rng.random(len(points)) < 0.05
    noise[strays] = rng.uniform(0.5, 1.5, (int(strays.sum()), 1))
    return np.asarray(eye + noise * away)


def box(rng: np.random.Generator, low: FloatArray, high: FloatArray, count: int) -> FloatArray:
    """Points on the sides and the top of a box."""
    points = rng.uniform(low, high, (count, 3))
    side = rng.integers(0, 5, count)
    for axis in (0, 1):
        points[side == axis, axis] = np.asarray(low)[axis]
        points[side == axis + 2, axis] = np.asarray(high)[axis]
    points[side == 4, 2] = np.asarray(high)[2]
    return points


def surface(
    rng: np.random.Generator, low: tuple[float, ...], high: tuple[float, ...], count: int
) -> FloatArray:
    """Points of a flat thing: one of the extents is none."""
    return rng.uniform(low, high, (count, 3))


def table_from(rng: np.random.Generator, tilt_deg: float, things: bool) -> DrawnScene:
    """A table, with or without things on it, from so many degrees above."""
    points = [surface(rng, (-0.8, -0.6, 0.0), (0.8, 0.6, 0.0), 700)]
    for _ in range(3 if things else 0):
        at = np.append(rng.uniform(-0.5, 0.5, 2), 0.0)
        points.append(box(rng, at, at + rng.uniform(0.08, 0.2, 3), 60))
    tilt, away = np.deg2rad(tilt_deg), rng.uniform(0.9, 1.4)
    turn = rng.uniform(-np.pi, np.pi)
    flat = np.array([np.cos(turn), np.sin(turn)]) * np.cos(tilt)
    path = by_hand(rng, away * np.append(flat, np.sin(tilt)), np.zeros(3))
    name = f"table from {tilt_deg:g} deg" + (", things on it" if things else "")
    return DrawnScene(name, seen(np.concatenate(points), path, rng), path, (0.0, 0.2))


def room(rng: np.random.Generator) -> DrawnScene:
    """A floor and two walls, walked through."""
    floor = surface(rng, (-2.0, 0.0, 0.0), (2.0, 6.0, 0.0), 350)
    back = surface(rng, (-2.0, 6.0, 0.0), (2.0, 6.0, 2.5), 350)
    side = surface(rng, (-2.0, 0.0, 0.0), (-2.0, 6.0, 2.5), 300)
    at = np.array([-1.2, 3.0, 0.0])
    sofa = box(rng, at, at + np.array([0.8, 1.5, 0.45]), 150)
    path = by_hand(rng, np.array([0.4, -2.5, 1.5]), np.array([0.0, 3.5, 0.6]), np.array([0, 1, 0]))
    points = np.concatenate([floor, back, side, sofa])
    return DrawnScene("room, walked through", seen(points, path, rng), path, (0.0, 0.45))


def wall_alone(rng: np.random.Generator) -> DrawnScene:
    """A facade, seen from below: nothing in view is level."""
    wall = surface(rng, (-3.0, 6.0, 0.0), (3.0, 6.0, 6.0), 800)
    eye = np.array([rng.uniform(-2, 2), 0.0, 1.5])
    path = by_hand(rng, eye, np.array([0.0, 6.0, 3.0]))
    return DrawnScene("wall alone, from below", seen(wall, path, rng), path, ())


def bushes(rng: np.random.Generator) -> DrawnScene:
    """Leaves in clumps on rough ground, walked towards."""
    clumps = rng.uniform([-3.0, 1.5, 0.3], [3.0, 8.0, 1.6], (14, 3))
    leaves = clumps[rng.integers(0, 14, 600)] + rng.normal(0.0, 0.35, (600, 3))
    leaves = leaves[leaves[:, 2] > 0.0]
    ground = surface(rng, (-2.0, 1.0, 0.0), (2.0, 8.0, 0.0), 150)
    ground[:, 2] = rng.normal(0.0, 0.08, len(ground))
    path = by_hand(rng, np.array([0.0, -2.0, 1.6]), np.array([0.0, 4.0, 0.9]), np.array([0, 1, 0]))
    points = np.concatenate([leaves, ground])
    return DrawnScene("bushes, walked towards", seen(points, path, rng), path, (0.0,))


def trunks(rng: np.random.Generator) -> DrawnScene:
    """Trunks and leaves above, hardly any ground."""
    feet = rng.uniform([-4.0, 2.0, 0.0], [4.0, 10.0, 0.0], (12, 3))
    stems = feet[rng.integers(0, 12, 500)] + np.stack(
        [rng.normal(0, 0.12, 500), rng.normal(0, 0.12, 500), rng.uniform(0.0, 4.0, 500)], axis=-1
    )
    leaves = rng.uniform([-4.0, 2.0, 2.0], [4.0, 10.0, 5.0], (300, 3))
    ground = surface(rng, (-3.0, 1.0, 0.0), (3.0, 8.0, 0.0), 80)
    ground[:, 2] = rng.normal(0.0, 0.06, len(ground))
    path = by_hand(rng, np.array([0.0, -1.0, 1.6]), np.array([0.0, 6.0, 1.4]), np.array([0, 1, 0]))
    points = np.concatenate([stems, leaves, ground])
    return DrawnScene("trunks, walked towards", seen(points, path, rng), path, (0.0,))


def stairs(rng: np.random.Generator) -> DrawnScene:
    """Ten steps that lead up before a landing."""
    steps = [surface(rng, (-1.0, 0.0, 0.0), (1.0, 2.0, 0.0), 150)]
    for k in range(10):
        y, z = 2.0 + 0.28 * k, 0.17 * k
        steps.append(surface(rng, (-1.0, y, z), (1.0, y, z + 0.17), 40))
        steps.append(surface(rng, (-1.0, y, z + 0.17), (1.0, y + 0.28, z + 0.17), 50))
    path = by_hand(rng, np.array([0.3, -1.5, 1.6]), np.array([0.0, 3.0, 0.6]))
    heights = tuple(0.17 * k for k in range(11))
    return DrawnScene("stairs", seen(np.concatenate(steps), path, rng), path, heights)


def board(rng: np.random.Generator, kind: str) -> DrawnScene:
    """A board that lies, leans by 70 degrees, or stands, and what was filmed of it."""
    lean = {"lying": 0.0, "leaning": 70.0, "upright": 90.0}[kind]
    middle = np.array([0.12, -0.09, 0.0])  # of the print, in its own frame
    turn = Rotor.from_rotation_vector([np.deg2rad(lean), 0.0, 0.0])
    pose = Motor.from_rotor_translation(turn, -turn.apply(middle))
    down = np.deg2rad(rng.uniform(30.0, 65.0) if kind == "lying" else rng.uniform(-5.0, 30.0))
    away = rng.uniform(0.4, 0.7)
    eye = away * np.array([rng.uniform(-0.2, 0.2), -np.cos(down), np.sin(down)])
    path = by_hand(rng, eye, np.zeros(3))
    top = float(turn.apply([0.0, 0.12, 0.0])[2])
    return DrawnScene(f"board {kind}", np.zeros((0, 3)), path, (0.0, top), pose, kind != "lying")


def thirty(rng: np.random.Generator) -> Iterator[DrawnScene]:
    """Thirty scenes, of every kind."""
    for tilt in TILTS_DEG:
        yield table_from(rng, tilt, things=False)
        yield table_from(rng, tilt, things=True)
    for scene in (room, wall_alone, bushes, trunks, stairs):
        for _ in range(2):
            yield scene(rng)
    for kind in ("lying", "leaning", "upright"):
        for _ in range(3 if kind != "leaning" else 2):
            yield board(rng, kind)


def stood(scene: DrawnScene, unit: float = 1.0, **knobs: int) -> Outcome:
    """What is chosen of a scene, in a world that begins with the first camera."""
    first = scene.path.motors[0].inverse()
    path = scene.path.transformed_by(left=first)
    sure = np.tile(np.eye(6) * 1e-6, (len(path), 1, 1))
    nothing = np.zeros(0, dtype=np.int64)
    stream = CornerStream(CAMERA, path.time_ns, nothing, nothing, np.zeros((0, 4, 2)))
    # Corners, of which there are none: no images, and so no lines in them.
    frames = CornerFrames(Path(), {"camera": stream}, {"camera": Motor.identity()}, {})
    recording = Recording("drawn", Path(), "images", frames, camera=CAMERA)
    origin: PoseOrigin = "slam"
    if scene.board is not None:
        origin = "board"
        recording = replace(recording, board=BOARD, world_T_board=first @ scene.board)
    poses = CameraPoses(
        PoseMeasurements(path, sure),
        path.time_ns,
        np.full(len(path), np.nan),
        origin,
        "drawn",
        metric=False,
        points=first.apply(scene.points),
    )
    ground, _ = Grounds(recording, poses, None, path).asked("auto", choice=knobs.get("choice", 0))
    world_T_plane = first.inverse() @ ground.world_T_plane
    up = world_T_plane.rotor.apply(UP)
    off = float(np.rad2deg(np.arccos(np.clip(up @ UP, -1.0, 1.0))))
    foot = float(world_T_plane.apply([*ground.position_m, 0.0])[2])
    nearest = min((abs(foot - height) for height in scene.heights), default=np.inf)
    return Outcome(scene.name, ground, off, nearest / max(ground.height_m, 1e-9))


def table(seed: int) -> str:
    """What is stood on in thirty scenes, a line each, and how many are wrong in silence."""
    lines, wrong = [], 0
    for scene in thirty(np.random.default_rng(seed)):
        outcome = stood(scene)
        silent = not outcome.right and not outcome.ground.doubt
        wrong += silent
        verdict = "right" if outcome.right else "WRONG" if silent else "off"
        lines.append(
            f"{scene.name:32} {outcome.off_deg:6.1f} deg {min(outcome.off_height, 9.99):5.2f} h  "
            f"{verdict:6} {outcome.ground.name.split(' found')[0][:34]:34} {outcome.ground.doubt}"
        )
    return "\n".join([*lines, f"{wrong} of {len(lines)} wrong in silence"])


if __name__ == "__main__":
    print(table(int(sys.argv[1]) if len(sys.argv) > 1 else 0))
