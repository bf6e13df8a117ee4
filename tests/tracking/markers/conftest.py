"""Scenes of markers seen by a moving camera, with the ground truth beside what was seen."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Camera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.families import marker_points_m

CAMERA = Camera(640, 480, 500.0, 502.0, 321.0, 238.0, "radtan", (-0.1, 0.02, 1e-4, -2e-4))


@dataclass(frozen=True)
class Scene:
    """Corners with noise, and what was true."""

    stream: CornerStream
    side_m: dict[int, float]
    world_T_camera: Motor
    world_T_marker: Motor

    def camera_T_marker(self) -> Motor:
        """True pose of each detection, ``(N,)``."""
        ids = self.stream.marker_ids
        world_T_camera = self.world_T_camera[self.stream.frame]
        if len(self.world_T_marker.shape) == 2:  # (F, M): markers that move
            return world_T_camera.inverse() @ self.world_T_marker[self.stream.frame, ids]
        return world_T_camera.inverse() @ self.world_T_marker[ids]


def path(frames: int, rng: np.random.Generator, around_m: float = 2.0) -> Motor:
    """A camera that wanders before the wall x, y at z = 0 and looks at its middle."""
    phase = np.linspace(0.0, 0.25 * frames, frames)
    offset = rng.uniform(0.0, 2.0 * np.pi, 3)
    centre = np.stack(
        [
            0.8 * np.sin(phase + offset[0]),
            0.5 * np.sin(1.3 * phase + offset[1]),
            around_m + 0.3 * np.sin(0.7 * phase + offset[2]),
        ],
        axis=-1,
    )
    forward = np.array([0.0, 0.0, 0.0]) - centre
    forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right, axis=-1, keepdims=True)
    axes = np.stack([right, np.cross(forward, right), forward], axis=-1)
    return Motor.from_rotor_translation(Rotor.from_matrix(axes), centre)


def wall(count: int, rng: np.random.Generator, tilt_deg: float = 35.0) -> Motor:
    """Markers near a wall, each tilted its own way."""
    places = rng.uniform([-0.7, -0.5, -0.1], [0.7, 0.5, 0.1], (count, 3))
    tilt = np.radians(tilt_deg) * rng.uniform(-1.0, 1.0, (count, 3))
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(tilt), places)


def seen_by(
    camera: Camera,
    world_T_camera: Motor,
    world_T_marker: Motor,
    side_m: dict[int, float],
    noise_px: float,
    rng: np.random.Generator,
    step_ns: int = 100_000_000,
    start_ns: int = 1_000_000_000,
) -> Scene:
    """What the camera sees of markers that face it, in its image."""
    points = np.stack([marker_points_m(side_m[one]) for one in sorted(side_m)])
    frames, ids, corners = [], [], []
    for frame in range(len(world_T_camera)):
        moving = len(world_T_marker.shape) == 2
        markers = world_T_marker[frame] if moving else world_T_marker
        camera_T_marker = world_T_camera[frame].inverse().reshape(1) @ markers
        before = camera_T_marker[:, None].apply(points)
        pixels = camera.project(before)
        normal = camera_T_marker.rotor.apply([0.0, 0.0, 1.0])
        facing = np.sum(normal * before.mean(axis=1), axis=-1) < -0.05
        limit = (camera.width - 1, camera.height - 1)
        inside = np.all((pixels >= 0) & (pixels <= limit), axis=(-1, -2))
        for marker in np.flatnonzero(facing & inside):
            frames.append(frame)
            ids.append(marker)
            corners.append(pixels[marker] + noise_px * rng.standard_normal((4, 2)))
    time_ns = start_ns + step_ns * np.arange(len(world_T_camera))
    stream = CornerStream(
        camera, time_ns, np.array(frames), np.array(ids), np.array(corners).reshape(-1, 4, 2)
    )
    return Scene(stream, side_m, world_T_camera, world_T_marker)


@pytest.fixture(scope="session")
def scenes() -> SimpleNamespace:
    """The functions above, for tests that arrange their own scenes."""
    return SimpleNamespace(camera=CAMERA, path=path, wall=wall, seen_by=seen_by)


@pytest.fixture
def make_scene():
    """``make_scene(frames, markers, seed, side_m=0.06, noise_px=0.3)``: an ambiguous wall."""

    def make(
        frames: int, markers: int, seed: int, side_m: float = 0.06, noise_px: float = 0.3
    ) -> Scene:
        rng = np.random.default_rng(seed)
        sides = dict.fromkeys(range(markers), side_m)
        return seen_by(CAMERA, path(frames, rng), wall(markers, rng), sides, noise_px, rng)

    return make
