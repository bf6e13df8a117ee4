"""What a trajectory is at a glance: how long in time and space, how fast, how even."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.stamps import near_steps


@dataclass(frozen=True)
class TrajectorySummary:
    """Figures of one trajectory; those of steps are None for a single pose.

    Fields:
        parent, child: the two frames; poses are ``parent_T_child``.
        poses: how many.
        start_ns, end_ns: first and last stamp.
        duration_s: seconds in between.
        path_length_m: sum of the distances from pose to pose.
        turned_deg: sum of the angles from pose to pose.
        first_m, last_m: first and last position.
        lowest_m, highest_m: least and largest coordinates.
        step_min_s, step_mean_s, step_max_s: time from pose to pose.
        gaps: steps of more than three median ones.
        speed_min_m_s, speed_mean_m_s, speed_max_m_s: distance by time, from pose to pose.
        turning_max_deg_s: the largest angle by time.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.replays.tasks.editing import TrajectorySummary
        >>> path = Trajectory(10**9 * np.arange(2), Motor.from_translation([[0, 0, 0], [3, 4, 0]]))
        >>> found = TrajectorySummary.of(path)
        >>> found.path_length_m, found.speed_mean_m_s
        (5.0, 5.0)
    """

    parent: str
    child: str
    poses: int
    start_ns: int
    end_ns: int
    duration_s: float
    path_length_m: float
    turned_deg: float
    first_m: tuple[float, ...]
    last_m: tuple[float, ...]
    lowest_m: tuple[float, ...]
    highest_m: tuple[float, ...]
    step_min_s: float | None = None
    step_mean_s: float | None = None
    step_max_s: float | None = None
    gaps: int = 0
    speed_min_m_s: float | None = None
    speed_mean_m_s: float | None = None
    speed_max_m_s: float | None = None
    turning_max_deg_s: float | None = None

    @classmethod
    def of(cls, trajectory: Trajectory) -> TrajectorySummary:
        """The figures of a trajectory; of similarities, those of the rigid part."""
        path = trajectory.rigid
        place, steps_ns = path.motors.translation_m, np.diff(path.time_ns)
        far = np.linalg.norm(np.diff(place, axis=0), axis=1)
        turned = np.rad2deg((path.motors.rotor[:-1].inverse() @ path.motors.rotor[1:]).angle())
        known: dict[str, Any] = {}
        if steps_ns.size:
            step_s = steps_ns * 1e-9
            speed = far / step_s
            known = {
                "step_min_s": float(step_s.min()),
                "step_mean_s": float(step_s.mean()),
                "step_max_s": float(step_s.max()),
                "gaps": int(np.count_nonzero(~near_steps(steps_ns))),
                "speed_min_m_s": float(speed.min()),
                "speed_mean_m_s": float(speed.mean()),
                "speed_max_m_s": float(speed.max()),
                "turning_max_deg_s": float((turned / step_s).max()),
            }
        return cls(
            parent=path.parent,
            child=path.child,
            poses=len(path),
            start_ns=int(path.time_ns[0]),
            end_ns=int(path.time_ns[-1]),
            duration_s=path.duration_s,
            path_length_m=float(far.sum()),
            turned_deg=float(turned.sum()),
            first_m=_triple(place[0]),
            last_m=_triple(place[-1]),
            lowest_m=_triple(place.min(axis=0)),
            highest_m=_triple(place.max(axis=0)),
            **known,
        )

    def as_dict(self) -> dict[str, Any]:
        """The figures ready for JSON."""
        return asdict(self)


def _triple(values: Any) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
