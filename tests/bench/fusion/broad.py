"""Trials of BROAD, a benchmark of inertial orientation, and the errors that it defines.

D. Laidig, M. Caruso, A. Cereatti and T. Seel, "BROAD: A benchmark for robust inertial orientation
estimation", Data 6(7), 2021. World axes: east, north, up.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.imu import ImuStream
from motorcade.fusion.orientation import estimate_orientation
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray
from tests.bench.data import data_folder

__all__ = ["BroadTrial", "broad_errors", "by_vqf", "estimated", "read_trial", "trial_paths"]


@dataclass(frozen=True)
class BroadTrial:
    """One recording: readings, ground truth, and which samples count."""

    name: str
    imu: ImuStream
    magnetic_field_ut: FloatArray
    world_R_imu: Rotor
    counted: NDArray[np.bool_]


def trial_paths() -> list[Path]:
    """The trials at hand, by number; none where there are no recordings."""
    folder = data_folder() / "imu"
    return sorted([*folder.glob("*.hdf5"), *folder.glob("broad/*.hdf5")], key=lambda p: p.name)


def read_trial(path: Path) -> BroadTrial:
    """A trial; samples count that are marked as moving and have a ground truth.

    Raises:
        ModuleNotFoundError: h5py is not installed.
    """
    import h5py

    with h5py.File(path) as file:
        gyro, accel, field, wxyz, moves = (
            file[name][:] for name in ("imu_gyr", "imu_acc", "imu_mag", "opt_quat", "movement")
        )
        rate_hz = float(file.attrs["sampling_rate"])
    known = np.isfinite(wxyz).all(axis=1)
    truth = Rotor.from_quaternion(np.where(known[:, None], wxyz, [1.0, 0.0, 0.0, 0.0]))
    stamps = np.round(np.arange(len(gyro)) * 1e9 / rate_hz).astype(np.int64)
    imu = ImuStream(stamps, gyro, accel)
    return BroadTrial(path.stem[:2], imu, field, truth, moves.astype(np.bool_) & known)


def broad_errors(trial: BroadTrial, estimate: Rotor) -> dict[str, float]:
    """RMSE over the samples that count: of all, of heading, and of inclination.

    With the error's quaternion in the axes of the world: 2 arccos w, 2 arctan(z / w) and
    2 arccos √(w² + z²).
    """
    error = np.abs((estimate @ trial.world_R_imu.inverse()).as_quaternion()[trial.counted])
    w, z = error[:, 0], error[:, 3]
    angles = {
        "total_deg": 2.0 * np.arccos(np.clip(w, 0.0, 1.0)),
        "heading_deg": 2.0 * np.arctan2(z, w),
        "inclination_deg": 2.0 * np.arccos(np.clip(np.hypot(w, z), 0.0, 1.0)),
    }
    return {name: float(np.degrees(np.sqrt(np.mean(angle**2)))) for name, angle in angles.items()}


def estimated(trial: BroadTrial, smooth: bool, magnetometer: bool) -> Rotor:
    """Our orientation, by the defaults."""
    field = trial.magnetic_field_ut if magnetometer else None
    return estimate_orientation(trial.imu, magnetic_field=field, smooth=smooth).world_R_imu


def by_vqf(trial: BroadTrial, smooth: bool, magnetometer: bool) -> Rotor:
    """VQF's, by its authors' package and its defaults.

    Raises:
        ModuleNotFoundError: vqf is not installed.
    """
    from vqf import VQF, offlineVQF

    gyro, accel, field = (
        np.ascontiguousarray(values)
        for values in (
            trial.imu.angular_rate_rad_s,
            trial.imu.specific_force_m_s2,
            trial.magnetic_field_ut,
        )
    )
    step_s = 1.0 / trial.imu.rate_hz
    given = field if magnetometer else None
    found = (
        offlineVQF(gyro, accel, given, step_s)
        if smooth
        else VQF(step_s).updateBatch(gyro, accel, given)
    )
    return Rotor.from_quaternion(found["quat9D" if magnetometer else "quat6D"])
