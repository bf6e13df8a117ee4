"""Paths with gaps: 200 poses of one handheld motion whose clock stands still while stamps leap.

The IMU of such a path was read 200 times a second, but not within gaps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.fusion import (
    ImuStream,
)
from motorcade.fusion.imu.simulate import specific_force_m_s2
from motorcade.fusion.motions import handheld
from motorcade.fusion.motions.degradations import (
    Gaussian,
)
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.motion import sampled_motion
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.trajectories import write_trajectory
from motorcade.tracking import PoseMeasurements

POSES, STEP_NS = 200, 33_333_333
TODAY_NS = 1_790_000_000 * 10**9
A_STEP = 7  # samples of the IMU from pose to pose
SIGMA = np.repeat([0.01, 0.005], 3)  # rad, m

MANIFEST = """
[frames]
images = "images/*.png"
stamps = "stamps.txt"
stamps_unit = "ns"
[camera]
width = 24
height = 16
fx = 20.0
fy = 20.0
cx = 11.5
cy = 7.5
[imu]
file = "imu.csv"
imu_T_camera = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
[truth]
file = "truth.csv"
format = "euroc"
convention = "world_T_camera"
"""


def shapes(gap_ns: int | None) -> dict[str, NDArray[np.int64]]:
    """Stamps ``(200,)`` with gaps of a length in several places; None: the first one is 0."""
    if gap_ns is None:
        today = TODAY_NS + STEP_NS * np.arange(POSES - 1)
        return {"first of 0": np.concatenate([[0], today])}
    steps = np.full(POSES - 1, STEP_NS)
    made = {}
    for name, chosen in (
        ("one gap", slice(POSES // 2, POSES // 2 + 1)),
        ("a gap every 20 poses", slice(20, None, 20)),
        ("gaps alone", slice(None)),
    ):
        with_gaps = steps.copy()
        with_gaps[chosen] = gap_ns
        span = sum(with_gaps.tolist())
        if span < 2**63 - 2**60:
            start = TODAY_NS if TODAY_NS + span < 2**62 else -span // 2
            made[name] = start + np.concatenate([[0], np.cumsum(with_gaps)])
    return made


@dataclass(frozen=True, eq=False)
class Case:
    """One path with all that doors want: made where it is asked for, files in a folder."""

    time_ns: NDArray[np.int64]
    folder: Path

    @classmethod
    def of(cls, time_ns: NDArray[np.int64], folder: Path) -> Case:
        folder.mkdir(exist_ok=True)
        return cls(time_ns, folder)

    @cached_property
    def truth(self) -> Trajectory:
        return Trajectory(self.time_ns, _motion(np.arange(POSES)).pose)

    @cached_property
    def noisy(self) -> Trajectory:
        return Gaussian(0.005, 0.01).apply(self.truth, np.random.default_rng(1))

    @cached_property
    def measured(self) -> PoseMeasurements:
        return PoseMeasurements(self.noisy, np.tile(np.diag(SIGMA**2), (POSES, 1, 1)))

    @cached_property
    def imu(self) -> ImuStream:
        """Samples between poses that stand close, and at all of them."""
        steps = np.diff(self.time_ns)
        near = steps == steps.min()
        part = np.arange(A_STEP) / A_STEP
        places = np.arange(POSES - 1)[:, None] + part
        stamps = self.time_ns[:-1, None] + np.rint(part * STEP_NS).astype(np.int64)
        kept = near[:, None] | (part == 0.0)
        time_ns = np.append(stamps[kept], self.time_ns[-1])
        exact = sampled_motion(_motion(np.append(places[kept], POSES - 1.0)))
        force = specific_force_m_s2(exact, 9.81)
        return ImuStream(time_ns, exact.body_angular_rate_rad_s, force)

    @cached_property
    def standing(self) -> ImuStream:
        """The stream of a sensor that lies still."""
        rng = np.random.default_rng(2)
        shape = self.imu.angular_rate_rad_s.shape
        noise = rng.standard_normal((2, *shape))
        up = np.array([0.0, 0.0, 9.81])
        return ImuStream(self.imu.time_ns, 1e-3 * noise[0], up + 1e-2 * noise[1])

    def file(self, name: str) -> str:
        """A file of this path: ``est.csv``, ``truth.csv``, ``imu.csv``."""
        path = self.folder / name
        if name.startswith("imu"):
            write_imu(self.imu, path)
        elif name.startswith("standing"):
            write_imu(self.standing, path)
        else:
            write_trajectory(self.noisy if name.startswith("est") else self.truth, path)
        return str(path)

    @property
    def recording(self) -> str:
        """A folder with images, stamps, IMU and ground truth."""
        images = self.folder / "images"
        if not images.is_dir():
            images.mkdir()
            rng = np.random.default_rng(3)
            for k in range(POSES):
                cv2.imwrite(
                    str(images / f"{k:03d}.png"), rng.integers(0, 255, (16, 24), dtype=np.uint8)
                )
        self.file("imu.csv"), self.file("truth.csv")
        (self.folder / "stamps.txt").write_text("".join(f"{one}\n" for one in self.time_ns))
        (self.folder / "motorcade.toml").write_text(MANIFEST)
        return str(self.folder)


def _motion(place: FloatArray) -> Any:
    return handheld(np.random.default_rng(0)).at(place * STEP_NS * 1e-9)
