"""Saved values: trajectories, maps and stages' outputs with faults in their archives.

Archives are changed member by member (another shape, type, order or content, one too few or too
many, packed giants), JSON value by value, and both byte by byte.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Trajectory
from motorcade.replays.engine.artifacts import read_artifact, write_artifact
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.slam import MapSnapshot
from tests.fuzz.hostile import bomb_npz
from tests.fuzz.kinds.manifests import write_maps
from tests.fuzz.kinds.trajectories import smooth_path
from tests.fuzz.mutations import changed_tree, mutated, one_of
from tests.fuzz.own import ended
from tests.fuzz.runner import Feed

__all__ = ["prepare"]


@dataclass(frozen=True)
class Output:
    """What a stage might give, of every type that is stored."""

    paths: dict[str, Trajectory]
    mask: NDArray[np.bool_]
    names: tuple[str, ...]
    share: float | None
    count: int


def prepare(folder: Path) -> Feed:
    """Saved values, changed, and read back."""
    path = smooth_path(12, 0.05)
    write_maps(folder, path)
    path.save(folder / "path.npz")
    value = Output({"raw": path}, np.ones(12, np.bool_), ("a", "b"), 0.5, 12)
    stored = write_artifact(value, folder / f"stage-{'0' * 24}", 0.1)
    readers: list[tuple[Path, Callable[[], object]]] = [
        (folder / "path.npz", lambda: _finite(Trajectory.load(folder / "path.npz"))),
        (folder / "slam_map.npz", lambda: MapSnapshot.load(folder / "slam_map.npz")),
        (folder / "marker_map.json", lambda: MarkerMap.load(folder / "marker_map.json")),
    ]
    readers += [
        (stored.folder / name, lambda: read_artifact(stored, Output))
        for name in ("value.json", "arrays.npz", "aside.json")
    ]
    whole = {path: path.read_bytes() for path, _ in readers}

    def feed(rng: np.random.Generator) -> str:
        for path, content in whole.items():
            path.write_bytes(content)
        path, read = one_of(readers, rng)
        path.write_bytes(_changed(path.suffix, whole[path], rng))
        return ended(read)

    return feed


def _finite(path: Trajectory) -> None:
    if not np.isfinite(path.poses.coefficients).all():
        raise AssertionError("poses are not finite")


def _changed(suffix: str, data: bytes, rng: np.random.Generator) -> bytes:
    if rng.random() < 0.25:
        return mutated(suffix, data, rng)
    if suffix == ".json":
        tree = json.loads(data)
        changed_tree(tree, rng)
        return json.dumps(tree).encode()
    if rng.random() < 0.002:
        return bomb_npz()
    with np.load(io.BytesIO(data)) as stored:
        arrays: dict[str, Any] = dict(stored)
    for _ in range(int(rng.integers(1, 3))):
        name = one_of([*arrays, "more", "a/../../b"], rng)
        kind = rng.random()
        if kind < 0.1:
            arrays.pop(name, None)
        elif kind < 0.2:
            arrays[name] = arrays[one_of([*arrays], rng)]
        else:
            given = arrays.get(name, np.zeros(3))
            arrays[name] = _array(given, rng)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    made = buffer.getvalue()
    return _with_more(made, rng) if rng.random() < 0.1 else made


def _array(given: NDArray[Any], rng: np.random.Generator) -> NDArray[Any]:
    """An array of another shape, type or content."""
    kind = rng.random()
    if kind < 0.3 and given.size and given.dtype.kind in "fiub":
        made = given.copy().reshape(-1)
        values = [0, 1, -1, 7, 255, 2**31, -(2**62), 2**62, np.nan, np.inf, 1e300, -1e-300]
        with np.errstate(all="ignore"):
            made[int(rng.integers(made.size))] = np.array(one_of(values, rng)).astype(made.dtype)
        return made.reshape(given.shape)
    if kind < 0.5:
        types = ["f4", "f8", "i8", "u1", "?", "c16", "U3", "S2", ">f8", ">i8", "M8[s]", "f2", "V4"]
        return np.zeros(given.shape, one_of(types, rng))
    if kind < 0.7 and given.ndim:
        return given[: int(rng.integers(len(given) + 1))]
    shapes = [(), (0,), (1,), (3, 3), (12, 8), (12, 12), (12,), (2, 2, 2), (1, 0), (100_000,)]
    return np.resize(given, one_of(shapes, rng)) if given.size else np.zeros(one_of(shapes, rng))


def _with_more(data: bytes, rng: np.random.Generator) -> bytes:
    """The archive with a member that is no array."""
    buffer = io.BytesIO(data)
    with zipfile.ZipFile(buffer, "a") as archive:
        archive.writestr(one_of(["notes.txt", "x/y.npy"], rng), rng.bytes(40))
    return buffer.getvalue()
