"""What the tests of several commands ask for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.replays.files.trajectories import write_trajectory
from tests.replays.commands.trajectory_files import path, write_transforms


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> Path:
    """An estimate, its ground truth, and a transform in three kinds of file; the current folder."""
    monkeypatch.chdir(tmp_path)
    true = path(rng)
    write_trajectory(true, "true.txt")
    off = Motor.from_euler_translation([0.3, -0.2, 0.1], [1.0, 2.0, 3.0])
    late = Trajectory(true.time_ns[5::2] + 2_000_000, true.motors[5::2])
    write_trajectory(late.transformed_by(off), "estimate.txt")
    write_transforms(tmp_path)
    return tmp_path
