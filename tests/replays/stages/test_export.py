"""Runs written for other viewers, read back from the file's own numbers."""

import json
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from motorcade.animation import skin
from motorcade.animation.formats import read_character, write_gltf
from motorcade.replays.cli import main
from motorcade.replays.demo import write_recording
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.job import Job, run_job
from motorcade.replays.pipeline.runs import Shown, open_run, read_origin
from tests.animation.formats.gltf_vertices import GltfVertices

TWO = """
[[characters]]
name = "ann"
start = [0.0, -0.2]

[[characters]]
name = "ben"
path = [[0.2, 0.1], [0.3, 0.2]]
height_m = 0.2
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory, opengl: None) -> Path:
    """A short run of the synthetic room, as far as its character's place."""
    root = tmp_path_factory.mktemp("run")
    write_recording(root / "room", frames=16)
    once = ("smoothed.representations=motor",)
    run_job(Job(recording=root / "room", out=root / "out", until="placed", settings=once))
    return root / "out"


@pytest.fixture(scope="module")
def shown(finished: Path) -> Shown:
    return open_run(finished)


def test_a_run_is_read_back_from_another_folder_than_it_was_made_in(
    finished: Path, shown: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    root, hero = finished.parent, finished.parent / "hero.glb"
    write_gltf(hero, shown.cast["character"].character, [shown.cast["character"].clip])
    monkeypatch.chdir(root)
    settings = ("smoothed.representations=motor", "placed.character=hero.glb")
    run_job(Job(Path("room"), Path("away"), until="placed", settings=settings))
    (root / "elsewhere").mkdir()
    monkeypatch.chdir(root / "elsewhere")
    found = open_run(root / "away")
    names = [one.cast["character"].character.skeleton.names for one in (found, shown)]
    assert names[0] == names[1]
    made = [one.name for one in (root / "away" / ".cache").glob("placed-*")]
    assert len(made) == 1  # found, not computed again


class Glb:
    """The document and the arrays of a `.glb`, read with `struct` and NumPy alone."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        (length,) = struct.unpack_from("<I", data, 12)
        self.document: dict[str, Any] = json.loads(data[20 : 20 + length])
        self._binary = data[28 + length :]

    def array(self, number: int) -> np.ndarray:
        accessor = self.document["accessors"][number]
        view = self.document["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        values = np.frombuffer(
            self._binary, "<f4", accessor["count"] * width, view.get("byteOffset", 0)
        )
        return values.reshape(-1, width)

    def channel(self, node: int, path: str) -> tuple[np.ndarray, np.ndarray]:
        animation = self.document["animations"][0]
        for channel in animation["channels"]:
            if channel["target"] == {"node": node, "path": path}:
                sampler = animation["samplers"][channel["sampler"]]
                return self.array(sampler["input"])[:, 0], self.array(sampler["output"])
        raise AssertionError(f"no channel {path} of node {node}")


def test_the_camera_of_the_gltf_goes_where_the_run_says(
    finished: Path, shown: Shown, tmp_path: Path
) -> None:
    file = tmp_path / "run.glb"
    assert main(["export", str(finished), "--gltf", str(file)]) == 0
    glb = Glb(file)
    (node,) = (k for k, one in enumerate(glb.document["nodes"]) if "camera" in one)
    time_s, places = glb.channel(node, "translation")
    path = shown.path
    stamps = path.time_ns[0] + np.rint(time_s.astype(np.float64) * 1e9).astype(np.int64)
    stamps = np.clip(stamps, path.time_ns[0], path.time_ns[-1])
    expected = path.motors_at(stamps)
    np.testing.assert_allclose(places, expected.translation_m, atol=2e-5)
    turn_s, xyzw = glb.channel(node, "rotation")
    stamps = path.time_ns[0] + np.rint(turn_s.astype(np.float64) * 1e9).astype(np.int64)
    # glTF's camera looks along -z with y up, OpenCV's along z with y down.
    x, y, z, w = xyzw.astype(np.float64).T
    ahead = -np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
    rotors = path.motors_at(np.clip(stamps, path.time_ns[0], path.time_ns[-1])).rotor
    np.testing.assert_allclose(ahead, rotors.apply(np.array([0.0, 0.0, 1.0])), atol=2e-5)
    lens = glb.document["cameras"][0]["perspective"]
    assert np.tan(0.5 * lens["yfov"]) * shown.camera.fy == pytest.approx(0.5 * shown.camera.height)


def test_the_character_of_the_gltf_stands_where_the_run_placed_it(
    finished: Path, shown: Shown, tmp_path: Path
) -> None:
    file = tmp_path / "run.glb"
    assert main(["export", str(finished), "--gltf", str(file)]) == 0
    glb = Glb(file)
    (node,) = (k for k, one in enumerate(glb.document["nodes"]) if one.get("name") == "path")
    _, places = glb.channel(node, "translation")
    stand = shown.cast["character"].placement.world_T_character.translation_m
    np.testing.assert_allclose(places, np.broadcast_to(stand, places.shape), atol=1e-6)
    assert len(read_character(file).triangles) == len(shown.cast["character"].character.triangles)


@pytest.mark.slow
def test_a_whole_cast_is_exported(finished: Path, tmp_path: Path) -> None:
    """Vertices of all figures, evaluated from the file's bytes, are those that a run draws."""
    cast = tmp_path / "cast.toml"
    cast.write_text(TWO)
    settings = ("smoothed.representations=motor", f"placed.cast={cast}", "placed.position_m=")
    run_job(Job(finished.parent / "room", tmp_path / "out", until="placed", settings=settings))
    assert main(["export", str(tmp_path / "out"), "--gltf", str(tmp_path / "cast.glb")]) == 0
    found, shown = GltfVertices(tmp_path / "cast.glb"), open_run(tmp_path / "out")
    assert list(shown.cast) == ["ann", "ben"]
    for time_s in (0.0, 0.2, 0.4):
        stamp = shown.path.time_ns[0] + round(1e9 * time_s)
        every = []
        for one in shown.cast.values():
            shaped = one.character.shaped(one.clip.morph_weights(time_s))
            vertices, _ = skin(shaped, one.clip.at(time_s), "linear")
            every.append(one.world_T_character(stamp).apply(vertices))
        expected = np.concatenate(every)[:, [1, 2, 0]]  # z up to y up
        far, _ = cKDTree(expected).query(found.at(time_s))
        assert far.max() < 1e-5


def test_points_of_a_map_are_in_the_gltf(shown: Shown, tmp_path: Path) -> None:
    from dataclasses import replace

    from motorcade.replays.pipeline.runs import write_run_gltf

    points = np.random.default_rng(1).normal(size=(50, 3))
    write_run_gltf(replace(shown, points_m=points), tmp_path / "map.glb")
    glb = Glb(tmp_path / "map.glb")
    (node,) = (one for one in glb.document["nodes"] if one.get("name") == "map")
    primitive = glb.document["meshes"][node["mesh"]]["primitives"][0]
    assert primitive["mode"] == 0
    np.testing.assert_allclose(glb.array(primitive["attributes"]["POSITION"]), points, atol=1e-6)


def test_frames_in_a_gap_are_said_or_left_out(
    shown: Shown, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A path without poses for a while: no pose is invented there without a word."""
    from dataclasses import replace

    from motorcade.replays.pipeline.export import write_images

    stamps = shown.recording.frames.time_ns
    lost = (shown.path.time_ns > stamps[4]) & (shown.path.time_ns < stamps[11])
    gap = replace(shown, path=shown.path[~lost])
    assert len(gap.frames_posed) == len(shown.frames_posed)
    assert "max_gap_s (--max-gap-s) leaves them out" in caplog.text
    told = replace(gap, max_gap_s=2.5e-9 * float(stamps[1] - stamps[0]))
    assert len(told.frames_posed) == len(shown.frames_posed) - 6
    assert "6 of 16 frames lie in gaps" in caplog.text
    written = write_images(told, tmp_path)
    assert [int(name[-10:-4]) for name in written.names] == told.frames_posed.tolist()
    with pytest.raises(ValueError, match="max_gap_s: expected seconds above 0"):
        _ = replace(gap, max_gap_s=0.0).frames_posed


def test_without_rerun_one_line_says_what_brings_it(
    finished: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert main(["export", str(finished), "--rrd", str(tmp_path / "run.rrd")]) == 1
    assert "motorcade[viewer]" in capsys.readouterr().err
    assert not (tmp_path / "run.rrd").exists()


def test_rerun_reads_what_is_written(finished: Path, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    file = tmp_path / "run.rrd"
    assert main(["export", str(finished), "--rrd", str(file)]) == 0
    data = file.read_bytes()
    assert data[:4] == b"RRF2"
    assert len(data) > 100_000
    assert data.count(b"ftypisom") == 1  # images are one encoded film


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--gltf", "x.obj"], "ends in .glb"),
        ([], "got none"),
    ],
)
def test_bad_requests_are_refused_in_one_line(
    finished: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], told: str
) -> None:
    assert main(["export", str(finished), *arguments]) == 1
    assert told in capsys.readouterr().err


def test_a_folder_without_a_run_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", str(tmp_path), "--gltf", "x.glb"]) == 1
    assert "run.json is not there" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text",
    ["[]", "{}", "7", '"run"', "{", '{"manifest": 7, "settings": [], "recording": 7}', "[" * 9000],
)
def test_a_run_log_of_another_program_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str
) -> None:
    (tmp_path / "run.json").write_text(text)
    assert main(["export", str(tmp_path), "--gltf", "x.glb"]) == 1
    told = capsys.readouterr().err
    assert f"{tmp_path / 'run.json'}: expected what `motorcade run` wrote of a recording" in told


def test_a_runs_command_line_gives_its_manifest_and_settings_again(tmp_path: Path) -> None:
    told = {
        "recording": "/my/board",
        "manifest": "/my/board.toml",
        "content": "",
        "settings": ["smoothed.order=2", "placed.clip=wave", "overlay.gain=1.5"],
    }
    (tmp_path / "run.json").write_text(json.dumps(told))
    frames: Any = (None,)  # nobody looks at them
    own = "smoothed.order=2"  # which the manifest says itself
    recording = Recording("board", Path("/my/board"), "made", frames, settings=(own,))
    origin = read_origin(tmp_path)
    assert origin.words(recording) == [
        *("motorcade", "run", "/my/board", "--manifest", "/my/board.toml"),
        *("--set", "overlay.gain=1.5"),  # who stands there is the scene's to say
    ]
    assert origin.knobs["placed"] == {"clip": "wave"}
