"""Videos that set representations and smoothing side by side, in one room, frame by frame.

The camera of the synthetic room swings through the pole of Euler angles, its poses are disturbed,
and smoothed alike as Euler angles, quaternions and motors. Into the true images the character is
drawn along each of these paths: what slides over the table is the path's error. Below, the errors
of rotation run along.

    python -m docs.making.side_by_side OUT
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path

import cv2
import numpy as np

from docs.making.traces import ErrorTraces, beside
from motorcade.animation import mannequin, place_on_plane
from motorcade.fusion.motions import gimbal_crossing
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import render_overlay
from motorcade.render.overlay import new_renderer
from motorcade.render.scene import ImageArray
from motorcade.render.video import contact_sheet, write_video
from motorcade.replays.demo.furniture import CHARACTER_HEIGHT_M
from motorcade.replays.demo.recording import CAMERA
from motorcade.replays.demo.scene import room

__all__ = [
    "paths_side_by_side",
    "rotation_errors_deg",
    "smoothed_paths",
    "swing",
    "write_side_by_side",
]

RATE_HZ, SECONDS, WINDOW_S = 30.0, 4.0, 0.4
MISS_RAD = float(np.deg2rad(0.3))
SIGMA_M, SIGMA_RAD, SEED = 0.003, np.deg2rad(0.4), 7
EYE_M, DRIFT = (-0.62, 0.05, 0.24), 0.2
STRIP_PX = 130


def swing() -> Trajectory:
    """`world_T_camera` that swings through gimbal lock, at the table of the synthetic room."""
    motion = gimbal_crossing(2.0, MISS_RAD, float(np.deg2rad(22.0)))
    sampled = motion.sampled(RATE_HZ, SECONDS)
    given = sampled.motors
    upright = Rotor.from_rotation_vector([0.0, 0.0, -0.5 * np.pi])
    place = np.array(EYE_M) + DRIFT * (given.translation_m - given.translation_m.mean(axis=0))
    return Trajectory(sampled.time_ns, Motor.from_rotor_translation(given.rotor @ upright, place))


def smoothed_paths(measured: Trajectory) -> dict[str, Trajectory]:
    """The same smoothing in three representations."""
    return {
        name: smooth(measured, "local_polynomial", name, window_s=WINDOW_S, order=2)
        for name in ("euler", "quaternion", "motor")
    }


def paths_side_by_side(
    truth: Trajectory, paths: Mapping[str, Trajectory], highest_deg: float | None = None
) -> Iterator[ImageArray]:
    """The synthetic room as the ground truth sees it, and the character drawn along each path.

    Args:
        truth: `world_T_camera` of the images.
        paths: by names of `plots.style.COLOURS`; each covers the ground truth's stamps.
        highest_deg: upper end of the axis of errors.

    Yields:
        uint8 (h, W, 3), one a stamp of the ground truth.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: a path that does not cover the ground truth's stamps.
    """
    figure = mannequin()
    placement = place_on_plane(figure, (0.0, 0.0), np.pi, height_m=CHARACTER_HEIGHT_M)
    errors = {name: rotation_errors_deg(path, truth) for name, path in paths.items()}
    time_s = 1e-9 * (truth.time_ns - truth.time_ns[0])
    width = CAMERA.width * len(paths)
    traces = ErrorTraces(time_s, errors, "deg", (width, STRIP_PX), highest_deg)
    footage = list(_room(truth))
    drawn = [
        render_overlay(footage, CAMERA, path, figure, figure.clip("idle"), placement)
        for path in paths.values()
    ]
    for now_s, images in zip(time_s, zip(*drawn, strict=True), strict=True):
        row = dict(zip(paths, images, strict=True))
        yield beside(row, traces.strip(float(now_s)))


def write_side_by_side(out: Path) -> dict[str, Path]:
    """Write both videos and a contact sheet of each into a folder.

    Returns:
        what each file shows.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        OSError: a file cannot be written.
    """
    out.mkdir(parents=True, exist_ok=True)
    truth = swing()
    measured = Gaussian(SIGMA_M, SIGMA_RAD).apply(truth, np.random.default_rng(SEED))
    ways = smoothed_paths(measured)
    written = {}
    for name, paths, highest in (
        ("representations", ways, 180.0),
        ("raw_and_smoothed", {"measured": measured, "motor": ways["motor"]}, None),
    ):
        frames = list(paths_side_by_side(truth, paths, highest))
        written[name] = out / f"{name}.mp4"
        write_video(written[name], frames, truth.time_ns)
        chosen = range(0, len(frames), max(1, len(frames) // 24))
        labels = [f"{1e-9 * truth.time_ns[k]:.2f} s" for k in chosen]
        sheet = contact_sheet([frames[k] for k in chosen], 3, 640, labels)
        cv2.imwrite(str(out / f"{name}_sheet.png"), sheet[..., ::-1])
    return written


def _room(truth: Trajectory) -> Iterator[tuple[int, ImageArray]]:
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        renderer.show(room(), None)
        for stamp, pose in zip(truth.time_ns.tolist(), truth.motors, strict=True):
            yield stamp, renderer.render(CAMERA, pose).rgba[..., :3].copy()


def rotation_errors_deg(path: Trajectory, truth: Trajectory) -> FloatArray:
    """Angle (N,) between a path and the ground truth at the latter's stamps, in degrees."""
    rotor = path.motors_at(truth.time_ns).rotor.inverse() @ truth.motors.rotor
    angle = np.linalg.norm(rotor.as_rotation_vector(), axis=-1)
    return np.asarray(np.rad2deg(np.minimum(angle, 2.0 * np.pi - angle)))


def main() -> None:
    """Write the videos where the first argument says."""
    parser = argparse.ArgumentParser(description="Write videos of paths side by side.")
    parser.add_argument("out", type=Path, metavar="OUT")
    for name, file in write_side_by_side(parser.parse_args().out).items():
        print(f"{name}: {file}")


if __name__ == "__main__":
    main()
