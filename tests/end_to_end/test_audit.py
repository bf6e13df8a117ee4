"""What users get wrong is found and named, and what is right is not doubted."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorcade.replays.stages.camera.slam_poses import found_cameras
from tests.end_to_end.audit import (
    boards,
    changed_kitchen,
    colour_zoomed,
    flights,
    judged,
    kitchens,
    pairs,
    tags,
)


@pytest.mark.slow
@pytest.mark.parametrize("planting", [kitchens, boards, flights, tags])
def test_each_contradiction_planted_in_a_recording_is_named(planting, data_dir: Path) -> None:
    wrong = {
        (one.recording, one.what): told
        for one in planting(data_dir)
        for right, told in [judged(one)]
        if not right
    }
    assert not wrong


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "share"), [("7scenes_redkitchen", 0.02), ("7scenes_redkitchen_200", 0.03)]
)
def test_which_focal_length_is_wrong_is_told(name: str, share: float, data_dir: Path) -> None:
    """The second recording's first five seconds turn less, and say less."""
    wrong = changed_kitchen(data_dir / "replays" / name, colour_zoomed(1.05))
    found = found_cameras(wrong)
    told = found.audit[-1]
    assert told.name == "focal_lengths"
    assert told.verdict == "contradicted"
    assert found.camera is not None
    assert found.depth_camera is not None
    assert found.camera.fx == pytest.approx(525.0, rel=share)
    assert found.depth_camera.camera.fx == pytest.approx(585.0, rel=share)


@pytest.mark.slow
def test_a_right_camera_on_the_left_is_named(tmp_path: Path) -> None:
    for one in pairs(tmp_path):
        right, told = judged(one)
        assert right, told
