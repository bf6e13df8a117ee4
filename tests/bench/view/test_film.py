"""The drawn recording is one that can be tracked, and the table holds every stage."""

from itertools import islice
from pathlib import Path

from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking import Checkerboard, track_board
from tests.bench.view.film import COLUMNS, ROWS, film_lines, write_drawn


def test_the_drawn_board_is_found_where_its_manifest_says_it_can_be(tmp_path: Path) -> None:
    recording = open_recording(tmp_path, write_drawn(tmp_path, 640, 480))
    assert recording.camera is not None
    assert isinstance(recording.board, Checkerboard)
    assert len(recording.frames) == 300
    images = [(frame.time_ns, frame.gray()) for frame in islice(recording.frames, 4)]
    found = track_board(images, recording.camera, recording.board)
    assert len(found.observations) == 4
    assert all(len(seen.ids) == COLUMNS * ROWS for seen in found.observations)
    assert found.error_px.max() < 0.5


def test_each_stage_has_a_line() -> None:
    rows = [{"stage": name, "cpu_s": 1.5, "wall_s": 1.0} for name in ("start", "overlay")]
    told = {"stages": rows, "cpu_s": 3.0, "wall_s": 2.0, "frames": 9, "footage_s": 0.3, "load": 1.0}
    head, *lines = film_lines(told)
    assert "processor 3.0 s, wall 2.0 s" in head
    assert [line.split()[0] for line in lines] == ["start", "overlay"]
