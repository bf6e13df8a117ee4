"""Clips taken apart into shots: cuts, fades, black and repeated frames, what the camera does."""

from __future__ import annotations

from motorcade.tracking.shots.camera_motion import CameraMotion
from motorcade.tracking.shots.finding import find_shots
from motorcade.tracking.shots.shot import ClipShot, ShotBreak, Shots

__all__ = ["CameraMotion", "ClipShot", "ShotBreak", "Shots", "find_shots"]
