"""`inspect` of bags and files of poses: what is named can be read, by the commands it names."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from tests.replays.readers.bag_poses import KINDS, Messages, write_messages

COUNT = 20
POSE = "geometry_msgs/msg/PoseStamped"


def told(capsys: pytest.CaptureFixture[str], path: Path) -> dict[str, object]:
    assert main(["inspect", str(path), "--json"]) == 0
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found


def bag(tmp_path: Path, kind: str) -> Path:
    """A bag of two topics of poses and one that is not read."""
    messages = Messages(ros1=kind == "bag")
    rng = np.random.default_rng(3)
    sent = []
    for index in range(COUNT):
        time_ns = 10**18 + index * 10**8
        turn = rng.standard_normal(4)
        numbers = np.concatenate([rng.standard_normal(3), turn / np.linalg.norm(turn)])
        for topic in ("/robot/pose", "/a"):
            sent.append((topic, time_ns, messages.pose(POSE, time_ns, numbers, ("map", "robot"))))
        sent.append(("/heard", time_ns, messages.header(time_ns, "map")))
    return write_messages(tmp_path, kind, sent)


@pytest.mark.parametrize("kind", KINDS)
def test_topics_of_a_bag_without_images_are_listed_with_what_reads_them(kind, tmp_path, capsys):
    path = bag(tmp_path, kind)
    found = told(capsys, path)
    topics = {one["name"]: one for one in found["topics"]}
    assert {name: one["messages"] for name, one in topics.items()} == {
        "/a": COUNT,
        "/heard": COUNT,
        "/robot/pose": COUNT,
    }
    assert topics["/heard"]["read_as"] == "not read"
    assert topics["/a"]["read_as"].startswith("poses")


@pytest.mark.parametrize("kind", KINDS)
def test_the_commands_that_follow_are_runnable(kind, tmp_path, capsys, monkeypatch):
    path = bag(tmp_path, kind)
    truth = tmp_path / "truth.tum"
    write_trajectory(read_trajectory(f"{path}:/a"), truth)
    monkeypatch.chdir(tmp_path)
    for line in told(capsys, path)["next"]:
        words = [str(truth) if word == "GROUND_TRUTH" else word for word in shlex.split(line)]
        assert words[0] == "motorcade"
        assert main(words[1:]) == 0, line
    assert len(read_trajectory(tmp_path / "smooth.tum")) == COUNT


@pytest.mark.parametrize("ending", ["tum", "csv", "kitti"])
def test_files_of_poses_are_recognised(ending, tmp_path, capsys, monkeypatch):
    rng = np.random.default_rng(5)
    path = Trajectory(np.arange(COUNT) * 50_000_000, Motor.random(rng, (COUNT,)), "world", "camera")
    file = tmp_path / f"path.{ending}"
    write_trajectory(path, file)
    found = told(capsys, file)
    assert found["poses_count"] == COUNT
    assert found["holds"].startswith("poses")
    steps = np.linalg.norm(np.diff(path.rigid.poses.translation_m, axis=0), axis=1)
    assert found["path_m"] == pytest.approx(steps.sum())
    if ending != "kitti":  # which holds no stamps
        assert found["poses_rate_hz"] == pytest.approx(20.0)
    monkeypatch.chdir(tmp_path)
    words = shlex.split(found["next"][0].replace("HZ", "20"))
    assert main(words[1:]) == 0


def test_a_file_of_inertial_readings_is_recognised(tmp_path, capsys):
    rows = ["#timestamp [ns],wx,wy,wz,ax,ay,az"]
    rows += [f"{index * 5_000_000},0.01,0,0,0,0,9.81" for index in range(50)]
    file = tmp_path / "imu.csv"
    file.write_text("\n".join(rows) + "\n")
    found = told(capsys, file)
    assert found["holds"] == "inertial readings"
    assert found["imu_rate_hz"] == pytest.approx(200.0)


def test_a_file_of_neither_is_refused_for_both_reasons(tmp_path, capsys):
    file = tmp_path / "notes.txt"
    file.write_text("1 2 3\n4 5 6\n")
    assert main(["inspect", str(file)]) == 1
    said = capsys.readouterr().err
    assert "neither poses" in said
    assert "nor inertial readings" in said
    assert said.count("\n") == 1
