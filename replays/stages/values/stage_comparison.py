"""Whether each stage of a run made the path better or worse than what it was given."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

JudgedBy = Literal["ground truth", "held-out poses", "nothing"]


@dataclass(frozen=True)
class StageComparison:
    """How far the path is from what it is judged by, after each stage, on the same stamps.

    Fields:
        judged_by: the ground truth; without one, measured poses that the path was made without.
        poses: at how many stamps.
        position_rmse_m, rotation_rmse_deg: by stage: camera_poses, fused, smoothed. What poses are
            held out have errors of their own, which are in these figures.
        worse: a sentence for each stage whose path is farther off than the one before, and why.

    >>> from motorcade.replays.stages.values.stage_comparison import StageComparison
    >>> found = StageComparison("nothing", 0, {}, {}, ())
    >>> found.as_dict()["worse"]
    []
    """

    judged_by: JudgedBy
    poses: int
    position_rmse_m: dict[str, float]
    rotation_rmse_deg: dict[str, float]
    worse: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The same, ready for JSON."""
        return asdict(self) | {"worse": list(self.worse)}


NOT_COMPARED = StageComparison("nothing", 0, {}, {}, ())
"""What is told where there is nothing to judge by."""
