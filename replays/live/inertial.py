"""The IMU between poses: how it sits on the camera is found as it runs, then it bridges gaps.

Offset and extrinsics come from `fusion.synchronise` over the poses so far, in a thread of its own;
they are used once their deviations are below `SURE_…`, and only while frames that had no part in
it are predicted better so than by constant velocity.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from motorcade.fusion import (
    ADIS16448,
    FilterSettings,
    ImuNoise,
    ImuStream,
    PoseFilter,
    Synchronised,
    synchronise,
)
from motorcade.fusion.imu.stream import upright
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.files import write_bytes
from motorcade.replays.io.imu import EUROC_HEADER, kalibr_noise

SURE_OFFSET_S, SURE_ROTATION_RAD, SURE_LEVER_M = 0.003, np.radians(0.5), 0.02
"""Deviations below which offset and extrinsics are used."""
FITTED_AT_S = (8.0, 16.0, 32.0, 60.0)
"""Of poses; from then on the last minute is tried, each half minute, until it is sure."""
BRIDGED_S = 0.5
"""How long the IMU alone gives a pose: 0.1 m/s² of a force's error are 12 mm then."""
_KEPT_NS, _FED_NS, _AGAIN_NS = 70_000_000_000, 2_000_000_000, 30_000_000_000
_MOST_SAMPLES = 1 << 16
_BETWEEN_S = 0.05
_JUDGED, _FEWEST = 60, 15


@dataclass(frozen=True, eq=False)
class ImuSample:
    """A reading: stamp (ns), angular rate ``(3,)`` rad/s, specific force ``(3,)`` m/s²."""

    time_ns: int
    rate_rad_s: FloatArray
    force_m_s2: FloatArray


_Pose = tuple[int, Motor, FloatArray]  # stamp (ns), world_T_camera, covariance


class InertialPoses:
    """Takes poses and readings as they come, and gives the pose between and after poses.

    Args:
        noise: the least that the IMU's noise is taken for; what is found may be more.
    """

    def __init__(self, noise: ImuNoise = ADIS16448) -> None:
        self.synchronised: Synchronised | None = None
        self._noise = noise
        self._samples: deque[ImuSample] = deque(maxlen=_MOST_SAMPLES)
        self._poses: deque[_Pose] = deque()
        self._worker = ThreadPoolExecutor(1, "imu")
        self._fit: Future[Synchronised] | None = None
        self._fits, self._next_ns, self._reason = 0, 0, ""
        self._filter: PoseFilter | None = None
        self._level = Motor.identity()
        self._missed: deque[tuple[float, float]] = deque(maxlen=_JUDGED)

    @property
    def used(self) -> bool:
        """Whether it is sure, and predicts better than constant velocity did."""
        if self._filter is None or len(self._missed) < _FEWEST:
            return False
        own, other = np.median(np.array(self._missed), axis=0)
        return bool(own <= other)

    @property
    def status(self) -> str:
        """What is known of the IMU, for people; "" where no reading came."""
        if not self._samples:
            return ""
        if self.synchronised is None:
            reason = f" ({self._reason})" if self._reason else ""
            return f"IMU not used yet: turn and move the camera{reason}"
        offset, sigma = 1e3 * self.synchronised.offset_s, 1e3 * self.synchronised.offset_sigma_s
        turn = np.degrees(self.synchronised.rotation_sigma_rad.max())
        lever = 1e3 * self.synchronised.lever_arm_sigma_m.max()
        known = f"offset {offset:.1f} ± {sigma:.1f} ms, rotation ± {turn:.2f}°, lever ± {lever:.0f}"
        return f"IMU {'used' if self.used else 'found'}: {known} mm"

    def add_imu(self, samples: Iterable[ImuSample]) -> None:
        """Take readings; those that are not later than the last are dropped."""
        for sample in samples:
            if self._samples and sample.time_ns <= self._samples[-1].time_ns:
                continue
            self._samples.append(sample)
            if self._filter is not None:
                self._filter.imu(sample.time_ns, sample.rate_rad_s, sample.force_m_s2)
        while self._samples and self._samples[-1].time_ns - self._samples[0].time_ns > _KEPT_NS:
            self._samples.popleft()

    def add_pose(
        self,
        time_ns: int,
        world_T_camera: Motor,
        covariance: FloatArray,
        predicted: Motor | None = None,
    ) -> None:
        """Take a measured pose, also a late one, with the covariance ``(6, 6)`` of its right
        perturbation; `predicted` is what constant velocity expected there.
        """
        self._poll()
        if not self._samples:
            return
        own = self.at(time_ns)
        if own is not None and predicted is not None:
            self._missed.append((_apart(own, world_T_camera), _apart(predicted, world_T_camera)))
        self._poses.append((time_ns, world_T_camera, covariance))
        while time_ns - self._poses[0][0] > _KEPT_NS:
            self._poses.popleft()
        if self._filter is not None:
            self._feed(self._filter, self._poses[-1])
        elif self._fit is None:
            self._begin_fit()

    def at(self, time_ns: int) -> Motor | None:
        """``world_T_camera`` at a moment of the camera's clock near the last reading."""
        state = None if self._filter is None else self._filter.state
        if state is None:
            return None
        ahead_s = 1e-9 * (time_ns - state.time_ns) + state.time_offset_s
        if abs(ahead_s) > _BETWEEN_S:
            return None
        rate = self._samples[-1].rate_rad_s - state.gyro_bias_rad_s
        turn = state.world_T_imu.rotor @ Rotor.from_rotation_vector(ahead_s * rate)
        position_m = state.world_T_imu.translation_m + ahead_s * state.velocity_m_s
        imu = Motor.from_rotor_translation(turn, position_m)
        return self._level.inverse() @ imu @ state.imu_T_camera

    def close(self) -> None:
        """Leave what is under way."""
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _begin_fit(self) -> None:
        """Synchronise what came so far, once there is enough of it."""
        least_s = FITTED_AT_S[min(self._fits, len(FITTED_AT_S) - 1)]
        now_ns = self._poses[-1][0]
        if now_ns - self._poses[0][0] < 1e9 * least_s or now_ns < self._next_ns:
            return
        self._fits += 1
        self._next_ns = now_ns + _AGAIN_NS * (self._fits >= len(FITTED_AT_S))
        stamps, poses, _ = zip(*self._poses, strict=True)
        camera = Trajectory(np.array(stamps), Motor.stack(poses))
        rows = [(one.time_ns, one.rate_rad_s, one.force_m_s2) for one in self._samples]
        imu = ImuStream(*(np.array(column) for column in zip(*rows, strict=True)))
        self._fit = self._worker.submit(synchronise, camera, imu, self._noise)

    def _poll(self) -> None:
        """Take what was found, where it is sure."""
        if self._fit is None or not self._fit.done():
            return
        fit, self._fit = self._fit, None
        try:
            synchronised = fit.result()
        except ValueError as fault:
            self._reason = str(fault)
            return
        sigma = (
            synchronised.offset_sigma_s,
            *synchronised.rotation_sigma_rad,
            *synchronised.lever_arm_sigma_m,
        )
        if np.any(np.array(sigma) > [SURE_OFFSET_S, *3 * [SURE_ROTATION_RAD], *3 * [SURE_LEVER_M]]):
            self._reason = "offset and extrinsics are not sure yet"
            return
        self.synchronised = synchronised
        self._start(synchronised)

    def _start(self, synchronised: Synchronised) -> None:
        """A filter by what synchronising told, fed with the last seconds."""
        turn = upright(synchronised.gravity_m_s2)
        self._level = Motor.from_rotor_translation(turn, np.zeros(3))
        sigma = np.sqrt(np.diag(synchronised.covariance))
        settings = FilterSettings(
            gravity_sigma_rad=float(sigma[7:10].max() / 9.81),
            extrinsics_sigma_rad=float(sigma[1:4].max()),
            extrinsics_sigma_m=float(sigma[4:7].max()),
            time_offset_sigma_s=float(sigma[0]),
        )
        self._filter = PoseFilter(
            synchronised.imu_noise,
            synchronised.imu_T_camera,
            settings=settings,
            time_offset_s=synchronised.offset_s,
        )
        since_ns = self._samples[-1].time_ns - _FED_NS
        for sample in (one for one in self._samples if one.time_ns >= since_ns):
            self._filter.imu(sample.time_ns, sample.rate_rad_s, sample.force_m_s2)
        for pose in (one for one in self._poses if one[0] + 1e9 * synchronised.offset_s > since_ns):
            self._feed(self._filter, pose)

    def _feed(self, running: PoseFilter, pose: _Pose) -> None:
        time_ns, world_T_camera, covariance = pose
        try:
            running.camera_pose(time_ns, self._level @ world_T_camera, covariance)
        except ValueError as fault:  # from before the filter's history
            self._reason = str(fault)


class ImuFile:
    """Readings as they come, in `imu.csv` of a recording's folder; none without readings."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._file: TextIO | None = None
        self._last_ns = -1

    def add(self, samples: Iterable[ImuSample]) -> None:
        """Write readings; those that are not later than the last are dropped."""
        for sample in samples:
            if self._file is None:
                self._file = (self._folder / "imu.csv").open("w", encoding="ascii")
                self._file.write(EUROC_HEADER)
            if sample.time_ns > self._last_ns:
                self._last_ns = sample.time_ns
                row = [sample.time_ns, *sample.rate_rad_s.tolist(), *sample.force_m_s2.tolist()]
                self._file.write(",".join(map(repr, row)) + "\n")

    def close(self, synchronised: Synchronised | None) -> str:
        """End the file, and give the manifest's table of the IMU; "" where nothing tells it."""
        if self._file is not None:
            self._file.close()
        if self._file is None or synchronised is None:
            return ""
        noise = kalibr_noise(synchronised.imu_noise)
        lines = "".join(f"{key}: {value!r}\n" for key, value in noise.items())
        write_bytes(self._folder / "imu.yaml", lines.encode())
        return (
            '\n[imu]\nfile = "imu.csv"\nnoise_file = "imu.yaml"\n'
            f"clock_offset_s = {synchronised.offset_s!r}\n"
            f"imu_T_camera = {synchronised.imu_T_camera.as_matrix().tolist()}\n"
        )


def _apart(pose: Motor, other: Motor) -> float:
    """By what angle (rad) the world's origin is seen elsewhere from the other pose."""
    seen, expected = (m.inverse().translation_m for m in (pose, other))
    return float(np.linalg.norm(seen - expected) / np.linalg.norm(expected))
