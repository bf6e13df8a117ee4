"""`motorcade orient`: orientation of an inertial sensor, with or without a magnetometer."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.replays.cli.arguments import Subparsers, new_command, shown

if TYPE_CHECKING:
    from motorcade.fusion.orientation import Orientation, OrientationModel


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        orient,
        name="orient",
        summary="orientation of an inertial sensor (z up; with a magnetometer y to the north)",
        example="motorcade orient imu0/data.csv --magnetometer mag0/data.csv -o orientation.tum",
    )
    parser.add_argument(
        "imu", type=Path, metavar="IMU", help="EuRoC's CSV, or a trial of BROAD (.hdf5)"
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="OUT.tum", help="positions are 0"
    )
    parser.add_argument(
        "--magnetometer",
        type=Path,
        nargs="?",
        const=Path(),
        metavar="FILE",
        help="CSV: stamp in ns, x, y, z in any unit and in the IMU's axes; without FILE: what IMU "
        "holds itself, in three more columns or as BROAD does",
    )
    parser.add_argument(
        "--online", action="store_true", help="each sample by what came before it alone"
    )
    parser.add_argument(
        "--readings",
        choices=("interval", "instant"),
        default="interval",
        help="a reading is the mean since the stamp before, or holds at its stamp (interval)",
    )
    parser.add_argument("--noise", type=Path, metavar="FILE", help="Kalibr or EuRoC YAML")
    parser.add_argument(
        "--deviations",
        type=Path,
        metavar="OUT.csv",
        help="deviations of tilt and heading, gyro bias, rest and field a sample",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the summary there")
    parser.add_argument(
        "--strict", action="store_true", help="exit with 1 where the result is doubtful"
    )


def orient(arguments: argparse.Namespace) -> None:
    """Read, estimate, write, and say what is doubtful."""
    from motorcade.fusion.orientation import estimate_orientation, orientation_doubts
    from motorcade.replays.files.atomic import write_bytes
    from motorcade.replays.files.magnetic import read_imu_and_field
    from motorcade.replays.files.orientations import write_deviations, write_orientation

    model, magnetometer = _model(arguments), arguments.magnetometer
    if magnetometer == Path():
        magnetometer = arguments.imu
    imu, field = read_imu_and_field(arguments.imu, magnetometer)
    found = estimate_orientation(imu, model, magnetic_field=field, smooth=not arguments.online)
    doubts = orientation_doubts(imu, found, model, with_magnetometer=field is not None)
    write_orientation(found, arguments.output)
    if arguments.deviations is not None:
        write_deviations(found, arguments.deviations)
    summary = {**_summary(found, field is not None), "doubts": list(doubts)}
    if arguments.json is not None:
        write_bytes(arguments.json, (json.dumps(summary, indent=2) + "\n").encode())
    for key, value in summary.items():
        if key != "doubts":
            print(f"{key:>28}  {shown(value)}")
    for doubt in doubts:
        print(f"doubtful: {doubt}", file=sys.stderr)
    if arguments.strict and doubts:
        raise RuntimeError(f"{arguments.output}: the orientation is doubtful")


def _model(arguments: argparse.Namespace) -> OrientationModel:
    from motorcade.fusion.orientation import OrientationModel
    from motorcade.replays.files.imu import read_noise

    if arguments.noise is None:
        return OrientationModel(readings=arguments.readings)
    return OrientationModel(noise=read_noise(arguments.noise), readings=arguments.readings)


def _summary(found: Orientation, with_magnetometer: bool) -> dict[str, float]:
    import numpy as np

    made = {
        "samples": found.time_ns.size,
        "duration_s": 1e-9 * float(found.time_ns[-1] - found.time_ns[0]),
        "at_rest_share": float(np.mean(found.at_rest)),
        "tilt_deviation_deg": float(np.degrees(np.median(found.tilt_deviation_rad))),
        "heading_deviation_deg": float(np.degrees(np.median(found.heading_deviation_rad))),
        "gyro_bias_deg_s": float(np.degrees(np.linalg.norm(found.gyro_bias_rad_s[-1]))),
    }
    if with_magnetometer:
        made["field_deviation_deg"] = float(np.degrees(np.median(found.field_deviation_rad)))
        made["magnetometer_lag_ms"] = 1e3 * found.magnetometer_lag_s
    return made
