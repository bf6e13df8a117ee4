"""Commands on a camera's poses and an IMU's readings together: `motorcade fuse`, `sync`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.replays.cli.arguments import (
    Commands,
    add_choice,
    add_file,
    add_flag,
    add_number,
    add_output,
    add_stamps,
    chosen,
    shown,
    write_json,
)

if TYPE_CHECKING:
    from motorcade.fusion.imu import ImuNoise, ImuStream
    from motorcade.fusion.sync.synchronise import Synchronised
    from motorcade.ga import Motor, Trajectory
    from motorcade.ga.arrays import IntArray
    from motorcade.replays.io.readers.manifest.sensors import ImuCalibration
    from motorcade.replays.tasks.fusing import FusingOptions


def add_fuse(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        fuse,
        "fuse",
        "fuse the poses of a trajectory file (metres) with the readings of an IMU",
        "motorcade fuse camera.tum imu0/data.csv -o fused.tum --extrinsics sync.json "
        "--noise imu.yaml --covariance fused.csv",
    )
    parser.add_argument(
        "poses", metavar="POSES", help="TUM, EuRoC or KITTI file, or BAG:TOPIC: world_T_camera"
    )
    add_file(
        parser,
        "imu",
        "whatever holds readings: a recording's folder, CSV, a phone's logger, BAG:/topic, a "
        "GoPro's video, PX4's .ulg, ArduPilot's .bin, KITTI's oxts",
        "IMU",
    )
    add_output(parser, "OUT")
    add_choice(parser, "--format", ("tum", "euroc", "kitti"), "of OUT")
    parser.add_argument(
        "--positions",
        metavar="FILE",
        help="positions on the poses' clock that hold a path which drifts: .gpx, .nmea, .ulg, "
        ".bin, BAG:TOPIC (NavSatFix), or a trajectory file in metres",
    )
    add_number(parser, "--positions-sigma-m", "their deviation (3 m)", 3.0, metavar="S")
    add_number(
        parser,
        "--antenna-m",
        "where they were measured, from the IMU in its axes (0 0 0)",
        (0.0, 0.0, 0.0),
        nargs=3,
        metavar=("X", "Y", "Z"),
    )
    add_stamps(parser)
    parser.add_argument(
        "--stamps",
        default="poses",
        metavar="WHICH",
        help="at which the path is wanted: poses, imu, or a trajectory file that has them (poses)",
    )
    add_flag(parser, "--online", "make every pose of what came before it alone")
    add_number(
        parser,
        "--lag",
        "make every pose of what was measured up to so many seconds after it (all)",
        metavar="S",
    )
    add_file(parser, "--covariance", "write 6 by 6 covariances there, as CSV")
    add_file(parser, "--json", "write the figures there")
    _add_known(parser)
    _add_doubts(parser)


def _add_known(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the sensor")
    add_file(
        group,
        "--rig",
        "how camera and IMU belong together, TOML of `motorcade calibrate --imu`: scale and "
        "axes of both sensors, extrinsics, clock offset, noise; other options go before it",
    )
    add_file(group, "--noise", "Kalibr or EuRoC YAML; without it: ADIS16448")
    add_number(group, "--noise-factor", "times its white noise, for a sensor that moves (10)")
    add_number(group, "--walk-factor", "times its bias walks (1)")
    add_flag(
        group,
        "--learn-noise",
        "learn its noise from how well poses are predicted, starting from that",
    )
    add_file(
        group,
        "--extrinsics",
        "imu_T_camera: JSON of `motorcade sync`, Kalibr's chain, evo's JSON, or 4 by 4 "
        "numbers; without it the poses are the IMU's",
    )
    add_number(
        group,
        "--offset-s",
        "what the IMU's clock shows minus what the poses' does (0, or as Kalibr's chain says)",
    )
    group.add_argument(
        "--estimate",
        nargs="+",
        default=(),
        choices=("extrinsics", "offset"),
        help="find these by the motion of both, as `motorcade sync` does; the filter refines them",
    )
    add_number(group, "--gravity-m-s2", "size of gravity (9.81)", 9.81)


def _add_doubts(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("deviations, an axis")
    add_number(group, "--sigma-m", "of positions (from how rough they are)")
    add_number(group, "--sigma-deg", "of rotations (likewise)")
    add_number(
        group, "--gravity-sigma-deg", "of the world's z from up, which is estimated then (1)", 1.0
    )
    add_number(group, "--extrinsics-sigma-deg", "of extrinsics' rotation, estimated then (1)")
    add_number(group, "--extrinsics-sigma-m", "of extrinsics' place, estimated then (0)")
    add_number(
        group,
        "--least-accepted",
        "of the poses: where fewer agree with the IMU there is no result; 0: always one (0.5)",
        0.5,
        metavar="SHARE",
    )
    add_number(group, "--gate", "probability that a good pose passes (0.9999)", 0.9999)


def fuse(arguments: argparse.Namespace) -> None:
    """Read, fuse, write; print what was found."""
    import numpy as np

    from motorcade.replays.io.readers.manifest.sensors import read_imu_calibration
    from motorcade.replays.io.readers.readings import read_imu_of
    from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
    from motorcade.replays.tasks.fusing import fuse_poses, write_covariance

    rig = None if arguments.rig is None else read_imu_calibration(arguments.rig)
    options = _options(arguments, rig)
    poses = read_trajectory(arguments.poses, rate_hz=arguments.rate_hz, times=arguments.times)
    if not np.ptp(poses.rigid.poses.rotor.coefficients, axis=0).any() and poses.child == "antenna":
        raise ValueError(
            f"{arguments.poses}: expected poses, got positions, which do not turn; "
            "give them as --positions beside poses; `motorcade evaluate` takes them for a reference"
        )
    imu = read_imu_of(arguments.imu)
    if rig is not None:
        imu = rig.corrected(imu)
    positions = None if arguments.positions is None else read_trajectory(arguments.positions)
    stamps = _stamps(arguments.stamps, poses, imu, options)
    fused = fuse_poses(poses, imu, options, stamps, positions)
    path = fused.fused.trajectory
    write_trajectory(path, arguments.output, arguments.format)
    if arguments.covariance is not None:
        write_covariance(arguments.covariance, path.time_ns, fused.fused.covariance)
    figures = fused.as_dict()
    if fused.noise is not None:
        print(fused.noise.summary)
    for key, value in figures.items():
        if key not in ("noise", "doubts", "health"):
            print(f"{key:>28}  {shown(value)}")
    if fused.fused.doubts:
        print(fused.fused.health.summary)
    write_json(arguments.json, figures)


def _options(arguments: argparse.Namespace, rig: ImuCalibration | None) -> FusingOptions:
    import numpy as np

    from motorcade.replays.io.imu import read_noise
    from motorcade.replays.tasks.fusing import FusingOptions

    if arguments.extrinsics is not None and "extrinsics" in arguments.estimate:
        raise ValueError("--extrinsics: expected a file or --estimate extrinsics, got both")

    def radians(degrees: float | None) -> float | None:
        return None if degrees is None else float(np.deg2rad(degrees))

    imu_T_camera, offset_s, noise = _calibration(arguments.extrinsics, rig)
    return FusingOptions(
        noise=noise if arguments.noise is None else read_noise(arguments.noise),
        **chosen(
            arguments,
            *("noise_factor", "walk_factor", "learn_noise", "sigma_m", "gravity_m_s2"),
            *("extrinsics_sigma_m", "gate", "least_accepted", "online", "positions_sigma_m"),
        ),
        antenna_m=tuple(arguments.antenna_m),
        imu_T_camera=imu_T_camera,
        offset_s=offset_s if arguments.offset_s is None else arguments.offset_s,
        estimate=tuple(arguments.estimate),
        sigma_rad=radians(arguments.sigma_deg),
        gravity_sigma_rad=float(np.deg2rad(arguments.gravity_sigma_deg)),
        extrinsics_sigma_rad=radians(arguments.extrinsics_sigma_deg),
        lag_s=arguments.lag,
    )


def _calibration(
    extrinsics: Path | None, rig: ImuCalibration | None
) -> tuple[Motor | None, float, ImuNoise | None]:
    """Extrinsics, the offset of the clocks and the noise, as files say them."""
    from motorcade.replays.io.readers.kalibr import read_extrinsics, read_offset

    imu_T_camera, offset_s, noise = None, 0.0, None
    if rig is not None:
        imu_T_camera, offset_s, noise = rig.imu_T_camera, rig.offset_s, rig.noise
    if extrinsics is not None:
        imu_T_camera = read_extrinsics(extrinsics)
        told_s = read_offset(extrinsics)
        offset_s = offset_s if told_s is None else told_s
    return imu_T_camera, offset_s, noise


def _stamps(
    which: str, poses: Trajectory, imu: ImuStream, options: FusingOptions
) -> IntArray | None:
    """Those asked for, on the poses' clock."""
    from motorcade.replays.io.trajectories import read_trajectory

    if which == "poses":
        return None
    if which == "imu":
        stamps: IntArray = imu.time_ns - round(options.offset_s * 1e9)
        inside: IntArray = stamps[(stamps >= poses.time_ns[0]) & (stamps <= poses.time_ns[-1])]
        return inside
    return read_trajectory(which).time_ns


def add_sync(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        sync,
        "sync",
        "time offset and extrinsics between a camera's trajectory (metres) and an IMU",
        "motorcade sync camera.tum imu0/data.csv --json sync.json",
    )
    parser.add_argument("camera", type=Path, metavar="CAMERA_TRAJECTORY")
    add_file(parser, "imu", "whatever holds readings, as of `orient`", "IMU")
    add_file(parser, "--noise", "Kalibr or EuRoC YAML; without it: ADIS16448")
    add_number(parser, "--search-s", "largest offset that is looked for (2 s)", 2.0)
    add_stamps(parser)
    add_file(parser, "--json", "write the results there")


def sync(arguments: argparse.Namespace) -> None:
    """Read both, estimate, print a table."""
    from motorcade.fusion.imu import ADIS16448, ImuNoise
    from motorcade.fusion.sync.synchronise import synchronise
    from motorcade.replays.io.readers.readings import read_imu_of
    from motorcade.replays.io.trajectories import read_trajectory

    noise = ADIS16448 if arguments.noise is None else ImuNoise.load(arguments.noise)
    camera = read_trajectory(arguments.camera, rate_hz=arguments.rate_hz, times=arguments.times)
    imu = read_imu_of(arguments.imu)
    synchronised = synchronise(camera, imu, noise, search_s=arguments.search_s)
    results = _as_dict(synchronised)
    for line in (
        *(one.summary for one in synchronised.health.findings),
        *synchronised.health.unknown,
    ):
        print(f"{'health':>34}  {line}")
    for key, value in results.items():
        print(f"{key:>34}  {shown(value)}")
    write_json(arguments.json, results | {"health": synchronised.health.as_dict()})


def _as_dict(synchronised: Synchronised) -> dict[str, float | list[float]]:
    import numpy as np

    noise = synchronised.imu_noise
    return {
        "offset_ms": 1e3 * synchronised.offset_s,
        "offset_sigma_ms": 1e3 * synchronised.offset_sigma_s,
        "imu_T_camera_wxyz": synchronised.imu_T_camera.rotor.as_quaternion().tolist(),
        "rotation_sigma_deg": np.rad2deg(synchronised.rotation_sigma_rad).tolist(),
        "imu_T_camera_translation_m": synchronised.imu_T_camera.translation_m.tolist(),
        "translation_sigma_m": synchronised.lever_arm_sigma_m.tolist(),
        "gravity_m_s2": synchronised.gravity_m_s2.tolist(),
        "gyro_bias_rad_s": synchronised.gyro_bias_rad_s.mean(axis=0).tolist(),
        "accel_bias_m_s2": synchronised.accel_bias_m_s2.mean(axis=0).tolist(),
        "rate_correlation": synchronised.correlation,
        "poses_used": len(synchronised.time_ns),
        "camera_sigma_deg": float(np.rad2deg(synchronised.camera_sigma_rad)),
        "camera_sigma_m": synchronised.camera_sigma_m,
        "gyro_density_rad_s_rthz": noise.gyro_density_rad_s_rthz,
        "gyro_walk_rad_s2_rthz": noise.gyro_walk_rad_s2_rthz,
        "accel_density_m_s2_rthz": noise.accel_density_m_s2_rthz,
        "accel_walk_m_s3_rthz": noise.accel_walk_m_s3_rthz,
    }
