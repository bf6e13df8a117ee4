"""Camera and IMU brought together: time offset and extrinsics estimated from what both recorded."""

from __future__ import annotations

from motorcade.fusion.sync.synchronise import Synchronised, synchronise

__all__ = ["Synchronised", "synchronise"]
