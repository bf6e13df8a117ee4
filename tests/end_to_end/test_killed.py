"""Runs that are killed, share their output folder or fill the disk end as an undisturbed one."""

from pathlib import Path

import pytest

from tests.end_to_end import shared_storage
from tests.end_to_end.killed import killed_at_random


@pytest.mark.slow
def test_killed_runs_resume_and_end_as_undisturbed_ones(
    board_recording: Path, tmp_path: Path, opengl: None
) -> None:
    ended = killed_at_random(board_recording, tmp_path, 4, 3, print)
    assert ended.kills == 4
    assert not ended.faults


@pytest.mark.slow
@pytest.mark.skipif(not shared_storage.can_contain(), reason="no containers are permitted")
def test_containers_hosts_and_full_disks_change_no_result(
    board_recording: Path, tmp_path: Path, opengl: None
) -> None:
    ways = shared_storage.disturbed(board_recording, tmp_path, 1, 3)
    assert {name: way.faults for name, way in ways.items()} == {name: [] for name in ways}
    assert sum(way.runs for way in ways.values()) >= 10
