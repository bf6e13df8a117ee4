"""Artifacts: what is written is read back, all or nothing, and only as the type asked for."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.replays.engine import artifacts
from motorcade.replays.stages.values.camera_poses import ASIDE


@dataclass(frozen=True)
class Inner:
    name: str
    weights: np.ndarray


@dataclass(frozen=True)
class Outer:
    inner: Inner
    parts: dict[str, Inner]
    spans: tuple[float, ...]
    note: str | None
    film: Path
    seconds: float = field(metadata=ASIDE)


def outer(tmp_path: Path, seconds: float = 1.0) -> Outer:
    film = tmp_path / "film.bin"
    film.write_bytes(b"moving images")
    inner = Inner("a", np.array([0.1, np.nan, -0.0]))
    return Outer(inner, {"b": Inner("b", np.arange(3))}, (1.0, 2.5), None, film, seconds)


def test_a_value_comes_back_as_it_was(tmp_path: Path) -> None:
    value = outer(tmp_path)
    read = artifacts.read_artifact(artifacts.write_artifact(value, tmp_path / "kept", 0.5), Outer)
    np.testing.assert_array_equal(read.inner.weights, value.inner.weights)
    np.testing.assert_array_equal(read.parts["b"].weights, [0, 1, 2])
    assert read.parts["b"].weights.dtype == np.int64
    assert (read.spans, read.note, read.seconds) == ((1.0, 2.5), None, 1.0)
    assert read.film.read_bytes() == b"moving images"


@pytest.mark.parametrize("kind", [Motor, Similarity])
def test_trajectories_come_back_with_their_type_of_pose(
    kind: type[Motor] | type[Similarity], tmp_path: Path
) -> None:
    value = Trajectory(np.arange(5), kind.random(np.random.default_rng(2), (5,)))
    read = artifacts.read_artifact(artifacts.write_artifact(value, tmp_path / "t", 0.5), Trajectory)
    assert type(read.poses) is kind
    np.testing.assert_array_equal(read.poses.coefficients, value.poses.coefficients)


def test_what_no_type_of_a_union_takes_is_refused(tmp_path: Path) -> None:
    @dataclass(frozen=True)
    class Poses:
        time_ns: np.ndarray
        poses: dict[str, np.ndarray]
        parent: str = "world"
        child: str = "camera"

    other = Poses(np.arange(2), {"coefficients": np.zeros((2, 5))})
    stored = artifacts.write_artifact(other, tmp_path / "t", 0.5)
    with pytest.raises(artifacts.ArtifactError, match=r"\(\*, 8\).*\(\*, 12\)"):
        artifacts.read_artifact(stored, Trajectory)


def test_the_digest_is_that_of_the_content_alone(tmp_path: Path) -> None:
    first = artifacts.write_artifact(outer(tmp_path, seconds=1.0), tmp_path / "first", 0.5)
    second = artifacts.write_artifact(outer(tmp_path, seconds=2.0), tmp_path / "second", 0.7)
    assert first.digest == second.digest


@pytest.mark.parametrize("name", ["arrays.npz", "value.json", "artifact.json", "files/0.bin"])
def test_a_damaged_artifact_is_found_out_and_dropped(
    name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    stored = artifacts.write_artifact(outer(tmp_path), tmp_path / "kept", 0.5)
    assert artifacts.find_artifact(stored.folder) == stored
    whole = (stored.folder / name).read_bytes()
    (stored.folder / name).write_bytes(whole[: len(whole) // 2])
    assert artifacts.find_artifact(stored.folder) is None
    assert "damaged, so it is computed again" in caplog.text
    assert not stored.folder.exists()


def test_content_that_does_not_fit_the_type_is_refused(tmp_path: Path) -> None:
    stored = artifacts.write_artifact(outer(tmp_path), tmp_path / "kept", 0.5)
    with pytest.raises(artifacts.ArtifactError, match="cannot be read as"):
        artifacts.read_artifact(stored, Inner)


def test_arrays_that_unpack_to_far_more_are_refused(tmp_path: Path) -> None:
    stored = artifacts.write_artifact(outer(tmp_path), tmp_path / "kept", 0.5)
    np.savez_compressed(stored.folder / "arrays.npz", **{"<f8": np.zeros(1 << 24)})
    with pytest.raises(artifacts.ArtifactError, match="expected at most"):
        artifacts.read_artifact(stored, Outer)


def test_text_in_place_of_a_table_is_refused(tmp_path: Path) -> None:
    stored = artifacts.write_artifact(outer(tmp_path), tmp_path / "kept", 0.5)
    value = stored.folder / "value.json"
    tree = json.loads(value.read_text())
    value.write_text(json.dumps(tree | {"parts": "none"}))
    with pytest.raises(artifacts.ArtifactError, match="cannot be read as"):
        artifacts.read_artifact(stored, Outer)


def test_what_cannot_be_stored_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match=r"value\.name: a set cannot be stored"):
        artifacts.write_artifact(Inner({1}, np.zeros(1)), tmp_path / "kept", 0.5)  # type: ignore[arg-type]


def test_a_file_made_outside_a_run_is_gone_when_the_program_ends(tmp_path: Path) -> None:
    code = (
        "from motorcade.replays.engine.artifacts import new_file\n"
        "paths = [new_file('film.mp4'), new_file('film.mp4')]\n"
        "assert paths[0] != paths[1]\n"
        "for path in paths:\n    path.write_bytes(b'film')\n"
    )
    environment = dict(os.environ, TMPDIR=str(tmp_path))
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    assert list(tmp_path.iterdir()) == []


@dataclass(frozen=True)
class ManyArrays:
    """As the corners of every frame of a long recording."""

    parts: tuple[np.ndarray, ...]
    flags: np.ndarray
    names: np.ndarray


def test_many_small_arrays_are_stored_in_few_and_read_back_as_they_were(tmp_path: Path) -> None:
    parts = tuple(np.arange(k * 2.0).reshape(k, 2) for k in range(50))
    given = ManyArrays(parts, np.array([True, False]), np.array(["lost", "detected"]))
    stored = artifacts.write_artifact(given, tmp_path / "many", 0.1)
    with np.load(stored.folder / "arrays.npz") as arrays:
        assert len(arrays.files) == 3
    again = artifacts.read_artifact(stored, ManyArrays)
    for before, after in zip(given.parts, again.parts, strict=True):
        np.testing.assert_array_equal(before, after)
    assert again.flags.tolist() == [True, False]
    assert again.names.tolist() == ["lost", "detected"]
