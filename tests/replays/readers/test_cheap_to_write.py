"""Files that are cheap to write and dear to read: what they ask for is counted beforehand."""

import json
import logging
import struct
import tomllib
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.animation.formats import read_character
from motorcade.animation.formats.gltf import Meshes
from motorcade.animation.formats.limits import MAX_PARTS
from motorcade.render import write_video
from motorcade.replays.cli import main
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.manifest.section import load_toml
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.transforms import read_transform
from motorcade.replays.pipeline.described.values import sample_rows


@pytest.mark.parametrize(
    "text",
    [
        ".".join(["a"] * 20_000) + " = 1",
        "[" + " . ".join(['"b"'] * 9_000) + "]",
        "frames.images = '*.png'\nx = {" + ".".join(["c"] * 20_000) + " = 2}",
    ],
)
def test_keys_of_many_parts_never_reach_the_parser(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "m.toml"
    path.write_text(text)
    monkeypatch.setattr(tomllib, "loads", lambda text: pytest.fail("it was parsed"))
    with pytest.raises(RecordingError, match="parts"):
        load_toml(path)


def test_prose_and_numbers_with_many_dots_are_no_keys(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    numbers = ", ".join(f"{k}.5" for k in range(200))
    path.write_text(f"name = '{'so it is. ' * 90}'\nx = [{numbers}]\n")
    assert set(load_toml(path)) == {"name", "x"}


def gltf(folder: Path, nodes: int, parts: int) -> Path:
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": list(range(nodes))}],
        "nodes": [{"mesh": 0}] * nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * parts}],
        "accessors": [{"componentType": 5126, "count": 3, "type": "VEC3"}],
    }
    path = folder / "many.gltf"
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(("nodes", "parts"), [(1, MAX_PARTS + 1), (10_000, 200)])
def test_parts_times_nodes_are_counted_before_one_is_read(
    nodes: int, parts: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = []
    monkeypatch.setattr(Meshes, "_shared", lambda *given: read.append(given) or [])
    with pytest.raises(ValueError, match="parts of meshes at all nodes"):
        read_character(gltf(tmp_path, nodes, parts))
    assert not read


def test_long_numbers_are_refused_without_advice_to_programmers(tmp_path: Path) -> None:
    digits = "9" * 10_000
    json_file, toml_file = tmp_path / "a.json", tmp_path / "b.toml"
    json_file.write_text(f'{{"x": {digits}}}')
    toml_file.write_text(f"name = {digits}\n")
    for read, path in ((read_transform, json_file), (load_toml, toml_file)):
        with pytest.raises(RecordingError, match="4300 digits") as caught:
            read(path)
        assert "sys" not in str(caught.value)


def images(folder: Path) -> Path:
    folder.mkdir()
    for number in range(3):
        cv2.imwrite(str(folder / f"{number}.png"), np.zeros((16, 24), np.uint8))
    return folder


def test_letters_that_turn_others_about_stand_in_no_name(tmp_path: Path) -> None:
    assert open_recording(images(tmp_path / "a\u202egpj")).name == "a?gpj"
    manifest = tmp_path / "m.toml"
    frames = "[frames]\nrate_hz = 30.0\n"
    manifest.write_text(f'name = "a\u202eb"\n{frames}', encoding="utf-8")
    with pytest.raises(RecordingError, match="letters that show"):
        open_recording(images(tmp_path / "plain"), manifest)


@pytest.mark.parametrize("scale", [0, 1, 7, 2**31 - 1, 2**32 - 1])
def test_damaged_time_scales_are_said(
    scale: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, capsys
) -> None:
    path = tmp_path / "a.mp4"
    grey = [np.full((48, 64, 3), 8 * k, np.uint8) for k in range(30)]
    write_video(path, grey, np.arange(30) * 33_333_333)
    data = bytearray(path.read_bytes())
    struct.pack_into(">I", data, data.index(b"mdhd") + 16, scale)
    path.write_bytes(data)
    with caplog.at_level(logging.WARNING):
        status = main(["inspect", str(path), "--json"])
    said = caplog.text + capsys.readouterr().err
    assert "time scale, hides 29 of 30" in said or (status == 1 and "10 us" in said)


def test_frames_too_large_are_refused_before_they_are_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(3):
        cv2.imwrite(str(tmp_path / f"{number}.png"), np.full((6000, 9000), 90, np.uint8))
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    with pytest.raises(RecordingError, match="at most 50000000 pixels, got 9000 x 6000"):
        open_recording(tmp_path).frames[0].gray()


@pytest.mark.parametrize("pixels", [2_000_000, 15_000_000, 33_000_000, 50_000_000])
def test_a_sample_of_frames_is_bounded_by_their_pixels(pixels: int) -> None:
    rows, places = sample_rows(500, pixels)
    assert len(rows) * pixels <= 1.5 * 2**28
    assert len(places) >= 3
