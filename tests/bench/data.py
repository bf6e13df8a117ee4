"""Where the recordings and rigs lie that benchmarks measure on, if they are there at all."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["data_folder"]


def data_folder() -> Path:
    """The folder that ``MOTORCADE_DATA`` names, or else ``../shared/data``; it may not exist."""
    return Path(os.environ.get("MOTORCADE_DATA") or "../shared/data")
