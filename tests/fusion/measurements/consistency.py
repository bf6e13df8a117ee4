"""Whether errors are as large as stated with each kind of measurements: NEES over many runs.

    python -m tests.fusion.measurements.consistency --runs 100 [KIND …]

Each run is five seconds of a simulated sensor in the hand at 100 Hz, with camera poses for the
first half second and one every two seconds after that, and ten measurements a second of the kind.
NEES/d is taken ten times a second from half a second on: of the camera's pose (d = 6) and of the
state (d = 15), live and smoothed, each the mean over runs and steps. Within bounds is a step whose
mean over the runs lies where χ² puts 95 % of them. gtsam's batch is the graph of the same data.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused, fuse
from motorcade.fusion.filter.extended_pose import extended_pose
from motorcade.fusion.graph import fuse_by_graph
from motorcade.fusion.imu import ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.metrics import Consistency, chi2_bounds, normalised_squared
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.measurements import PoseMeasurements
from tests.fusion.conftest import IMU_T_CAMERA, NOISE, SIGMA_M, SIGMA_RAD, Handheld
from tests.fusion.measurements.along import KINDS, Along, measured_along

_STEP_NS = 1_000_000  # of the true rate's differences
DURATION_S, RATE_HZ, EVERY = 5.0, 100.0, 10
OPEN = FilterSettings(gate=1.0)  # every measurement is as its covariance says


@dataclass(frozen=True, eq=False)
class Simulated:
    """One run: what is true at the IMU's stamps, and what was measured."""

    path: Along
    bias: FloatArray
    imu: ImuStream
    poses: PoseMeasurements

    @classmethod
    def of(cls, rng: np.random.Generator) -> Simulated:
        sensor = simulate_imu(
            Handheld().trajectory(RATE_HZ, DURATION_S, "imu"), RATE_HZ, NOISE, rng
        )
        gyro, accel = 0.05 * rng.standard_normal(3), 0.25 * rng.standard_normal(3)
        rate = sensor.stream.angular_rate_rad_s
        imu = ImuStream(
            sensor.stream.time_ns, rate + gyro, sensor.stream.specific_force_m_s2 + accel
        )
        camera = sensor.path.transformed_by(right=IMU_T_CAMERA)
        given = simulate_camera_poses(camera, 20.0, SIGMA_M, SIGMA_RAD, rng)
        rows = np.arange(len(given))
        kept = rows[(rows < 10) | (rows % 40 == 0)]
        sides = [Handheld().poses(sensor.path.time_ns + side) for side in (-_STEP_NS, _STEP_NS)]
        own = sides[0].local(sides[1])[:, :3] / (2e-9 * _STEP_NS)
        bias = np.hstack([sensor.gyro_bias_rad_s + gyro, sensor.accel_bias_m_s2 + accel])
        return cls(
            Along(sensor.path.time_ns, sensor.path.motors, sensor.velocity_m_s, own),
            bias,
            imu,
            PoseMeasurements(given.trajectory[kept], given.covariance[kept]),
        )

    def nees(self, fused: Fused) -> tuple[FloatArray, FloatArray]:
        """Of pose and state, at the stamps of the result, over their degrees of freedom."""
        rows = np.searchsorted(self.path.time_ns, fused.trajectory.time_ns)
        true = self.path.poses[rows]
        apart = fused.trajectory.motors.local(true @ IMU_T_CAMERA)
        pose = normalised_squared(apart, fused.covariance)
        own = fused.trajectory.motors @ IMU_T_CAMERA.inverse()
        states = (
            extended_pose(own.rotor, own.translation_m, fused.velocity_m_s),
            extended_pose(true.rotor, true.translation_m, self.path.velocity_m_s[rows]),
        )
        twists = states[0].local(states[1])
        bias = np.hstack([fused.gyro_bias_rad_s, fused.accel_bias_m_s2])
        error = np.hstack([twists[:, 0], twists[:, 1, 3:], self.bias[rows] - bias])
        return pose / 6, normalised_squared(error, fused.state_covariance) / 15


ESTIMATORS: dict[str, Callable[..., Fused]] = {
    "live": partial(fuse, smoothed=False),
    "smoothed": fuse,
    "batch": fuse_by_graph,
}


def consistency(
    kind: str, runs: int, seed: int, estimators: tuple[str, ...]
) -> dict[str, tuple[Consistency, Consistency]]:
    """NEES/d of pose and state by estimator, of as many runs."""
    found: dict[str, list[tuple[FloatArray, FloatArray]]] = {name: [] for name in estimators}
    for run in range(runs):
        rng = np.random.default_rng([seed, run])
        made = Simulated.of(rng)
        also = [] if kind == "none" else [measured_along(kind, made.path[::EVERY], rng)]
        stamps = made.path.time_ns[50::EVERY]
        for name in estimators:
            fused = ESTIMATORS[name](
                made.poses, made.imu, NOISE, IMU_T_CAMERA, stamps, also=also, settings=OPEN
            )
            found[name].append(made.nees(fused))
    return {
        name: tuple(
            Consistency.of(np.array(values) * size, size)
            for values, size in zip(zip(*rows, strict=True), (6, 15), strict=True)
        )
        for name, rows in found.items()
    }  # type: ignore[return-value]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kinds", nargs="*", default=["none", *KINDS])
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--batch", action="store_true", help="by the graph too: minutes a kind")
    given = parser.parse_args()
    names = ("live", "smoothed", "batch") if given.batch else ("live", "smoothed")
    head = "".join(f"{name + ' pose':>24}{name + ' state':>24}" for name in names)
    for size, name in ((6, "pose"), (15, "state")):
        low, high = chi2_bounds(size, given.runs)
        print(f"bounds of a step's {name}: {low / size:.2f} to {high / size:.2f}")
    print(f"{'NEES/d (steps in bounds)':24}{head}")
    for kind in given.kinds:
        row = ""
        for both in consistency(kind, given.runs, given.seed, names).values():
            for one in both:
                row += f"{one.ratio:15.2f} ({one.share_within:5.0%})"
        print(f"{kind:24}{row}", flush=True)


if __name__ == "__main__":
    main()
