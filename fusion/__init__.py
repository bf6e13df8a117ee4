"""Fusion room: inertial data, filters, smoothers and metrics, from measurements to trajectories.

Poses are ``world_T_camera`` or ``world_T_imu``, worlds have z up, an accelerometer at rest reads
+g upward. Import from the rooms below: ``motorcade.fusion.imu``, ``.filter``, ``.smooth``,
``.motions``, ``.metrics``.
"""
