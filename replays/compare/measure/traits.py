"""What a method in a representation is on any path: its cost, and its frame-change defect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics import frame_change_defect, seconds_per_pose
from motorcade.ga import Motor, Trajectory
from motorcade.replays.compare.cells import Setting, inputs_of, why
from motorcade.replays.compare.measure.truth import RecordedMotion

_FRAMES_SEED = 20240229


@dataclass(frozen=True)
class Trait:
    """A setting, and the cell whose poses it is tried on."""

    motion: str
    degradation: str
    seed: int
    rate_hz: float
    duration_s: float
    setting: Setting
    recorded: RecordedMotion | None = None


def run_trait(trait: Trait) -> dict[str, str | int | float]:
    """`measured_trait` on the poses of a cell."""
    degraded, _ = inputs_of(
        trait.motion,
        trait.degradation,
        trait.seed,
        trait.rate_hz,
        trait.duration_s,
        trait.recorded,
    )
    return measured_trait(trait.setting, degraded)


def measured_trait(setting: Setting, path: Trajectory) -> dict[str, str | int | float]:
    """Largest difference between smoothing first and changing the frame first, and the time.

    The world's frame (left) and the sensor's (right) are changed by motors of any turn, with
    shifts of about a metre. The time is that of the fastest of three runs, a pose, called from
    Python.
    """
    made: dict[str, str | int | float] = {
        "method": setting.method,
        "representation": setting.representation,
        "poses": len(path),
    }
    rng = np.random.default_rng(_FRAMES_SEED)
    left, right = Motor.random(rng), Motor.random(rng)
    try:
        defect = frame_change_defect(setting.smooth, path, left, right)
        time_s = seconds_per_pose(setting.smooth, path)
    except Exception as error:  # one failing method never ends the others; its row says why
        return made | {"failure": why(error)}
    return made | {
        "left_defect_m": defect.left_m,
        "left_defect_rad": defect.left_rad,
        "right_defect_m": defect.right_m,
        "right_defect_rad": defect.right_rad,
        "time_us_per_pose": 1e6 * time_s,
        "failure": "",
    }
