"""Camera and IMU calibrated together from a recording of a board, as Kalibr does it.

Unlike `motorcade.fusion.sync`, which takes poses as they are, this uses what is known of a board's
images: how sure each pose is, and how the camera's intrinsics move them all.
"""

from __future__ import annotations

from motorcade.fusion.camera_imu.calibrate import CameraImuCalibration, calibrate_camera_imu

__all__ = ["CameraImuCalibration", "calibrate_camera_imu"]
