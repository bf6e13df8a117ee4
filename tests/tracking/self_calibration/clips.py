"""Corners as a phone would see them, exact but for noise: boards, tags, points; rolling shutter."""

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Camera, Detection
from motorcade.tracking.boards import BoardCorners

FACE_DOWN = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
RATE_HZ = 30.0


def hand(count: int, distance: float, turn_rad: float, phase: float = 0.0) -> Motor:
    """Poses ``camera_T_world`` of a hand that waves round a print whose middle is the origin."""
    t = np.arange(count) / RATE_HZ + phase
    turn = turn_rad * np.stack([np.sin(1.1 * t), np.cos(1.7 * t), 0.4 * np.sin(0.7 * t)], axis=-1)
    place = np.stack([0.15 * np.sin(2.0 * t), 0.1 * np.cos(1.5 * t), 1.0 + 0.2 * np.sin(t)], -1)
    return Motor.from_rotor_translation(
        Rotor.from_rotation_vector(turn) @ FACE_DOWN, distance * place
    )


def pixels(
    camera: Camera, camera_T_world: Motor, points: np.ndarray, readout_s: tuple[float, float]
) -> np.ndarray:
    """Where points ``(n, 3)`` are seen ``(V, n, 2)``, lines read across and down in such time.

    The pose of a line's time is the path's own, interpolated: no first-order formula of the fit.
    """
    frames, count = camera_T_world.shape[0], len(points)
    row = np.broadcast_to(np.arange(frames)[:, None], (frames, count)).astype(float)
    px = camera.project(camera_T_world[:, None].apply(points))
    for _ in range(4):
        line = (px + 0.5) / (camera.width, camera.height) - 0.5
        at = np.clip(row + (line @ np.array(readout_s)) * RATE_HZ, 0.0, frames - 1.0)
        first = np.minimum(at.astype(int), frames - 2)
        share = (at - first)[..., None]
        one, other = camera_T_world[first.ravel()], camera_T_world[first.ravel() + 1]
        between = one.retract(share.reshape(-1, 1) * one.local(other))
        flat = np.broadcast_to(points, (frames, count, 3)).reshape(-1, 3)
        px = camera.project(between.apply(flat)).reshape(frames, count, 2)
    return px


def board_views(
    px: np.ndarray, camera: Camera, points: np.ndarray, noise_px: float, rng: np.random.Generator
) -> list[BoardCorners | None]:
    """Frames of a whole board; None where it is not all in the image."""
    inside = np.all((px > 2.0) & (px < (camera.width - 3.0, camera.height - 3.0)), axis=(1, 2))
    noisy = px + noise_px * rng.standard_normal(px.shape)
    return [
        BoardCorners(np.arange(len(points)), one, points) if fine else None
        for one, fine in zip(noisy, inside, strict=True)
    ]


def tag_frames(
    px: np.ndarray, camera: Camera, noise_px: float, rng: np.random.Generator
) -> list[list[Detection]]:
    """Frames of tags, four corners each in `px`; those not all in the image are left out."""
    corners = px.reshape(len(px), -1, 4, 2)
    inside = np.all((corners > 2.0) & (corners < (camera.width - 3.0, camera.height - 3.0)), (2, 3))
    noisy = corners + noise_px * rng.standard_normal(corners.shape)
    return [
        [
            Detection("tag36h11", tag, noisy[frame, tag], 0, 1.0, True)
            for tag in np.flatnonzero(inside[frame]).tolist()
        ]
        for frame in range(len(px))
    ]
