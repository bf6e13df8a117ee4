"""Clips taken apart into shots: cuts, fades, black and repeated frames, what the camera does."""

from __future__ import annotations

from motorcade.tracking.shots.camera_motion import CameraMotion
from motorcade.tracking.shots.finding import ClipShot, Shots, find_shots

__all__ = ["CameraMotion", "ClipShot", "Shots", "find_shots"]
