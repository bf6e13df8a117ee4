"""Trajectories of files and bags edited, summed up, and written under names of their own."""

from __future__ import annotations

from motorcade.replays.tasks.editing.edits import TrajectoryEdits, edit_trajectories
from motorcade.replays.tasks.editing.summary import TrajectorySummary

__all__ = ["TrajectoryEdits", "TrajectorySummary", "edit_trajectories"]
