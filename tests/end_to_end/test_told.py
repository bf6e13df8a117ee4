"""What a run tells while it runs: a line a stage on standard error, whoever listens."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

RUN = "import sys; from motorcade.replays.cli import main; sys.exit(main())"
STAGES = ["board_poses", "camera_poses", "imu", "fused", "smoothed"]


def told(*arguments: object) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [sys.executable, "-c", RUN, "run", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done


@pytest.mark.slow
def test_a_line_a_stage_and_one_of_the_result_where_there_is_no_terminal(
    board_recording: Path, tmp_path: Path
) -> None:
    asked = (board_recording, "--out", tmp_path, "--until", "errors", "--json")
    first, again = told(*asked), told(*asked)
    every = [*STAGES, "integrity", "errors"]
    assert set(json.loads(first.stdout)["stages"]) == set(every)
    assert json.loads(again.stdout)["errors"] == json.loads(first.stdout)["errors"]
    *lines, last = first.stderr.splitlines()
    opened, *lines = lines
    assert opened.startswith("small board: 24 images of 320 x 240 in ")
    for line, stage in zip(lines, every, strict=True):
        assert re.fullmatch(rf"{stage}: \d+\.\d s", line)
    assert last == f"done as far as errors; look into {tmp_path}"
    assert again.stderr.splitlines() == [
        opened,
        *(f"{stage}: kept from before" for stage in every),
        last,
    ]


@pytest.mark.parametrize("executor", ["local", pytest.param("processes", marks=pytest.mark.slow)])
def test_of_several_recordings_every_line_names_its_own(
    executor: str, board_recording: Path, tmp_path: Path
) -> None:
    other = shutil.copytree(board_recording, tmp_path / "other")
    out = tmp_path / "out"
    asked = ("--out", out, "--until", "smoothed", "--executor", executor)
    lines = told(board_recording, other, *asked).stderr.splitlines()
    for name in (board_recording.name, "other"):
        own = [line.removeprefix(f"{name}: ") for line in lines if line.startswith(f"{name}: ")]
        assert [line.partition(":")[0] for line in own[:-1]] == ["small board", *STAGES]
        assert own[-1] == f"done as far as smoothed; look into {out / name}"
    assert len(lines) == 2 * (len(STAGES) + 2)


def test_on_a_terminal_every_line_has_its_own_row(board_recording: Path, tmp_path: Path) -> None:
    """As a terminal shows it: after a carriage return, text is written over what stood there."""
    pty = pytest.importorskip("pty", reason="no terminals here")
    termios = pytest.importorskip("termios")
    near, far = pty.openpty()
    termios.tcsetwinsize(far, (24, 200))  # bars know that one without a size shows nothing
    slow = "from motorcade.ga import progress; progress.DELAY_S = 0.0; "
    command = ["run", str(board_recording), "--out", str(tmp_path), "--until", "smoothed"]
    with subprocess.Popen(
        [sys.executable, "-c", slow + RUN, *command], stdout=subprocess.DEVNULL, stderr=far
    ) as running:
        os.close(far)
        written = b""
        try:
            while piece := os.read(near, 4096):
                written += piece
        except OSError:  # how Linux tells that nobody holds the other end
            pass
    os.close(near)
    assert running.returncode == 0
    assert "board_poses: 00:00" in written.decode()
    rows = rows_shown(written.decode())
    opened, *rows = rows
    assert opened.startswith("small board: 24 images")
    for row, stage in zip(rows, STAGES, strict=False):
        assert re.fullmatch(rf"{stage}: \d+\.\d s", row)
    assert rows[len(STAGES) :] == [f"done as far as smoothed; look into {tmp_path}"]


def rows_shown(written: str) -> list[str]:
    """The rows that are left when all is written; rows that are blank are not told."""
    rows: dict[int, list[str]] = {}
    row = column = 0
    for part in re.findall(r"\x1b\[A|\x1b\[\d*m|[\s\S]", written):
        if part == "\x1b[A":
            row = max(row - 1, 0)
        elif part == "\r":
            column = 0
        elif part == "\n":
            row += 1
        elif len(part) == 1:
            cells = rows.setdefault(row, [])
            cells.extend(" " * (column + 1 - len(cells)))
            cells[column] = part
            column += 1
    shown = ["".join(rows[row]).rstrip() for row in sorted(rows)]
    return [line for line in shown if line]
