"""A run as a USD stage."""

from __future__ import annotations

from motorcade.replays.pipeline.export.usd.stage import write_usd

__all__ = ["write_usd"]
