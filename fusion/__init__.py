"""Fusion room: inertial data, filters, smoothers and metrics, from measurements to trajectories.

Poses are ``world_T_camera`` or ``world_T_imu``, worlds have z up, an accelerometer at rest reads
+g upward. `smooth` is the function that smooths a trajectory in one line; it stands before the room
of that name, which is imported from all the same. Import the rest from the rooms below:
``motorcade.fusion.imu``, ``.filter``, ``.graph``, ``.preintegration``, ``.sync``,
``.visual_inertial``, ``.orientation``, ``.smooth``, ``.motions``, ``.metrics``.
"""

from __future__ import annotations

from motorcade.fusion.smoothing import smooth

__all__ = ["smooth"]
