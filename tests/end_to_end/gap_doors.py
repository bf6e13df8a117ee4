"""What `gaps` and its quick tests try: every door that takes a path or stream."""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import redirect_stderr
from functools import partial

import numpy as np

from motorcade.fusion import (
    ADIS16448,
    ContinuousPath,
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
from motorcade.fusion.filter import latency_curve, learn_noise
from motorcade.fusion.filter.fitting import fit_noise
from motorcade.fusion.graph.calibrate import calibrate_by_graph
from motorcade.fusion.graph.odometry import fuse_odometry
from motorcade.fusion.health import check_health
from motorcade.fusion.imu import (
    estimate_noise,
    screen_imu,
    simulate_imu_in_chunks,
)
from motorcade.fusion.metrics import (
    alignment_of,
    angular_rate_lag_s,
    associate,
    cropped,
    energy_excess_above,
    frame_change_defect,
    gimbal_index,
    jitter,
    jitter_above,
    log_dimensionless_jerk,
    match,
    position_lag_s,
    position_overshoot_m,
    rotation_overshoot_rad,
)
from motorcade.fusion.motions.degradations import (
    Blackouts,
    DroppedFrames,
    Latency,
    Outliers,
    PlanarFlips,
    Quantised,
    StampJitter,
)
from motorcade.fusion.smoothing import (
    METHODS,
    ConstantVelocityFilter,
    LiveSmoother,
    PathCurve,
    automatic_window_s,
    choose,
    smooth,
    smoothed_automatically,
)
from motorcade.fusion.smoothing.batch.robust_map import estimate_path
from motorcade.fusion.smoothing.causal import smoothed_states
from motorcade.fusion.visual_inertial import InertialSlam, start_inertial
from motorcade.ga import CumulativeBSpline, Motor, ScrewPath
from motorcade.replays.cli.main import main as motorcade
from motorcade.replays.comparison.run import compare_recorded
from motorcade.replays.io.imu import read_imu, write_imu
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from motorcade.tracking import Camera
from tests.end_to_end.gap_paths import Case


class CommandFailedError(Exception):
    """A command that ended with neither 0 nor a refusal."""


def _tracked(case: Case) -> object:
    """A camera that stands still before noise, and the case's samples."""
    slam = InertialSlam(Camera(160, 120, 150.0, 150.0, 79.5, 59.5), ADIS16448, Motor.identity())
    slam.imu(case.imu)
    gray = np.random.default_rng(0).integers(0, 255, (120, 160)).astype(np.uint8)
    covered = case.time_ns[(case.time_ns >= 0) & (case.time_ns <= case.imu.time_ns[-1])]
    for time_ns in covered[:: max(len(covered) // 10, 1)].tolist():
        slam.track(time_ns, gray)
    return slam.finish()


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
        plot_paths,
        plot_plan_and_elevation,
        plot_rotation_and_twist,
    )

    paths = {"measured": case.noisy, "truth": case.truth}
    plot_plan_and_elevation(paths)
    plot_path_3d(paths)
    plot_paths(paths)
    plot_rotation_and_twist(case.noisy)


def _as_gltf(case: Case) -> None:
    from motorcade.animation.formats import CameraPath, CharacterOnPath, write_cast_gltf
    from motorcade.animation.mannequin import mannequin

    figure = mannequin()
    member = CharacterOnPath("figure", figure, figure.clip("walk"), case.truth)
    camera = CameraPath(case.truth, 1.0, 1.5)
    write_cast_gltf(case.folder / "path.glb", [member], camera=camera)


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
    "smooth full": lambda case: smooth(case.noisy, "gaussian", full=True).at(case.time_ns),
    "PathCurve": lambda case: PathCurve(case.noisy).twists(case.time_ns),
    "choose": lambda case: choose(case.noisy).smooth(case.noisy),
    "smoothed_automatically": lambda case: smoothed_automatically(case.noisy),
    "smoothed_states": lambda case: smoothed_states(case.noisy, ConstantVelocityFilter()),
    "LiveSmoother": lambda case: LiveSmoother(0.1).smooth(case.noisy.rigid),
    "log_likelihood": lambda case: ConstantVelocityFilter().log_likelihood(case.noisy),
    "frame_change_defect": lambda case: frame_change_defect(
        partial(smooth, method="spline"), case.noisy, *Motor.random(_rng(), (2,))
    ),
    "cropped": lambda case: cropped(case.noisy, end_s=1e-9 * float(case.time_ns[100])),
    "match": lambda case: match(case.noisy, case.truth, "se3", interpolate=True),
    "associate": lambda case: alignment_of(associate(case.noisy, case.truth), "se3").apply_to(
        case.noisy.rigid
    ),
    "estimate_path": lambda case: estimate_path(case.noisy),
    "automatic_window_s": lambda case: automatic_window_s(case.noisy, case.measured.covariance),
    "differentiated": lambda case: differentiated(case.noisy),
    "ContinuousPath.through": lambda case: ContinuousPath.through(case.truth).twists(
        np.array([0.0, 1e-9 * float(case.time_ns[-1] - case.time_ns[0])])
    ),
    "simulate_imu_in_chunks": lambda case: sum(
        len(chunk.stream)
        for chunk in simulate_imu_in_chunks(case.truth, 200.0, ADIS16448, _rng())
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
    "latency_curve": lambda case: latency_curve(
        lambda lag_s: fuse(case.measured, case.imu, ADIS16448, Motor.identity(), lag_s=lag_s)
    ),
    "fit_noise": lambda case: fit_noise(case.measured, case.imu, ADIS16448, Motor.identity()),
    "learn_noise": lambda case: learn_noise(
        case.measured, case.imu, ADIS16448, Motor.identity()
    ),
    "fuse_by_graph": lambda case: fuse_by_graph(
        case.measured, case.imu, ADIS16448, Motor.identity()
    ),
    "calibrate_by_graph": lambda case: calibrate_by_graph(
        case.measured, case.imu, ADIS16448, Motor.identity()
    ),
    "check_health": lambda case: check_health(case.noisy, case.imu, Motor.identity()),
    "fuse_odometry": lambda case: fuse_odometry(case.measured, case.truth, Motor.identity()),
    "synchronise": lambda case: synchronise(case.noisy, case.imu, ADIS16448).on_imu_clock(
        case.noisy
    ),
    "start_inertial": lambda case: start_inertial(
        case.measured, case.imu, ADIS16448, Motor.identity()
    ).in_metres(case.noisy),
    "InertialSlam": lambda case: _tracked(case),
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
    "write_cast_gltf": _as_gltf,
}  # fmt: skip

COMMANDS: dict[str, Callable[[Case], object]] = {
    "motorcade evaluate": command("evaluate", _file("est.csv"), _file("truth.csv")),
    "motorcade smooth": command("smooth", _file("est.csv"), "-o", _out("smooth.csv"), "--report"),
    "motorcade smooth --method spline": command(
        "smooth", _file("est.csv"), "-o", _out("smooth.csv"), "--method", "spline"
    ),
    "motorcade simulate-imu": command("simulate-imu", _file("truth.csv"), "-o", _out("made.csv")),
    "motorcade sync": command("sync", _file("est.csv"), _file("imu.csv")),
    "motorcade fuse": command("fuse", _file("est.csv"), _file("imu.csv"), "-o", _out("fused.csv")),
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
