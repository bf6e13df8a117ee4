"""A run that is killed at random moments and resumed ends as an undisturbed one."""

from pathlib import Path

import pytest

from tests.end_to_end.killed import killed_at_random


@pytest.mark.slow
def test_killed_runs_resume_and_end_as_undisturbed_ones(
    board_recording: Path, tmp_path: Path, opengl: None
) -> None:
    ended = killed_at_random(board_recording, tmp_path, 4, 3, print)
    assert ended.kills == 4
    assert not ended.faults
