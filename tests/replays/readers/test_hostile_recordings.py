"""Hostile files: whatever stands in them, a reader gives a recording or one line of refusal.

Without the guards, the first tests here would hang, fill the memory or leave the folder.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.ga.names import one_line
from motorcade.replays.io.files import RecordingError, refusal
from motorcade.replays.io.readers.calibration import read_numbers, read_yaml
from motorcade.replays.io.readers.frames.files import image_glob
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.readers.tables import read_listing

Make = Callable[..., Any]


def refused(act: Callable[[], object]) -> str:
    """The message of the refusal, which must be one line."""
    with pytest.raises(RecordingError) as caught:
        act()
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600
    return str(caught.value)


def test_yaml_that_unfolds_to_more_than_the_memory_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "laughs.yaml"
    lines = ["a0: &a0 [1, 1]", *(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]" for i in range(1, 60))]
    path.write_text("\n".join([*lines, "T_BS: *a59"]))
    assert "alias" in refused(lambda: read_yaml(path))


def test_the_line_of_a_fault_in_yaml_is_named(tmp_path: Path) -> None:
    path = tmp_path / "sensor.yaml"
    for head in ("", "%YAML:1.0\n", "%YAML:1.0\n---\n"):
        path.write_text(f"{head}a: 1\nb: c: d\n")
        line = 2 + head.count("\n")
        assert f"sensor.yaml, line {line}: expected YAML" in refused(lambda: read_yaml(path))


@pytest.mark.parametrize("nest", ["[", "{", "- ", "? ", "[{", "!!map {"])
@pytest.mark.parametrize("count", [900, 20_000])
def test_deep_yaml_is_refused(tmp_path: Path, nest: str, count: int) -> None:
    path = tmp_path / "deep.yaml"
    path.write_text("a:\n  " + nest * count)
    assert "expected" in refused(lambda: read_yaml(path))


@pytest.mark.parametrize(
    "text", ["!!python/object/apply:os.system ['true']", "a: !!python/name:os.system"]
)
def test_yaml_makes_no_objects(tmp_path: Path, text: str) -> None:
    path = tmp_path / "objects.yaml"
    path.write_text(text)
    assert "expected YAML" in refused(lambda: read_yaml(path))


def test_a_pipe_in_place_of_a_file_does_not_hang(make: Make) -> None:
    made = make("seven_scenes")
    pose = made.root / "frame-000002.pose.txt"
    pose.unlink()
    os.mkfifo(pose)
    assert "frame-000002.pose.txt" in refused(lambda: open_recording(made.root))
    image = made.root / "frame-000002.color.png"
    image.unlink()
    os.mkfifo(image)
    pose.unlink()
    pose.write_text("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1")
    assert "expected a file" in refused(open_recording(made.root).check)


def test_a_link_that_leads_to_itself_is_refused(make: Make) -> None:
    made = make("folder")
    (made.root / "endless.txt").symlink_to("endless.txt")
    (made.root / "motorcade.toml").write_text(
        '[frames]\nimages = "images/*.jpg"\nrate_hz = 25.0\n[truth]\nfile = "endless.txt"\n'
        'format = "tum"\nconvention = "world_T_camera"\n'
    )
    assert "endless.txt" in refused(lambda: open_recording(made.root))
    assert "no such file" in refused(lambda: open_recording(made.root / "endless.txt"))


def test_a_name_longer_than_any_file_has_is_refused() -> None:
    assert "File name too long" in refused(lambda: read_numbers(Path("x" * 5000)))


def test_a_file_larger_than_its_limit_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "huge.txt"
    with path.open("wb") as file:
        file.truncate(2**40)
    assert "expected at most" in refused(lambda: read_numbers(path))


def test_more_numbers_than_a_calibration_has_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "many.txt"
    path.write_text("1 2 3 4 5 6 7 8\n" * 20_000)
    assert "expected at most 100000 numbers" in refused(lambda: read_numbers(path))


@pytest.mark.parametrize("name", ["x" * 5000, "../" * 50 + "etc/passwd", "/dev/zero", "a\0b", "."])
def test_a_name_that_cannot_be_an_image_is_refused(make: Make, name: str) -> None:
    made = make("tum_rgbd")
    (made.root / "rgb.txt").write_text(f"1.0 rgb/0.png\n2.0 {name}\n")
    refused(lambda: open_recording(made.root))


def test_names_that_are_not_utf8_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "rgb.txt"
    path.write_bytes(b"1.0 \xff\xfe.png\n")
    refused(lambda: read_listing(path, separator=None, unit="s"))


def test_odd_digits_in_names_do_not_confuse_the_order(tmp_path: Path) -> None:
    for name in ("²", "٣", "1", "10", "9", "9" * 60):
        (tmp_path / f"{name}.png").touch()
    names = [path.stem for path in image_glob(tmp_path, "*.png")]
    assert [name for name in names if name in ("1", "9", "10")] == ["1", "9", "10"]


def test_patterns_that_walk_the_tree_again_and_again_are_refused(tmp_path: Path) -> None:
    assert "at most one **" in refused(lambda: image_glob(tmp_path, "**/**/**/*.png"))


def test_a_message_is_short_and_printable_whatever_it_quotes() -> None:
    nested: list[object] = [1]
    for _ in range(60):
        nested = [nested, nested]
    for value in (nested, "a\nb\x1b[31m" * 1000, b"\xff\0" * 1000, {"a": nested}, 10**300):
        assert len(one_line(value)) < 100
        assert one_line(value).isprintable()
    error = refusal("folder\nname", "got\r\nthis", field="a\tb")
    assert str(error) == "folder?name, a?b: got??this"


FILES = {
    "euroc": [
        "mav0/cam0/data.csv",
        "mav0/cam0/sensor.yaml",
        "mav0/imu0/data.csv",
        "mav0/imu0/sensor.yaml",
        "mav0/state_groundtruth_estimate0/data.csv",
    ],
    "seven_scenes": ["frame-000001.pose.txt", "frame-000001.color.png", "frame-000001.depth.png"],
    "tum_rgbd": ["rgb.txt", "depth.txt", "groundtruth.txt"],
    "kitti": ["calib.txt", "poses.txt", "times.txt"],
}


def garble(data: bytes, rng: np.random.Generator) -> bytes:
    """Change, cut, repeat or insert something."""
    at, length = int(rng.integers(len(data))), int(rng.integers(1, 40))
    junk = bytes(rng.integers(0, 256, length, dtype=np.uint8))
    words = [b"nan", b"-", b"1e999", b"\n", b",", b"[", b"{", b"&a", b"*a", b"\0", b"9" * 30, b"#"]
    word = words[int(rng.integers(len(words)))]
    changed = [
        data[:at] + junk + data[at + length :],
        data[:at],
        data[:at] + data[at : at + length] * 50 + data[at:],
        data[:at] + word + data[at + 1 :],
        word + data,
    ]
    return changed[int(rng.integers(len(changed)))]


@pytest.mark.parametrize(
    ("layout", "name"), [(layout, name) for layout in FILES for name in FILES[layout]]
)
def test_a_garbled_file_is_read_or_refused(make: Make, layout: str, name: str) -> None:
    path = make(layout).root / name
    root = path.parents[len(Path(name).parts) - 1]
    whole = path.read_bytes()
    rng = np.random.default_rng(len(whole))
    outcomes = []
    for _ in range(40):
        path.write_bytes(garble(whole, rng))
        try:
            open_recording(root).check()
            outcomes.append("")
        except RecordingError as fault:
            outcomes.append(str(fault))
    assert any(outcomes)
    assert all(outcome.isprintable() for outcome in outcomes)
