"""A path by RGB-D lays depth on depth as well as the published one."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.end_to_end.depth_agreement import figures, together


@pytest.mark.slow
def test_depth_maps_agree_along_the_path(data_dir: Path, tmp_path: Path) -> None:
    replays = data_dir / "replays"
    folders = [replays / "7scenes_redkitchen", replays / "7scenes_redkitchen_200"]
    found = figures(together(folders, tmp_path / "both"), mono=False)["with depth"]
    assert found[30] <= 5.3
    assert found[300] <= 7.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["7scenes_redkitchen", "7scenes_redkitchen_200"])
def test_depth_is_worth_more_than_one_camera_alone(name: str, data_dir: Path) -> None:
    found = figures(data_dir / "replays" / name, mono=True)
    assert found["with depth"][30] < found["one camera"][30]
