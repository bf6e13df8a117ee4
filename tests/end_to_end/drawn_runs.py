"""Short runs drawn at random, with exact truth: boards, grids and loose tags before a camera.

Every image is the mean of four rays a pixel onto prints that lie about on a textured table; each
line of an image has its own time where the shutter rolls. What then happens to the images, their
order and their stamps has a name in `HAPPENINGS`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import LooseMarkers, Recording
from motorcade.tracking import (
    Board,
    Camera,
    CharucoBoard,
    Checkerboard,
    MarkerGrid,
    SingleMarker,
)

__all__ = ["HAPPENINGS", "TARGETS", "DrawnRun", "draw_run"]

Path3 = Callable[[FloatArray], Motor]
TARGETS = ("checkerboard", "charuco", "grid", "marker", "loose")
HAPPENINGS = (
    "clean", "shuffled", "cut", "repeated", "mirrored", "moved", "doubled", "blurred", "darkened",
    "hidden", "noisy", "compressed", "motion", "rolling", "dropped", "wide",
)  # fmt: skip
STEP_S = 1.0 / 30.0
_SAMPLES, _EXPOSURES = 2, 5
_PAPER, _INK = 215.0, 35.0
_WIDTH, _HEIGHT = 320, 240
_TEXELS = 3.0
"""Of a print, on a pixel in the middle."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A print ``(rows, columns)`` in grey levels, and where it lies.

    Fields:
        levels: of its texels.
        origin_px, px_per_m: texel of the board frame's origin, and texels a metre.
        world_T_sheet: by time.
    """

    levels: FloatArray
    origin_px: tuple[float, float]
    px_per_m: float
    world_T_sheet: Path3


@dataclass(frozen=True, eq=False)
class DrawnRun:
    """A recording on the disk, and what is true of it.

    Fields:
        recording: as a user would open it.
        world_T_camera: F true poses, in each of the worlds that a right answer may be in; of loose
            tags the worlds are those of the tags, by id.
        planted: whether something about it contradicts what is stated, so that a doubt is right.
    """

    recording: Recording
    world_T_camera: dict[int, Motor]
    planted: bool


@dataclass
class _Stage:
    """What is drawn while it is being arranged."""

    camera: Camera
    path: Path3
    times_s: FloatArray
    sheets: list[Sheet]
    rays: FloatArray
    readout_s: float = 0.0
    exposure_s: float = 0.0
    after: Callable[[np.ndarray, int], np.ndarray] = field(default=lambda image, frame: image)


def draw_run(seed: int, target: str, happening: str, folder: Path) -> DrawnRun:
    """Draw a run into an empty folder; the same seed draws the same."""
    rng = np.random.default_rng([seed, TARGETS.index(target), HAPPENINGS.index(happening)])
    camera = _camera(rng, happening)
    frames = int(rng.integers(10, 17))
    times_s = STEP_S * np.arange(frames)
    boards, world_T_board = _targets(rng, target)
    extent = _extent(boards, world_T_board)
    distance, path = _path(rng, extent, camera)
    px_per_m = _TEXELS * camera.fx / distance
    sheets = [_table(rng)]
    still = [_standing(pose) for pose in world_T_board]
    worlds: dict[int, Path3] = dict(enumerate(still))
    stage = _Stage(camera, path, times_s, sheets, _rays(camera))
    readout_stated_s = 0.0
    planted = happening in ("mirrored", "moved", "doubled")
    if happening == "moved":
        if target == "loose":
            movers = rng.choice(len(boards), int(rng.integers(1, 3)), replace=False)
        else:
            movers = np.arange(len(boards))
        for mover in movers:
            still[mover] = _moving(rng, world_T_board[mover], times_s[-1])
            worlds[int(mover)] = still[mover]
        if target == "loose":
            worlds = {key: one for key, one in worlds.items() if key not in movers}
    sheets += [_sheet(one, pose, px_per_m) for one, pose in zip(boards, still, strict=True)]
    if happening == "doubled":
        copied = int(rng.integers(len(boards)))
        beside = np.array([1.15 * boards[copied].size_m[0] + 0.02, 0.0, 0.0])
        if target == "loose":
            beside = np.array([0.0, extent[1][1] - extent[0][1] + 0.05, 0.0])
        turn = Rotor.from_rotation_vector([0.0, 0.0, float(rng.uniform(-0.5, 0.5))])
        copy = world_T_board[copied] @ Motor.from_rotor_translation(turn, beside)
        sheets.append(_sheet(boards[copied], _standing(copy), px_per_m))
        if target != "loose":
            worlds[1] = _standing(copy)
        high = (extent[0], np.maximum(extent[1], copy.translation_m + 0.05))
        stage.path = _path(rng, high, camera)[1]
    if happening == "cut":
        other = _path(rng, extent, camera)[1]
        at = times_s[frames // 2 + int(rng.integers(-3, 4))]
        stage.path = _cut(stage.path, other, at)
    if happening == "rolling":
        stage.readout_s = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.01, 0.025))
        stated = str(rng.choice(["stated", "unstated", "reversed"]))
        readout_stated_s = {"stated": 1.0, "unstated": 0.0, "reversed": -1.0}[stated]
        readout_stated_s *= stage.readout_s
        planted = stated != "stated"
        if readout_stated_s < 0.0:  # a recording has no negative one: what is upside down
            stage.readout_s, readout_stated_s = -stage.readout_s, -readout_stated_s
            if stated == "reversed":
                stage.readout_s = -readout_stated_s
    if happening == "motion":
        stage.exposure_s = float(rng.uniform(0.01, 0.03))
    stage.after = _degraded(rng, happening, _covering(boards, still))
    images = [_image(stage, rng, row) for row in range(frames)]
    rows, stamps = _order(rng, happening, frames)
    if happening == "mirrored":
        images = [np.ascontiguousarray(image[:, ::-1]) for image in images]
    quality = int(rng.integers(8, 35)) if happening == "compressed" else None
    files = _written(folder, [images[row] for row in rows], quality)
    shown_s = times_s[rows]
    truth = {key: world(shown_s).inverse() @ stage.path(shown_s) for key, world in worlds.items()}
    if happening == "mirrored":
        truth = {}
        if isinstance(boards[0], Checkerboard):
            truth = {0: _mirrored(boards[0], stage.path(shown_s))}
    if isinstance(boards[0], Checkerboard):
        truth |= _half_turned(boards[0], truth)
    recording = Recording(
        f"{target} {happening} {seed}",
        folder,
        "images",
        ImageFrames(files, stamps, (camera.width, camera.height)),
        camera,
        board=None if target == "loose" else boards[0],
        markers=LooseMarkers("tag36h11", boards[0].size_m[0]) if target == "loose" else None,
        readout_s=readout_stated_s,
    )
    return DrawnRun(recording, truth, planted)


def _camera(rng: np.random.Generator, happening: str) -> Camera:
    cx, cy = 0.5 * (_WIDTH - 1), 0.5 * (_HEIGHT - 1)
    if happening != "mirrored":
        cx, cy = cx + rng.uniform(-4.0, 4.0), cy + rng.uniform(-4.0, 4.0)
    if happening == "wide":
        focal = float(rng.uniform(95.0, 125.0))
        lens = (0.03 * rng.standard_normal(), 0.01 * rng.standard_normal(), 0.0, 0.0)
        return Camera(_WIDTH, _HEIGHT, focal, focal, cx, cy, "equidistant", lens)
    focal = float(rng.uniform(240.0, 380.0))
    lens = (float(rng.uniform(-0.25, 0.05)), float(rng.uniform(0.0, 0.05)), 0.0, 0.0)
    return Camera(_WIDTH, _HEIGHT, focal, focal, cx, cy, "radtan", lens)


def _targets(rng: np.random.Generator, target: str) -> tuple[list[Board], list[Motor]]:
    """Boards, and where each lies; a board alone is the world."""
    here = [Motor.identity()]
    if target == "checkerboard":
        columns, rows = int(rng.integers(5, 10)), int(rng.integers(4, 8))
        columns += columns == rows
        return [Checkerboard(columns, rows, 0.03)], here
    if target == "charuco":
        columns, rows = int(rng.integers(5, 8)), int(rng.integers(4, 6))
        return [CharucoBoard("aruco_5x5_100", columns, rows, 0.04, 0.03)], here
    if target == "grid":
        columns, rows = int(rng.integers(2, 5)), int(rng.integers(2, 4))
        return [MarkerGrid("tag36h11", columns, rows, 0.05, float(rng.uniform(0.011, 0.02)))], here
    if target == "marker":
        return [SingleMarker("tag36h11", int(rng.integers(500)), 0.1)], here
    count = int(rng.integers(4, 8))
    place = np.stack([np.arange(count) % 3 * 0.16, np.arange(count) // 3 * 0.17], -1)
    place = np.pad(place + rng.uniform(-0.02, 0.02, place.shape), ((0, 0), (0, 1)))
    turn = Rotor.from_rotation_vector(
        np.pad(rng.normal(0.0, 0.15, (count, 2)), ((0, 0), (0, 1)))
        + np.array([0.0, 0.0, 1.0]) * rng.uniform(-0.4, 0.4, (count, 1))
    )
    boards: list[Board] = [SingleMarker("tag36h11", key, 0.08) for key in range(count)]
    return boards, [Motor.from_rotor_translation(turn[k], place[k]) for k in range(count)]


def _extent(boards: Sequence[Board], poses: Sequence[Motor]) -> tuple[FloatArray, FloatArray]:
    points = [pose.apply(one.points_m) for one, pose in zip(boards, poses, strict=True)]
    joined = np.concatenate(points)
    return joined.min(axis=0), joined.max(axis=0)


def _path(
    rng: np.random.Generator,
    extent: tuple[FloatArray, FloatArray],
    camera: Camera,
) -> tuple[float, Path3]:
    """A hand that sways before the middle of what there is, and how far away it is held."""
    middle, size = 0.5 * (extent[0] + extent[1]), extent[1] - extent[0]
    fill = rng.uniform(0.5, 0.95)
    share = max(size[0] / camera.width, np.linalg.norm(size) / camera.height)
    distance = float(camera.fx * share / fill)
    tilt, azimuth = np.radians(rng.uniform(8.0, 35.0)), rng.uniform(0.0, 2.0 * np.pi)
    roll, rate = rng.uniform(-0.5, 0.5), rng.uniform(1.0, 3.0, 5)
    phase, swing = rng.uniform(0.0, 6.28, 5), rng.uniform(0.3, 1.0, 5)

    def pose(time_s: FloatArray) -> Motor:
        time_s = np.asarray(time_s, np.float64)
        wave = swing * np.sin(time_s[..., None] * rate + phase)
        tilted = tilt + 0.2 * wave[..., 0]
        about = azimuth + 0.4 * wave[..., 1]
        axis = np.stack([-np.sin(about), np.cos(about), np.zeros_like(about)], axis=-1)
        lean = Rotor.from_rotation_vector(tilted[..., None] * axis)
        rolled = np.zeros((*time_s.shape, 3))
        rolled[..., 2] = roll + 0.2 * wave[..., 2]
        head_on = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])
        away = np.zeros((*time_s.shape, 3))
        away[..., 2] = distance * (1.0 + 0.12 * wave[..., 3])
        aside = np.zeros((*time_s.shape, 3))
        aside[..., 0] = 0.05 * distance * wave[..., 4]
        rotor = lean @ head_on @ Rotor.from_rotation_vector(rolled)
        return Motor.from_rotor_translation(rotor, middle + aside + lean.apply(away))

    return distance, pose


def _cut(first: Path3, second: Path3, at_s: float) -> Path3:
    def pose(time_s: FloatArray) -> Motor:
        late = (np.asarray(time_s) >= at_s)[..., None]
        return Motor(np.where(late, second(time_s).coefficients, first(time_s).coefficients))

    return pose


def _standing(pose: Motor) -> Path3:
    return lambda time_s: Motor(np.broadcast_to(pose.coefficients, (*np.shape(time_s), 8)))


def _moving(rng: np.random.Generator, pose: Motor, end_s: float) -> Path3:
    """What slides on the table from some moment on, or turns there."""
    way = np.append(rng.normal(size=2), 0.0)
    way *= rng.uniform(0.02, 0.12) / np.linalg.norm(way)
    start_s, turn = float(rng.uniform(0.0, 0.6)) * end_s, float(rng.uniform(-0.5, 0.5))

    def moved(time_s: FloatArray) -> Motor:
        share = np.clip((np.asarray(time_s) - start_s) / (end_s - start_s), 0.0, 1.0)[..., None]
        spin = Rotor.from_rotation_vector(share * np.array([0.0, 0.0, turn]))
        return Motor.from_rotor_translation(Rotor.identity(share.shape[:-1]), share * way) @ (
            pose @ Motor.from_rotor_translation(spin, np.zeros((*share.shape[:-1], 3)))
        )

    return moved


def _sheet(board: Board, world_T_sheet: Path3, px_per_m: float) -> Sheet:
    drawn, origin = board.draw(pixels_per_m=px_per_m)
    levels = _INK + (_PAPER - _INK) * drawn.astype(np.float32) / 255.0
    return Sheet(levels, origin, px_per_m, world_T_sheet)


def _table(rng: np.random.Generator) -> Sheet:
    """Blobs of all sizes, below everything."""
    levels = np.zeros((600, 600), np.float32)
    for size in (4, 16, 64):
        coarse = rng.standard_normal((600 // size + 1, 600 // size + 1)).astype(np.float32)
        levels += cv2.resize(coarse, (600, 600), interpolation=cv2.INTER_CUBIC)
    levels = 110.0 + 15.0 * levels
    return Sheet(levels, (300.0, 300.0), 200.0, _standing(Motor.from_translation([0, 0, -0.02])))


def _image(stage: _Stage, rng: np.random.Generator, row: int) -> np.ndarray:
    """The grey image of a frame, degraded and rounded."""
    camera, time_s = stage.camera, float(stage.times_s[row])
    lines = (np.arange(camera.height * _SAMPLES) + 0.5) / (camera.height * _SAMPLES) - 0.5
    shares = [0.0]
    if stage.exposure_s:
        shares = list((np.arange(_EXPOSURES) - 0.5 * (_EXPOSURES - 1)) / _EXPOSURES)
    total = np.zeros((camera.height, camera.width), np.float32)
    for share in shares:
        late = time_s + share * stage.exposure_s + lines * stage.readout_s
        if not stage.readout_s:
            late = late[:1]
        total += _drawn(stage, late) / len(shares)
    image = cv2.GaussianBlur(total, (0, 0), 0.6)
    image = stage.after(image, row) + 1.5 * rng.standard_normal(image.shape)
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def _rays(camera: Camera) -> FloatArray:
    """``(rows, columns, 3)`` through all samples, between those of pixels."""
    x, y = np.arange(-1.0, camera.width + 1.0), np.arange(-1.0, camera.height + 1.0)
    whole = np.nan_to_num(camera.bearings(np.stack(np.meshgrid(x, y), axis=-1)))
    columns, lines = (
        (np.arange(size * _SAMPLES, dtype=np.float32) + 0.5) / _SAMPLES + 0.5
        for size in (camera.width, camera.height)
    )
    places = np.meshgrid(columns, lines)
    return cv2.remap(whole.astype(np.float32), *places, cv2.INTER_LINEAR)


def _drawn(stage: _Stage, late_s: FloatArray) -> FloatArray:
    world_T_camera, camera = stage.path(late_s), stage.camera
    fine = np.full(stage.rays.shape[:2], 90.0, np.float32)
    for sheet in stage.sheets:
        sheet_T_camera = sheet.world_T_sheet(late_s).inverse() @ world_T_camera
        part = _shown(camera, sheet, sheet_T_camera)
        rays, lines = stage.rays[part], slice(None) if len(late_s) == 1 else part[0]
        if not rays.size:
            continue
        rotation = sheet_T_camera.rotor.as_matrix().astype(np.float32)[lines]
        eye = sheet_T_camera.translation_m.astype(np.float32)[lines, None]
        if len(late_s) == 1:
            along = rays @ rotation[0].T
        else:
            along = np.einsum("rij,rcj->rci", rotation, rays)
        down = np.minimum(along[..., 2], -1e-6)
        depth = -eye[..., 2] / down
        x = sheet.origin_px[0] + sheet.px_per_m * (eye[..., 0] + depth * along[..., 0])
        y = sheet.origin_px[1] - sheet.px_per_m * (eye[..., 1] + depth * along[..., 1])
        rows, columns = sheet.levels.shape
        on = (along[..., 2] < -1e-6) & (x > -0.5) & (x < columns - 0.5) & (y > -0.5)
        on &= y < rows - 0.5
        places = x.astype(np.float32), y.astype(np.float32)
        levels = cv2.remap(sheet.levels, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        fine[part][on] = levels[on]
    return cv2.resize(fine, (camera.width, camera.height), interpolation=cv2.INTER_AREA)


def _shown(camera: Camera, sheet: Sheet, sheet_T_camera: Motor) -> tuple[slice, slice]:
    """Lines and columns of samples that a sheet can cover."""
    rows, columns = sheet.levels.shape
    around = np.linspace(0.0, 1.0, 9)
    x = np.concatenate([around, around, 0 * around, 0 * around + 1.0]) * columns
    y = np.concatenate([0 * around, 0 * around + 1.0, around, around]) * rows
    edge = np.stack([x - sheet.origin_px[0], sheet.origin_px[1] - y, 0 * x], -1) / sheet.px_per_m
    some = sheet_T_camera[[0, -1]].inverse()
    px = camera.project(some[:, None].apply(edge)).reshape(-1, 2)
    if not np.isfinite(px).all():
        return slice(None), slice(None)
    low = np.floor(_SAMPLES * (px.min(axis=0) - 4.0)).clip(0).astype(int)
    high = np.ceil(_SAMPLES * (px.max(axis=0) + 4.0)).clip(1).astype(int)
    return slice(low[1], high[1]), slice(low[0], high[0])


def _covering(boards: Sequence[Board], poses: Sequence[Path3]) -> FloatArray:
    """Middle of what there is, in the world."""
    now = [pose(np.array(0.0)) for pose in poses]
    low, high = _extent(boards, now)
    return 0.5 * (low + high)


def _degraded(
    rng: np.random.Generator, happening: str, middle: FloatArray
) -> Callable[[np.ndarray, int], np.ndarray]:
    """What becomes of an image before it is rounded."""
    if happening == "blurred":
        sigma = float(rng.uniform(1.2, 4.0))
        if rng.random() < 0.4:
            size = 2 * int(rng.integers(2, 12)) + 1
            return lambda image, row: cv2.blur(image, (size, size))
        return lambda image, row: cv2.GaussianBlur(image, (0, 0), sigma)
    if happening == "darkened":
        left, level = float(rng.uniform(0.04, 0.3)), float(rng.uniform(0.0, 20.0))
        return lambda image, row: level + left * image
    if happening == "noisy":
        sigma = float(rng.uniform(8.0, 35.0))
        return lambda image, row: image + sigma * rng.standard_normal(image.shape)
    if happening == "hidden":
        side, speed = int(rng.integers(70, 150)), float(rng.uniform(-6.0, 6.0))
        start = rng.uniform([100.0, 80.0], [300.0, 220.0])
        grey = float(rng.uniform(30.0, 200.0))

        def covered(image: np.ndarray, row: int) -> np.ndarray:
            x, y = int(start[0] + speed * row), int(start[1])
            return cv2.ellipse(image, (x, y), (side, int(0.7 * side)), 20, 0, 360, grey, -1)

        return covered
    return lambda image, row: image


def _order(rng: np.random.Generator, happening: str, frames: int) -> tuple[IntArray, IntArray]:
    """Which image stands in each frame of the recording, and its stamp."""
    rows = np.arange(frames)
    if happening == "shuffled":
        rows = rng.permutation(frames)
    if happening == "repeated":
        rows = np.repeat(rows, rng.integers(1, 4, frames))[:30]
    stamps = np.round(1e9 * STEP_S * np.arange(len(rows))).astype(np.int64)
    if happening == "dropped":
        kept = np.sort(rng.choice(frames, max(frames // 2, 8), replace=False))
        rows, stamps = rows[kept], stamps[kept]
    return rows, stamps


def _written(folder: Path, images: Sequence[np.ndarray], quality: int | None) -> tuple[Path, ...]:
    suffix, options = (".png", []) if quality is None else (".jpg", [1, quality])
    files = tuple(folder / f"{row:04d}{suffix}" for row in range(len(images)))
    for file, image in zip(files, images, strict=True):
        cv2.imwrite(str(file), image, options)
    return files


def _mirrored(board: Checkerboard, world_T_camera: Motor) -> Motor:
    """The pose from which a mirrored image of a checkerboard could have been taken unmirrored."""
    swap, shift = np.eye(4), np.eye(4)
    if board.columns % 2 == 0:
        swap[0, 0], shift[0, 3] = -1.0, (board.columns - 1) * board.square_m
    else:
        swap[1, 1], shift[1, 3] = -1.0, -(board.rows - 1) * board.square_m
    matrix = shift @ swap @ world_T_camera.as_matrix() @ np.diag([-1.0, 1.0, 1.0, 1.0])
    return Motor.from_matrix(matrix)


def _half_turned(board: Checkerboard, truth: dict[int, Motor]) -> dict[int, Motor]:
    """The same in the board's frame turned by 180 degrees, where the print looks alike then."""
    if len(board.turns) == 1:
        return {}
    across = (board.columns - 1) * board.square_m, -(board.rows - 1) * board.square_m, 0.0
    turn = Motor.from_rotor_translation(Rotor.from_rotation_vector([0.0, 0.0, np.pi]), across)
    return {10 + key: turn @ poses for key, poses in truth.items()}
