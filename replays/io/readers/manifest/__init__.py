"""Manifests: TOML files that describe recordings; one file a table, put together in `reading`."""

from __future__ import annotations

from motorcade.replays.io.readers.manifest.reading import (
    DEPTH_CAMERA_KEYS,
    FRAMES_KEYS,
    LOCAL_NAME,
    STEREO_KEYS,
    read,
)
from motorcade.replays.io.readers.manifest.sensors import IMU_KEYS

__all__ = ["DEPTH_CAMERA_KEYS", "FRAMES_KEYS", "IMU_KEYS", "LOCAL_NAME", "STEREO_KEYS", "read"]
