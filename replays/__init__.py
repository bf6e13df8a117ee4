"""Recordings in and out, the stage graph and its pipeline, reports, and the command line.

Conventions:

* **Frames.** A pose is named by what it maps: ``world_T_camera`` takes camera coordinates to the
  world's. Cameras have OpenCV's axes (x right, y down, z forward); worlds are right-handed with z
  up, where anything tells which way up is.
* **Units.** Metres, radians, seconds; stamps are integer nanoseconds. Units end the names of knobs
  and of keys in reports (``window_s``, ``ape_rmse_m``).
* **Untrusted files.** What does not fit is refused by a `RecordingError` of one line that names the
  file, the line or field, what was expected and what was found.

Reading and writing trajectories needs NumPy alone; names are imported when they are first used.

Write a path of the camera as a TUM file, and read it back to the last digit:

>>> import tempfile
>>> from pathlib import Path
>>> import numpy as np
>>> from motorcade.ga import Motor, Trajectory
>>> from motorcade.replays import read_trajectory, write_trajectory
>>> world_T_camera = Motor.from_translation([[0.0, 0.0, 1.5], [0.1, 0.0, 1.5]])
>>> path = Trajectory(np.array([0, 50_000_000]), world_T_camera, "world", "camera")
>>> with tempfile.TemporaryDirectory() as folder:
...     write_trajectory(path, Path(folder) / "path.tum")
...     again = read_trajectory(Path(folder) / "path.tum")
>>> np.array_equal(again.motors.coefficients, world_T_camera.coefficients)
True

`run_job` does what ``motorcade run`` does: it opens a recording, runs the stages of
`pipeline_graph` as far as they are needed, and leaves trajectories, a video and a report:

>>> from motorcade.replays import pipeline_graph
>>> pipeline_graph().needed("smoothed")[-3:]
('imu', 'fused', 'smoothed')

Sub-packages, from the bottom up: `io` (recordings and files), `engine` (the graph of stages) and
`web` (pages); `stages` with the values that they hand on; `pipeline` (the run and its report);
`comparison`, `tasks`, `studio`, `demo`; `cli`.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
