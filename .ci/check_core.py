"""What an installed wheel must do on every system with NumPy alone: compiled kernels, smoothing."""

import sys
import tempfile
from pathlib import Path

import numpy as np

import motorcade.ga as ga
from motorcade.fusion import LiveSmoother, smooth
from motorcade.replays import read_trajectory, write_trajectory


def main() -> None:
    """Move poses by kernels, smooth them, write and read them, and say what was tried."""
    assert ga.kernels.backend == "compiled", ga.kernels.backend
    turns = ga.Rotor.from_rotation_vector(np.random.default_rng(1).normal(size=(1000, 3)))
    motors = ga.Motor.from_rotor_translation(turns, np.ones((1000, 3)))
    there_and_back = (motors @ motors.inverse()).as_matrix()
    assert np.abs(there_and_back - np.eye(4)).max() < 1e-14
    times_ns = np.arange(100) * 33_000_000
    along = np.linspace(0.0, 1.0, 100)[:, None] * [1.0, 0.0, 0.0]
    path = ga.Trajectory(times_ns, ga.Motor.from_translation(along), "world", "camera")
    with tempfile.TemporaryDirectory() as folder:
        write_trajectory(smooth(path), Path(folder) / "smooth.tum")
        again = read_trajectory(Path(folder) / "smooth.tum")
    assert np.abs(again.motors.translation_m - along).max() < 1e-6
    LiveSmoother().update(0.0, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
    print(f"the core works on {sys.platform}, Python {sys.version.split()[0]}")


main()
