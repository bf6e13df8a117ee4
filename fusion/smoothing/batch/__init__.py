"""Smoothers that see the whole path at once: least-squares splines and robust estimation."""

from __future__ import annotations

from motorcade.fusion.smoothing.batch.robust_map import RobustPath, estimate_path, robust_map
from motorcade.fusion.smoothing.batch.spline import spline

__all__ = ["RobustPath", "estimate_path", "robust_map", "spline"]
