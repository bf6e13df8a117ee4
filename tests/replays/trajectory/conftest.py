"""An estimate, its ground truth and a transform as files, for the command on trajectories."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.trajectories import even_stamps, write_trajectory


def path(rng: np.random.Generator, count: int = 300, rate_hz: float = 30.0) -> Trajectory:
    """A smooth path that turns and climbs."""
    t = np.arange(count) / rate_hz
    place = np.stack([np.cos(t), np.sin(t), 0.3 * t], axis=1) + 0.01 * rng.standard_normal(
        (count, 3)
    )
    turn = np.stack([0.2 * np.sin(t), 0.1 * np.cos(3 * t), t], axis=1)
    start_ns = 1_305_031_098_665_900_000
    return Trajectory(
        even_stamps(count, rate_hz) + start_ns, Motor.from_euler_translation(turn, place)
    )


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
    (tmp_path / "more").mkdir()
    write_trajectory(true, "more/true.txt")
    return tmp_path


def write_transforms(folder: Path) -> Motor:
    made = Motor.from_euler_translation([0.02, 0.01, 0.3], [0.1, -0.2, 0.05])
    (w, *vector), place = (one.tolist() for one in made.as_quaternion_translation())
    names = ("qw", "qx", "qy", "qz", "x", "y", "z")
    given = dict(zip(names, (w, *vector, *place), strict=True))
    (folder / "T.json").write_text(json.dumps(given))
    np.savetxt(folder / "T.txt", made.as_matrix())
    np.save(folder / "T.npy", made.as_matrix())
    return made
