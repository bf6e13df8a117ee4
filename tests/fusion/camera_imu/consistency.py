"""Whether errors of a calibration of camera and IMU are as large as it says: over many recordings.

    python -m tests.fusion.camera_imu.consistency --seeds 20

Each seed draws another sensor (scales to 1 %, axes to half a degree), extrinsics, offset, motion
and noise; the camera's intrinsics are found along with all the rest.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from time import perf_counter
from typing import Any

import numpy as np

from motorcade.fusion.camera_imu import CameraImuCalibration, calibrate_camera_imu
from motorcade.fusion.imu import ImuFaults
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import measure_board
from tests.fusion.camera_imu.board_recordings import CAMERA, BoardRecording, recording

GROUPS = {
    "rotation": slice(0, 3),
    "lever arm": slice(3, 6),
    "offset": slice(6, 7),
    "gyroscope": slice(7, 16),
    "accelerometer": slice(16, 22),
}


def errors(found: CameraImuCalibration, true: BoardRecording) -> FloatArray:
    """Errors ``(22,)`` of extrinsics, offset and corrections, as the covariance orders them."""
    lower = np.tril_indices(3)
    return np.concatenate(
        [
            found.imu_T_camera.local(true.imu_T_camera),
            [true.offset_s - found.offset_s],
            (true.gyro_correction - found.gyro_correction).ravel(),
            (true.accel_correction - found.accel_correction)[lower],
        ]
    )


def drawn_recording(seed: int, duration_s: float) -> BoardRecording:
    """A recording by a sensor of the seed's own."""
    rng = np.random.default_rng([seed, 1])
    faults = ImuFaults(
        gyro_scale=1.0 + 0.01 * rng.standard_normal(3),
        accel_scale=1.0 + 0.01 * rng.standard_normal(3),
        gyro_misalignment_rad=np.deg2rad(0.5) * rng.standard_normal(3),
        accel_misalignment_rad=np.deg2rad(0.5) * rng.standard_normal(3),
        gyro_bias_rad_s=0.02 * rng.standard_normal(3),
        accel_bias_m_s2=0.1 * rng.standard_normal(3),
    )
    turn = Rotor.from_rotation_vector(np.deg2rad(0.5) * rng.standard_normal(3))
    place = 0.1 * rng.standard_normal(3)
    return recording(
        seed,
        duration_s,
        faults=faults,
        gyro_turn=turn.as_matrix(),
        imu_T_camera=Motor.from_rotor_translation(Rotor.random(rng), place),
        offset_s=float(rng.uniform(-0.1, 0.1)),
    )


def consistency(seeds: Iterable[int], *, duration_s: float = 20.0) -> dict[str, Any]:
    """NEES a number, normalised RMS errors by group, and the share within three deviations."""
    size = CAMERA.width, CAMERA.height
    nees, scaled, camera, misfit, sigma, off, seconds = [], [], [], [], [], [], []
    for seed in seeds:
        true = drawn_recording(seed, duration_s)
        start = perf_counter()
        seen = measure_board(true.time_ns, true.views, size=size)
        found = calibrate_camera_imu(seen, true.imu, true.noise, gravity_m_s2=9.81)
        seconds.append(perf_counter() - start)
        apart = errors(found, true)
        spread = found.covariance[: len(apart), : len(apart)]
        nees.append(apart @ np.linalg.solve(spread, apart) / len(apart))
        scaled.append(apart / np.sqrt(np.diag(spread)))
        off.append(apart)
        sigma.append(np.sqrt(np.diag(spread)))
        own = found.camera
        numbers = np.array([own.fx, own.fy, own.cx, own.cy, *own.distortion])
        camera.append(
            (numbers - [CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy, *CAMERA.distortion])
            / found.intrinsics_sigma
        )
        misfit.append(found.misfit)
    every = np.hstack([scaled, camera])

    def by_group(rows: list[FloatArray], size: Callable[[FloatArray], float]) -> dict[str, float]:
        return {name: size(np.array(rows)[:, columns]) for name, columns in GROUPS.items()}

    rms = by_group(scaled, _rms)
    rms["intrinsics"] = _rms(np.array(camera))
    return {
        "recordings": len(nees),
        "nees_per_number": float(np.mean(nees)),
        "within_three_sigma": float(np.mean(np.abs(every) < 3.0)),
        "normalised_rms": rms,
        "error_rms": by_group(off, _rms),
        "sigma_rms": by_group(sigma, _rms),
        "misfit": float(np.mean(misfit)),
        "seconds": float(np.median(seconds)),
    }


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--duration-s", type=float, default=20.0)
    given = parser.parse_args()
    found = consistency(range(given.seeds), duration_s=given.duration_s)
    print(
        f"{found['recordings']} recordings of {given.duration_s:g} s: NEES a number "
        f"{found['nees_per_number']:.2f}, {found['within_three_sigma']:.1%} within 3 σ, misfit "
        f"{found['misfit']:.2f}, {found['seconds']:.0f} s each"
    )
    print(f"{'':<16}{'RMS in σ':>10}{'RMS error':>14}{'stated σ':>14}   (rad, m, s, 1, 1)")
    for name, rms in found["normalised_rms"].items():
        own = found["error_rms"].get(name), found["sigma_rms"].get(name)
        figures = "".join("" if one is None else f"{one:14.2e}" for one in own)
        print(f"{name:<16}{rms:>10.2f}{figures}")


if __name__ == "__main__":
    main()
