"""Every message that says what to do: doing it works, or leads to the next message and on."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from tests.end_to_end.advice.following import Known, Words, followed
from tests.replays.readers.bag_poses import Messages, write_messages
from tests.replays.tiny_recordings import write_tiny

TURNS = 4
"""No more messages than this stand between a user and the result."""


@dataclass(frozen=True)
class Case:
    """A command line that goes wrong, what its message says, and what its user knows."""

    line: str
    says: str
    known: Known = field(default_factory=dict)


SIMULATED = "--set tracked.by=simulated"
FLOOR = f"{SIMULATED} --set placed.on=floor"
POSES = f"{SIMULATED} --until camera_poses"
QUICK = (
    Case("smoth a.tum -o o.tum", "no command 'smoth'"),
    Case("smooth a.tum --outputt o.tum", "no option --outputt"),
    Case("evaluate a.tum b.tum --pairs-fron=reference", "arguments: --pairs-fron"),
    Case("evaluate a.tum b.tum --align sm3", "argument --align"),
    Case("smooth a.tum -o o.tum --representation moter", "unknown 'moter'"),
    Case("smooth a.tum -o o.tum --method gausian", "unknown 'gausian'"),
    Case("smooth a.tum -o o.tum --method gaussian --set sigm_s=0.1", "--set: expected name=value"),
    Case("evaluate a.tum b.tum --relations trans_pat", "--relations: unknown"),
    Case(f"run tiny {SIMULATED} --until camera_pose", "no stage 'camera_pose'"),
    Case(f"run tiny {POSES} --set smothed.method=auto", "no stage 'smothed' to set"),
    Case(f"run tiny {POSES} --set fused.gat=0.99", "fused has no knob"),
    Case(f"run tiny {POSES} --set placed.on=markr", "placed.on: expected one of"),
    Case(f"run tiny {POSES} --executor procesess", "--executor: expected"),
    Case(f"run badkey {POSES}", "'rate_herz': unknown key"),
    Case(f"run badchoice {POSES}", "[truth] format: expected one of"),
    Case(f"run nokey {POSES}", "[camera] cx: the key is missing", {"cx": "11.5"}),
    Case(f"run long {POSES}", "say how many of its first rows", {"rows": "41"}),
    Case(f"run turned {POSES}", "leave rotation_deg out"),
    Case(f"run cut {POSES}", "copy the file again", {"copy": "tiny/images"}),
    Case(f"run tiny two/tiny {POSES}", "recordings are called 'tiny'"),
    Case(f"run tiny {POSES} --out file/out", "choose another --out", {"--out": "o"}),
    Case("smooth p.kitti -o o.tum", "KITTI files hold no stamps", {"--times": "times.txt"}),
    Case("smooth back.tum -o o.tum", "sort the file by its stamps"),
    Case("smooth two.bag -o o.tum", "got no name; name one of them as"),
    Case("smooth two.bag:/nothere -o o.tum", "got '/nothere'; name one"),
    Case("smooth a.tum b.tum -o o.tum", "expected a folder for 2 trajectories, got"),
    Case("smooth a.tum -o o.bag", "bags are only read"),
    Case("trajectory a.tum --format kitti", "--format: expected -o", {"-o": "o.kitti"}),
    Case("trajectory a.tum -o a.tum", "this is one of the inputs"),
    Case("trajectory a.tum b.tum -o o.tum", "or --merge to make one", {"--merge": None}),
    Case("trajectory a.tum b.tum -o made", "expected --format for", {"--format": "euroc"}),
    Case(
        "trajectory a.tum --invert-transform",
        "--invert-transform: expected",
        {"--transform-left": "transform.txt"},
    ),
    Case("trajectory a.tum --plot x.jpg", "--plot x.jpg: expected a name ending"),
    Case("evaluate a.tum b.tum --plot x.png", "--plot: expected a name ending"),
    Case("evaluate a.tum b.tum --drift 5m", "--drift: expected"),
    Case("evaluate a.tum a.tum b.tum", "expected each file once"),
    Case("evaluate a.tum later.tum", "expected stamps within max_difference_s"),
    Case("simulate-imu a.tum -o i.csv --noise n.yaml n.yaml", "--noise: expected one file"),
    Case("print checkerboard_40x30_40mm -o b.pdf", "make it", {"smaller": "checkerboard_7x5_30mm"}),
    Case("print checkerboard_9x6_40mm -o b.pdf", "print it on"),
    Case("print checkerbord_7x5_30mm -o b.pdf", "board: expected a name such as"),
    Case("print checkerboard_7x5_30mm -o b.pdf --count 3", "is one board"),
    Case("print tag36h11_id_7_65mm -o b.pdf --count 0", "--count: expected 1 or more"),
    Case("print checkerboard_7x5_30mm -o b.png", "a name that ends in"),
    Case("detect tiny/images/0.png --family tag36h12", "family: expected one of"),
    Case(
        "detect tiny/images/0.png --family tag36h11 --size-m 0.1",
        "--size-m: expected --camera",
        {"--camera": "tiny/motorcade.toml"},
    ),
    Case("run a.tum", "`motorcade inspect a.tum` says", {"only": "quoted"}),
)
SLOW = (
    Case(f"run tiny {FLOOR} --until placed --set placed.clip=wlak", "no clip 'wlak'"),
    Case(
        "compare --input noisy.tum --methods exponential --representations motor --executor local",
        "--input and --truth together",
        {"--truth": "walk.tum"},
    ),
    Case("compare --quick --methods exponential --trajectories handhold", "unknown 'handhold'"),
    Case("compare --quick --methods exponential --seeds 0", "--seeds: expected 1 or more"),
    Case(f"run tiny {SIMULATED} --strict --until fused", "expected a run up to integrity"),
    Case(
        "fuse walk.tum imu.csv -o f.tum --extrinsics transform.txt --estimate extrinsics",
        "--extrinsics: expected a file or",
    ),
    Case(
        "export fresh --colmap out/colmap",
        "expected a folder that `motorcade run",
        {"RECORDING": "tiny", "more": FLOOR},
    ),
)


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Small files of every kind, right and wrong."""
    folder = tmp_path_factory.mktemp("world")
    write_tiny(folder / "tiny", 0.3)
    shutil.copytree(folder / "tiny", folder / "two" / "tiny")
    right = (folder / "tiny" / "motorcade.toml").read_text()
    wrong = {
        "badkey": right.replace("rate_hz", "rate_herz"),
        "badchoice": right.replace('format = "tum"', 'format = "tumm"'),
        "nokey": right.replace("cx = 11.5\n", ""),
        "long": right.replace("truth.tum", "truth.kitti").replace('"tum"', '"kitti"'),
        "turned": right.replace("[camera]\n", "[camera]\nrotation_deg = 90\n"),
        "cut": right,
    }
    for name, text in wrong.items():
        shutil.copytree(folder / "tiny", folder / name)
        (folder / name / "motorcade.toml").write_text(text)
    _damage(folder)
    _write_paths(folder)
    return folder


def _damage(folder: Path) -> None:
    whole = (folder / "cut" / "images" / "0.png").read_bytes()
    for number in range(21):
        (folder / "cut" / "images" / f"{number}.png").write_bytes(whole[:60])
    (folder / "file").write_text("in the way")
    (folder / "made").mkdir()


def _write_paths(folder: Path) -> None:
    path = read_trajectory(folder / "tiny" / "truth.tum")
    rng = np.random.default_rng(11)
    noisy = path.motors @ Motor.exp(0.002 * rng.standard_normal((len(path.time_ns), 6)))
    write_trajectory(path, folder / "a.tum")
    write_trajectory(Trajectory(path.time_ns, noisy), folder / "b.tum")
    write_trajectory(Trajectory(path.time_ns + 90 * 10**9, noisy), folder / "later.tum")
    write_trajectory(path, folder / "p.kitti")
    write_trajectory(path, folder / "long" / "truth.kitti")
    walk = MOTIONS["handheld"].sampled(20.0, 15.0)
    turned = walk.motors @ Motor.exp(0.002 * rng.standard_normal((len(walk.time_ns), 6)))
    write_trajectory(walk, folder / "walk.tum")
    write_trajectory(Trajectory(walk.time_ns, turned), folder / "noisy.tum")
    rows = (folder / "p.kitti").read_text().splitlines()
    (folder / "long" / "truth.kitti").write_text("\n".join([*rows, *rows[:3]]) + "\n")
    (folder / "times.txt").write_text("".join(f"{1e-9 * stamp:.9f}\n" for stamp in path.time_ns))
    rows = (folder / "a.tum").read_text().splitlines()
    (folder / "back.tum").write_text("\n".join([*rows[:5], *rows[7:], *rows[5:7]]) + "\n")
    np.savetxt(folder / "transform.txt", np.eye(4))
    (folder / "n.yaml").write_text(
        "gyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 1.9e-5\n"
        "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n"
    )
    messages = Messages(ros1=True)
    sent = []
    for index, stamp in enumerate(range(10**18, 10**18 + 20 * 10**8, 10**8)):
        numbers = np.array([0.1 * index, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        for topic in ("/a", "/robot/pose"):
            sent.append((topic, stamp, messages.pose(KIND, stamp, numbers, ("map", "robot"))))
    shutil.move(write_messages(folder, "bag", sent), folder / "two.bag")


KIND = "geometry_msgs/msg/PoseStamped"


def told(words: Words, capsys: pytest.CaptureFixture[str]) -> str | None:
    """The last line of the error; None where the command worked."""
    capsys.readouterr()
    try:
        status = main(words)
    except SystemExit as stop:
        status = stop.code
    said = capsys.readouterr().err.strip().splitlines()
    if status == 0:
        return None
    assert status in (1, 2)
    return said[-1]


def follow(case: Case, capsys: pytest.CaptureFixture[str]) -> Sequence[str]:
    """Do what every message says until the command works; the messages."""
    words, messages = shlex.split(case.line), list[str]()
    while (message := told(words, capsys)) is not None:
        assert message not in messages, f"what this says leads nowhere: {message}"
        messages.append(message)
        assert len(messages) <= TURNS, messages
        *before, words = followed(message, words, case.known)
        for line in before:
            assert told(line, capsys) is None, line
        if "only" in case.known:
            break
    return messages


@pytest.fixture
def within(world: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the world, which the case may change, as the working folder."""
    folder = tmp_path / "world"
    shutil.copytree(world, folder)
    monkeypatch.chdir(folder)
    return folder


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.says)
def test_what_a_message_says_works(case, within, capsys) -> None:
    messages = follow(case, capsys)
    assert messages, "it worked at once"
    assert case.says in messages[0]


@pytest.mark.slow
@pytest.mark.parametrize("case", SLOW, ids=lambda case: case.says)
def test_what_a_message_of_a_longer_job_says_works(case, within, capsys) -> None:
    if "imu.csv" in case.line:
        assert told(shlex.split("simulate-imu walk.tum -o imu.csv"), capsys) is None
    messages = follow(case, capsys)
    assert messages, "it worked at once"
    assert case.says in messages[0]


@pytest.mark.slow
def test_a_run_whose_recording_changed_says_how_to_run_it_again(within, capsys) -> None:
    assert told(shlex.split(f"run tiny {FLOOR} --out out"), capsys) is None
    manifest = within / "tiny" / "motorcade.toml"
    manifest.write_text(manifest.read_text().replace("fx = 20.0", "fx = 21.0"))
    assert follow(Case("export out --colmap colmap", ""), capsys)


def test_at_least_thirty_messages_are_followed() -> None:
    assert len({case.says for case in QUICK}) == len(QUICK) >= 30
