"""Recordings of a board that hangs on a wall, with an IMU on the camera: all of it known.

The camera swings around the board and rolls, with a shake on top: turns about all axes and
accelerations along them, as one is told to move for Kalibr. Corners have Gaussian noise; for
images that are drawn and searched see `drawn`.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.imu import ADIS16448, ImuFaults, ImuNoise, ImuStream, simulate_imu
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking import Camera, Checkerboard
from motorcade.tracking.boards import BoardCorners

BOARD = Checkerboard(9, 6, 0.04)
CAMERA = Camera(752, 480, 460.0, 458.0, 368.0, 246.0, "radtan", (-0.28, 0.07, 2e-4, 2e-5))
IMU_T_CAMERA = Motor.from_euler_translation([1.5, -0.1, 1.6], [0.06, -0.03, 0.02])
OFFSET_S = 0.0137
SIGMA_PX = 0.2
PATH_HZ = 200.0
# The board's y is up on the wall, and the wall leans by a few degrees.
WORLD_T_BOARD = Motor.from_euler_translation([np.pi / 2 + 0.05, 0.03, 0.0], [0.2, 1.0, 1.4])
FAULTS = ImuFaults(
    gyro_scale=(1.008, 0.994, 1.004),
    accel_scale=(1.006, 0.992, 1.003),
    gyro_misalignment_rad=(0.004, -0.006, 0.005),
    accel_misalignment_rad=(-0.005, 0.004, 0.003),
    gyro_bias_rad_s=(0.02, -0.03, 0.01),
    accel_bias_m_s2=(0.1, -0.08, 0.12),
)
GYRO_TURN = Rotor.from_rotation_vector([0.005, -0.008, 0.006]).as_matrix()


@dataclass(frozen=True, eq=False)
class BoardRecording:
    """What a camera and an IMU recorded over a board, and what is true.

    Fields:
        time_ns, views: of the images.
        imu, noise: the stream, on its own clock.
        gyro_correction, accel_correction: what makes true rates and forces of readings.
        gravity_m_s2: ``(3,)`` in the board's axes.
        board_T_camera: Motor ``(N,)``.
        imu_T_camera, offset_s: extrinsics, and what the IMU's clock shows more than the camera's.
    """

    time_ns: IntArray
    views: list[BoardCorners]
    imu: ImuStream
    noise: ImuNoise
    gyro_correction: FloatArray
    accel_correction: FloatArray
    gravity_m_s2: FloatArray
    board_T_camera: Motor
    imu_T_camera: Motor
    offset_s: float


def swinging(seconds: FloatArray, rng: np.random.Generator, *, turning: float = 1.0) -> Motor:
    """Poses ``board_T_camera`` of a camera that is moved as a calibration asks for.

    `turning` scales all rotation: at zero it is carried along without any.
    """
    phase = rng.uniform(0.0, 2.0 * np.pi, (12,))

    def wave(size: float, hertz: float, k: int) -> FloatArray:
        return size * np.sin(2.0 * np.pi * hertz * seconds + phase[k])

    zero = np.zeros_like(seconds)
    around = turning * np.stack([wave(0.5, 0.31, 0), wave(0.6, 0.23, 1), zero], axis=-1)
    roll = turning * np.stack([zero, zero, wave(0.9, 0.37, 2) + wave(0.1, 1.3, 3)], axis=-1)
    shake = turning * np.stack([wave(0.06, 1.1, 4), wave(0.06, 1.4, 5), zero], axis=-1)
    away = np.stack(
        [
            wave(0.03, 0.9, 6) + wave(0.01, 2.1, 7),
            wave(0.03, 0.8, 8) + wave(0.01, 1.9, 9),
            0.55 + wave(0.08, 0.43, 10) + wave(0.02, 1.5, 11),
        ],
        axis=-1,
    )
    turn = Rotor.from_rotation_vector(around)
    facing = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])  # the camera's z into the board
    own = Rotor.from_rotation_vector(roll) @ Rotor.from_rotation_vector(shake)
    place = BOARD.points_m.mean(axis=0) + turn.apply(away)
    return Motor.from_rotor_translation(turn @ facing @ own, place)


def recording(
    seed: int,
    duration_s: float = 30.0,
    *,
    rate_hz: float = 20.0,
    imu_hz: float = 200.0,
    faults: ImuFaults = FAULTS,
    gyro_turn: FloatArray = GYRO_TURN,
    noise: ImuNoise = ADIS16448,
    sigma_px: float = SIGMA_PX,
    turning: float = 1.0,
    imu_T_camera: Motor = IMU_T_CAMERA,
    offset_s: float = OFFSET_S,
) -> BoardRecording:
    """A recording whose motion and noise are the seed's."""
    rng = np.random.default_rng(seed)
    start_ns = 1_500_000_000_000_000_000
    count = round((duration_s + 1.0) * PATH_HZ) + 1
    path_ns = start_ns + np.round(np.arange(count) * 1e9 / PATH_HZ).astype(np.int64)
    poses = swinging(np.arange(count) / PATH_HZ, rng, turning=turning)
    world_T_camera = Trajectory(path_ns, WORLD_T_BOARD @ poses, "world", "camera")
    run = simulate_imu(
        world_T_camera,
        imu_hz,
        noise,
        rng,
        knot_spacing_s=0.02,
        faults=faults,
        imu_T_child=imu_T_camera,
        time_offset_s=offset_s,
    )
    imu = ImuStream(
        run.stream.time_ns,
        run.stream.angular_rate_rad_s @ gyro_turn.T,
        run.stream.specific_force_m_s2,
    )
    frames = round(duration_s * rate_hz)
    stamps = start_ns + 500_000_000 + np.round(np.arange(frames) * 1e9 / rate_hz).astype(np.int64)
    seen = Trajectory(path_ns, poses).motors_at(stamps)
    kept, views = [], []
    for k, pose in enumerate(seen):
        pixels = CAMERA.project(pose.inverse().apply(BOARD.points_m))
        pixels = pixels + sigma_px * rng.standard_normal(pixels.shape)
        inside = np.all((pixels > 8.0) & (pixels < [743.0, 471.0]), axis=-1)
        if inside.sum() >= 12:
            views.append(
                BoardCorners(np.flatnonzero(inside), pixels[inside], BOARD.points_m[inside])
            )
            kept.append(k)
    return BoardRecording(
        stamps[kept],
        views,
        imu,
        noise,
        np.linalg.inv(gyro_turn @ faults.gyro_matrix),
        np.linalg.inv(faults.accel_matrix),
        WORLD_T_BOARD.rotor.inverse().apply([0.0, 0.0, -9.81]),
        seen[kept],
        imu_T_camera,
        offset_s,
    )


def drawn(poses: Motor, camera: Camera = CAMERA) -> list[NDArray[np.uint8]]:
    """Images of the board from these poses, through the camera's lens."""
    scale = 4000.0
    image, origin = BOARD.draw(scale)
    large = cv2.GaussianBlur(image, (0, 0), 2.5)
    columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = camera.unproject(np.stack([columns, rows], axis=-1).astype(np.float64))
    made = []
    for pose in poses:
        # Where each pixel's ray meets the board's plane.
        along = pose.rotor.apply(rays)
        far = -pose.translation_m[2] / along[..., 2]
        met = pose.translation_m + far[..., None] * along
        places = np.array(origin) + scale * met[..., :2] * (1.0, -1.0)
        made.append(
            cv2.remap(
                large,
                places[..., 0].astype(np.float32),
                places[..., 1].astype(np.float32),
                cv2.INTER_LINEAR,
                borderValue=170,
            )
        )
    return made
