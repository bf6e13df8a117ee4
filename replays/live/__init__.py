"""Poses while it is filmed: frames that come, trackers that keep up, a page that draws on them."""

from motorcade.replays.live.frames import LiveFrame, newest, open_frames
from motorcade.replays.live.tracker import LivePose, LiveTracker

__all__ = ["LiveFrame", "LivePose", "LiveTracker", "newest", "open_frames"]
