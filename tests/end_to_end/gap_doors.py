"""What `gaps` and its quick tests try: paths with gaps, and every door that takes a path or stream.

A path is 200 poses of one handheld motion whose clock stands still while stamps leap; its IMU was
read 200 times a second, but not within gaps.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import redirect_stderr
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.fusion import (
    ADIS16448,
    ContinuousPath,
    ImuStream,
    differentiated,
    estimate_orientation,
    evaluate,
    fuse,
    fuse_by_graph,
    preintegrate,
    simulate_camera_poses,
    simulate_imu,
    synchronise,
)
from motorcade.fusion.graph.odometry import fuse_odometry
from motorcade.fusion.imu import estimate_noise, screen_imu
from motorcade.fusion.imu.simulate import specific_force_m_s2
from motorcade.fusion.metrics import (
    alignment_of,
    angular_rate_lag_s,
    associate,
    energy_excess_above,
    frame_change_defect,
    gimbal_index,
    jitter,
    jitter_above,
    log_dimensionless_jerk,
    position_lag_s,
    position_overshoot_m,
    rotation_overshoot_rad,
    without_scale,
)
from motorcade.fusion.motions import handheld
from motorcade.fusion.motions.degradations import (
    Blackouts,
    DroppedFrames,
    Gaussian,
    Latency,
    Outliers,
    PlanarFlips,
    Quantised,
    StampJitter,
)
from motorcade.fusion.smoothing import (
    METHODS,
    ConstantVelocityFilter,
    automatic_window_s,
    choose,
    estimate_path,
    smooth,
    smoothed_states,
)
from motorcade.fusion.visual_inertial import start_inertial
from motorcade.ga import CumulativeBSpline, Motor, ScrewPath, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.motion import sampled_motion
from motorcade.replays.cli.main import main as motorcade
from motorcade.replays.compare.own_data import compare_recorded
from motorcade.replays.files.imu import read_imu, write_imu
from motorcade.replays.files.trajectories import read_trajectory, write_trajectory
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
        """A folder with pictures, stamps, IMU and ground truth."""
        pictures = self.folder / "images"
        if not pictures.is_dir():
            pictures.mkdir()
            rng = np.random.default_rng(3)
            for k in range(POSES):
                cv2.imwrite(
                    str(pictures / f"{k:03d}.png"), rng.integers(0, 255, (16, 24), dtype=np.uint8)
                )
        self.file("imu.csv"), self.file("truth.csv")
        (self.folder / "stamps.txt").write_text("".join(f"{one}\n" for one in self.time_ns))
        (self.folder / "motorcade.toml").write_text(MANIFEST)
        return str(self.folder)


def _motion(place: FloatArray) -> Any:
    return handheld(np.random.default_rng(0)).at(place * STEP_NS * 1e-9)


class CommandFailedError(Exception):
    """A command that ended with neither 0 nor a refusal."""


def command(*words: str | Callable[[Case], str]) -> Callable[[Case], object]:
    """A command line; callables make words of the case."""

    def run(case: Case) -> None:
        with redirect_stderr(io.StringIO()) as told:
            said = motorcade([word if isinstance(word, str) else word(case) for word in words])
        last = told.getvalue().strip().rpartition("\n")[2]
        if said not in (0, None) and (said not in (1, 2) or "unexpected" in last):
            raise CommandFailedError(f"exit code {said}: {last}")
        if said:
            raise ValueError(last)

    return run


def _file(name: str) -> Callable[[Case], str]:
    return lambda case: case.file(name)


def _out(name: str) -> Callable[[Case], str]:
    return lambda case: str(case.folder / name)


def _rng() -> np.random.Generator:
    return np.random.default_rng(0)


def _recording(case: Case) -> str:
    return case.recording


def _rewritten(case: Case, name: str) -> None:
    write_trajectory(case.truth, case.folder / name)
    read_trajectory(case.folder / name, rate_hz=30.0 if name.endswith("kitti") else None)


def _imu_rewritten(case: Case) -> None:
    write_imu(case.imu, case.folder / "imu.csv")
    read_imu(case.folder / "imu.csv")


def _drawn(case: Case) -> None:
    from motorcade.render.plots import (
        plot_path_3d,
        plot_plan_and_elevation,
        plot_rotation_and_twist,
    )

    paths = {"measured": case.noisy, "truth": case.truth}
    plot_plan_and_elevation(paths)
    plot_path_3d(paths)
    plot_rotation_and_twist(case.noisy)


def _as_gltf(case: Case) -> None:
    from motorcade.animation.formats import CameraPath, write_gltf
    from motorcade.animation.mannequin import mannequin

    write_gltf(
        case.folder / "path.glb",
        mannequin(),
        [],
        world_T_character=case.truth,
        camera=CameraPath(case.truth, 1.0, 1.5),
    )


_RUN = ("run", _recording, "--set", "tracked.by=simulated")

FUNCTIONS: dict[str, Callable[[Case], object]] = {
    "Trajectory.at_rate": lambda case: case.truth.at_rate(200.0),
    "Trajectory.at": lambda case: case.truth.at(case.time_ns[:-1] + np.diff(case.time_ns) // 2),
    "CumulativeBSpline.fit": lambda case: CumulativeBSpline.fit(case.truth, 0.1),
    "ScrewPath": lambda case: ScrewPath(case.truth).twists(case.truth.time_s),
    "evaluate": lambda case: evaluate(case.noisy, case.truth, align="se3"),
    "jitter": lambda case: jitter(case.noisy, case.truth),
    "jitter_above": lambda case: jitter_above(case.noisy, 5e-9),
    "energy_excess_above": lambda case: energy_excess_above(case.noisy, case.truth, 1e-9),
    "log_dimensionless_jerk": lambda case: log_dimensionless_jerk(case.noisy),
    "position_lag_s": lambda case: position_lag_s(case.noisy, case.truth),
    "angular_rate_lag_s": lambda case: angular_rate_lag_s(case.noisy, case.truth),
    "position_overshoot_m": lambda case: position_overshoot_m(case.noisy, case.truth),
    "rotation_overshoot_rad": lambda case: rotation_overshoot_rad(case.noisy, case.truth),
    "gimbal_index": lambda case: gimbal_index(case.noisy, case.truth),
    **{f"smooth {name}": partial(lambda m, case: smooth(case.noisy, m), name) for name in METHODS},
    "smooth spline euler": lambda case: smooth(case.noisy, "spline", "euler"),
    "smooth spline rotor": lambda case: smooth(case.noisy, "spline", "rotor"),
    "choose": lambda case: choose(case.noisy).smooth(case.noisy),
    "smoothed_states": lambda case: smoothed_states(case.noisy, ConstantVelocityFilter()),
    "log_likelihood": lambda case: ConstantVelocityFilter().log_likelihood(case.noisy),
    "frame_change_defect": lambda case: frame_change_defect(
        partial(smooth, method="spline"), case.noisy, *Motor.random(_rng(), (2,))
    ),
    "associate": lambda case: alignment_of(associate(case.noisy, case.truth), "se3").apply_to(
        without_scale(case.noisy)
    ),
    "estimate_path": lambda case: estimate_path(case.noisy),
    "automatic_window_s": lambda case: automatic_window_s(case.noisy, case.measured.covariance),
    "differentiated": lambda case: differentiated(case.noisy),
    "ContinuousPath.through": lambda case: ContinuousPath.through(case.truth).twists(
        np.array([0.0, 1e-9 * float(case.time_ns[-1] - case.time_ns[0])])
    ),
    "simulate_imu": lambda case: simulate_imu(case.truth, 200.0, ADIS16448, _rng()),
    "simulate_camera_poses": lambda case: simulate_camera_poses(
        case.truth, 20.0, 0.01, 0.01, _rng()
    ),
    **{
        f"{type(one).__name__}.apply": partial(lambda d, case: d.apply(case.truth, _rng()), one)
        for one in (
            Outliers(0.05, 0.3, 0.5),
            PlanarFlips(0.1),
            Quantised(0.01, 0.01),
            StampJitter(0.002),
            DroppedFrames(0.2, 3.0),
            Blackouts(1.0, 4.0),
            Latency(0.03, 0.01),
        )
    },
    "fuse": lambda case: fuse(case.measured, case.imu, ADIS16448, Motor.identity()),
    "fuse live": lambda case: fuse(
        case.measured, case.imu, ADIS16448, Motor.identity(), smoothed=False
    ),
    "fuse_by_graph": lambda case: fuse_by_graph(
        case.measured, case.imu, ADIS16448, Motor.identity()
    ),
    "fuse_by_graph with lag": lambda case: fuse_by_graph(
        case.measured, case.imu, ADIS16448, Motor.identity(), lag_s=1.0
    ),
    "fuse_odometry": lambda case: fuse_odometry(case.measured, case.truth, Motor.identity()),
    "synchronise": lambda case: synchronise(case.noisy, case.imu, ADIS16448).on_imu_clock(
        case.noisy
    ),
    "start_inertial": lambda case: start_inertial(
        case.measured, case.imu, ADIS16448, Motor.identity()
    ).in_metres(case.noisy),
    "preintegrate": lambda case: preintegrate(case.imu, case.time_ns, ADIS16448),
    "estimate_noise": lambda case: estimate_noise(case.standing),
    "estimate_orientation": lambda case: estimate_orientation(case.imu),
    "screen_imu": lambda case: screen_imu(case.imu),
    "ImuStream.around": lambda case: case.imu.around(case.time_ns),
    "compare_recorded": lambda case: compare_recorded(
        case.noisy, case.truth, case.folder / "compared", methods=["spline"],
        representations=["motor"],
    ),
    "trajectory as tum": partial(_rewritten, name="path.tum"),
    "trajectory as euroc": partial(_rewritten, name="path.csv"),
    "trajectory as kitti": partial(_rewritten, name="path.kitti"),
    "imu as euroc": _imu_rewritten,
    "plots of trajectories": _drawn,
    "write_gltf": _as_gltf,
}  # fmt: skip

COMMANDS: dict[str, Callable[[Case], object]] = {
    "motorcade evaluate": command("evaluate", _file("est.csv"), _file("truth.csv")),
    "motorcade smooth": command("smooth", _file("est.csv"), "-o", _out("smooth.csv"), "--report"),
    "motorcade smooth --method spline": command(
        "smooth", _file("est.csv"), "-o", _out("smooth.csv"), "--method", "spline"
    ),
    "motorcade simulate-imu": command("simulate-imu", _file("truth.csv"), "-o", _out("made.csv")),
    "motorcade sync": command("sync", _file("est.csv"), _file("imu.csv")),
    "motorcade allan": command("allan", _file("standing.csv")),
    "motorcade compare --input": command(
        "compare", "--input", _file("est.csv"), "--truth", _file("truth.csv"),
        "--methods", "gaussian", "--representations", "motor", "--out", _out("compared"),
    ),
    "motorcade inspect": command("inspect", _recording),
    "motorcade run --until errors": command(*_RUN, "--until", "errors", "--out", _out("errors")),
    "motorcade run (tracked IMU)": command(
        *_RUN, "--set", "imu.source=reference", "--until", "fused", "--out", _out("tracked")
    ),
    "motorcade run --until convergence": command(
        *_RUN, "--until", "convergence", "--out", _out("converged")
    ),
}  # fmt: skip

DOORS = FUNCTIONS | COMMANDS

Line = tuple[str | Callable[[Case], str], ...]
FRESH: dict[str, tuple[Line, ...]] = {
    "motorcade run": ((*_RUN, "--out", _out("run")),),
    "motorcade export": (
        (*_RUN, "--until", "placed", "--out", _out("run")),
        ("export", _out("run"), "--gltf", _out("run.glb")),
    ),
}
"""Commands one after another that want a process of their own from the start: they draw."""
