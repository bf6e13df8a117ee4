"""Files that the command `trajectory` is tried on."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.replays.files.trajectories import even_stamps


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


def write_transforms(folder: Path) -> Motor:
    made = Motor.from_euler_translation([0.02, 0.01, 0.3], [0.1, -0.2, 0.05])
    (w, *vector), place = (one.tolist() for one in made.as_quaternion_translation())
    names = ("qw", "qx", "qy", "qz", "x", "y", "z")
    given = dict(zip(names, (w, *vector, *place), strict=True))
    (folder / "T.json").write_text(json.dumps(given))
    np.savetxt(folder / "T.txt", made.as_matrix())
    np.save(folder / "T.npy", made.as_matrix())
    return made
