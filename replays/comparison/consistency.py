"""Many runs of every filter on every motion, over the cores: are errors as large as stated?

One experiment is a motion, its simulated sensors, and what a filter's errors come to. Every filter
starts `tilt_deg` wrong in tilt, always to the same side, and states that as its deviation; it
starts at rest, 20 m/s uncertain, and with zero biases, while the true ones are drawn from its
prior. So the first square of the velocity is near 0 and that of the pose near 5: all later ones are
draws from what the filter is told, Gaussian noise and bias walks. Errors are judged in the filter's
own coordinates, by the covariance that it states in them, after each measured pose.

The report is one HTML file that needs nothing beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any
from zlib import crc32

import numpy as np

from motorcade.fusion.filter import FilterSettings, fuse
from motorcade.fusion.filter.comparison import (
    ErrorCoordinates,
    Estimates,
    EulerErrors,
    ExactEulerErrors,
    ExtendedPoseErrors,
    QuaternionTranslationErrors,
    Runs,
    RunStates,
    filter_runs,
)
from motorcade.fusion.imu import ContinuousPath, ImuFaults, ImuNoise, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.metrics.consistency import Consistency, normalised_squared
from motorcade.fusion.motions import Motion
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import nearest_name
from motorcade.render.plots import Band, plot_bands, plot_squares
from motorcade.render.plots.style import with_own_ids
from motorcade.replays.engine.jobs import job_key, run_jobs
from motorcade.replays.io.files import write_bytes, write_csv
from motorcade.replays.web.pages import PageCell, PagePlot, page_environment
from motorcade.tracking.measurements import PoseMeasurements

PARTS: Mapping[str, slice] = MappingProxyType(
    {
        "pose": slice(0, 6),
        "velocity": slice(6, 9),
        "biases": slice(9, 15),
    }
)
"""What is judged apart: places in the error of 15 numbers."""
_SQUARES = (*(f"nees_{part}" for part in PARTS), "nis")

# Deviations of the true biases, those of the filter's prior.
_GYRO_BIAS_RAD_S, _ACCEL_BIAS_M_S2 = 0.1, 0.5
# Motions of a camera that looks ahead. Their IMU has its x axis ahead and z up, as on vehicles:
# in the camera's axes Euler angles would stand at gimbal lock all the time.
_LOOKING_AHEAD = (
    "screw",
    "distant_circle",
    "handheld",
    "walk_and_look",
    "stop_and_go",
    "fast_spin",
)
_AHEAD = Motor.from_rotor_translation(
    Rotor.from_matrix(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])), np.zeros(3)
)


# White noise of a cheap sensor, and biases that wander so fast that a run sees many of them.
_FAST_WALKS = ImuNoise(1e-3, 1e-3, 1e-2, 1e-2)


@dataclass(frozen=True)
class Experiment:
    """What is simulated, and how long.

    Fields:
        motion: name of one of `MOTIONS`, rigid.
        duration_s: of each run. Bias errors live for seconds; the share of steps within bounds
            means something only over many times that.
        noise: of the IMU. The default has the white noise of a cheap sensor and fast bias walks,
            so that a run sees many independent biases.
        imu_hz: inertial samples a second.
        camera_hz: measured poses a second, a divisor of `imu_hz`.
        sigma_m, sigma_deg: deviations of measured poses, an axis.
        tilt_deg: how wrong the first orientation is, about the world's x.
    """

    motion: str
    duration_s: float = 120.0
    noise: ImuNoise = _FAST_WALKS
    imu_hz: float = 200.0
    camera_hz: float = 20.0
    sigma_m: float = 0.01
    sigma_deg: float = 0.5
    tilt_deg: float = 5.0

    def path(self) -> ContinuousPath:
        """The true path of the IMU. Raises ValueError: a name that is no rigid motion's."""
        motion = MOTIONS.get(self.motion)
        if motion is None or motion.versor is not Motor:
            names = [name for name, one in MOTIONS.items() if one.versor is Motor]
            near = nearest_name(self.motion, names)
            listed = ", ".join(names)
            raise ValueError(f"motion: expected one of {listed}, got {self.motion!r}{near}")
        rigid: Motion[Motor] = motion
        path = ContinuousPath.along(rigid, self.duration_s)
        return path.seen_from(_AHEAD) if self.motion in _LOOKING_AHEAD else path

    def settings(self) -> FilterSettings:
        """What every filter is told."""
        return FilterSettings(initial_tilt_error_rad=float(np.deg2rad(self.tilt_deg)))


@dataclass(frozen=True, eq=False)
class Simulated:
    """R runs of one experiment, and the true states ``(R, M)`` at the measured stamps."""

    recorded: tuple[tuple[PoseMeasurements, ImuStream], ...]
    truth: RunStates


@dataclass(frozen=True, eq=False)
class Judged:
    """Squares and errors ``(R, M)`` of R runs at M measured stamps.

    Fields:
        time_s: ``(M,)`` from the start.
        nees: by part of the state, see `PARTS`.
        nis: of the innovations; NaN at the first stamp.
        rotation_rad, position_m: sizes of the errors.
        left_out: ``(R,)`` measurements that the gate refused.
    """

    time_s: FloatArray
    nees: dict[str, FloatArray]
    nis: FloatArray
    rotation_rad: FloatArray
    position_m: FloatArray
    left_out: IntArray


def simulate(experiment: Experiment, seeds: range) -> Simulated:
    """Simulate a run a seed; a seed's run is the same whatever the others are."""
    path, tag = experiment.path(), crc32(experiment.motion.encode())
    runs = [_run(experiment, path, np.random.default_rng((tag, seed))) for seed in seeds]
    return Simulated(tuple(data for data, _ in runs), RunStates.stacked([true for _, true in runs]))


def _run(
    experiment: Experiment, path: ContinuousPath, rng: np.random.Generator
) -> tuple[tuple[PoseMeasurements, ImuStream], RunStates]:
    faults = ImuFaults(
        gyro_bias_rad_s=_GYRO_BIAS_RAD_S * rng.standard_normal(3),
        accel_bias_m_s2=_ACCEL_BIAS_M_S2 * rng.standard_normal(3),
    )
    imu = simulate_imu(path, experiment.imu_hz, experiment.noise, rng, faults=faults)
    measured = simulate_camera_poses(
        imu.path, experiment.camera_hz, experiment.sigma_m, np.deg2rad(experiment.sigma_deg), rng
    )
    at = np.searchsorted(imu.stream.time_ns, measured.trajectory.time_ns)
    bias = np.concatenate([imu.gyro_bias_rad_s, imu.accel_bias_m_s2], axis=-1)
    true = imu.path.motors[at]
    return (measured, imu.stream), RunStates(
        true.rotor, true.translation_m, imu.velocity_m_s[at], bias[at]
    )


def judge(simulated: Simulated, experiment: Experiment, name: str) -> Judged:
    """Filter the runs of an experiment by the filter of a name in `FILTERS`, and judge it."""
    filtered, coordinates = FILTERS[name]
    estimates = filtered(simulated, experiment)
    errors = coordinates.local(estimates.state, simulated.truth)
    nees = {
        part: normalised_squared(errors[..., at], estimates.covariance[..., at, at])
        for part, at in PARTS.items()
    }
    turn = (estimates.state.rotor.inverse() @ simulated.truth.rotor).angle()
    shift = np.linalg.norm(estimates.state.position_m - simulated.truth.position_m, axis=-1)
    time_s = simulated.recorded[0][0].trajectory.time_s
    left_out = np.count_nonzero(~estimates.accepted, axis=1)
    return Judged(time_s - time_s[0], nees, estimates.nis, turn, shift, left_out)


def _on_motors(simulated: Simulated, experiment: Experiment) -> Estimates:
    """The filter itself, run by run."""
    settings = experiment.settings()
    plain = partial(fuse, settings=settings, smoothed=False, fits_noise=False)
    each = [
        plain(measured, imu, experiment.noise, Motor.identity())
        for measured, imu in simulated.recorded
    ]
    states = [
        RunStates(
            run.trajectory.motors.rotor,
            run.trajectory.motors.translation_m,
            run.velocity_m_s,
            np.concatenate([run.gyro_bias_rad_s, run.accel_bias_m_s2], axis=-1),
        )
        for run in each
    ]
    return Estimates(
        RunStates.stacked(states),
        np.stack([one.state_covariance for one in each]),
        np.stack([one.nis for one in each]),
        np.stack([one.accepted for one in each]),
    )


def _in(coordinates: ErrorCoordinates) -> Filtering:
    def filtered(simulated: Simulated, experiment: Experiment) -> Estimates:
        return filter_runs(
            Runs.of(simulated.recorded), experiment.noise, coordinates, experiment.settings()
        )

    return filtered


Filtering = Callable[[Simulated, Experiment], Estimates]
FILTERS: Mapping[str, tuple[Filtering, ErrorCoordinates]] = MappingProxyType(
    {
        "motor": (_on_motors, ExtendedPoseErrors()),
        "quaternion": (_in(QuaternionTranslationErrors()), QuaternionTranslationErrors()),
        "euler": (_in(EulerErrors()), EulerErrors()),
        "euler_exact": (_in(ExactEulerErrors()), ExactEulerErrors()),
    }
)
"""Every filter by name: what runs it, and the coordinates of its errors."""


_RUNS_A_JOB = 20
_INNOVATION_FREEDOM = 6
# Errors are told of once the wrong start is forgotten.
_SETTLED_S = 5.0


@dataclass(frozen=True)
class ConsistencyPlan:
    """What to compare.

    Fields:
        motions: names of rigid motions.
        filters: names of filters.
        runs: of each motion; every filter sees the same ones.
        seed: of the first run, the next have those that follow.
        duration_s: of a run.

    Raises:
        ValueError: an unknown name, none at all, or a number out of its range.
    """

    motions: tuple[str, ...] = ("gimbal_crossing", "handheld", "walk_and_look")
    filters: tuple[str, ...] = ("motor", "quaternion", "euler")
    runs: int = 100
    seed: int = 0
    duration_s: float = 120.0

    def __post_init__(self) -> None:
        if not self.motions or not self.filters:
            raise ValueError("plan: expected one motion and one filter or more, got none")
        for name in self.filters:
            if name not in FILTERS:
                raise ValueError(
                    f"plan.filters: expected some of {', '.join(FILTERS)}, got {name!r}"
                )
        if self.runs < 1 or self.seed < 0:
            raise ValueError(
                f"plan: expected runs >= 1 and seed >= 0, got {self.runs} and {self.seed}"
            )
        if not 2.0 * _SETTLED_S <= self.duration_s < np.inf:
            raise ValueError(
                f"plan.duration_s: expected {2.0 * _SETTLED_S:g} or more, got {self.duration_s}"
            )
        for experiment in self.experiments():
            experiment.path()

    def experiments(self) -> tuple[Experiment, ...]:
        """One a motion."""
        return tuple(Experiment(name, self.duration_s) for name in self.motions)


@dataclass(frozen=True, eq=False)
class Verdict:
    """What all runs of one filter on one motion come to; arrays are over the measured stamps.

    Fields:
        time_s: from the start.
        nis: of the innovations, without the first stamp.
        rotation_rms_deg, position_rms_m: over the runs, stamp by stamp.
        rotation_spread_deg: the 10th, 50th and 90th percentile over the runs, stamp by stamp.
        rotation_worst_deg: of any run at any stamp after five seconds.
        left_out: measurements that the gate refused, of all runs.
    """

    time_s: FloatArray
    nees: Mapping[str, Consistency]
    nis: Consistency
    rotation_rms_deg: FloatArray
    position_rms_m: FloatArray
    rotation_spread_deg: tuple[FloatArray, FloatArray, FloatArray]
    rotation_worst_deg: float
    left_out: int

    @property
    def settled(self) -> slice:
        """Stamps after five seconds."""
        return slice(int(np.searchsorted(self.time_s, _SETTLED_S)), None)


def run_plan(
    plan: ConsistencyPlan, out: Path, executor: str = "local"
) -> dict[str, dict[str, Verdict]]:
    """Verdicts by motion and filter, and the table ``consistency.csv``.

    What is finished is kept in ``OUT/.finished``, a folder for every twenty runs of a motion. A
    call that was stopped goes on where it was, one with more runs or motions computes those.

    On a cluster `out` must be a folder that all workers see. The verdicts do not depend on the
    `executor` (see `motorcade.replays.engine.jobs.outcomes`).

    Raises KeyboardInterrupt: stopped by Ctrl-C; what is finished is kept, and no table is written;
    ValueError, RuntimeError: the executor is unknown or cannot be reached; OSError: a folder that
    cannot be written.
    """
    jobs = {job: out / ".finished" / job_key(run_seeds, asdict(job)) for job in _jobs(plan)}
    judged = run_jobs(run_seeds, jobs, executor, "parts").whole("parts")
    parts: dict[str, list[dict[str, Judged]]] = {motion: [] for motion in plan.motions}
    for job, of in judged.items():
        parts[job.experiment.motion].append(of)
    verdicts = {motion: _verdicts(plan, of) for motion, of in parts.items()}
    rows = as_json(plan, verdicts)["rows"]
    write_csv(out / "consistency.csv", list(rows[0]), [list(row.values()) for row in rows])
    return verdicts


def _jobs(plan: ConsistencyPlan) -> Iterator[SeedRange]:
    last = plan.seed + plan.runs
    for experiment in plan.experiments():
        for first in range(plan.seed, last, _RUNS_A_JOB):
            count = min(_RUNS_A_JOB, last - first)
            yield SeedRange(experiment, plan.filters, first, count)


def as_json(plan: ConsistencyPlan, verdicts: Mapping[str, Mapping[str, Verdict]]) -> dict[str, Any]:
    """The figures as a JSON-ready tree: a row a motion and filter; keys carry units."""
    return {
        "runs": plan.runs,
        "seed": plan.seed,
        "duration_s": plan.duration_s,
        "probability": 0.95,
        "rows": [
            {"motion": motion, "filter": name, **_row(verdict)}
            for motion, of in verdicts.items()
            for name, verdict in of.items()
        ],
    }


def as_table(figures: Mapping[str, Any]) -> str:
    """The figures of `as_json` as aligned text: shares of steps within the bounds, and errors."""
    heads = (*PARTS, "NIS", "rotation", "worst", "position", "left out")
    lines = [
        f"steps within the 95 % bounds of {figures['runs']} runs of {figures['duration_s']:g} s",
        f"{'':<34}" + "".join(f"{head:>10}" for head in heads),
    ]
    for row in figures["rows"]:
        shares = "".join(f"{100 * row[f'{name}_share_within']:>8.1f} %" for name in _SQUARES)
        errors = (
            f"{row['rotation_rmse_deg']:>9.3g}°{row['rotation_worst_deg']:>9.3g}°"
            f"{1e3 * row['position_rmse_m']:>7.3g} mm{row['left_out']:>10}"
        )
        lines.append(f"{row['motion'] + ', ' + row['filter']:<34}{shares}{errors}")
    return "\n".join(lines)


def _row(verdict: Verdict) -> dict[str, Any]:
    judged = {f"nees_{part}": one for part, one in verdict.nees.items()} | {"nis": verdict.nis}
    row: dict[str, Any] = {}
    for name, judged_filter in judged.items():
        row[f"{name}_share_within"] = judged_filter.share_within
        row[f"{name}_over_expected"] = judged_filter.ratio
    rotation, position = (
        float(np.sqrt(np.mean(values[verdict.settled] ** 2)))
        for values in (verdict.rotation_rms_deg, verdict.position_rms_m)
    )
    return row | {
        "rotation_rmse_deg": rotation,
        "rotation_worst_deg": verdict.rotation_worst_deg,
        "position_rmse_m": position,
        "left_out": verdict.left_out,
    }


@dataclass(frozen=True)
class SeedRange:
    """Runs of one motion that are done together: `count` seeds from the first."""

    experiment: Experiment
    filters: tuple[str, ...]
    first_seed: int
    count: int


def run_seeds(job: SeedRange) -> dict[str, Judged]:
    """Simulate the runs and judge every filter on them."""
    simulated = simulate(job.experiment, range(job.first_seed, job.first_seed + job.count))
    return {name: judge(simulated, job.experiment, name) for name in job.filters}


def _verdicts(plan: ConsistencyPlan, judged: Sequence[Mapping[str, Judged]]) -> dict[str, Verdict]:
    return {name: _verdict([one[name] for one in judged]) for name in plan.filters}


def _verdict(parts: Sequence[Judged]) -> Verdict:
    """Of all runs, from those of each job."""

    def joined(values: Sequence[FloatArray]) -> FloatArray:
        return np.concatenate(values)

    time_s = parts[0].time_s
    rotation = np.rad2deg(joined([one.rotation_rad for one in parts]))
    position = joined([one.position_m for one in parts])
    nis = joined([one.nis for one in parts])[:, 1:]
    settled = int(np.searchsorted(time_s, _SETTLED_S))
    low, middle, high = np.percentile(rotation, (10, 50, 90), axis=0)
    return Verdict(
        time_s,
        {
            part: Consistency.of(joined([one.nees[part] for one in parts]), at.stop - at.start)
            for part, at in PARTS.items()
        },
        Consistency.of(nis, _INNOVATION_FREEDOM),
        np.sqrt(np.mean(rotation**2, axis=0)),
        np.sqrt(np.mean(position**2, axis=0)),
        (low, middle, high),
        float(rotation[:, settled:].max()),
        int(sum(np.sum(one.left_out) for one in parts)),
    )


_TEMPLATE = Path(__file__).with_name("consistency.html")
# Where 95 % of steps are expected within the bounds.
_GOOD = (0.90, 0.99)
_FILTERS = {
    "motor": "the filter on motors: errors on the right of a pair of motors",
    "quaternion": "the same filter, errors split into a turn in the moving frame and world "
    "coordinates",
    "euler": "angles as the state, integrated by their rates, measured with a noise of their own",
    "euler_exact": "angles as the state, motion and noise converted exactly",
}


def write_page(
    plan: ConsistencyPlan, verdicts: Mapping[str, Mapping[str, Verdict]], folder: Path
) -> Path:
    """Write `consistency.html` into a folder, and say where it is.

    Raises OSError: a folder that cannot be written.
    """
    page = (
        page_environment(_TEMPLATE.parent)
        .get_template(_TEMPLATE.name)
        .render(
            plan=plan,
            experiment=Experiment(plan.motions[0], plan.duration_s),
            parts=tuple(PARTS),
            rows=[_shown(row) for row in as_json(plan, verdicts)["rows"]],
            filters={name: _FILTERS[name] for name in plan.filters},
            plots={motion: _plots(motion, of) for motion, of in verdicts.items()},
        )
    )
    path = folder / "consistency.html"
    write_bytes(path, page.encode())
    return path


def _shown(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row of the table: shares within and averages over what is expected, then errors."""
    shares = [float(row[f"{name}_share_within"]) for name in _SQUARES]
    position_mm = 1e3 * float(row["position_rmse_m"])
    return {
        "motion": row["motion"],
        "filter": row["filter"],
        "shares": [
            PageCell(f"{100 * share:.1f} %", share, "b2" if _GOOD[0] <= share <= _GOOD[1] else "o3")
            for share in shares
        ],
        "ratios": [_figure(row[f"{name}_over_expected"]) for name in _SQUARES],
        "errors": [
            _figure(row["rotation_rmse_deg"], "°"),
            _figure(row["rotation_worst_deg"], "°"),
            _figure(position_mm, " mm"),
            PageCell(str(row["left_out"]), float(row["left_out"])),
        ],
    }


def _figure(value: float, unit: str = "") -> PageCell:
    return PageCell(f"{value:.3g}{unit}", float(value))


def _plots(motion: str, verdicts: Mapping[str, Verdict]) -> list[PagePlot]:
    plots = []
    for part in PARTS:
        judged = {name: one.nees[part] for name, one in verdicts.items()}
        plots.append(_squares(motion, part, f"NEES of the {part}", judged, verdicts, 0))
    innovations = {name: one.nis for name, one in verdicts.items()}
    plots.append(_squares(motion, "nis", "NIS of the measured poses", innovations, verdicts, 1))
    spread = {name: Band(one.time_s, *one.rotation_spread_deg) for name, one in verdicts.items()}
    svg = plot_bands(spread, f"rotation error on {motion}", "rotation error (°)")
    caption = "Median over the runs, and where the middle 80 % of them lie."
    plots.append(PagePlot("Rotation error", caption, with_own_ids(svg, f"{motion}-rotation")))
    return plots


def _squares(
    motion: str,
    name: str,
    title: str,
    judged: Mapping[str, Consistency],
    verdicts: Mapping[str, Verdict],
    skipped: int,
) -> PagePlot:
    first = next(iter(judged.values()))
    series = {of: (verdicts[of].time_s[skipped:], found.average) for of, found in judged.items()}
    unit = "average over the runs"
    svg = plot_squares(series, first.freedom, (first.low, first.high), f"{title} on {motion}", unit)
    caption = f"Expected {first.freedom}, dashed; tinted: {first.low:.2f} to {first.high:.2f}."
    return PagePlot(title, caption, with_own_ids(svg, f"{motion}-{name}"))
