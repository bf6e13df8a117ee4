"""Draws recordings of prints and of a room, small and clean, to plant contradictions into."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np

from motorcade.fusion.imu import ADIS16448, simulate_imu
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.readers.manifest.section import board_toml, camera_toml
from motorcade.replays.io.trajectories import even_stamps
from motorcade.tracking import Board, Camera, SingleMarker
from motorcade.tracking.checks import GrayImage
from tests.textured_room.inertial import IMU_T_CAMERA
from tests.textured_room.paths import handheld
from tests.textured_room.recording import write_recording
from tests.textured_room.renderer import Sensor
from tests.textured_room.scenarios import Scenario

RATE_HZ, IMU_HZ = 20.0, 200.0
PINHOLE = Camera(480, 360, 420.0, 420.0, 239.5, 179.5)
RADTAN = Camera(480, 360, 400.0, 400.0, 242.0, 176.0, "radtan", (-0.3, 0.1, 0.0, 0.0))
FISHEYE = Camera(480, 360, 300.0, 300.0, 238.0, 181.0, "equidistant", (-0.03, 0.01, 0.0, 0.0))
SMALL = Camera(320, 240, 280.0, 280.0, 159.5, 119.5)
ROOM = Camera(640, 480, 525.0, 525.0, 319.5, 239.5)
_FINE = 2


@dataclass(frozen=True, eq=False)
class Sheet:
    """A drawn print on a grey table, and where its texture lies.

    Fields:
        image: of the sheet, origin_px of the board's origin in it, pixels_per_m.
        table: the manifest's table that states it.
        size_m: of what is looked at.
    """

    image: GrayImage
    origin_px: FloatArray
    pixels_per_m: float
    table: str
    middle_m: FloatArray
    size_m: float


def sheet_of(board: Board) -> Sheet:
    """The print of a board."""
    width_m, height_m = board.size_m
    scale = 1000.0 / max(width_m, height_m)
    image, origin_px = board.draw(scale)
    middle = board.points_m.mean(axis=0)
    origin = np.array(origin_px, np.float64)
    return Sheet(image, origin, scale, board_toml(board), middle, max(width_m, height_m))


def loose_sheet(family: str, ids: range, side_m: float, rng: np.random.Generator) -> Sheet:
    """Loose markers on a wall, each turned and shifted in a cell of its own."""
    scale, cell_m = 60.0 / side_m, 2.6 * side_m
    columns = int(np.ceil(np.sqrt(len(ids))))
    side_px = round(scale * cell_m)
    wall = np.full((side_px * -(-len(ids) // columns), side_px * columns), 150, np.uint8)
    for place, marker in enumerate(ids):
        printed, _ = SingleMarker(family, marker, side_m).draw(scale)
        turn = float(rng.uniform(0.0, 360.0))
        middle = np.array(printed.shape[::-1]) / 2.0
        rotate = cv2.getRotationMatrix2D((float(middle[0]), float(middle[1])), turn, 1.0)
        row, column = divmod(place, columns)
        target = side_px * (np.array([column, row]) + 0.5) + rng.uniform(-0.15, 0.15, 2) * side_px
        rotate[:, 2] += target - middle
        size = (wall.shape[1], wall.shape[0])
        mask = cv2.warpAffine(np.full_like(printed, 255), rotate, size)
        turned = cv2.warpAffine(printed, rotate, size, flags=cv2.INTER_AREA)
        wall = np.where(mask > 250, turned, wall)
    table = f'[markers]\nfamily = "{family}"\nside_m = {side_m!r}\n'
    extent = np.array(wall.shape[::-1]) / scale
    middle_m = np.array([0.5 * extent[0], -0.5 * extent[1], 0.0])
    return Sheet(wall, np.zeros(2), scale, table, middle_m, float(extent.max()))


PosesByTime = Callable[[FloatArray], Motor]


def camera_path(
    sheet: Sheet, camera: Camera, rng: np.random.Generator, near: float, period_s: float
) -> PosesByTime:
    """A hand that carries a camera about before a print, looking at it: poses by time."""
    first_s, phases = rng.uniform(0.0, 6.0), rng.uniform(0.0, 2.0 * np.pi, 6)
    focal = max(camera.fx / camera.width, camera.fy / camera.height)
    reach = 1.35 * near * sheet.size_m * focal
    down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])

    def poses(time_s: FloatArray) -> Motor:
        s = 2.0 * np.pi * (first_s + np.asarray(time_s)) / period_s
        tilt = np.stack([0.5 * np.sin(0.7 * s + phases[0]), 0.5 * np.cos(s + phases[1])], axis=-1)
        sway = np.concatenate([tilt, 0.3 * np.sin(s + phases[2])[..., None]], axis=-1)
        rotor = down @ Rotor.from_rotation_vector(sway)
        away = reach * (1.0 + 0.15 * np.sin(s + phases[4]))
        behind = -away[..., None] * rotor.apply(np.array([0.0, 0.0, 1.0]))
        return Motor.from_rotor_translation(rotor, sheet.middle_m + behind)

    return poses


@cache
def _bearings(camera: Camera) -> FloatArray:
    rows, columns = np.mgrid[0 : camera.height * _FINE, 0 : camera.width * _FINE]
    pixels = (np.stack([columns, rows], axis=-1).reshape(-1, 2) + 0.5) / _FINE - 0.5
    return camera.bearings(pixels)


def photograph(
    sheet: Sheet, camera: Camera, world_T_camera: Motor, rng: np.random.Generator
) -> GrayImage:
    """What a camera of any lens sees of a sheet: each ray met with its plane, twice as fine."""
    rays = world_T_camera.rotor.apply(_bearings(camera))
    centre = world_T_camera.apply(np.zeros(3))
    with np.errstate(all="ignore"):
        along = -centre[2] / rays[:, 2]
        hit = centre + along[:, None] * rays
    texture = sheet.origin_px + hit[:, :2] * [sheet.pixels_per_m, -sheet.pixels_per_m]
    texture[~(along > 0.0)] = -1e6
    shape = camera.height * _FINE, camera.width * _FINE
    maps = [
        np.nan_to_num(texture[:, k], nan=-1e6).reshape(shape).astype(np.float32) for k in (0, 1)
    ]
    seen = cv2.remap(
        cv2.GaussianBlur(sheet.image, (0, 0), 0.8), *maps, cv2.INTER_LINEAR, borderValue=150.0
    )
    small = cv2.resize(seen, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    noisy = cv2.GaussianBlur(small, (0, 0), 0.6) + 2.0 * rng.standard_normal(small.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class Drawn:
    """A clean recording on the disk, and its manifest.

    Fields:
        folder: of the recording; `manifest` states it as it is.
        notes: what a contradiction may need to know.
    """

    folder: Path
    manifest: str
    notes: dict[str, object] = field(default_factory=dict)

    def stated(self, *changes: tuple[str, str]) -> Drawn:
        """With other lines in the manifest; each `(old, new)` must be there."""
        text = self.manifest
        for old, new in changes:
            if old not in text:
                raise ValueError(f"manifest: expected {old!r} in it, got {text}")
            text = text.replace(old, new, 1)
        return replace(self, manifest=text)


def write_sheet(
    folder: Path,
    sheet: Sheet,
    camera: Camera,
    rng: np.random.Generator,
    frames: int = 12,
    imu: bool = False,
    near: float = 1.0,
) -> Drawn:
    """A recording of a print: images, and where asked the IMU that was carried along."""
    folder.mkdir(parents=True)
    path = camera_path(sheet, camera, rng, near, 3.5 if imu else 1.5)
    (folder / "images").mkdir()
    for row, pose in enumerate(path(np.arange(frames) / RATE_HZ)):
        image = photograph(sheet, camera, pose, rng)
        cv2.imwrite(str(folder / "images" / f"{row:04d}.png"), image)
    manifest = (
        f'name = "drawn"\n[frames]\nimages = "images/*.png"\nrate_hz = {RATE_HZ}\n'
        f"{camera_toml(camera)}{sheet.table}"
    )
    if imu:
        manifest += _write_imu(folder, path, frames, rng)
    return Drawn(folder, manifest)


def _write_imu(folder: Path, path: PosesByTime, frames: int, rng: np.random.Generator) -> str:
    """The IMU along a path; the print lies flat, z up."""
    time_ns = even_stamps(int(2 * IMU_HZ * (frames / RATE_HZ + 0.1)), 2 * IMU_HZ)
    carried = Trajectory(time_ns, path(1e-9 * time_ns) @ IMU_T_CAMERA.inverse())
    stream = simulate_imu(carried, IMU_HZ, ADIS16448, rng, knot_spacing_s=0.05).stream
    write_imu(stream, folder / "imu.csv")
    (folder / "imu.yaml").write_text(
        f"gyroscope_noise_density: {ADIS16448.gyro_density_rad_s_rthz!r}\n"
        f"gyroscope_random_walk: {ADIS16448.gyro_walk_rad_s2_rthz!r}\n"
        f"accelerometer_noise_density: {ADIS16448.accel_density_m_s2_rthz!r}\n"
        f"accelerometer_random_walk: {ADIS16448.accel_walk_m_s3_rthz!r}\n"
    )
    pose = IMU_T_CAMERA.as_matrix().tolist()
    return f'[imu]\nfile = "imu.csv"\nnoise_file = "imu.yaml"\nimu_T_camera = {pose!r}\n'


def write_room(folder: Path, rng: np.random.Generator, frames: int = 20) -> Drawn:
    """A textured room in the layout of TUM RGB-D, with depth and right images."""
    seed = int(rng.integers(1 << 30))
    sensor = Sensor(camera=ROOM, depth_noise_px=0.15)
    first_s = rng.uniform(0.0, 10.0)
    scenario = Scenario(lambda time_s: handheld(first_s + time_s), frames, sensor, seed=seed)
    write_recording(folder, scenario, name="drawn room")
    manifest = (folder / "motorcade.toml").read_text()
    (folder / "motorcade.toml").unlink()
    return Drawn(folder, manifest)
