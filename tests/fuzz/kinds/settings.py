"""Files that say how things are: cameras, boards, noise, camera chains, sweeps, knobs, streams.

Trees are changed value by value and written as TOML or YAML, which is then changed as text now and
then; IMU streams are read and their noise is estimated.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from motorcade.fusion.imu import estimate_noise
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.replays.comparison.sweep import read_sweep
from motorcade.replays.engine.graph import parse_knobs
from motorcade.replays.io.imu import read_imu, read_noise
from motorcade.replays.io.readers.calibration import read_matrix, read_numbers, yaml_transform
from motorcade.replays.io.readers.kalibr import read_chain
from motorcade.replays.io.readers.manifest.section import read_board, read_camera
from motorcade.replays.pipeline.job import pipeline_graph
from tests.fuzz.hostile import write_hostile
from tests.fuzz.kinds.manifests import KNOBS, MATRIX, toml
from tests.fuzz.mutations import changed_tree, mutated, one_of
from tests.fuzz.own import ended
from tests.fuzz.runner import Feed

__all__ = ["prepare"]

CAMERA = {"model": "radtan", "width": 752, "height": 480, "fx": 458.6, "fy": 457.2, "cx": 367.2}
CAMERA |= {"cy": 248.3, "distortion": [-0.28, 0.07, 0.0002, 1e-5]}
SENSOR = {
    "T_BS": {"cols": 4, "rows": 4, "data": np.eye(4).ravel().tolist()},
    "resolution": [752, 480],
    "intrinsics": [458.6, 457.2, 367.2, 248.3],
    "distortion_model": "radial-tangential",
    "distortion_coefficients": [-0.28, 0.07, 0.0002, 1e-5],
    "gyroscope_noise_density": 1.7e-4,
    "gyroscope_random_walk": 1.9e-5,
    "accelerometer_noise_density": 2.0e-3,
    "accelerometer_random_walk": 3.0e-3,
}
CHAIN_CAMERA = {
    "camera_model": "pinhole",
    "distortion_model": "equidistant",
    "distortion_coeffs": [0.01, -0.02, 0.003, -0.0004],
    "intrinsics": [20.0, 21.0, 11.5, 7.5],
    "resolution": [24, 16],
    "rostopic": "/cam0/image_raw",
    "T_cam_imu": MATRIX,
}
BOARD = {"type": "charuco", "family": "aruco_4x4_50", "columns": 5, "rows": 4}
BOARD |= {"square_m": 0.04, "marker_m": 0.03}
SWEEP: dict[str, Any] = {
    "recordings": ["one", {"path": "two", "manifest": "camera.toml"}, "*"],
    "seeds": [0, 1],
    "until": "errors",
    "knobs": {"tracked": {"by": "simulated"}, "fused": {"gate": [0.99, 0.999]}},
}
READERS = [read_camera, read_noise, read_chain, read_imu, read_numbers, read_matrix]
NAMES = ["9x6 0.04", "checkerboard 9x6 0.04", "tag36h11", "", "x", "9x6", "-1x6:0.1", "a" * 500]


def prepare(folder: Path) -> Feed:
    """Settings of every kind, changed, and read."""
    hostile = write_hostile(folder)
    graph = pipeline_graph()
    stages = [name for name, stage in graph.stages.items() if stage.knobs]

    def tree(given: dict[str, Any], name: str, write: Any, read: Callable[[Path], object]) -> Any:
        def act(rng: np.random.Generator) -> str:
            made = copy.deepcopy(given)
            for _ in range(int(rng.integers(0, 3))):
                changed_tree(made, rng)
            data = write(made).encode("utf-8", "surrogatepass")
            path = folder / name
            path.write_bytes(mutated("", data, rng) if rng.random() < 0.25 else data)
            return ended(lambda: read(path))

        return act

    def board(path: Path) -> object:
        return read_board(str(path))

    chain = {"cam0": CHAIN_CAMERA, "cam1": CHAIN_CAMERA}
    kinds: list[Callable[[np.random.Generator], str]] = [
        tree({"camera": CAMERA}, "given.toml", _tables, read_camera),
        tree({"board": BOARD}, "given.toml", _tables, board),
        tree(SENSOR, "given.yaml", yaml.safe_dump, read_camera),
        tree(SENSOR, "given.yaml", _opencv, read_noise),
        tree({"imu0": SENSOR}, "given.yaml", yaml.safe_dump, ImuNoise.load),
        tree(SENSOR, "given.yaml", json.dumps, yaml_transform),
        tree(chain, "given.yaml", yaml.safe_dump, read_chain),
        tree(SWEEP, "given.toml", _tables, lambda path: read_sweep(path, graph)),
        tree(SWEEP, "given.toml", _tables, lambda path: read_sweep(path, graph)),
    ]

    def knobs(rng: np.random.Generator) -> str:
        stage = one_of([*stages, "x", ""], rng)
        known = sorted(graph.stages[stage].knobs) if stage in stages else ["a"]
        value = one_of([*KNOBS, "1,2", ",", "motor,euler", "1e400", "0x1", "١", "x" * 300], rng)
        given = f"{stage}.{one_of([*known, 'none', ''], rng)}={value}"
        return ended(
            lambda: parse_knobs([mutated("", given.encode(), rng).decode("latin-1")], graph)
        )

    def stream(rng: np.random.Generator) -> str:
        path = folder / "imu.csv"
        path.write_bytes(_stream(rng))
        return ended(lambda: estimate_noise(read_imu(path)))

    def names(rng: np.random.Generator) -> str:
        path = folder / str(one_of(hostile, rng))
        read = one_of(
            [read_camera, read_noise, read_chain, read_imu, read_numbers, read_matrix], rng
        )
        return ended(lambda: read(path))

    def named_board(rng: np.random.Generator) -> str:
        text = mutated("", str(one_of(NAMES, rng)).encode(), rng).decode("latin-1")
        return ended(lambda: read_board(text))

    kinds += [knobs, stream, names, named_board]

    def feed(rng: np.random.Generator) -> str:
        ending: str = one_of(kinds, rng)(rng)
        return ending

    return feed


def _tables(tree: Any) -> str:
    """A tree as TOML: tables of tables, as far as TOML can say it."""
    lines = []
    for key, value in tree.items() if isinstance(tree, dict) else ():
        if isinstance(value, dict) and value:
            lines += [f"[{key}]", *(f"{name} = {toml(one)}" for name, one in value.items())]
        else:
            lines.insert(0, f"{key} = {toml(value)}")
    return "\n".join(lines)


def _opencv(tree: Any) -> str:
    return "%YAML:1.0\n" + yaml.safe_dump(tree)


def _stream(rng: np.random.Generator) -> bytes:
    """An IMU that lies still, in any size, rate, noise and state."""
    count = int(one_of([2, 30, 120, 400], rng))
    scale = float(one_of([0.0, 1e-320, 1e-160, 1e-30, 1e-6, 0.01, 1.0, 1e9, 1e160], rng))
    values = scale * rng.standard_normal((count, 6))
    if rng.random() < 0.6:
        values[:, 5] += float(one_of([9.81, 1.0, 1000.0, 32.174, 1e9], rng))
    if rng.random() < 0.3:
        values[int(rng.integers(count)), int(rng.integers(6))] = one_of(
            [1e9, -1e12, 1e300, 0.0], rng
        )
    if rng.random() < 0.2:
        values = np.round(values, 1)
    step_ns = int(one_of([1, 1000, 5_000_000, 10**9, 10**15], rng))
    stamps = int(one_of([0, 10**18, -(2**61)], rng)) + step_ns * np.arange(count)
    if rng.random() < 0.3:
        stamps[count // 2 :] += int(one_of([1, 3600, 86_400 * 365 * 30], rng)) * 10**9
    rows = zip(stamps.tolist(), values.tolist(), strict=True)
    data = "\n".join(f"{stamp},{','.join(map(repr, row))}" for stamp, row in rows).encode()
    return mutated("", data, rng) if rng.random() < 0.2 else data
