"""Commands on the readings of an IMU alone: `motorcade simulate-imu`, `allan`, `orient`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import (
    Commands,
    add_choice,
    add_file,
    add_flag,
    add_number,
    add_output,
    add_seed,
    chosen,
    print_json,
    shown,
    write_json,
)

if TYPE_CHECKING:
    from motorcade.fusion.imu import ImuFaults, ImuNoise, VibrationSpectrum
    from motorcade.fusion.imu.allan import StreamNoise
    from motorcade.fusion.orientation.estimate import Orientation, OrientationModel
    from motorcade.ga import Motor


_THREE = ("X", "Y", "Z")


def add_simulate_imu(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        simulate,
        "simulate-imu",
        "simulate an IMU along a trajectory (z up, poses of the IMU), as CSV or .npz",
        "motorcade simulate-imu truth.tum -o imu.csv --rate-hz 200 --seed 1 "
        "--gyro-bias 0.01 0 -0.02 --dropped 0.01",
    )
    parser.add_argument("trajectory", type=Path, metavar="TRAJECTORY")
    add_output(
        parser,
        "OUT",
        "EuRoC's CSV, or the same arrays as .npz: smaller, and quicker to write and read",
    )
    add_number(parser, "--rate-hz", "of the samples (200)", 200.0)
    add_file(parser, "--times", "stamps of a KITTI file's poses, one a row, s")
    add_seed(parser, 0, "the noise")
    parser.add_argument(
        "--noise",
        metavar="FILE",
        nargs="+",
        default=[],
        help="Kalibr or EuRoC YAML, or one for each of x, y and z, or 'none'; else ADIS16448",
    )
    add_number(
        parser,
        "--knots-s",
        "spacing of the spline's knots; it follows motion up to 1 / (4 spacing) Hz (0.1)",
        0.1,
    )
    _add_extrinsics(parser)
    _add_faults(parser)
    _add_vibration(parser)


def _add_extrinsics(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("where the sensor sits, and its clock")
    add_number(
        group,
        "--imu-from-poses",
        "where the poses are a camera's: that frame in the IMU's axes (imu_T_camera)",
        nargs=7,
        metavar=("TX", "TY", "TZ", "QX", "QY", "QZ", "QW"),
    )
    add_number(group, "--time-offset-s", "what the IMU's clock shows too much", 0.0)


_AXES = (
    ("--gyro-scale", "gyro_scale", "factors of the angular rate"),
    ("--accel-scale", "accel_scale", "factors of the specific force"),
    ("--gyro-misalignment", "gyro_misalignment_rad", "rad: y towards x, z towards x, z towards y"),
    (
        "--accel-misalignment",
        "accel_misalignment_rad",
        "rad: y towards x, z towards x, z towards y",
    ),
    (
        "--gyro-turn",
        "gyro_turn_rad",
        "rad, rotation vector from the accelerometer's axes to the gyroscope's",
    ),
    (
        "--gyro-g-sensitivity",
        "gyro_g_sensitivity_rad_s_m",
        "(rad/s)/(m/s²), rate read for force along each axis",
    ),
    ("--gyro-bias", "gyro_bias_rad_s", "rad/s, where the walk starts"),
    ("--accel-bias", "accel_bias_m_s2", "m/s², where the walk starts"),
    ("--gyro-flicker", "gyro_flicker_rad_s", "rad/s, bias instability"),
    ("--accel-flicker", "accel_flicker_m_s2", "m/s², bias instability"),
    ("--gyro-bias-per-k", "gyro_bias_rad_s_k", "rad/s for each kelvin of warming"),
    ("--accel-bias-per-k", "accel_bias_m_s2_k", "m/s² for each kelvin of warming"),
    ("--gyro-scale-per-k", "gyro_scale_k", "growth of the factors for each kelvin"),
    ("--accel-scale-per-k", "accel_scale_k", "growth of the factors for each kelvin"),
)
"""Options with a number an axis, and what `ImuFaults` calls them."""
_NUMBERS = (
    ("--warming-k", 0.0, "kelvins by which the sensor gets warmer in the end"),
    ("--warming-time-s", 600.0, "within which it does 63 %% of that (600)"),
    ("--gyro-lowpass-hz", float("inf"), "its own filter, a Butterworth of second order (none)"),
    ("--accel-lowpass-hz", float("inf"), "its own filter, a Butterworth of second order (none)"),
    ("--gyro-delay-s", 0.0, "how much readings are older than their stamps"),
    ("--accel-delay-s", 0.0, "how much readings are older than their stamps"),
    ("--stamp-jitter-s", 0.0, "deviation of stamps, up to a quarter of the interval"),
    ("--gyro-range-rad-s", float("inf"), "where it saturates (nowhere)"),
    ("--accel-range-m-s2", float("inf"), "where it saturates (nowhere)"),
    ("--gyro-step-rad-s", 0.0, "of the converter"),
    ("--accel-step-m-s2", 0.0, "of the converter"),
    ("--dropped", 0.0, "share of samples that are lost"),
)


def _add_faults(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("faults of the sensor")
    axes: dict[str, Any] = {"type": float, "nargs": 3, "metavar": _THREE}
    for name, field, text in _AXES:
        default = [1.0] * 3 if name.endswith("scale") else [0.0] * 3
        group.add_argument(name, dest=field, default=default, help=text, **axes)
    for name, number, text in _NUMBERS:
        add_number(group, name, text, number)


def _add_vibration(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("vibration of what carries it")
    sources = group.add_mutually_exclusive_group()
    add_file(
        sources,
        "--vibration",
        "rows of Hz, (rad/s)²/Hz for x, y, z and (m/s²)²/Hz for x, y, z",
        "SPECTRUM.csv",
    )
    add_file(sources, "--vibration-of", "a recording in motion to learn it from", "IMU")
    add_number(
        group, "--vibration-above-hz", "what is slower in that recording is its motion (10)", 10.0
    )


def simulate(arguments: argparse.Namespace) -> None:
    """Read the trajectory, simulate, write the stream."""
    import numpy as np

    from motorcade.fusion.imu import simulate_imu_in_chunks
    from motorcade.replays.io.imu import write_imu
    from motorcade.replays.io.trajectories import read_trajectory

    simulated = simulate_imu_in_chunks(
        read_trajectory(arguments.trajectory, times=arguments.times),
        arguments.rate_hz,
        _noise(arguments.noise),
        np.random.default_rng(arguments.seed),
        knot_spacing_s=arguments.knots_s,
        faults=_faults(arguments),
        vibration=_vibration(arguments),
        imu_T_child=_extrinsics(arguments),
        time_offset_s=arguments.time_offset_s,
    )
    write_imu((chunk.stream for chunk in simulated), arguments.output)


def _noise(values: list[str]) -> ImuNoise | tuple[ImuNoise, ...] | None:
    from motorcade.fusion.imu import ADIS16448, ImuNoise

    if values == ["none"]:
        return None
    if len(values) not in (0, 1, 3):
        raise ValueError(f"--noise: expected one file, or one for each axis, got {len(values)}")
    axes = tuple(ImuNoise.load(Path(file)) for file in values)
    return axes if len(axes) == 3 else axes[0] if axes else ADIS16448


def _faults(arguments: argparse.Namespace) -> ImuFaults:
    from motorcade.fusion.imu import ImuFaults

    numbers = [name.removeprefix("--").replace("-", "_") for name, _, _ in _NUMBERS]
    named = chosen(arguments, *(field for _, field, _ in _AXES), *numbers)
    return ImuFaults(dropped_share=named.pop("dropped"), **named)


def _vibration(arguments: argparse.Namespace) -> VibrationSpectrum | None:
    from motorcade.fusion.imu import VibrationSpectrum
    from motorcade.replays.io.imu import read_vibration
    from motorcade.replays.io.readers.readings import read_imu_of

    if arguments.vibration is not None:
        return read_vibration(arguments.vibration)
    if arguments.vibration_of is None:
        return None
    return VibrationSpectrum.learnt(
        read_imu_of(arguments.vibration_of), arguments.vibration_above_hz
    )


def _extrinsics(arguments: argparse.Namespace) -> Motor | None:
    from motorcade.ga import Motor, Rotor

    if arguments.imu_from_poses is None:
        return None
    x, y, z, *turn, w = arguments.imu_from_poses
    size = sum(part**2 for part in (*turn, w)) ** 0.5
    if not abs(size - 1.0) < 1e-3:
        raise ValueError(f"--imu-from-poses: expected a unit quaternion, got one of length {size}")
    wxyz = [part / size for part in (w, *turn)]
    return Motor.from_rotor_translation(Rotor.from_quaternion(wxyz), [x, y, z])


def add_allan(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        allan,
        "allan",
        "noise densities and bias walks of an IMU that stood still, from its EuRoC CSV",
        "motorcade allan static.csv --plot allan.svg",
    )
    parser.add_argument("stream", type=Path, metavar="STREAM")
    add_flag(parser, "--json", "machine-readable")
    add_file(parser, "--plot", "draw the curves there", "FILE.svg")


def allan(arguments: argparse.Namespace) -> None:
    """Read the stream, estimate, print; draw where asked to."""
    from motorcade.fusion.imu.allan import estimate_noise
    from motorcade.replays.io.imu import kalibr_noise
    from motorcade.replays.io.readers.readings import read_imu_of

    stream = read_imu_of(arguments.stream)
    noise = estimate_noise(stream)
    if arguments.plot is not None:
        _draw_allan(noise, arguments.plot)
    if arguments.json:
        print_json({"duration_s": stream.duration_s, "rate_hz": stream.rate_hz} | _as_dict(noise))
        return
    print(f"{stream.duration_s:.0f} s at {stream.rate_hz:.1f} Hz; each ± one standard deviation")
    print(f"{'':8}{'density':>26}{'walk of the bias':>26}{'flicker of the bias':>26}")
    for sensor, axes in (("gyro", noise.gyro), ("accel", noise.accel)):
        for name, axis in zip("xyz", axes, strict=True):
            values = (
                f"{value:.4g} ± {deviation:.1g}"
                for value, deviation in (
                    (axis.density, axis.density_deviation),
                    (axis.walk, axis.walk_deviation),
                    (axis.flicker, axis.flicker_deviation),
                )
            )
            print(f"{sensor:>6} {name}" + "".join(f"{value:>26}" for value in values))
    print("as Kalibr and EuRoC name them:")
    for name, value in kalibr_noise(noise.noise).items():
        print(f"{name}: {value:.6e}")


def _as_dict(stream_noise: StreamNoise) -> dict[str, Any]:
    from motorcade.replays.io.imu import kalibr_noise

    described: dict[str, Any] = dict(kalibr_noise(stream_noise.noise))
    for sensor, axes, units in (
        ("gyro", stream_noise.gyro, ("rad_s_rthz", "rad_s2_rthz", "rad_s")),
        ("accel", stream_noise.accel, ("m_s2_rthz", "m_s3_rthz", "m_s2")),
    ):
        for name, unit in zip(("density", "walk", "flicker"), units, strict=True):
            for suffix in ("", "_deviation"):
                key = f"{sensor}_{name}{suffix}_{unit}"
                described[key] = [getattr(axis, name + suffix) for axis in axes]
    return described


def _draw_allan(stream_noise: StreamNoise, path: Path) -> None:
    import numpy as np

    from motorcade.render.plots import plot_allan, standing_alone
    from motorcade.replays.io.files import write_bytes

    curves = {}
    for name, curve, axes in (
        ("gyroscope", stream_noise.gyro_curve, stream_noise.gyro),
        ("accelerometer", stream_noise.accel_curve, stream_noise.accel),
    ):
        model = np.stack([axis.curve(curve.tau_s) for axis in axes], axis=-1)
        curves[name] = (curve.tau_s, curve.deviation, model)
    svg = plot_allan(curves, {"gyroscope": "rad/s", "accelerometer": "m/s²"})
    write_bytes(path, standing_alone(svg).encode())


def add_orient(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        orient,
        "orient",
        "orientation of an inertial sensor (z up; with a magnetometer y to the north)",
        "motorcade orient imu0/data.csv --magnetometer mag0/data.csv -o orientation.tum",
    )
    add_file(
        parser,
        "imu",
        "whatever holds readings: a recording's folder, CSV, a phone's logger (folder or "
        "zip), BAG:/topic, a video with telemetry, PX4's .ulg, ArduPilot's .bin, KITTI's oxts, "
        "BROAD's .hdf5",
        "IMU",
    )
    add_output(parser, "OUT.tum", "positions are 0")
    add_file(
        parser,
        "--magnetometer",
        "CSV: stamp in ns, x, y, z in any unit and in the IMU's axes; without FILE: what IMU "
        "holds itself, as its header or its kind says, or in three more columns",
        nargs="?",
        const=Path(),
    )
    add_flag(parser, "--online", "each sample by what came before it alone")
    add_choice(
        parser,
        "--readings",
        ("interval", "instant"),
        "a reading is the mean since the stamp before, or holds at its stamp (interval)",
        "interval",
    )
    add_file(parser, "--noise", "Kalibr or EuRoC YAML")
    add_file(
        parser,
        "--deviations",
        "deviations of tilt and heading, gyro bias, rest and field a sample",
        "OUT.csv",
    )
    add_file(parser, "--json", "write the summary there")
    add_flag(parser, "--strict", "exit with 1 where the result is doubtful")


def orient(arguments: argparse.Namespace) -> None:
    """Read, estimate, write, and say what is doubtful."""
    from motorcade.fusion.orientation.estimate import estimate_orientation, orientation_doubts
    from motorcade.replays.io.readers.readings import read_imu_and_field
    from motorcade.replays.io.trajectories import write_deviations, write_orientation

    model, magnetometer = _model(arguments), arguments.magnetometer
    if magnetometer == Path():
        magnetometer = arguments.imu
    imu, field = read_imu_and_field(arguments.imu, magnetometer)
    orientation = estimate_orientation(
        imu, model, magnetic_field=field, smooth=not arguments.online
    )
    doubts = orientation_doubts(imu, orientation, model, with_magnetometer=field is not None)
    write_orientation(orientation, arguments.output)
    if arguments.deviations is not None:
        write_deviations(orientation, arguments.deviations)
    summary = {**_summary(orientation, field is not None), "doubts": list(doubts)}
    write_json(arguments.json, summary)
    for key, value in summary.items():
        if key != "doubts":
            print(f"{key:>28}  {shown(value)}")
    for doubt in doubts:
        print(f"doubtful: {doubt}", file=sys.stderr)
    if arguments.strict and doubts:
        raise RuntimeError(f"{arguments.output}: the orientation is doubtful")


def _model(arguments: argparse.Namespace) -> OrientationModel:
    from motorcade.fusion.orientation.estimate import OrientationModel
    from motorcade.replays.io.imu import read_noise

    if arguments.noise is None:
        return OrientationModel(readings=arguments.readings)
    return OrientationModel(noise=read_noise(arguments.noise), readings=arguments.readings)


def _summary(orientation: Orientation, with_magnetometer: bool) -> dict[str, float]:
    import numpy as np

    summary = {
        "samples": orientation.time_ns.size,
        "duration_s": 1e-9 * float(orientation.time_ns[-1] - orientation.time_ns[0]),
        "at_rest_share": float(np.mean(orientation.at_rest)),
        "tilt_deviation_deg": float(np.degrees(np.median(orientation.tilt_deviation_rad))),
        "heading_deviation_deg": float(np.degrees(np.median(orientation.heading_deviation_rad))),
        "gyro_bias_deg_s": float(np.degrees(np.linalg.norm(orientation.gyro_bias_rad_s[-1]))),
    }
    if with_magnetometer:
        summary["field_deviation_deg"] = float(
            np.degrees(np.median(orientation.field_deviation_rad))
        )
        summary["magnetometer_lag_ms"] = 1e3 * orientation.magnetometer_lag_s
    return summary
