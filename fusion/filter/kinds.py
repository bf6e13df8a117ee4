"""Names of the measurements that the compiled filter knows, and its numbers for them."""

from __future__ import annotations

__all__ = ["KINDS"]

KINDS = {"camera_pose": 1, "imu_pose": 2, "position": 3, "velocity": 4, "corners": 5}
