"""What smoothing invents: detours and turns, overshoot, and answers that depend on the frame.

Frame-change defect: is smoothed motion the same in another world, with other extrinsics?

A smoother that is one of motions, not of numbers, commutes with a change of the world's frame
(left, ``L pose``) and of the sensor's (right, ``pose R``). The defect is how far smoothing first
and changing the frame first are apart.

Gimbal index: how much more, how much faster and how often an estimate turns than the ground truth.

What smoothing or interpolating Euler angles does near gimbal lock shows here: detours, bursts of
speed, and full revolutions that never happened. All three are 1, 1 and 0 for a perfect estimate,
and do not depend on the frames.

Overshoot: how far an estimate runs on where the ground truth stops or turns back.

A stop or turn is a local minimum of the ground truth's speed (linear, or angular) that lies below a
fifth of the speed's peaks on both sides; the end of the trajectory may stand for the second. The
direction is that of the ground truth's way from the peak before to the minimum. From the peak
before to the peak after, overshoot is the farthest the estimate gets in that direction, less the
farthest the ground truth gets, and never below zero. As whole segments are compared, an estimate
that is merely late has none; noise has some, and so has a constant offset: compare with the raw
poses. For rotations the way is the rotation vector seen from the pose at the minimum. It is the
maximum overshoot of a step response (K. Ogata, Modern Control Engineering), in metres or radians
and for any motion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics.smooth_path import NotObservableError, beside
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True)
class FrameChangeDefect:
    """Largest difference over all poses; left is the world's frame, right the sensor's.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import frame_change_defect
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.ga import Motor
        >>> path, rng = screw().sampled(30.0, 2.0), np.random.default_rng(0)
        >>> map_T_world, camera_T_imu = Motor.random(rng, (2,))
        >>> found = frame_change_defect(lambda given: given, path, map_T_world, camera_T_imu)
        >>> bool(found.left_m < 1e-12)
        True
    """

    left_m: float
    left_rad: float
    right_m: float
    right_rad: float


def frame_change_defect(
    smoother: Callable[[Trajectory], Trajectory],
    trajectory: Trajectory,
    left: Motor | Similarity,
    right: Motor | Similarity,
) -> FrameChangeDefect:
    """Smooth then change the frame, against change the frame then smooth, each side for itself.

    Args:
        smoother: what is judged; it must answer at the same stamps for both.
        trajectory: what it is judged on.
        left: change of the world's frame; `Motor.random` gives one of any orientation. With a
            similarity the differences are in the new world's metres.
        right: change of the sensor's frame.

    Raises:
        ValueError: a smoother whose stamps depend on the frame.

    Examples:
        >>> from functools import partial
        >>> import numpy as np
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import frame_change_defect
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.ga import Motor
        >>> path, rng = screw().sampled(30.0, 2.0), np.random.default_rng(0)
        >>> map_T_world, camera_T_imu = Motor.random(rng, (2,))
        >>> for representation in ("motor", "euler"):
        ...     smoother = partial(smooth, method="gaussian", representation=representation)
        ...     found = frame_change_defect(smoother, path, map_T_world, camera_T_imu)
        ...     print(f"{representation} {found.left_rad:.2f} rad")
        motor 0.00 rad
        euler 0.03 rad
    """
    smoothed = smoother(trajectory)

    def defect(change: Callable[[Trajectory], Trajectory]) -> tuple[float, float]:
        return _apart(change(smoothed), smoother(change(trajectory)))

    of_world = defect(lambda path: path.transformed_by(left))
    of_sensor = defect(lambda path: path.transformed_by(right=right))
    return FrameChangeDefect(*of_world, *of_sensor)


def _apart(first: Trajectory, second: Trajectory) -> tuple[float, float]:
    if not np.array_equal(first.time_ns, second.time_ns):
        raise ValueError(
            f"smoother: expected the same stamps in every frame, got {len(first)} and "
            f"{len(second)} poses at stamps that differ"
        )
    shift = first.poses.translation_m - second.poses.translation_m
    turn = first.poses.rotor.inverse() @ second.poses.rotor
    return float(np.max(np.linalg.norm(shift, axis=-1))), float(np.max(turn.angle()))


# Within this angle (a quarter of a turn) of the ground truth an estimate is at home again.
_HOME_COSINE = float(np.cos(0.25 * np.pi))
_STILL_RAD = 1e-9


@dataclass(frozen=True)
class GimbalIndex:
    """An estimate's rotation beside the ground truth's, at the estimate's stamps.

    Fields:
        path_ratio: length of the path of orientations (sum of the angles between neighbours) over
            the ground truth's; noise lengthens it too.
        peak_rate_ratio: largest angular rate from stamp to stamp over the ground truth's largest.
        spurious_turns: full revolutions that the estimate makes and the ground truth does not: how
            often the error, followed continuously, left the ground truth and came back to within
            90° of it after going all the way round. Noise of less than half a turn makes none.

    Examples:
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import gimbal_index
        >>> from motorcade.fusion.motions import tumble
        >>> true = tumble().sampled(100.0, 4.0)
        >>> blurred = smooth(true, "gaussian", "euler", sigma_s=0.2)  # angles leap at ±180°
        >>> found = gimbal_index(blurred, true)
        >>> found.peak_rate_ratio > 2.0, found.spurious_turns > 0
        (True, True)
    """

    path_ratio: float
    peak_rate_ratio: float
    spurious_turns: int


def gimbal_index(estimate: Trajectory, truth: Trajectory) -> GimbalIndex:
    """Compare the turning of two trajectories; steps must turn by less than half a turn.

    Stamps that the ground truth does not cover are left out.

    Raises:
        NotObservableError: fewer than two stamps within the ground truth, or one that does not
            turn.

    Examples:
        >>> from motorcade.fusion.metrics import gimbal_index
        >>> from motorcade.fusion.motions import tumble
        >>> true = tumble().sampled(100.0, 4.0)
        >>> found = gimbal_index(true, true)
        >>> round(found.path_ratio, 3), round(found.peak_rate_ratio, 3), found.spurious_turns
        (1.0, 1.0, 0)
    """
    path, true_path = beside(estimate, truth, 2, "gimbal index")
    ours, true = path.motors.rotor, true_path.motors.rotor
    steps_s = 1e-9 * np.diff(path.time_ns)
    turned, true_turned = steps_rad(ours), steps_rad(true)
    length = float(np.sum(true_turned))
    if length <= _STILL_RAD:
        raise NotObservableError(
            "gimbal index: expected a ground truth that turns, got one that does not"
        )
    return GimbalIndex(
        path_ratio=float(np.sum(turned)) / length,
        peak_rate_ratio=float(np.max(turned / steps_s) / np.max(true_turned / steps_s)),
        spurious_turns=winding_count(true.inverse() @ ours),
    )


def rotation_path_rad(rotors: Rotor) -> float:
    """Length of a path of orientations ``(N,)``: the sum of the angles between neighbours.

    Examples:
        >>> from motorcade.fusion.metrics.artifacts import rotation_path_rad
        >>> from motorcade.ga import Rotor
        >>> rotors = Rotor.from_euler([[0.0, 0.0, 0.0], [0.0, 0.0, 0.9], [0.0, 0.0, 0.6]])
        >>> round(rotation_path_rad(rotors), 6)
        1.2
    """
    return float(np.sum(steps_rad(rotors)))


def path_over_geodesic(rotors: Rotor) -> float:
    """Length of a path of orientations ``(N,)`` over the angle between its ends; 1 is shortest.

    Raises:
        NotObservableError: ends of the same orientation.

    Examples:
        >>> from motorcade.fusion.metrics.artifacts import path_over_geodesic
        >>> from motorcade.ga import Rotor
        >>> rotors = Rotor.from_euler([[0.0, 0.0, 0.0], [0.0, 0.0, 0.9], [0.0, 0.0, 0.6]])
        >>> round(path_over_geodesic(rotors), 6)
        2.0
    """
    geodesic = float((rotors[0].inverse() @ rotors[-1]).angle())
    if geodesic <= _STILL_RAD:
        raise NotObservableError("path over geodesic: expected ends that differ, got equal ones")
    return rotation_path_rad(rotors) / geodesic


def steps_rad(rotors: Rotor) -> FloatArray:
    """Angles ``(*, N-1)`` between neighbours of orientations ``(*, N)``."""
    return (rotors[..., :-1].inverse() @ rotors[..., 1:]).angle()


def winding_count(error: Rotor) -> int:
    """How often the error's rotor, followed continuously, goes from near 1 to near -1 or back."""
    together = np.sum(error.coefficients[1:] * error.coefficients[:-1], axis=-1)
    signs = np.cumprod(np.concatenate([[1.0], np.where(together < 0.0, -1.0, 1.0)]))
    real = signs * error.coefficients[:, 0]
    home = np.sign(real[np.abs(real) > _HOME_COSINE])
    return int(np.count_nonzero(home[1:] != home[:-1]))


_STOP_SHARE = 0.2
# Speeds below this part of the fastest are standing still.
_STILL_SHARE = 1e-6
# Speeds nearer to each other than this are equal, and the first one counts in every frame.
_TIE = 1e-9

# Way (*, 3) from the first pose to the second, as seen from the first.
Way = Callable[[Motor, Motor], FloatArray]


def position_overshoot_m(estimate: Trajectory, truth: Trajectory) -> float:
    """Largest overshoot of the position in metres; the worlds must be aligned.

    Raises:
        NotObservableError: fewer than five stamps within the ground truth, or one that neither
            stops nor turns back on its way.

    Examples:
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import position_overshoot_m
        >>> from motorcade.fusion.motions import stop_and_go
        >>> true = stop_and_go().sampled(50.0, 8.0)
        >>> late = smooth(true, "double_exponential", cutoff_hz=1.0)
        >>> for path in (late, true):
        ...     print(f"{position_overshoot_m(path, true):.2f} m")
        0.13 m
        0.00 m
    """
    return _overshoot(estimate, truth, position_way)


def rotation_overshoot_rad(estimate: Trajectory, truth: Trajectory) -> float:
    """Largest overshoot of the orientation in radians, in the moving frame of the ground truth.

    Turns between neighbouring peaks of the angular rate must stay below half a turn.

    Raises:
        NotObservableError: as `position_overshoot_m`.

    Examples:
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import rotation_overshoot_rad
        >>> from motorcade.fusion.motions import stop_and_go
        >>> true = stop_and_go().sampled(50.0, 8.0)
        >>> late = smooth(true, "double_exponential", cutoff_hz=1.0)
        >>> print(f"{rotation_overshoot_rad(late, true):.2f} rad")
        0.13 rad
    """
    return _overshoot(estimate, truth, rotation_way)


def position_way(at: Motor, poses: Motor) -> FloatArray:
    """A `Way` in metres, in the world."""
    return poses.translation_m - at.translation_m


def rotation_way(at: Motor, poses: Motor) -> FloatArray:
    """A `Way` in radians, in the first pose's axes."""
    return (at.rotor.inverse() @ poses.rotor).as_rotation_vector()


def _overshoot(estimate: Trajectory, truth: Trajectory, way: Way) -> float:
    path, true_path = beside(estimate, truth, 5, "overshoot")
    seconds = 1e-9 * (path.time_ns - path.time_ns[0])
    overshoot = float(overshoots(path.motors, true_path.motors, seconds, way))
    if np.isnan(overshoot):
        raise NotObservableError(
            "overshoot: expected a ground truth that stops or turns back on its way, got none"
        )
    return overshoot


def overshoots(ours: Motor, true: Motor, time_s: FloatArray, way: Way) -> FloatArray:
    """Largest overshoot ``(*)`` of poses ``(*, N)`` beside true ones ``(N,)``; NaN without any."""
    speed = np.linalg.norm(way(true[:-1], true[1:]), axis=-1) / np.diff(time_s)
    largest = np.full(ours.shape[:-1], np.nan)
    for before, stop, after in stops(speed):
        at, segment = true[stop : stop + 1], slice(before, after + 1)
        course = -way(at, true[before : before + 1])[0]
        length = float(np.linalg.norm(course))
        if length > 0.0:
            farthest = np.max(way(at, true[segment]) @ course)
            over = np.max(way(at, ours[..., segment]) @ course, axis=-1) - farthest
            largest = np.fmax(largest, np.maximum(over / length, 0.0))
    return largest


def stops(speed: FloatArray) -> list[tuple[int, int, int]]:
    """Peak before, minimum and peak after (or the end), for speeds ``(N-1,)`` of steps.

    A minimum follows a peak once the speed is below a fifth of it, and a peak follows a minimum
    once the speed is five times as high again.
    """
    moving = np.where(speed > _STILL_SHARE * float(np.max(speed)), speed, 0.0)
    extremes = [0]
    falling = False
    for i, now in enumerate(moving):
        best = moving[extremes[-1]]
        if falling:
            turned, better = _STOP_SHARE * now > best, now < (1.0 - _TIE) * best
        else:
            turned, better = now < _STOP_SHARE * best, now > (1.0 + _TIE) * best
        if turned:
            extremes.append(i)
            falling = not falling
        elif better:
            extremes[-1] = i
    peaks, stops = extremes[::2], extremes[1::2]
    ends = [*peaks[1:], moving.size]
    return list(zip(peaks, stops, ends, strict=False))
