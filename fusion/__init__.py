"""From measurements to trajectories: inertial sensors, filters, smoothers and what they are worth.

Frames: ``world_T_camera`` and ``world_T_imu`` map coordinates of the camera, of the IMU to those of
the world, whose z points up; ``imu_T_camera`` are the extrinsics, so that
``world_T_imu @ imu_T_camera`` is the camera's pose. An accelerometer at rest reads +g, upwards.
Errors and covariances ``(6, 6)`` stand on the right of a pose, in the moving frame, rotation first.

Units: metres, radians, seconds, rad/s and m/s²; stamps are integer nanoseconds. Noise densities are
continuous, in Kalibr's units.

A camera's noisy poses, fused with what an IMU beside it read, and what that was worth:

>>> import numpy as np
>>> from motorcade import fusion
>>> from motorcade.ga import Motor, Rotor
>>> rng = np.random.default_rng(0)
>>> imu_T_camera = Motor.from_rotor_translation(Rotor.identity(), [0.05, 0.0, 0.0])
>>> path = fusion.ContinuousPath.along(fusion.motions.handheld(rng), 5.0)  # world_T_imu
>>> sensor = fusion.simulate_imu(path, 200.0, fusion.ADIS16448, rng)
>>> true = sensor.path.transformed_by(right=imu_T_camera, child="camera")  # world_T_camera
>>> measured = fusion.simulate_camera_poses(true, 20.0, sigma_m=0.02, sigma_rad=0.02, rng=rng)
>>> fused = fusion.fuse(measured, sensor.stream, fusion.ADIS16448, imu_T_camera)
>>> fused.trajectory
Trajectory(world_T_camera, 101 poses, 5.000 s)
>>> for found in (measured.trajectory, fused.trajectory):
...     print(f"{1e3 * fusion.evaluate(found, true).ape_m.rmse:.0f} mm")
33 mm
6 mm

What is here is used most; the packages below hold the rest, such as `motorcade.fusion.metrics` and
`motorcade.fusion.smoothing.causal`. Everything loads when it is first used.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
