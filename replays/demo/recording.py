"""Writes the synthetic room as a recording: images, truth, IMU and a manifest, like any user's.

The world has z up and its origin on the table top, z = 0, where a character may stand. Images
are 640 x 480 from a pinhole camera at 30 Hz, with vignetting and sensor noise; the ground truth is
exact, four poses a frame. The same seed writes the same bytes on the same machine.
"""

from __future__ import annotations

import errno
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.fusion.imu.noise import ADIS16448
from motorcade.fusion.imu.simulate import simulate_imu
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import read_bounded
from motorcade.ga.lookahead import ahead
from motorcade.ga.progress import track
from motorcade.ga.unfinished import unfinished
from motorcade.render import Layer, Renderer, Surface, new_renderer
from motorcade.replays.demo.furniture import BOARD, CHARACTER_HEIGHT_M, world_T_board
from motorcade.replays.demo.scene import room
from motorcade.replays.engine.store import code_digest
from motorcade.replays.io.imu import kalibr_noise, write_imu
from motorcade.replays.io.trajectories import even_stamps, write_trajectory
from motorcade.replays.stages.view.placed import CAST_SAYS
from motorcade.tracking.cameras.camera import Camera

FIRST_POLE_S = 0.6
BETWEEN_POLES_S = 1.2
BASE_RAD_S = np.pi / BETWEEN_POLES_S
MIDDLE_M = (-0.625, 0.045, 0.172)
# World axes of a level camera that looks along +x: columns x right, y down, z forward.
LEVEL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])

# amplitude of the sine of each multiple of the base frequency; degrees
SIDEWAYS_DEG = {1: -10.0, 2: 4.6, 3: 2.8}
UPWARDS_DEG = {1: 2.0, 2: 3.6, 3: -2.3}
# the hand moves against the gaze, so that what is looked at stays in the image; metres
AGAINST_M = (0.0, 0.085, -0.016)
TREMOR_DEG = 0.35
# deliberate motion: amplitude, frequency (Hz), phase (rad) for every axis, metres
SWEEP = (
    ((0.095, 0.155, 0.4), (0.020, 0.47, 1.0)),
    ((0.050, 0.205, 2.6), (0.016, 0.55, 0.2)),
    ((0.028, 0.260, 1.2), (0.012, 0.62, 2.0)),
)
ROLL_DEG = ((12.0, 0.23, 0.3), (5.0, 0.71, 1.4))
TREMOR_M = 0.0016
TREMOR_HZ = (1.1, 1.5, 1.9, 2.1)


@dataclass(frozen=True)
class HandheldPath:
    """The path of one seed; the deliberate motion is always the same, the tremor is the seed's.

    Sums of sines, exact at any time: nothing moves faster than 2.1 Hz. The camera looks along +x.
    The gaze's two angles off +x hold only sines of whole multiples of one frequency about
    `FIRST_POLE_S`, so both vanish together every `BETWEEN_POLES_S`: there the optical axis is
    exactly +x and the pitch of the intrinsic x-y′-z″ angles is exactly +90°.

    Attributes:
        gaze_tremor_rad: (2, 2) amplitudes sideways and upwards at 4 and 5 times the base.
        tremor: (4, n, 2) amplitude and phase at `TREMOR_HZ` of x, y, z (m) and roll (rad).
    """

    gaze_tremor_rad: FloatArray
    tremor: FloatArray

    @classmethod
    def of(cls, rng: np.random.Generator) -> HandheldPath:
        """A path whose tremor is drawn from `rng`."""
        gaze = np.deg2rad(TREMOR_DEG) * rng.uniform(-1.0, 1.0, (2, 2))
        size = np.array([TREMOR_M, TREMOR_M, TREMOR_M, np.deg2rad(TREMOR_DEG)])[:, None]
        amplitude = size * rng.uniform(0.4, 1.0, (4, len(TREMOR_HZ)))
        phase = rng.uniform(0.0, 2.0 * np.pi, (4, len(TREMOR_HZ)))
        return cls(gaze, np.stack([amplitude, phase], axis=-1))

    def at(self, time_s: ArrayLike) -> Motor:
        """Poses `world_T_camera` (*) at times (*) in seconds, OpenCV camera axes."""
        time = np.asarray(time_s, dtype=np.float64)
        gaze = np.zeros((*time.shape, 3))
        gaze[..., 1] = -self._gaze(time, UPWARDS_DEG, 1)
        gaze[..., 2] = self._gaze(time, SIDEWAYS_DEG, 0)
        roll = np.zeros((*time.shape, 3))
        roll[..., 0] = np.deg2rad(_waves(time, ROLL_DEG)) + self._tremor(time, 3)
        rotor = Rotor.from_rotation_vector(gaze) @ Rotor.from_rotation_vector(roll)
        against = np.sin(BASE_RAD_S * (time - FIRST_POLE_S))
        place = [
            MIDDLE_M[k] + AGAINST_M[k] * against + _waves(time, SWEEP[k]) + self._tremor(time, k)
            for k in range(3)
        ]
        return Motor.from_rotor_translation(
            rotor @ Rotor.from_matrix(LEVEL), np.stack(place, axis=-1)
        )

    def trajectory(self, time_ns: IntArray) -> Trajectory:
        """The path at stamps (N,) in ns; stamp 0 is its beginning."""
        return Trajectory(time_ns, self.at(time_ns * 1e-9))

    def _gaze(self, time: FloatArray, amplitudes_deg: dict[int, float], axis: int) -> FloatArray:
        angle = BASE_RAD_S * (time - FIRST_POLE_S)
        total = np.zeros_like(time)
        for multiple, degrees in amplitudes_deg.items():
            total += np.deg2rad(degrees) * np.sin(multiple * angle)
        for k, multiple in enumerate((4, 5)):
            total += self.gaze_tremor_rad[axis, k] * np.sin(multiple * angle)
        return total

    def _tremor(self, time: FloatArray, axis: int) -> FloatArray:
        total = np.zeros_like(time)
        for hertz, (amplitude, phase) in zip(TREMOR_HZ, self.tremor[axis], strict=True):
            total += amplitude * np.sin(2.0 * np.pi * hertz * time + phase)
        return total


def _waves(time: FloatArray, terms: tuple[tuple[float, float, float], ...]) -> FloatArray:
    """Sum of sines given by amplitude, frequency and phase."""
    total = np.zeros_like(time)
    for amplitude, hertz, phase in terms:
        total += amplitude * np.sin(2.0 * np.pi * hertz * time + phase)
    return total


CAMERA = Camera(640, 480, 510.0, 510.0, 319.5, 239.5)
FRAMES, RATE_HZ = 204, 30.0
TRUTH_A_FRAME = 4
IMU_RATE_HZ, IMU_KNOTS_S = 200.0, 0.03
# The IMU's x points forward, y to the left, z up; the camera sits a little ahead of it.
IMU_T_CAMERA = Motor.from_rotor_translation(Rotor.from_matrix(LEVEL), np.array([0.03, 0.01, 0.005]))
VIGNETTING, NOISE_FLOOR, NOISE_SLOPE = 0.20, 1.1, 0.006
JPEG_QUALITY = 94

Track = Callable[[Iterable[int], str, int], Iterable[int]]


STANDING = "placed.position_m=0,0"
"""A setting: the character stands in the middle of the table."""


def write_recording(
    folder: Path,
    *,
    frames: int = FRAMES,
    seed: int = 0,
    placed: str = STANDING,
    progress: Track | None = None,
) -> None:
    """Render the room along its path and write everything a reader needs into a folder.

    Args:
        folder: made where it is missing; it must be empty.
        frames: images to write, 2 or more.
        seed: of the hand's tremor, the sensor's noise and the IMU's.
        placed: the setting that says where the character is.
        progress: wraps the loop over frames: (numbers, what is done, how many) -> numbers.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: fewer than two frames.
        OSError: the folder is not empty, or cannot be written.
    """
    if frames < 2:
        raise ValueError(f"write_recording(frames): expected 2 or more, got {frames}")
    hand, sensor, inertial = (
        np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(3)
    )
    path = HandheldPath.of(hand)
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise FileExistsError(f"{folder}: expected an empty folder for the recording")
        numbers: Iterable[int] = range(frames)
        if progress is not None:
            numbers = progress(numbers, "rendering the room", frames)
        _write_images(folder / "images", renderer, path, numbers, sensor)
    write_trajectory(truth(path, frames), folder / "truth.tum")
    _write_inertial(folder, path, frames, inertial)
    (folder / "motorcade.toml").write_text(manifest(placed), encoding="utf-8")


def truth(path: HandheldPath, frames: int) -> Trajectory:
    """The exact path, at every frame's stamp and three times between."""
    count = (frames - 1) * TRUTH_A_FRAME + 1
    return path.trajectory(even_stamps(count, TRUTH_A_FRAME * RATE_HZ))


def _write_images(
    folder: Path,
    renderer: Renderer,
    path: HandheldPath,
    numbers: Iterable[int],
    rng: np.random.Generator,
) -> None:
    """Render, expose and save every frame."""
    folder.mkdir()
    renderer.show([_as_light(surface) for surface in room()], None)

    def write(drawn: tuple[int, Layer]) -> None:
        number, layer = drawn
        image = exposed(cv2.LUT(layer.rgba, _AS_LEVELS)[..., :3], rng)
        file = folder / f"{number:06d}.jpg"
        if not cv2.imwrite(str(file), image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]):
            raise OSError(f"{file}: cannot be written")

    stamps_ns = ((number, even_stamps(number + 1, RATE_HZ)[-1]) for number in numbers)
    drawn = ((k, renderer.render(CAMERA, path.at(time_ns * 1e-9))) for k, time_ns in stamps_ns)
    deque(ahead(write, drawn), maxlen=0)


# The room's textures are levels of a camera, and its images mix them as such: in a mean of light,
# which the renderer takes, white grows into black, and corners move by a quarter of a pixel.
_LEVELS = np.arange(256) / 255.0
_AS_LIGHT, _AS_LEVELS = (
    np.rint(255.0 * curve(_LEVELS)).astype(np.uint8) for curve in (to_srgb, to_linear)
)


def _as_light(surface: Surface) -> Surface:
    """The surface whose linear light, as the renderer reads it, is the levels of this one."""
    texture = None if surface.texture is None else _AS_LIGHT[surface.texture]
    colors = None if surface.colors is None else to_srgb(surface.colors)
    return replace(surface, texture=texture, colors=colors)


def exposed(image: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """What the sensor makes of a rendered image: darker corners and noise.

    Args:
        image: (h, w, 3) uint8.
        rng: of the noise.

    Returns:
        (h, w, 3) uint8.
    """
    height, width = image.shape[:2]
    x = (np.arange(width, dtype=np.float32) - 0.5 * (width - 1)) / (0.5 * width)
    y = (np.arange(height, dtype=np.float32) - 0.5 * (height - 1)) / (0.5 * width)
    gain = 1.0 - VIGNETTING * (x[None, :] ** 2 + y[:, None] ** 2) / (1.0 + (height / width) ** 2)
    noise = rng.standard_normal((height, width), dtype=np.float32)
    taken = np.empty_like(image)
    for k in range(image.shape[2]):  # a channel at once: three numbers a row are slow
        seen = image[..., k] * gain
        noisy = seen + noise * (NOISE_FLOOR + NOISE_SLOPE * seen)
        taken[..., k] = np.clip(np.rint(noisy, out=noisy), 0, 255, out=noisy)
    return taken


def _write_inertial(
    folder: Path, path: HandheldPath, frames: int, rng: np.random.Generator
) -> None:
    """The simulated IMU along the path, and what its noise is."""
    # A little longer than the images, so that the last one lies between two samples.
    last_s = (frames - 1) / RATE_HZ + 0.05
    stamps = even_stamps(int(last_s * IMU_RATE_HZ * 2) + 1, IMU_RATE_HZ * 2)
    world_T_imu = path.trajectory(stamps).transformed_by(right=IMU_T_CAMERA.inverse(), child="imu")
    simulated = simulate_imu(world_T_imu, IMU_RATE_HZ, ADIS16448, rng, knot_spacing_s=IMU_KNOTS_S)
    write_imu(simulated.stream, folder / "imu.csv")
    noise = "".join(f"{name}: {value!r}\n" for name, value in kalibr_noise(ADIS16448).items())
    (folder / "imu.yaml").write_text(noise, encoding="utf-8")


def manifest(placed: str = STANDING) -> str:
    """The recording's manifest."""
    settings = [
        "placed.on=floor",
        placed,
        f"placed.height_m={CHARACTER_HEIGHT_M}",
        "errors.align=none",
        "fused.noise_factor=1",  # the sensor is exactly as its data sheet says
        "smoothed.window_s=0.167",  # five poses, to set the representations side by side
    ]
    listed = ", ".join(f'"{setting}"' for setting in settings)
    return f"""\
# A synthetic room. World: metres, z up, origin on the table top. Images are rendered, and the IMU
# is simulated, along the same exact path.
name = "synthetic room, with a simulated IMU"
settings = [{listed}]

[frames]
images = "images/*.jpg"
rate_hz = {RATE_HZ}

[camera]
model = "pinhole"
width = {CAMERA.width}
height = {CAMERA.height}
fx = {CAMERA.fx}
fy = {CAMERA.fy}
cx = {CAMERA.cx}
cy = {CAMERA.cy}

[board]
type = "marker_grid"
family = "{BOARD.family}"
columns = {BOARD.columns}
rows = {BOARD.rows}
marker_m = {BOARD.marker_m}
gap_m = {BOARD.gap_m}
first_id = {BOARD.first_id}
world_T_board = {_rows(world_T_board())}

[truth]
file = "truth.tum"
format = "tum"
convention = "world_T_camera"

[imu]
file = "imu.csv"
noise_file = "imu.yaml"
imu_T_camera = {_rows(IMU_T_CAMERA)}
"""


def _rows(pose: Motor) -> str:
    """A pose as the four rows of its matrix, in TOML."""
    rows = ",\n".join("    " + repr([float(x) for x in row]) for row in pose.as_matrix())
    return f"[\n{rows},\n]"


PLAY = """\
# A visitor comes from behind the board, walks round its end, turns to the camera and waves.
[[characters]]
name = "visitor"
path = [[0.32, 0.04], [0.30, -0.09], [0.20, -0.12], [0.05, -0.03]]
look_at = "camera"
gaits = ["walk", "jog"]
speed_m_s = 1.9
acts = ["wave"]
"""
"""The demo's cast: where it goes is clear of the things on the table."""
MARKER = ".rendered"
MAX_MARKER_BYTES = 1 << 12


def ensure_demo_recording(folder: Path, seed: int) -> Path:
    """Render the synthetic room into `folder` unless this code has done so with this seed.

    The folder appears complete or not at all. Raises `render.RenderUnavailable` without OpenGL,
    and FileExistsError where `folder` holds something else.
    """
    made_from = f"{code_digest(ensure_demo_recording)} seed {seed}\n"
    if _is_made_from(made_from, folder):
        return folder
    if folder.exists() and not (folder / MARKER).is_file():
        raise FileExistsError(
            errno.EEXIST,
            "is not a recording that this demo made; choose another --out",
            str(folder),
        )
    with unfinished(folder.parent) as place:
        recording = place / "recording"
        write_recording(recording, seed=seed, placed="placed.cast=cast.toml", progress=track)
        (recording / "cast.toml").write_text(PLAY, encoding="utf-8")
        (recording / MARKER).write_text(made_from, encoding="utf-8")
        if not _is_made_from(made_from, folder):  # else another run was faster
            if folder.exists():
                folder.rename(place / "earlier")
            recording.rename(folder)
    return folder


def settings_beside(asked: Sequence[str]) -> tuple[str, ...]:
    """Settings of a run of the demo: who asks for another character gets it in place of the play.

    >>> from motorcade.replays.demo.recording import settings_beside
    >>> settings_beside(["placed.character=knight.glb"])
    ('placed.cast=none', 'placed.position_m=0,0', 'placed.character=knight.glb')
    >>> settings_beside(["fused.gate=0.99"])
    ('fused.gate=0.99',)
    """
    knobs = {one.partition("=")[0].strip() for one in asked}
    instead = knobs & {f"placed.{name}" for name in CAST_SAYS} and "placed.cast" not in knobs
    return (*(("placed.cast=none", STANDING) if instead else ()), *asked)


def _is_made_from(origin: str, folder: Path) -> bool:
    marker = folder / MARKER
    return marker.is_file() and read_bounded(marker, MAX_MARKER_BYTES) == origin.encode()
