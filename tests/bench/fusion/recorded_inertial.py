"""SLAM with an IMU inside on a recording that has both, whatever is known of how they sit.

Where nobody says how the camera sits on the IMU, its rotation comes from the turns that visual SLAM
alone and the gyroscope tell (Kabsch), its place is the IMU's; so metres are as good as that guess.

    python -m tests.bench.fusion.recorded_inertial ../shared/data/replays/gopro/karma.mp4 \
        --manifest docs/manifests/gopro_karma.toml
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import astuple
from itertools import islice
from pathlib import Path

import numpy as np

from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.fusion.preintegration import preintegrate
from motorcade.fusion.visual_inertial import InertialSlam
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking import Camera
from motorcade.tracking.slam import VisualSlam
from tests.bench.fusion.inertial_slam import feed

__all__ = ["track_recorded"]

# A small camera's sensor is some ten times worse than EuRoC's, and shakes with its holder.
_TIMES_WORSE = 10.0
_STEP = 5  # frames between which turns are compared


def track_recorded(path: Path, manifest: Path | None, frames: int | None) -> str:
    """Track a recording, and say what was found.

    Raises:
        ValueError: no camera or no IMU, or no map by images alone.
    """
    recording = open_recording(path, manifest)
    imu = recording.imu if recording.imu is not None else open_recording(path).imu
    camera = recording.camera
    if imu is None or camera is None:
        raise ValueError(f"{path}: expected a recording with a camera and an IMU")
    noise = recording.imu_noise or ImuNoise(*(_TIMES_WORSE * one for one in astuple(ADIS16448)))
    images = [(int(one.time_ns), one.gray()) for one in islice(recording.frames, frames)]
    images = [one for one in images if imu.time_ns[0] <= one[0] <= imu.time_ns[-3]]
    sits = recording.imu_T_camera or _turned(camera, images, imu, noise)
    slam, fed = InertialSlam(camera, noise, sits), 0
    for time_ns, gray in images:
        fed = feed(slam, imu, fed, time_ns)
        slam.track(time_ns, gray)
    found = slam.finish()
    lines = [
        f"{path.name}: {len(images)} frames, states {dict(Counter(found.states))}",
        f"  camera on IMU, rotation vector {sits.rotor.as_rotation_vector().round(3).tolist()}",
    ]
    if found.start is None or found.fused is None or found.metric_from_ns is None:
        lines.append("  the IMU did not tell metres: too little acceleration for its noise")
    else:
        lines.append(
            f"  metres {1e-9 * (found.metric_from_ns - images[0][0]):.1f} s after the first "
            f"frame, scale to {100 * found.start.log_scale_sigma:.1f} % at first; "
            f"{len(found.fused.trajectory)} poses, {_length_m(found.fused.trajectory):.1f} m long"
        )
    return "\n".join(lines)


def _turned(
    camera: Camera, images: list[tuple[int, np.ndarray]], imu: ImuStream, noise: ImuNoise
) -> Motor:
    """imu_T_camera by turns alone, without a lever arm."""
    slam = VisualSlam(camera)
    for time_ns, gray in images:
        slam.track(time_ns, gray)
    path = slam.finish(adjust=False).trajectory
    if path is None or len(path) <= 2 * _STEP:
        raise ValueError("images: expected a map by visual SLAM alone, got none")
    path = path[::_STEP]
    rotor = path.motors.rotor
    seen = (rotor[:-1].inverse() @ rotor[1:]).as_rotation_vector()
    felt = preintegrate(imu, path.time_ns, noise).motion[:, 0].rotor.as_rotation_vector()
    felt = felt - np.median(felt, axis=0)
    u, _, vt = np.linalg.svd(felt.T @ (seen - np.median(seen, axis=0)))
    turn = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return Motor.from_rotor_translation(Rotor.from_matrix(turn), np.zeros(3))


def _length_m(path: Trajectory) -> float:
    return float(np.linalg.norm(np.diff(path.motors.translation_m, axis=0), axis=-1).sum())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--manifest", type=Path)
    parser.add_argument("--frames", type=int)
    options = parser.parse_args()
    print(track_recorded(options.recording, options.manifest, options.frames))
