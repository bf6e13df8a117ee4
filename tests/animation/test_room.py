"""The room's door: what it brings can be had from it, and nothing heavy comes along."""

from __future__ import annotations

import subprocess
import sys

import motorcade.animation as room


def test_every_name_is_there():
    assert sorted(room.__all__) == sorted(set(room.__all__))
    for name in room.__all__:
        assert callable(getattr(room, name)), name


def test_nothing_heavy_is_imported():
    heavy = ("scipy", "skimage", "cv2", "torch", "casadi", "PIL", "matplotlib")
    code = f"import sys, motorcade.animation; print([m for m in {heavy} if m in sys.modules])"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "[]"
