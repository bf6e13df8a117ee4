"""What is stated wrongly: sixty kinds and more, each with the words that must name its mend."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from motorcade.replays.io.readers.manifest.section import board_toml, camera_toml
from motorcade.tracking import Board, Camera, CharucoBoard, Checkerboard, MarkerGrid, SingleMarker
from tests.end_to_end.contradictions.drawing import (
    FISHEYE,
    PINHOLE,
    RADTAN,
    SMALL,
    Drawn,
    loose_sheet,
    sheet_of,
    write_room,
    write_sheet,
)
from tests.textured_room.inertial import IMU_T_CAMERA

Rng = np.random.Generator
Draw = Callable[[Path, Rng], Drawn]
Plant = Callable[[Drawn, Rng], Drawn]


@dataclass(frozen=True)
class Kind:
    """A contradiction.

    Fields:
        base: the clean recording's name.
        name: what is wrong.
        plant: makes it so; files are changed in a copy.
        mend: regular expression that the closing line must match.
        files: whether files of the recording are changed.
        mendable: whether keys of the manifest mend it; else files must be changed.
        known: lengths that the user must measure.
        open: why it is not named yet.
    """

    base: str
    name: str
    plant: Plant
    mend: str
    files: bool = False
    mendable: bool = True
    known: Mapping[str, str] = field(default_factory=dict)
    open: str = ""


GRID = MarkerGrid("tag36h11", 4, 3, 0.06, 0.018, first_id=5)
UP = replace(GRID, order="up")
ARUCO = MarkerGrid("aruco_5x5_100", 5, 3, 0.05, 0.012, first_id=2)
KALIBR = MarkerGrid("tag36h11_border2", 4, 3, 0.06, 0.018, 0, "up", 0, True)
CHECKER = Checkerboard(8, 5, 0.03)
CHARUCO = CharucoBoard("aruco_5x5_50", 7, 6, 0.04, 0.028)
LEGACY = replace(CHARUCO, legacy=True)
MARKER = SingleMarker("tag36h11", 7, 0.1)
_MAP_IDS = range(3, 9)
_SIZES = {"square_m": "0.04", "marker_m": "0.028"}
_SQUARE = {"square_m": "0.03"}
_GRID = {"marker_m": "0.06", "gap_m": "0.018"}
_ARUCO = {"marker_m": "0.05", "gap_m": "0.012"}


def _board(board: Board, camera: Camera = PINHOLE, imu: bool = False, near: float = 1.0) -> Draw:
    def draw(folder: Path, rng: Rng) -> Drawn:
        frames = 260 if imu else 12
        return write_sheet(folder, sheet_of(board), camera, rng, frames, imu, near)

    return draw


def _loose(folder: Path, rng: Rng) -> Drawn:
    return write_sheet(folder, loose_sheet("tag36h11", _MAP_IDS, 0.08, rng), PINHOLE, rng)


BASES: dict[str, Draw] = {
    "grid": _board(GRID),
    "grid upwards": _board(UP),
    "grid turned": _board(replace(GRID, turned_deg=90)),
    "aruco grid": _board(ARUCO, RADTAN),
    "kalibr": _board(KALIBR),
    "checkerboard": _board(CHECKER),
    "checkerboard radtan": _board(CHECKER, RADTAN, near=0.75),
    "checkerboard fisheye": _board(CHECKER, FISHEYE, near=0.7),
    "charuco": _board(CHARUCO),
    "charuco legacy": _board(LEGACY, FISHEYE),
    "grid radtan": _board(GRID, RADTAN, near=0.75),
    "marker": _board(MARKER, near=2.5),
    "loose": _loose,
    "grid imu": _board(GRID, SMALL, imu=True),
    "room": write_room,
}


def states(board: Board, stated: Board) -> Plant:
    """Another board stated."""
    return lambda drawn, rng: drawn.stated((board_toml(board), board_toml(stated)))


def sees(camera: Camera, stated: Camera) -> Plant:
    """Another camera stated."""
    return lambda drawn, rng: drawn.stated((camera_toml(camera), camera_toml(stated)))


def scaled(camera: Camera, factor: float) -> Camera:
    """The intrinsics of images of another size."""
    size = {"fx": factor * camera.fx, "fy": factor * camera.fy}
    centre = {key: factor * (getattr(camera, key) + 0.5) - 0.5 for key in ("cx", "cy")}
    return replace(camera, **size, **centre)


def line(old: str, new: str) -> Plant:
    """Another line in the manifest."""
    return lambda drawn, rng: drawn.stated((old, new))


def images(change: Callable[[np.ndarray], np.ndarray], folder: str = "images") -> Plant:
    """Images changed on the disk."""

    def plant(drawn: Drawn, rng: Rng) -> Drawn:
        for path in sorted((drawn.folder / folder).iterdir()):
            cv2.imwrite(str(path), change(cv2.imread(str(path), cv2.IMREAD_UNCHANGED)))
        return re_sized(drawn)

    return plant


def re_sized(drawn: Drawn) -> Drawn:
    """Without the images' size in the manifest, which is then that of the files."""
    return replace(drawn, manifest=re.sub(r"(width|height) = \d+\n", "", drawn.manifest))


def _boards() -> Iterator[Kind]:
    yield Kind("grid upwards", "order down", states(UP, GRID), r'order = "up"')
    yield Kind("grid", "order up", states(GRID, UP), r'order = "down"')
    swapped = replace(GRID, columns=3, rows=4)
    yield Kind("grid", "rows by columns", states(GRID, swapped), "columns = 4, rows = 3")
    swapped = replace(UP, columns=3, rows=4)
    yield Kind("grid upwards", "rows by columns", states(UP, swapped), "columns = 4, rows = 3")
    wide = replace(GRID, columns=5)
    yield Kind("grid", "a column too many", states(GRID, wide), "columns = 4")
    for base, board, off in (("grid", GRID, 3), ("aruco grid", ARUCO, -2), ("grid", GRID, -1)):
        other = replace(board, first_id=board.first_id + off)
        yield Kind(base, f"ids {off:+d}", states(board, other), f"first_id = {board.first_id}")
    for gap_m in (0.03, 0.012, 0.078, 0.0018, 18.0, 0.018 / 2.54):
        other = replace(GRID, gap_m=gap_m)
        yield Kind("grid", f"gap {gap_m:.4g}", states(GRID, other), r"gap_m = 0\.01[78]")
    small = replace(GRID, marker_m=0.006)
    yield Kind("grid", "marker 6 mm", states(GRID, small), "marker_m = 0.0[56]")
    for base, board, turn in (
        ("grid", GRID, 180),
        ("grid", GRID, 90),
        ("grid turned", replace(GRID, turned_deg=90), 270),
    ):
        other = replace(board, turned_deg=turn)
        yield Kind(base, f"turned {turn}", states(board, other), f"turned_deg = {board.turned_deg}")
    yield Kind(
        "grid",
        "family tag25h9",
        states(GRID, replace(GRID, family="tag25h9")),
        'family = "tag36h11"',
    )
    yield Kind(
        "aruco grid",
        "family 4x4_100",
        states(ARUCO, replace(ARUCO, family="aruco_4x4_100")),
        'family = "aruco_5x5_50"',
    )
    plain = MarkerGrid("tag36h11", 4, 3, 0.06, 0.018)
    yield Kind("kalibr", "plain grid", states(KALIBR, plain), "aprilgrid|border2")
    yield Kind(
        "grid upwards", "aprilgrid", states(UP, replace(KALIBR, first_id=5)), 'family = "tag36h11"'
    )
    yield Kind("kalibr", "ids down", states(KALIBR, replace(KALIBR, order="down")), 'order = "up"')
    yield Kind("charuco", "legacy", states(CHARUCO, LEGACY), "legacy = false")
    yield Kind("charuco legacy", "not legacy", states(LEGACY, CHARUCO), "legacy = true")
    swapped_charuco = replace(CHARUCO, columns=6, rows=7)
    yield Kind(
        "charuco", "rows by columns", states(CHARUCO, swapped_charuco), "columns = 7, rows = 6"
    )
    yield Kind(
        "charuco",
        "marker 24 of 40 mm",
        states(CHARUCO, replace(CHARUCO, marker_m=0.024)),
        r"marker_m = 0\.02[789]",
    )
    yield Kind(
        "charuco",
        "marker of inch",
        states(CHARUCO, replace(CHARUCO, marker_m=0.028 / 2.54)),
        r"marker_m = 0\.02[789]",
    )
    yield Kind(
        "charuco",
        "family",
        states(CHARUCO, replace(CHARUCO, family="aruco_6x6_50")),
        'family = "aruco_5x5_50"',
    )
    yield Kind(
        "charuco", "a column too few", states(CHARUCO, replace(CHARUCO, columns=6)), "columns = 7"
    )
    grid = MarkerGrid("aruco_5x5_50", 7, 3, 0.028, 0.012)
    yield Kind(
        "charuco", "grid of markers", states(CHARUCO, grid), 'type = "charuco"', known=_SIZES
    )
    other = CharucoBoard("aruco_5x5_100", 5, 6, 0.062, 0.05)
    yield Kind("aruco grid", "charuco", states(ARUCO, other), 'type = "marker_grid"', known=_ARUCO)
    yield Kind(
        "charuco",
        "checkerboard",
        states(CHARUCO, Checkerboard(6, 5, 0.04)),
        'type = "charuco"',
        known=_SIZES,
    )
    yield Kind(
        "checkerboard", "charuco", states(CHECKER, CHARUCO), 'type = "checkerboard"', known=_SQUARE
    )
    yield Kind(
        "checkerboard", "grid", states(CHECKER, GRID), 'type = "checkerboard"', known=_SQUARE
    )
    yield Kind("grid", "checkerboard", states(GRID, CHECKER), 'type = "marker_grid"', known=_GRID)
    for columns, rows, what in (
        (9, 6, "squares counted"),
        (7, 5, "a column too few"),
        (8, 4, "a row too few"),
        (9, 5, "a column too many"),
    ):
        yield Kind(
            "checkerboard",
            what,
            states(CHECKER, Checkerboard(columns, rows, 0.03)),
            "columns = 8, rows = 5|columns = 8|rows = 5",
        )
    yield Kind("marker", "id 9", states(MARKER, replace(MARKER, marker_id=9)), "marker_id = 7")
    yield Kind(
        "marker", "family", states(MARKER, replace(MARKER, family="tag25h9")), 'family = "tag36h11"'
    )
    yield Kind("loose", "family", line('"tag36h11"', '"tag25h9"'), 'family = "tag36h11"')


def _cameras() -> Iterator[Kind]:
    for base, camera, factor in (
        ("grid", PINHOLE, 2.0),
        ("checkerboard radtan", RADTAN, 0.5),
        ("loose", PINHOLE, 2.0),
    ):
        wrong = scaled(camera, factor)
        fx = rf"divide fx, fy, cx and cy by {factor:g}.*say fx = {camera.fx:.2f}"
        yield Kind(base, f"intrinsics times {factor:g}", sees(camera, wrong), fx)
    for base, camera, factor in (
        ("checkerboard", PINHOLE, 1.15),
        ("charuco", PINHOLE, 0.85),
        ("grid", PINHOLE, 1.3),
    ):
        wrong = replace(camera, fx=factor * camera.fx, fy=factor * camera.fy)
        yield Kind(base, f"focal length times {factor:g}", sees(camera, wrong), r"fx = 4[12]\d")
    bent = replace(PINHOLE, model="radtan", distortion=RADTAN.distortion)
    yield Kind(
        "checkerboard", "rectified, distortion stated", sees(PINHOLE, bent), r'model = "pinhole"'
    )
    straight = replace(RADTAN, model="pinhole", distortion=())
    yield Kind(
        "checkerboard radtan",
        "distortion left out",
        sees(RADTAN, straight),
        r'model = "radtan"|distortion = \[',
    )
    yield Kind(
        "grid radtan",
        "distortion left out",
        sees(RADTAN, straight),
        r'model = "radtan"|distortion = \[',
    )
    sign = replace(RADTAN, distortion=(0.3, -0.1, 0.0, 0.0))
    yield Kind(
        "checkerboard radtan",
        "distortion of the other sign",
        sees(RADTAN, sign),
        r"distortion = \[",
    )
    equidistant = replace(RADTAN, model="equidistant")
    yield Kind(
        "checkerboard radtan",
        "radtan as equidistant",
        sees(RADTAN, equidistant),
        r'model = "radtan"',
    )
    radtan = replace(FISHEYE, model="radtan")
    yield Kind(
        "checkerboard fisheye",
        "equidistant as radtan",
        sees(FISHEYE, radtan),
        r'model = "equidistant"',
    )
    for base in ("grid", "charuco", "checkerboard", "loose"):
        quarter = images(lambda one: np.rot90(one, -1).copy())
        mend = r"rotation_deg = (90|270)"
        yield Kind(base, "images turned by 90°", quarter, mend, files=True)
    for base in ("grid", "charuco", "marker", "loose"):
        mirrored = images(lambda one: one[:, ::-1].copy())
        yield Kind(base, "images mirrored", mirrored, "mirror", files=True, mendable=False)
    cropped = images(lambda one: one[:, 120:].copy())
    yield Kind("checkerboard", "images cropped", cropped, r"cx = 1[12]\d", files=True)


def _inertial() -> Iterator[Kind]:
    base, board = "grid imu", GRID
    inch = replace(GRID, marker_m=GRID.marker_m / 2.54, gap_m=GRID.gap_m / 2.54)
    tenth = replace(GRID, marker_m=10 * GRID.marker_m, gap_m=10 * GRID.gap_m)
    yield Kind(base, "sizes in inches", states(board, inch), "2.5|marker_m", mendable=False)
    yield Kind(base, "sizes ten times", states(board, tenth), "10|marker_m", mendable=False)
    yield Kind(
        base,
        "images' rate 30 for 20",
        line("rate_hz = 20.0", "rate_hz = 30.0"),
        "rate_hz = 20",
    )
    pose = IMU_T_CAMERA.as_matrix()
    old = f"imu_T_camera = {pose.tolist()!r}"
    inverse = np.linalg.inv(pose).tolist()
    yield Kind(
        base,
        "extrinsics inverted",
        line(old, f"imu_T_camera = {inverse!r}"),
        "inver|transpos",
        mendable=False,
    )
    axes = pose.copy()
    axes[:2] = axes[1::-1]
    axes[2] *= -1.0
    yield Kind(
        base,
        "axes of another IMU",
        line(old, f"imu_T_camera = {axes.tolist()!r}"),
        "imu_T_camera|axes|x and y",
        mendable=False,
    )

    def columns(change: Callable[[np.ndarray], np.ndarray]) -> Plant:
        def plant(drawn: Drawn, rng: Rng) -> Drawn:
            path = drawn.folder / "imu.csv"
            head, *rows = path.read_text().splitlines()
            values = change(np.array([list(map(float, row.split(",")[1:])) for row in rows]))
            stamps = [row.split(",")[0] for row in rows]
            text = [
                f"{s},{','.join(map(repr, v))}"
                for s, v in zip(stamps, values.tolist(), strict=True)
            ]
            path.write_text("\n".join([head, *text, ""]))
            return drawn

        return plant

    yield Kind(
        base,
        "gyroscope in deg/s",
        columns(lambda v: np.hstack([np.rad2deg(v[:, :3]), v[:, 3:]])),
        "deg/s|degrees",
        files=True,
        mendable=False,
    )
    yield Kind(
        base,
        "accelerometer in g",
        columns(lambda v: np.hstack([v[:, :3], v[:, 3:] / 9.81])),
        r"\bg\b",
        files=True,
        mendable=False,
    )
    yield Kind(
        base,
        "gyroscope's axis flipped",
        columns(lambda v: v * [1, -1, 1, 1, 1, 1]),
        "left-handed",
        files=True,
        mendable=False,
    )

    def late(drawn: Drawn, rng: Rng) -> Drawn:
        path = drawn.folder / "imu.csv"
        head, *rows = path.read_text().splitlines()
        text = [f"{int(row.split(',')[0]) + 200_000_000},{row.partition(',')[2]}" for row in rows]
        path.write_text("\n".join([head, *text, ""]))
        return drawn

    yield Kind(base, "IMU 0.2 s late", late, "0.2|200 ms|clock|offset", files=True, mendable=False)


def _rooms() -> Iterator[Kind]:
    def swapped(drawn: Drawn, rng: Rng) -> Drawn:
        shutil.rmtree(drawn.folder / "depth")
        (drawn.folder / "depth.txt").unlink()
        (drawn.folder / "rgb").rename(drawn.folder / "other")
        (drawn.folder / "right").rename(drawn.folder / "rgb")
        (drawn.folder / "other").rename(drawn.folder / "right")
        return drawn

    yield Kind(
        "room", "left for right", swapped, "swap the left and right", files=True, mendable=False
    )

    def shifted(drawn: Drawn, rng: Rng) -> Drawn:
        path = drawn.folder / "depth.txt"
        rows = [row.split() for row in path.read_text().splitlines()[1:]]
        path.write_text("".join(f"{float(s) + 1.0:.9f} {name}\n" for s, name in rows))
        return drawn

    yield Kind("room", "depth 1 s late", shifted, "depth.txt", files=True, mendable=False)
    for factor, what in ((5.0, "times 5"), (0.2, "by 5")):

        def plant(drawn: Drawn, rng: Rng, factor: float = factor) -> Drawn:
            for path in sorted((drawn.folder / "depth").iterdir()):
                depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED).astype(np.float64) * factor
                cv2.imwrite(str(path), np.where(depth < 65535, depth, 0).astype(np.uint16))
            return drawn

        yield Kind(
            "room", f"depth {what}", plant, r"depth_units_per_m = |unit", files=True, mendable=False
        )

    def zoomed(drawn: Drawn, rng: Rng) -> Drawn:
        for path in sorted((drawn.folder / "depth").iterdir()):
            depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
            inner = depth[20:-20, 27:-27]
            cv2.imwrite(
                str(path), cv2.resize(inner, depth.shape[::-1], interpolation=cv2.INTER_NEAREST)
            )
        return drawn

    yield Kind(
        "room",
        "depth not registered",
        zoomed,
        r"depth_camera|focal",
        files=True,
        mendable=False,
        open="where surfaces end in few places, edges do not tell a zoom",
    )

    def smaller(drawn: Drawn, rng: Rng) -> Drawn:
        for path in sorted((drawn.folder / "depth").iterdir()):
            depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
            cv2.imwrite(str(path), depth[::2, ::2])
        return drawn

    yield Kind(
        "room", "depth of half the size", smaller, r"depth_camera", files=True, mendable=False
    )
    from tests.end_to_end.contradictions.drawing import ROOM

    def doubled(drawn: Drawn, rng: Rng) -> Drawn:
        lines = {key: getattr(scaled(ROOM, 2.0), key) for key in ("fx", "fy", "cx", "cy")}
        for key, value in lines.items():
            drawn = camera_line(key, repr(value))(drawn, rng)
        return drawn

    def without_depth(plant: Plant) -> Plant:
        def changed(drawn: Drawn, rng: Rng) -> Drawn:
            shutil.rmtree(drawn.folder / "depth")
            (drawn.folder / "depth.txt").unlink()
            return plant(drawn, rng)

        return changed

    def camera_line(key: str, value: str) -> Plant:
        return lambda drawn, rng: replace(
            drawn, manifest=re.sub(rf"\b({key}) = .*", rf"\1 = {value}", drawn.manifest)
        )

    yield Kind(
        "room",
        "intrinsics times 2",
        doubled,
        "divide fx|fx = ",
        files=False,
    )
    yield Kind(
        "room",
        "baseline in mm",
        camera_line("baseline_m", "120.0"),
        "baseline_m = 0.12",
        files=True,
    )
    yield Kind(
        "room",
        "baseline negative",
        camera_line("baseline_m", "-0.12"),
        "baseline_m|swap",
        mendable=False,
    )

    def raised(drawn: Drawn, rng: Rng) -> Drawn:
        for path in sorted((drawn.folder / "right").iterdir()):
            image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
            cv2.imwrite(str(path), np.roll(image, 6, axis=0))
        return drawn

    yield Kind(
        "room", "pair not rectified", without_depth(raised), "rectify", files=True, mendable=False
    )

    def same(drawn: Drawn, rng: Rng) -> Drawn:
        for path in sorted((drawn.folder / "right").iterdir()):
            shutil.copy(drawn.folder / "rgb" / path.name, path)
        return drawn

    yield Kind(
        "room",
        "left given twice",
        without_depth(same),
        "same|no right|right",
        files=True,
        mendable=False,
    )
    bent = partial(
        re.sub, 'model = "pinhole"', 'model = "radtan"\ndistortion = [-0.3, 0.1, 0.0, 0.0]'
    )
    yield Kind(
        "room",
        "rectified, distortion stated",
        lambda drawn, rng: replace(drawn, manifest=bent(drawn.manifest)),
        'model = "pinhole"',
    )


def kinds() -> list[Kind]:
    """All of them."""
    return [*_boards(), *_cameras(), *_inertial(), *_rooms()]
