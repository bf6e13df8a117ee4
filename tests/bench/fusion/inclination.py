"""Tilt by gyroscope and accelerometer alone on a recording of BROAD, beside VQF's package."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.imu import ImuStream
from motorcade.fusion.orientation import OrientationModel, estimate_orientation
from motorcade.ga import Rotor
from tests.bench.data import data_folder

__all__ = ["bench_inclination", "inclination_rmse_deg", "inclination_table"]

_TRIAL = "02_undisturbed_slow_rotation_B.hdf5"


def bench_inclination() -> dict[str, Any]:
    """Trial 02, online and offline, ours and VQF's without magnetometer."""
    path = data_folder() / "imu" / _TRIAL
    if not path.is_file():
        return {"rows": [], "left_out": [f"BROAD 02: not at {path}; set MOTORCADE_DATA"]}
    try:
        imu, truth, moves = _trial(path)
    except ModuleNotFoundError as fault:
        return {"rows": [], "left_out": [f"BROAD 02: needs the Python package {fault.name}"]}
    # Its ground truth is aligned to gyros that are integrated sample by sample: a reading is the
    # mean over the interval before it.
    model = OrientationModel(readings="interval")
    rows, left_out = [], []
    for way, smooth in (("online", False), ("offline", True)):
        ours = estimate_orientation(imu, model, smooth=smooth).world_R_imu
        row = {"way": way, "ours_deg": inclination_rmse_deg(ours, truth, moves)}
        try:
            row["vqf_deg"] = inclination_rmse_deg(_vqf(imu, smooth), truth, moves)
        except ModuleNotFoundError as fault:
            left_out = [f"VQF: needs the Python package {fault.name}"]
        rows.append(row)
    return {"rows": rows, "left_out": left_out}


def inclination_rmse_deg(estimate: Rotor, truth: Rotor, chosen: NDArray[np.bool_]) -> float:
    """RMSE over chosen samples of the angle of the error less its turn about the vertical.

    Source: 2 arccos √(w² + z²) of the error in the world's axes, D. Laidig, M. Caruso, A.
    Cereatti and T. Seel, BROAD, Data 6(7), 2021.
    """
    error = (estimate @ truth.inverse()).as_quaternion()
    level = np.sqrt(error[:, 0] ** 2 + error[:, 3] ** 2)
    angle = 2.0 * np.arccos(np.clip(level, 0.0, 1.0))
    return float(np.degrees(np.sqrt(np.mean(angle[chosen] ** 2))))


def _trial(path: Path) -> tuple[ImuStream, Rotor, NDArray[np.bool_]]:
    """Stream, optical orientation, and which samples move and have one."""
    import h5py

    with h5py.File(path) as file:
        gyro, accel, wxyz, moves = (
            file[name][:] for name in ("imu_gyr", "imu_acc", "opt_quat", "movement")
        )
        rate_hz = float(file.attrs["sampling_rate"])
    known = np.isfinite(wxyz).all(axis=1)
    truth = Rotor.from_quaternion(np.where(known[:, None], wxyz, [1.0, 0.0, 0.0, 0.0]))
    stamps = np.round(np.arange(len(gyro)) * 1e9 / rate_hz).astype(np.int64)
    return ImuStream(stamps, gyro, accel), truth, moves.astype(np.bool_) & known


def _vqf(imu: ImuStream, smooth: bool) -> Rotor:
    from vqf import VQF, offlineVQF

    gyro = np.ascontiguousarray(imu.angular_rate_rad_s)
    accel = np.ascontiguousarray(imu.specific_force_m_s2)
    step_s = 1.0 / imu.rate_hz
    if smooth:
        return Rotor.from_quaternion(offlineVQF(gyro, accel, None, step_s)["quat6D"])
    return Rotor.from_quaternion(VQF(step_s).updateBatch(gyro, accel)["quat6D"])


def inclination_table(found: Mapping[str, Any]) -> str:
    """A line online and one offline."""
    lines = [f"{'BROAD 02, inclination over moving samples':<48}{'ours':>10}{'VQF':>10}"]
    for row in found["rows"]:
        rival = f"{row['vqf_deg']:>9.3f}°" if "vqf_deg" in row else ""
        lines.append(f"{row['way']:<48}{row['ours_deg']:>9.3f}°{rival}")
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)
