"""`motorcade calibrate`: a camera from pictures of a board, with --imu an IMU beside it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from motorcade.replays.cli.arguments import Subparsers, new_command, print_json

DESCRIPTION = """\
Calibrate a camera from pictures of a printed board: PNG, JPEG, BMP or PNM files, folders of them,
or a video. Ten or more views, tilted by 20 to 45 degrees all ways, that fill the picture between
them are a good start. Views that fit three times worse than the others are left out.

Writes FILE (a TOML [camera] table: usable as --manifest of `run` and as --camera of `detect`) and
a picture of the coverage beside it. Standard deviations suppose independent errors of at least
0.1 pixel a corner; a bent board, or a lens that the model does not describe, is not in them.

With --imu the one path is a recording (a folder of any known layout, a bag, a video) in which
camera and IMU moved together before the board, half a minute or longer, turned about all axes and
shaken along them. Found are the camera, where it sits on the IMU, the offset of their clocks,
gravity, and the IMU's scales and misalignments, each with its deviation; what the motion does not
tell is named. Kalibr's files, -camchain-imucam.yaml and -imu.yaml, are written beside FILE.

boards      checkerboard_9x6_40mm (inner corners, square)
            charuco_aruco_5x5_100_7x5_40mm_30mm (squares, square, marker)
            tag36h11_6x4_30mm_gap_9mm_from_0 (markers, side, gap, first id)
            or a .toml file with a [board] table"""


_OWN = Path()
_MUCH = 1.5  # of misfit, worth a word; noise alone leaves it within some percent of 1


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        calibrate,
        name="calibrate",
        summary="calibrate a camera from pictures or a video of a printed board",
        example="motorcade calibrate images/ --board checkerboard_9x6_40mm -o camera.toml",
    )
    parser.description = DESCRIPTION
    parser.add_argument("images", type=Path, nargs="+", metavar="IMAGES")
    parser.add_argument("--board", required=True, metavar="B", help="its name, or a .toml file")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE")
    parser.add_argument(
        "--model",
        choices=("radtan", "equidistant", "pinhole"),
        default="radtan",
        help="lens: k1 k2 p1 p2, fisheye k1 to k4, or none (radtan)",
    )
    parser.add_argument(
        "--imu",
        type=Path,
        nargs="?",
        const=_OWN,
        metavar="FILE",
        help="calibrate an IMU too: EuRoC's CSV, or a video or recording with one; alone: that of "
        "the recording",
    )
    parser.add_argument(
        "--camera", type=Path, metavar="FILE", help="the camera, known (with --imu)"
    )
    parser.add_argument(
        "--noise", type=Path, metavar="FILE", help="Kalibr or EuRoC YAML; without it: ADIS16448"
    )
    parser.add_argument(
        "--gravity",
        type=float,
        metavar="M_S2",
        help="its size there; without it 9.81, give or take 0.02",
    )
    parser.add_argument(
        "--search-s", type=float, default=2.0, help="largest offset that is looked for (2 s)"
    )
    parser.add_argument("--json", action="store_true", help="machine-readable, each view")


def calibrate(arguments: argparse.Namespace) -> None:
    """Find the board, fit, write, and say how good it is."""
    if arguments.imu is not None:
        _calibrate_imu(arguments)
        return
    from motorcade.replays.markers.calibration import (
        calibrate_pictures,
        describe_calibration,
        write_calibration,
    )
    from motorcade.replays.readers.manifest.section import read_board

    run = calibrate_pictures(arguments.images, read_board(arguments.board), arguments.model)
    for line in run.unreadable:
        print(f"motorcade: left out: {line}", file=sys.stderr)
    picture = write_calibration(run, arguments.output)
    described = describe_calibration(run)
    if arguments.json:
        print_json(described)
        return
    _print(described)
    print(f"camera in {arguments.output}, coverage in {picture}")


def _calibrate_imu(arguments: argparse.Namespace) -> None:
    from motorcade.fusion.imu import ADIS16448
    from motorcade.replays.errors import refusal
    from motorcade.replays.files.imu import read_noise
    from motorcade.replays.markers.inertial_calibration import (
        calibrate_recording,
        describe_inertial,
        write_inertial,
    )
    from motorcade.replays.readers.manifest.section import read_board, read_camera

    if len(arguments.images) != 1:
        raise refusal(arguments.images[1], "expected one recording beside an IMU, got several")
    run = calibrate_recording(
        arguments.images[0],
        read_board(arguments.board),
        None if arguments.imu == _OWN else arguments.imu,
        camera=None if arguments.camera is None else read_camera(arguments.camera),
        model=arguments.model,
        noise=ADIS16448 if arguments.noise is None else read_noise(arguments.noise),
        gravity_m_s2=arguments.gravity,
        search_s=arguments.search_s,
    )
    chain, imu = write_inertial(run, arguments.output)
    described = describe_inertial(run)
    if arguments.json:
        print_json(described)
        return
    _print_inertial(described)
    print(f"manifest in {arguments.output}; for Kalibr {chain} and {imu}")


def _print_inertial(found: dict[str, Any]) -> None:
    print(
        f"{found['board']}: found in {found['pictures_with_board']} of "
        f"{found['pictures_searched']} pictures; {found['pictures_used']} used, "
        f"{found['pictures_refused']} refused, over {found['span_s']:.1f} s"
    )
    for one in found["parameters"]:
        print(f"  {one['name']:<18} {one['value']:12.6f} +- {one['sigma']:.6f}")
    print(
        f"  reprojection {found['reprojection_rmse_px']:.3f} px RMS; residuals squared, of what "
        f"noise explains: {found['misfit']:.2f}"
    )
    if found["misfit"] > _MUCH:
        print("  deviations are stated larger by its root; is the board flat, and of that size?")
    for one in found["parameters"]:
        if one["untold"]:
            print(f"  not told by this motion: {one['name']}; {one['untold']}")


def _print(found: dict[str, Any]) -> None:
    camera, deviation = found["camera"], found["standard_deviation"]
    print(
        f"{found['board']}: found in {found['pictures_with_board']} of "
        f"{found['pictures_searched']} pictures; {found['views_used']} views used, "
        f"{found['views_left_out']} left out"
    )
    for key in ("fx_px", "fy_px", "cx_px", "cy_px"):
        print(f"  {key[:2]}  {camera[key]:10.3f} +- {deviation[key]:.3f} px")
    for index, (value, spread) in enumerate(
        zip(camera["distortion"], deviation["distortion"], strict=True)
    ):
        name = ("k1", "k2", "p1", "p2") if camera["model"] == "radtan" else ("k1", "k2", "k3", "k4")
        print(f"  {name[index]}  {value:10.5f} +- {spread:.5f}")
    print(
        f"  reprojection {found['reprojection_rmse_px']:.4f} px RMS, worst view "
        f"{found['worst_view_rmse_px']:.4f}; {found['coverage']:.0%} of the picture's cells "
        f"covered; board turned by up to {found['largest_turn_deg']:.0f} degrees"
    )
