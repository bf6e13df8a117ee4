"""What the README shows a newcomer works as it stands there."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.cli.main import command_parser
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.trajectories import write_trajectory
from tests.bench.tables import SUITES
from tests.bench.whole.quoted import quoted_rows, rows_of

README = Path(__file__).resolve().parents[2] / "README.md"
BENCHMARKS = README.parent / "docs" / "benchmarks.md"
GUIDE = README.parent / "docs" / "which_smoother.md"

if not README.exists():
    pytest.skip("no README here: an installed wheel is tested", allow_module_level=True)


def blocks(language: str, page: Path = README) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The README's camera.toml beside a few images of its board, and a trajectory to smooth."""
    (tmp_path / "camera.toml").write_text(blocks("toml")[0])
    (tmp_path / "images").mkdir()
    cv2.imwrite(str(tmp_path / "images" / "0.png"), np.zeros((480, 752), np.uint8))
    recording = open_recording(tmp_path / "images", tmp_path / "camera.toml")
    camera, board = recording.camera, recording.board
    assert camera is not None
    assert board is not None
    scale = 2000.0
    drawing, origin = board.draw(scale)
    to_board = np.array([[1, 0, -origin[0]], [0, -1, origin[1]], [0, 0, scale]]) / scale
    pixels = np.stack(np.meshgrid(np.arange(752), np.arange(480)), axis=-1)
    straight = camera.undistort(pixels.astype(float)).astype(np.float32)
    poses = []
    for i in range(8):
        rotor = Rotor.from_rotation_vector([np.pi - 0.05 * i, 0.02 * i, 0.1])
        behind = -0.5 * rotor.apply([0.0, 0.0, 1.0])
        poses.append(Motor.from_rotor_translation(rotor, board.points_m.mean(axis=0) + behind))
        view = poses[-1].inverse().as_matrix()[:3][:, [0, 1, 3]]
        flat = cv2.warpPerspective(drawing, camera.matrix @ view @ to_board, (752, 480))
        image = cv2.remap(flat, straight, None, cv2.INTER_LINEAR)
        cv2.imwrite(str(tmp_path / "images" / f"{i}.png"), image)
    stamps = np.arange(24, dtype=np.int64) * 33_333_333
    there_and_back = Motor.stack([*poses, *poses[::-1], *poses])
    write_trajectory(Trajectory(stamps, there_and_back), tmp_path / "poses.tum")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_python_blocks_run(number: int, folder: Path) -> None:
    exec(compile(blocks("python")[number], f"README block {number}", "exec"), {})


@pytest.mark.parametrize("number", range(len(blocks("python", GUIDE))))
def test_python_blocks_of_the_guide_to_smoothers_run(number: int) -> None:
    exec(compile(blocks("python", GUIDE)[number], f"guide block {number}", "exec"), {})


def test_the_commands_for_ones_own_recording_work(folder: Path) -> None:
    commands = [line for line in blocks("sh")[1].splitlines() if line.startswith("motorcade")]
    assert len(commands) == 2
    for command in commands:
        words = [*command.split()[1:]]
        if words[0] == "run":
            words += ["--until", "errors"]
        assert main(words) == 0
    assert (folder / "out" / "kitchen" / "trajectories" / "smoothed_motor.tum").exists()


def test_every_link_leads_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#:]+)\)", README.read_text(encoding="utf-8")):
        assert (README.parent / target).exists(), target


def test_every_figure_stands_beside_the_command_that_makes_it() -> None:
    rows = [row.split("|")[1:-1] for row in rows_of(README.read_text(encoding="utf-8"))]
    assert len(rows) >= 6
    for _, here, _, _, command in rows:
        assert re.search(r"\d", here)
        words = command.strip().strip("`").split()
        if words[:2] == ["make", "bench"]:
            assert words[2].removeprefix("SUITE=") in SUITES
        else:
            assert words[0] == "motorcade"
            command_parser().parse_args([*words[1:]])


def test_figures_are_those_of_the_pages_that_they_come_from() -> None:
    """Row by row as the page of benchmarks has them; `make bench` writes both."""
    page, guide = (path.read_text(encoding="utf-8") for path in (BENCHMARKS, GUIDE))
    lacking = page.partition("## Not in this run")[2]
    waiting = []
    for row, there in quoted_rows(README.read_text(encoding="utf-8"), page):
        command = row.split("|")[-2].strip()
        if "motorcade compare" in command:
            shares = re.findall(r"[\d.]+ %", row)
            assert len(shares) == 3
            assert all(share in guide for share in shares)
        elif command in lacking:
            waiting.append(command)
        else:
            assert row == there, "`make bench` writes the README's rows as the page has them"
    if waiting:
        pytest.skip(f"the page lacks {', '.join(sorted(set(waiting)))}: make bench")


def test_no_speed_or_accuracy_stands_outside_the_table() -> None:
    told = README.read_text(encoding="utf-8")
    table = set(rows_of(told))
    rest = "\n".join(line for line in told.splitlines() if line not in table)
    assert not re.findall(
        r"\b\d[\d.,]* (?:ms|ns|µs|rad/s²|%)", re.sub(r"```.*?```", "", rest, flags=re.S)
    )
