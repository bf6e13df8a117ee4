"""Manifests that say what took the depth: it is registered as it is read."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from motorcade.replays.tasks.inspection import describe
from tests.replays.readers.test_manifests import CAMERA, FRAMES, described

Make = Callable[..., Any]

TABLE = "[depth_camera]\nfx = 10.0\nfy = 10\ncx = 5.5\ncy = 3.5\n"
ASIDE = "colour_T_depth = [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
DEPTH = FRAMES + 'depth = "depth/*.png"\ndepth_units_per_m = 1000\n'


def half_as_fine(make: Make) -> Path:
    """Half as many pixels as the images have, 2 m everywhere."""
    root: Path = make("folder").root
    (root / "depth").mkdir()
    for index in range(len(list((root / "images").iterdir()))):
        stored = np.full((8, 12), 2000, np.uint16)
        cv2.imwrite(str(root / "depth" / f"{index}.png"), stored)
    return root


def test_depth_on_its_own_pixels_is_registered(make: Make) -> None:
    recording = described(half_as_fine(make), DEPTH, CAMERA, TABLE, ASIDE)
    recording.check()
    depth_m = recording.frames[0].depth_m()
    assert depth_m is not None
    assert depth_m.shape == (16, 24)
    assert np.nanmedian(depth_m) == 2.0
    # The sensor stands 0.1 m to the right: at 2 m its left rim is 20 * 0.1 / 2 = 1 px in.
    known = np.flatnonzero(np.isfinite(depth_m[8]))
    assert known[0] == pytest.approx(11.5 + 20.0 * (0.1 / 2.0 - 6.0 / 10.0), abs=1.0)
    about = describe(recording)
    assert about["depth_image_size_px"] == [12, 8]
    assert about["depth_position_m"] == pytest.approx([0.1, 0.0, 0.0])


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ((FRAMES, CAMERA, TABLE, ASIDE), "expected depth images, got none; say"),
        ((DEPTH, TABLE, ASIDE), r"expected a \[camera\] to register depth to"),
        ((DEPTH, CAMERA, TABLE), "colour_T_depth: the key is missing"),
        ((DEPTH, CAMERA, TABLE.replace("10.0", "0.01"), ASIDE), "at least a 64th"),
    ],
)
def test_what_is_missing_is_named(make: Make, tables: tuple[str, ...], message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        described(half_as_fine(make), *tables)


def test_depth_of_another_size_asks_for_its_camera(make: Make) -> None:
    recording = described(half_as_fine(make), DEPTH, CAMERA)
    with pytest.raises(RecordingError, match=r"\[depth_camera\] in a manifest"):
        recording.check()
