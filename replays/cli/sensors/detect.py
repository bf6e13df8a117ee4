"""`motorcade detect`: markers in picture files."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import Subparsers, new_command, one_line, print_json

if TYPE_CHECKING:
    from motorcade.replays.markers.pictures import MarkerPicture

DESCRIPTION = """\
Find the markers of one family in pictures, each by itself.

corners     in pixels, (0, 0) is the centre of the top-left pixel; clockwise from the printed
            top-left corner of the marker, however it is turned in the picture
candidates  with --size-m and --camera: both poses that a flat marker allows, the better
            reprojection first, as camera_T_marker: from the marker's frame (origin at its printed
            top-left corner, x right and y up as printed, z out of its face; metres) to the
            camera's (x right, y down, z forward)
ambiguity   the better reprojection error over the other, 0 to 1; near 1 either pose may be true
agreement   correlation of the picture with the marker's print, 0.75 to 1
sharp       whether all four sides were fitted; otherwise corners are right to a pixel only"""


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        detect,
        name="detect",
        summary="find markers in pictures: ids, corners, pose candidates",
        example="motorcade detect *.png --family tag36h11 --size-m 0.065 --camera camera.toml",
    )
    parser.description = DESCRIPTION
    parser.add_argument("images", type=Path, nargs="+", metavar="IMAGE")
    parser.add_argument(
        "--family",
        required=True,
        metavar="F",
        help="tag16h5, tag25h9, tag36h10, tag36h11, tagStandard41h12, tagStandard52h13, "
        "tagCircle21h7, tagCircle49h12, tagCustom48h12, aruco_NxN_COUNT (N 4 to 7; COUNT 50, 100, "
        "250, 1000), aruco_original, aruco_mip_36h12",
    )
    parser.add_argument("--size-m", type=float, metavar="S", help="side between corners, for poses")
    parser.add_argument(
        "--camera",
        type=Path,
        metavar="FILE",
        help="TOML with a [camera] table (as `motorcade calibrate` writes), or EuRoC's sensor.yaml",
    )
    parser.add_argument("--json", action="store_true", help="machine-readable")
    parser.add_argument(
        "--draw", type=Path, metavar="FOLDER", help="write pictures of what was found"
    )


def detect(arguments: argparse.Namespace) -> None:
    """Search every picture; print what was found, and complain of the others at the end."""
    from motorcade.replays.errors import RecordingError
    from motorcade.replays.markers.pictures import (
        describe,
        drawing_names,
        markers_in,
        write_drawing,
    )
    from motorcade.replays.readers.manifest.section import read_camera, stated_rotation

    if arguments.size_m is not None and arguments.camera is None:
        raise ValueError("--size-m: expected --camera FILE with it, since poses need both")
    camera = None if arguments.camera is None else read_camera(arguments.camera)
    rotation_deg = None if arguments.camera is None else stated_rotation(arguments.camera)
    described: list[dict[str, Any]] = []
    failed = 0
    found = markers_in(arguments.images, arguments.family, camera, arguments.size_m, rotation_deg)
    names = drawing_names(arguments.images)
    for path, name, picture in zip(arguments.images, names, found, strict=True):
        if isinstance(picture, RecordingError):
            failed += 1
            print(f"motorcade: {one_line(picture)}", file=sys.stderr)
            described.append({"file": str(path), "error": one_line(picture)})
            continue
        described.append(describe(picture))
        if not arguments.json:
            _print(picture)
        if arguments.draw is not None:
            write_drawing(picture, arguments.draw / name)
    if arguments.json:
        print_json({"family": arguments.family, "pictures": described})
    if failed:
        of = f"{failed} of {len(arguments.images)} pictures"
        raise RuntimeError(f"{of} could not be searched; the others are done")


def _print(picture: MarkerPicture) -> None:
    count = len(picture.detections)
    print(f"{picture.path}: {count} marker{'s' if count != 1 else ''}")
    for index, one in enumerate(picture.detections):
        corners = "  ".join(f"{x:8.2f} {y:8.2f}" for x, y in one.corners_px)
        print(f"  id {one.marker_id:4d}  {corners}" + ("" if one.sharp else "  (not sharp)"))
        posed = picture.posed[index] if picture.posed else None
        if posed is None:
            continue
        for pose, error in zip(posed.camera_T_marker, posed.candidates.error_px, strict=True):
            place = " ".join(f"{value:8.4f}" for value in pose.translation_m)
            turn = " ".join(f"{value:8.5f}" for value in pose.rotor.as_quaternion())
            print(f"           at {place} m, wxyz {turn}, {error:.3f} px")
        print(f"           ambiguity {posed.ambiguity:.3f}")
