"""Rolling shutter: where a point would be seen, had all rows been read at the frame's stamp.

A stamp is taken to be the time of the middle row; row r of h is read (r / (h - 1) - 1/2) times the
readout time later. Meanwhile the camera goes on as its velocity and the gyroscope say, evenly: over
30 ms a hand's acceleration moves it by less than a millimetre from that.

Source: J. Hedborg, P.-E. Forssén, M. Felsberg, E. Ringaby, Rolling shutter bundle adjustment, CVPR
2012; here the motion within a frame is the IMU's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import LONGEST_READOUT_S
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.slam.geometry import seen_through


def checked_readout(readout_s: float) -> float:
    """Seconds from the first row to the last, 0 for a global shutter.

    Raises:
        ValueError: less than 0, or more than 0.2 s.
    """
    if not 0.0 <= readout_s <= LONGEST_READOUT_S:
        raise ValueError(
            f"readout_s: expected seconds from 0 to {LONGEST_READOUT_S:g}, got {readout_s}"
        )
    return float(readout_s)


@dataclass(frozen=True)
class Readout:
    """How a camera reads its rows.

    Args:
        camera: with its lens.
        readout_s: from the first row to the last, 0 for a global shutter.

    Raises:
        ValueError: a readout time below 0 or above 0.2 s.

    >>> import numpy as np
    >>> from motorcade.fusion.visual_inertial.readout import Readout
    >>> from motorcade.tracking import Camera
    >>> camera = Camera(640, 481, 500.0, 500.0, 319.5, 240.0)
    >>> Readout(camera, 0.02).later_s(np.array([[320.0, 0.0], [320.0, 480.0]]))
    array([-0.01,  0.01])
    """

    camera: Camera
    readout_s: float

    def __post_init__(self) -> None:
        checked_readout(self.readout_s)

    def later_s(self, px: FloatArray) -> FloatArray:
        """How long ``(n,)`` after the stamp what SLAM has at pixels ``(n, 2)`` was read."""
        return rows_later_s(self.camera, as_recorded(self.camera, px), self.readout_s)


def rows_later_s(camera: Camera, px: FloatArray, readout_s: float) -> FloatArray:
    """How long ``(n,)`` after the stamp a camera's own pixels ``(n, 2)`` were read."""
    return (px[:, 1] / (camera.height - 1) - 0.5) * readout_s


def as_recorded(camera: Camera, px: FloatArray) -> FloatArray:
    """Where pixels ``(n, 2)`` of the images that SLAM works in lie in the camera's own ones."""
    return px if seen_through(camera) == camera else camera.distort(px)


def rows_moved_px(
    camera: Camera,
    later_s: FloatArray,
    world_T_camera: Motor,
    twist_rate: FloatArray,
    pose_of: IntArray,
    points: FloatArray,
) -> FloatArray:
    """How far ``(n, 2)`` points are seen from where they are at the stamp, because rows come later.

    Args:
        camera: what saw them.
        later_s: ``(n,)`` how long after the stamp of the image.
        world_T_camera: Motor ``(k,)`` at the stamps.
        twist_rate: ``(k, 6)`` how the camera moves: rad/s and m/s in its own axes.
        pose_of: ``(n,)`` from which pose.
        points: ``(n, 3)`` in the world.

    >>> import numpy as np
    >>> from motorcade.fusion.visual_inertial.readout import rows_later_s, rows_moved_px
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> camera = Camera(640, 481, 500.0, 500.0, 319.5, 240.0)
    >>> to_the_right = np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]])  # m/s, two metres before a wall
    >>> points = np.array([[0.0, -0.96, 2.0], [0.0, 0.0, 2.0], [0.0, 0.96, 2.0]])
    >>> later_s = rows_later_s(camera, camera.project(points), readout_s=0.02)
    >>> rows_moved_px(camera, later_s, Motor.identity((1,)), to_the_right, np.zeros(3, np.int64),
    ...     points)[:, 0].round(6)
    array([ 2.5,  0. , -2.5])
    """
    poses = world_T_camera.inverse().as_matrix()[pose_of]
    at_stamp = (poses[:, :3, :3] @ points[..., None])[..., 0] + poses[:, :3, 3]
    moved = Motor.from_twist(later_s[:, None] * twist_rate[pose_of])
    then = moved.inverse().as_matrix()
    later = (then[:, :3, :3] @ at_stamp[..., None])[..., 0] + then[:, :3, 3]
    shift = camera.project(later, allow_nan=True) - camera.project(at_stamp, allow_nan=True)
    return np.nan_to_num(shift)


def camera_twist_rate(
    world_T_imu: Motor, velocity_m_s: FloatArray, rate_rad_s: FloatArray, camera_T_imu: Motor
) -> FloatArray:
    """How a camera moves ``(k, 6)``, from velocity in the world and rate of the IMU it sits on."""
    forward = world_T_imu.rotor.inverse().apply(velocity_m_s)
    twist = np.concatenate([rate_rad_s, forward], axis=-1)
    return twist @ camera_T_imu.adjoint().T
