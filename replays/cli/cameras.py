"""Commands on cameras and markers: `motorcade detect`, `calibrate`, `print`."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import (
    Commands,
    add_choice,
    add_file,
    add_flag,
    add_number,
    add_output,
    one_line,
    print_json,
)

if TYPE_CHECKING:
    from motorcade.replays.tasks.images import MarkerImage
    from motorcade.tracking import Board


DETECTION = """\
Find the markers of one family in images, each by itself; or with --board the corners of a board.

corners     in pixels, (0, 0) is the centre of the top-left pixel; clockwise from the printed
            top-left corner of the marker, however it is rotated in the image
candidates  with --size-m and --camera: both poses that a flat marker allows, the better
            reprojection first, as camera_T_marker: from the marker's frame (origin at its printed
            top-left corner, x right and y up as printed, z out of its face; metres) to the
            camera's (x right, y down, z forward)
ambiguity   the better reprojection error over the other, 0 to 1; near 1 either pose may be true
agreement   correlation of the image with the marker's print, 0.75 to 1
sharp       whether all four sides were fitted; otherwise corners are right to a pixel only"""


def add_detect(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        detect,
        "detect",
        "find markers in images: ids, corners, pose candidates",
        "motorcade detect *.png --family tag36h11 --size-m 0.065 --camera camera.toml",
    )
    parser.description = DETECTION
    parser.add_argument("images", type=Path, nargs="+", metavar="IMAGE")
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument(
        "--board", metavar="B", help="a board's name or file, as of `calibrate`: its corners alone"
    )
    which.add_argument(
        "--family",
        metavar="F",
        help="tag16h5, tag25h9, tag36h10, tag36h11, tagStandard41h12, tagStandard52h13, "
        "tagCircle21h7, tagCircle49h12, tagCustom48h12, aruco_NxN_COUNT (N 4 to 7; COUNT 50, 100, "
        "250, 1000), aruco_original, aruco_mip_36h12",
    )
    add_number(parser, "--size-m", "side between corners, for poses", metavar="S")
    add_file(
        parser,
        "--camera",
        "TOML with a [camera] table (as `motorcade calibrate` writes), or EuRoC's sensor.yaml",
    )
    add_flag(parser, "--json", "machine-readable")
    add_file(parser, "--draw", "write images of what was found", "FOLDER")


def detect(arguments: argparse.Namespace) -> None:
    """Search every image; print what was found, and complain of the others at the end."""
    from motorcade.replays.io.files import RecordingError
    from motorcade.replays.io.readers.manifest.section import (
        read_board,
        read_camera,
        stated_rotation,
    )
    from motorcade.replays.tasks.images import describe, drawing_names, markers_in, write_drawing

    if arguments.size_m is not None and arguments.board is not None:
        raise ValueError("--size-m: expected no size beside --board, whose name or file says it")
    if arguments.size_m is not None and arguments.camera is None:
        raise ValueError("--size-m: expected --camera FILE with it, since poses need both")
    camera = None if arguments.camera is None else read_camera(arguments.camera)
    rotation_deg = None if arguments.camera is None else stated_rotation(arguments.camera)
    target = arguments.family if arguments.board is None else read_board(arguments.board)
    described: list[dict[str, Any]] = []
    failed = 0
    images = markers_in(arguments.images, target, camera, arguments.size_m, rotation_deg)
    names = drawing_names(arguments.images)
    for path, name, image in zip(arguments.images, names, images, strict=True):
        if isinstance(image, RecordingError):
            failed += 1
            print(f"motorcade: {one_line(image)}", file=sys.stderr)
            described.append({"file": str(path), "error": one_line(image)})
            continue
        described.append(describe(image))
        if not arguments.json:
            _print(image)
        if arguments.draw is not None:
            write_drawing(image, arguments.draw / name)
    if arguments.json:
        header = {"family": target} if arguments.board is None else {"board": target.name}
        print_json(header | {"images": described})
    if failed:
        of = f"{failed} of {len(arguments.images)} images"
        raise RuntimeError(f"{of} could not be searched; the others are done")


def _print(image: MarkerImage) -> None:
    count = len(image.detections)
    if image.board is not None:
        from motorcade.replays.tasks.images import describe

        corners = f"{len(image.board)} corners"
        pose = describe(image).get("camera_T_board")
        at = " ".join(f"{value:8.4f}" for value in pose["translation_m"]) if pose else ""
        print(f"{image.path}: the board, {corners}" + f", at {at} m" * bool(pose))
        return
    print(f"{image.path}: {count} marker{'s' if count != 1 else ''}")
    for index, detection in enumerate(image.detections):
        corners = "  ".join(f"{x:8.2f} {y:8.2f}" for x, y in detection.corners_px)
        print(
            f"  id {detection.marker_id:4d}  {corners}"
            + ("" if detection.sharp else "  (not sharp)")
        )
        posed = image.posed[index] if image.posed else None
        if posed is None:
            continue
        for pose, error in zip(posed.camera_T_marker, posed.candidates.error_px, strict=True):
            place = " ".join(f"{value:8.4f}" for value in pose.translation_m)
            turn = " ".join(f"{value:8.5f}" for value in pose.rotor.as_quaternion())
            print(f"           at {place} m, wxyz {turn}, {error:.3f} px")
        print(f"           ambiguity {posed.ambiguity:.3f}")


CALIBRATION = """\
Calibrate a camera from images of a printed board: PNG, JPEG, BMP or PNM files, folders of them,
or a video. Ten or more views, tilted by 20 to 45 degrees all ways, that fill the image between
them are a good start. Views that fit three times worse than the others are left out.

Writes FILE (a TOML [camera] table: usable as --manifest of `run` and as --camera of `detect`) and
an image of the coverage beside it. Standard deviations suppose independent errors of at least
0.1 pixel a corner; a bent board, or a lens that the model does not describe, is not in them.

With --imu the one path is a recording (a folder of any known layout, a bag, a video) in which
camera and IMU moved together before the board, half a minute or longer, turned about all axes and
shaken along them. Found are the camera, where it sits on the IMU, the offset of their clocks,
gravity, and the IMU's scales and misalignments, each with its deviation; what the motion does not
tell is named. Kalibr's files, -camchain-imucam.yaml and -imu.yaml, are written beside FILE.

boards      checkerboard_9x6_40mm (inner corners, square)
            charuco_aruco_5x5_100_7x5_40mm_30mm (squares, square, marker)
            tag36h11_6x4_30mm_gap_9mm_from_0 (markers, side, gap, first id)
            aprilgrid_6x6_88mm_gap_26.4mm (Kalibr's), or Kalibr's target.yaml
            circles_7x5_30mm_15mm (circles, spacing, diameter), circles_4x11_…_asymmetric
            calib.io_checker_200x150_8x11_15 (a file of calib.io)
            or a .toml file with a [board] table"""


_OWN = Path()
_MUCH = 1.5  # of misfit, worth a word; noise alone leaves it within some percent of 1


def add_calibrate(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        calibrate,
        "calibrate",
        "calibrate a camera from images or a video of a printed board",
        "motorcade calibrate images/ --board checkerboard_9x6_40mm -o camera.toml",
    )
    parser.description = CALIBRATION
    parser.add_argument("images", type=Path, nargs="+", metavar="IMAGES")
    parser.add_argument("--board", required=True, metavar="B", help="its name, or a file")
    add_output(parser)
    add_choice(
        parser,
        "--model",
        ("radtan", "equidistant", "pinhole"),
        "lens: k1 k2 p1 p2, fisheye k1 to k4, or none; without it the simplest that predicts "
        "held-out views as well as the best (with --imu: radtan)",
    )
    add_file(
        parser,
        "--imu",
        "calibrate an IMU too: EuRoC's CSV, or a video or recording with one; alone: that of "
        "the recording",
        nargs="?",
        const=_OWN,
    )
    add_file(parser, "--camera", "the camera, known (with --imu)")
    add_file(parser, "--noise", "Kalibr or EuRoC YAML; without it: ADIS16448")
    add_number(
        parser, "--gravity", "its size there; without it 9.81, give or take 0.02", metavar="M_S2"
    )
    add_number(parser, "--search-s", "largest offset that is looked for (2 s)", 2.0)
    add_flag(parser, "--json", "machine-readable, each view")


def calibrate(arguments: argparse.Namespace) -> None:
    """Find the board, fit, write, and say how good it is."""
    if arguments.imu is not None:
        _calibrate_imu(arguments)
        return
    from motorcade.replays.io.readers.manifest.section import read_board
    from motorcade.replays.tasks.calibration import (
        calibrate_images,
        describe_calibration,
        write_calibration,
    )

    run = calibrate_images(arguments.images, read_board(arguments.board), arguments.model)
    for line in run.unreadable:
        print(f"motorcade: left out: {line}", file=sys.stderr)
    image = write_calibration(run, arguments.output)
    described = describe_calibration(run)
    if arguments.json:
        print_json(described)
        return
    _print_camera(described)
    print(f"camera in {arguments.output}, coverage in {image}")


def _calibrate_imu(arguments: argparse.Namespace) -> None:
    from motorcade.fusion.imu import ADIS16448
    from motorcade.replays.io.files import refusal
    from motorcade.replays.io.imu import read_noise
    from motorcade.replays.io.readers.manifest.section import read_board, read_camera
    from motorcade.replays.tasks.calibration import (
        calibrate_recording,
        describe_inertial,
        write_inertial,
    )

    if len(arguments.images) != 1:
        raise refusal(arguments.images[1], "expected one recording beside an IMU, got several")
    run = calibrate_recording(
        arguments.images[0],
        read_board(arguments.board),
        None if arguments.imu == _OWN else arguments.imu,
        camera=None if arguments.camera is None else read_camera(arguments.camera),
        model=arguments.model or "radtan",
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


def _print_inertial(calibration: dict[str, Any]) -> None:
    print(
        f"{calibration['board']}: found in {calibration['images_with_board']} of "
        f"{calibration['images_searched']} images; {calibration['images_used']} used, "
        f"{calibration['images_refused']} refused, over {calibration['span_s']:.1f} s"
    )
    for parameter in calibration["parameters"]:
        print(f"  {parameter['name']:<18} {parameter['value']:12.6f} +- {parameter['sigma']:.6f}")
    print(
        f"  reprojection {calibration['reprojection_rmse_px']:.3f} px RMS; residuals squared, "
        "of what "
        f"noise explains: {calibration['misfit']:.2f}"
    )
    if calibration["misfit"] > _MUCH:
        print("  deviations are stated larger by its root; is the board flat, and of that size?")
    for parameter in calibration["parameters"]:
        if parameter["unobservable"]:
            print(
                f"  unobservable by this motion: {parameter['name']}; {parameter['unobservable']}"
            )


def _print_camera(calibration: dict[str, Any]) -> None:
    camera, deviation = calibration["camera"], calibration["standard_deviation"]
    print(
        f"{calibration['board']}: found in {calibration['images_with_board']} of "
        f"{calibration['images_searched']} images; {calibration['views_used']} views used, "
        f"{calibration['views_left_out']} left out"
    )
    for key in ("fx_px", "fy_px", "cx_px", "cy_px"):
        print(f"  {key[:2]}  {camera[key]:10.3f} +- {deviation[key]:.3f} px")
    for index, (value, spread) in enumerate(
        zip(camera["distortion"], deviation["distortion"], strict=True)
    ):
        name = ("k1", "k2", "p1", "p2") if camera["model"] == "radtan" else ("k1", "k2", "k3", "k4")
        print(f"  {name[index]}  {value:10.5f} +- {spread:.5f}")
    print(
        f"  reprojection {calibration['reprojection_rmse_px']:.4f} px RMS, worst view "
        f"{calibration['worst_view_rmse_px']:.4f}; {calibration['coverage']:.0%} of the "
        "image's cells "
        f"covered; board turned by up to {calibration['largest_turn_deg']:.0f} degrees"
    )
    trials = calibration["held_out_px"].items()
    listed = ", ".join(f"{model} {px:.3f}" for model, px in trials if px is not None)
    print(f"  lens {camera['model']}; error on held-out views: {listed or 'too few views'} px")
    if calibration["doubt"]:
        print(f"motorcade: doubtful: {calibration['doubt']}", file=sys.stderr)


PRINTING = """\
Write boards and markers as sheets to print, at true size, with rulers that check the printer.
FILE ends in .pdf (a page a sheet) or .svg (a file a sheet); the tables of a manifest that describe
what was printed are written beside it, as FILE with .toml, for `run --manifest` and
`calibrate --board`. Print at 100 %, and measure the rulers.

boards      checkerboard_9x6_22mm (inner corners, square)
            charuco_aruco_5x5_100_7x5_26mm_19mm (squares, square, marker)
            tag36h11_4x5_30mm_gap_9mm_from_0 (markers, side, gap, first id)
            tag36h11_id_7_65mm (id, side); with --count 12: ids 7 to 18, as many a sheet as fit
            aprilgrid_6x6_25mm_gap_7.5mm (Kalibr's), or Kalibr's target.yaml
            circles_7x5_26mm_13mm (circles, spacing, diameter), circles_4x11_…_asymmetric
            or a .toml file with a [board] table"""


def add_print(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        print_boards,
        "print",
        "write boards and markers to print, at true size",
        "motorcade print checkerboard_9x6_22mm -o board.pdf",
    )
    parser.description = PRINTING
    parser.add_argument("boards", nargs="+", metavar="BOARD", help="its name, or a file")
    add_output(parser)
    parser.add_argument(
        "--paper", default="a4", metavar="P", help="a4, a3, letter, …, or 300x400mm (a4)"
    )
    parser.add_argument(
        "--count", type=int, default=1, metavar="N", help="of single markers: ids that follow (1)"
    )


def print_boards(arguments: argparse.Namespace) -> None:
    """Lay the boards out, write the sheets and the manifest's tables, and say where."""
    from motorcade.replays.io.files import write_bytes
    from motorcade.replays.io.readers.manifest.section import read_board
    from motorcade.replays.tasks.printing import (
        lay_out,
        manifest_lines,
        paper_named,
        sheet_svg,
        sheets_pdf,
    )

    output: Path = arguments.output
    if output.suffix.lower() not in (".pdf", ".svg"):
        raise ValueError(f"-o {output}: expected a name that ends in .pdf or .svg")
    boards = [
        board
        for name in arguments.boards
        for board in _following(read_board(name), arguments.count)
    ]
    sheets = lay_out(boards, paper_named(arguments.paper))
    if output.suffix.lower() == ".pdf":
        files = {output: sheets_pdf(sheets)}
    elif len(sheets) == 1:
        files = {output: sheet_svg(sheets[0])}
    else:
        files = {
            output.with_stem(f"{output.stem}_{number}"): sheet_svg(sheet)
            for number, sheet in enumerate(sheets, 1)
        }
    tables = "\n".join(manifest_lines(boards))
    files[output.with_suffix(".toml")] = tables.encode()
    for path, data in files.items():
        write_bytes(path, data)
    print(tables)
    print(
        f"{len(sheets)} sheet{'s' if len(sheets) > 1 else ''} in "
        f"{', '.join(map(str, files))}; print at 100 % and measure the rulers"
    )


def _following(board: Board, count: int) -> list[Board]:
    """A board; of a single marker also those whose ids follow."""
    from motorcade.tracking import SingleMarker

    if count < 1:
        raise ValueError(f"--count: expected 1 or more, got {count}")
    if count == 1:
        return [board]
    if not isinstance(board, SingleMarker):
        raise ValueError(
            f"--count {count}: {board.name} is one board; only single markers, such as "
            "tag36h11_id_0_65mm, are counted on"
        )
    return [replace(board, marker_id=board.marker_id + step) for step in range(count)]
