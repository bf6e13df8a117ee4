"""Commands on cameras and inertial sensors: detection, calibration, noise, time."""
