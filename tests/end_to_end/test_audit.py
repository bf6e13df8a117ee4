"""What users get wrong is found and named, and what is right is not doubted."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.end_to_end.audit import boards, flights, judged, kitchens, pairs, tags


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
def test_a_right_camera_on_the_left_is_named(tmp_path: Path) -> None:
    for one in pairs(tmp_path):
        right, told = judged(one)
        assert right, told
