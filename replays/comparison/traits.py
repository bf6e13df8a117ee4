"""What a method in a representation is on any path: its cost, and its frame-change defect.

Ties that theory predicts, shown in figures: the largest difference over a path, and its bound.

They hold for every path; all other ties depend on chance and on the data. Kalman filters on motors
and similarities have no such ties in rotation: they propagate the errors of rotation, translation
and scale together, so that each affects the others. Splines fitted to motors weigh rotations and
translations in one sum of squares.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.fusion.metrics import frame_change_defect, seconds_per_pose
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor, Trajectory, blend
from motorcade.replays.comparison.cells import Setting, inputs_of, why
from motorcade.replays.comparison.truth import RecordedMotion

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
    fields: dict[str, str | int | float] = {
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
        return fields | {"failure": why(error)}
    return fields | {
        "left_defect_m": defect.left_m,
        "left_defect_rad": defect.left_rad,
        "right_defect_m": defect.right_m,
        "right_defect_rad": defect.right_rad,
        "time_us_per_pose": 1e6 * time_s,
        "failure": "",
    }


_BOUND = 1e-9
_ONE_BY_ONE = (
    "exponential",
    "double_exponential",
    "one_euro",
    "gaussian",
    "savitzky_golay",
    "local_polynomial",
)
_TWISTS = (*_ONE_BY_ONE, "spline")
_POSITIONS_APART = (
    *_TWISTS,
    "constant_velocity",
    "constant_acceleration",
    "rts_constant_velocity",
    "rts_constant_acceleration",
)


def exact_ties() -> list[dict[str, Any]]:
    """Every tie with what theory says and what was measured on a noisy path of 300 poses."""
    path = _noisy("walk_and_look")
    rows = [
        _tie_row(
            "the linear blend of rigid motors is the dual quaternion linear blend",
            "motor coefficients and dual quaternions are the same eight numbers up to order and "
            "sign, and both are projected to the nearest unit one",
            "gaussian of order 0",
            ("motors blended", "dual_quaternion"),
            _apart(
                _blended(path, 0.1),
                smooth(path, "gaussian", "dual_quaternion", sigma_s=0.1, order=0),
            ),
        )
    ]
    for method in _POSITIONS_APART:
        smoothed = _cached(path, method)
        for theory, reason, first, second, which, methods in _LAWS:
            if method not in methods:
                continue
            try:
                metres, radians = _apart(smoothed(first), smoothed(second))
            except Exception as error:  # one failing method never ends the others; its row says why
                row = _tie_row(theory, reason, method, (first, second), (None, None))
                rows.append(row | {"holds": False, "failure": why(error)})
                continue
            costs = (
                metres if which != "rotation" else None,
                radians if which != "position" else None,
            )
            rows.append(_tie_row(theory, reason, method, (first, second), costs))
    return rows


_LAWS = (
    (
        "similarity equals motor on rigid paths",
        "with scale 1 a similarity's logarithm is the motor's twist and a zero",
        "similarity",
        "motor",
        "both",
        _TWISTS,
    ),
    (
        "motor and rotor give the same orientations",
        "the turning part of twists composes without regard to translations",
        "motor",
        "rotor",
        "rotation",
        _ONE_BY_ONE,
    ),
    (
        "rotor and quaternion give the same positions",
        "both carry translations beside the rotation, in the world",
        "rotor",
        "quaternion",
        "position",
        _POSITIONS_APART,
    ),
    (
        "quaternion and Euler angles give the same positions",
        "both carry translations beside the rotation, in the world",
        "quaternion",
        "euler",
        "position",
        _POSITIONS_APART,
    ),
)


def _noisy(motion: str) -> Trajectory:
    clean = MOTIONS[motion].sampled(30.0, 10.0)
    return Gaussian(0.005, float(np.deg2rad(0.5))).apply(clean, np.random.default_rng(20240229))


def _cached(path: Trajectory, method: str) -> Callable[[str], Trajectory]:
    paths: dict[str, Trajectory] = {}

    def smoothed(representation: str) -> Trajectory:
        if representation not in paths:
            paths[representation] = smooth(path, method, representation)
        return paths[representation]

    return smoothed


def _blended(path: Trajectory, sigma_s: float) -> Trajectory:
    """Every pose a blend of motors within four deviations, with Gaussian weights."""
    poses = []
    for now_ns in path.time_ns:
        near = np.abs(path.time_ns - now_ns) <= round(4e9 * sigma_s)
        offset = (path.time_ns[near] - now_ns) * 1e-9 / sigma_s
        poses.append(blend(path.motors[near], np.exp(-0.5 * offset**2)))
    return Trajectory(path.time_ns, Motor.stack(poses), path.parent, path.child)


def _apart(first: Trajectory, second: Trajectory) -> tuple[float, float]:
    shift = np.linalg.norm(first.motors.translation_m - second.motors.translation_m, axis=-1)
    turn = (first.motors.rotor.inverse() @ second.motors.rotor).angle()
    return float(np.max(shift)), float(np.max(turn))


def _tie_row(
    theory: str,
    reason: str,
    method: str,
    names: tuple[str, str],
    differences: tuple[float | None, float | None],
) -> dict[str, Any]:
    return {
        "theory": theory,
        "reason": reason,
        "method": method,
        "first": names[0],
        "second": names[1],
        "largest_difference_m": differences[0],
        "largest_difference_rad": differences[1],
        "bound": _BOUND,
        "holds": all(value is None or value <= _BOUND for value in differences),
        "failure": "",
    }
