"""The manifests among the examples: every one is right, and one of them names every key."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers import manifest
from motorcade.replays.io.readers.manifest.section import BOARD_KEYS, CAMERA_KEYS, MARKERS_KEYS
from motorcade.replays.io.readers.manifest.sensors import TRUTH_KEYS
from motorcade.replays.io.readers.opening import open_recording

Make = Callable[..., Any]
FOLDER = Path(__file__).parents[3] / "docs" / "manifests"
CASTS = {"every_cast_key"}
"""Examples that are no manifests; see tests/replays/characters/test_cast.py."""
EXAMPLES = sorted(path for path in FOLDER.glob("*.toml") if path.stem not in CASTS)


def refusal_of(act: Callable[[], object]) -> str:
    """What an action is refused with; "" where it is not."""
    try:
        act()
    except RecordingError as refused:
        return str(refused)
    return ""


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_has_known_keys_only(make: Make, path: Path) -> None:
    made = make("folder")
    tables = tomllib.loads(path.read_text())
    assert {"frames", "camera", "truth"} & set(tables)
    message = refusal_of(lambda: open_recording(made.root, path))
    assert "unknown key" not in message
    assert "expected one of" not in message


def test_the_example_of_every_key_opens_and_names_every_key(make: Make) -> None:
    made = make("folder")
    example = next(path for path in EXAMPLES if path.stem == "every_key")
    (made.root / "right").mkdir()
    for index in range(12):
        for side in ("images", "right"):
            cv2.imwrite(str(made.root / side / f"{index}.png"), np.zeros((480, 752), np.uint8))
    (made.root / "truth.txt").write_text("1 1 2 3 0 0 0 1\n")
    (made.root / "imu.csv").write_text("0,1,1,1,1,1,1\n5,1,1,1,1,1,1\n")
    (made.root / "imu.yaml").write_text(
        "gyroscope_noise_density: 0.1\ngyroscope_random_walk: 0.1\n"
        "accelerometer_noise_density: 0.1\naccelerometer_random_walk: 0.1\n"
    )
    recording = open_recording(made.root, example)
    assert recording.truth is not None
    assert recording.imu_noise is not None
    text = example.read_text()
    boards = {key for keys in BOARD_KEYS.values() for key in keys}
    assert recording.markers is not None
    assert recording.markers.side_m == 0.08
    known = {
        *manifest.FRAMES_KEYS,
        *MARKERS_KEYS,
        *CAMERA_KEYS,
        *manifest.IMU_KEYS,
        *manifest.STEREO_KEYS,
        *manifest.DEPTH_CAMERA_KEYS,
        *TRUTH_KEYS,
        *boards,
    }
    assert {key for key in known if key not in text} == set()
