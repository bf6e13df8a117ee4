"""The digest of a recording covers all of it: caches and sweeps go by it."""

import json
import logging
import re
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import LooseMarkers, Recording
from motorcade.tracking import MapSnapshot, MarkerMap
from tests.replays.conftest import Made

Make = Callable[[str], Made]


def changed(value: Any) -> Any:
    """Another value of the same kind, by as little as it can be."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, Motor):
        return value @ Motor.from_translation([0.0, 0.0, 2.0**-40])
    if isinstance(value, Rotor):
        return value @ Rotor.from_rotation_vector([0.0, 0.0, 2.0**-40])
    array = np.array(value)
    array.reshape(-1)[0] = array.reshape(-1)[0] * (1 + 2.0**-40) if array.dtype.kind == "f" else 1
    return array


def saved_map() -> MapSnapshot:
    return MapSnapshot(
        time_ns=[0, 500_000_000],
        world_T_camera=Motor.from_translation([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]),
        points=[[0.1, 0.0, 2.0], [0.0, 0.2, 2.5]],
        descriptors=np.zeros((2, 32), np.uint8),
        keyframe_of=[0, 1, 1],
        point_of=[0, 0, 1],
        px=[[12.0, 8.0], [10.0, 8.0], [3.0, 4.0]],
        depth=[2.0, 2.0, 2.5],
        metric=True,
    )


def marker_map() -> MarkerMap:
    turns = Rotor.from_rotation_vector([[0.0, 0.0, 0.1], [0.0, 0.5, 0.0]])
    return MarkerMap([4, 9], [0.1, 0.1], turns, [[0.5, 0.0, 0.0], [1.0, 0.0, 0.0]])


@pytest.mark.parametrize("name", [field.name for field in fields(MapSnapshot)])
def test_every_part_of_a_saved_map_counts(make: Make, name: str) -> None:
    recording = replace(open_recording(make("kitti").root), slam_map=saved_map())
    other = replace(saved_map(), **{name: changed(getattr(saved_map(), name))})
    assert replace(recording, slam_map=saved_map()).digest() == recording.digest()
    assert replace(recording, slam_map=other).digest() != recording.digest()


@pytest.mark.parametrize("name", [field.name for field in fields(MarkerMap)])
def test_every_part_of_a_map_of_markers_counts(make: Make, name: str) -> None:
    def digest(known: MarkerMap) -> str:
        markers = LooseMarkers("tag36h11", 0.1, known)
        return replace(recording, markers=markers).digest()

    recording: Recording = open_recording(make("kitti").root)
    other = replace(marker_map(), **{name: changed(getattr(marker_map(), name))})
    assert digest(marker_map()) == digest(marker_map()) != digest(other)


def facts(root: Path) -> tuple[str, ...]:
    """What a run makes of a recording, or why it makes nothing."""
    try:
        recording = open_recording(root).intact()
    except (ValueError, OSError) as refusal:
        return ("refused", str(refusal))
    return (recording.digest(), *recording.settings)


def _blanked(text: str, pattern: str | None) -> str:
    if pattern is None:
        return text
    return re.sub(pattern, lambda part: "-" * len(part[0]), text, flags=re.MULTILINE)


UNUSED = {
    "calib.txt": r"P[01]: .*|P3: .*|Tr: .*",  # of other cameras
    "depth.txt": r".*",  # says only which of the images, here all alike, go together
    "data.csv": r"(,1\.0)+$",  # velocities and biases
    "sensor.yaml": r"%YAML.*|(cols|rows): 4",
}
"""Parts of files that no value comes of."""


@pytest.mark.parametrize("layout", ["euroc", "seven_scenes", "tum_rgbd", "kitti"])
def test_every_number_of_every_file_counts(
    make: Make, layout: str, caplog: pytest.LogCaptureFixture
) -> None:
    """One digit at a time: each has another digest, or is refused."""
    caplog.set_level(logging.ERROR)
    root = make(layout).root
    before, rng = facts(root), Random(3)
    assert before[0] != "refused"
    texts = [path for path in sorted(root.rglob("*.*")) if path.suffix in (".txt", ".csv", ".yaml")]
    for path in texts:
        text = path.read_text()
        used = _blanked(text, UNUSED.get(path.name))
        numbers = [one.start() for one in re.finditer(r"(?<![\w.])[1-9]", used)]
        for place in rng.sample(numbers, min(8, len(numbers))):
            digit = str(int(text[place]) % 9 + 1)
            path.write_text(text[:place] + digit + text[place + 1 :])
            assert facts(root) != before, f"{path.name}: {json.dumps(text[place - 20 : place + 9])}"
        path.write_text(text)
    assert facts(root) == before
