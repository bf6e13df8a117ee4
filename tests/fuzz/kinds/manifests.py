"""Manifests that hold any of the keys, right or wrong, and what is run on the recording then.

Keys come from the readers' own lists, so that a new one is fed too. Values are right ones, wrong
ones of any type, and names of files: good ones of another kind, pipes, devices, links, giants. What
opens is looked at, described, and now and then run through the cheap stages of the pipeline.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.replays.engine.graph import parse_knobs
from motorcade.replays.io.readers.manifest import reading, section, sensors
from motorcade.replays.io.readers.manifest import reading as slam
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.trajectories import write_trajectory
from motorcade.replays.pipeline.job import pipeline_graph
from motorcade.replays.tasks.inspection import describe
from motorcade.tracking.markers import FAMILIES
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.slam import MapSnapshot
from tests.fuzz.hostile import write_hostile
from tests.fuzz.kinds.recordings import expect_inside, look
from tests.fuzz.kinds.trajectories import STEPS_S, smooth_path
from tests.fuzz.mutations import mutated, one_of
from tests.fuzz.own import ended
from tests.fuzz.runner import Feed
from tests.replays import conftest as layouts
from tests.replays.readers.bag_poses import write_poses

__all__ = ["KEYS", "KNOBS", "MATRIX", "RIGHT", "prepare", "toml", "write_maps"]

COUNT = 12
KEYS: dict[str, tuple[str, ...]] = {
    "": reading._TOP,
    "frames": reading.FRAMES_KEYS,
    "camera": section.CAMERA_KEYS,
    "depth_camera": reading.DEPTH_CAMERA_KEYS,
    "stereo": reading.STEREO_KEYS,
    "board": ("type", "world_T_board", *{k for keys in section.BOARD_KEYS.values() for k in keys}),
    "markers": section.MARKERS_KEYS,
    "slam": slam.SLAM_KEYS,
    "truth": sensors.TRUTH_KEYS,
    "imu": reading.IMU_KEYS,
}
MATRIX = np.eye(4).tolist()
RIGHT: dict[str, list[Any]] = {
    "name": ["some name", "ü", "<script>"],
    "settings": [[], ["fused.gate=0.99"], ["placed.character=/dev/zero"], ["a.b=c"], ["x"]],
    "doubts": [[], ["the focal length is a guess"]],
    "start_s": [0.0, 0.1, 1e6],
    "end_s": [0.2, 1e6, 0.0],
    "images": ["images/*.png", "images/*", "*.png", "**/*.png"],
    "video": ["clip.mp4"],
    "rate_hz": [25.0, 30, 1e-3, 1e5, 1],
    "stamps": ["stamps.txt", "gaps.txt", "even.txt"],
    "stamps_unit": ["s", "ms", "us", "ns"],
    "depth": ["depth/*.png"],
    "depth_units_per_m": [1000, 5000.0],
    "masks": ["images", "depth", "."],
    "zoom_s": [[0.0, 0.1], [0.0, 1e6], [0.0], []],
    "zoom": [[1.0, 2.0], [1e-9, 1e9], [1.0], [2.0, 1.0]],
    "model": ["pinhole", "radtan", "equidistant"],
    "width": [layouts.WIDTH],
    "height": [layouts.HEIGHT],
    "fx": [20.0, 1e-3, 1e9],
    "fy": [21.0, 1e9],
    "cx": [11.5, -1e9],
    "cy": [7.5, 1e9],
    "matrix_file": ["K.txt"],
    "focal_sigma": [0.0, 0.02, 1.0],
    "fov_deg": [65.0, 1.0, 170.0],
    "rotation_deg": [0, 90, 180, 270],
    "metric": [True, False],
    "distortion": [[], [-0.28, 0.07, 0.0002, 1e-5], [0.1, 0.1], [1e12] * 5, [-5.0] * 8],
    "distortion_file": ["D.txt"],
    "colour_T_depth": [MATRIX],
    "readout_s": [0.0, 0.015, 0.2],
    "right": ["right/*.png"],
    "baseline_m": [0.12, 1e3],
    "type": list(section.BOARD_KEYS),
    "world_T_board": [MATRIX],
    "columns": [4, 9, 1000, 2],
    "rows": [3, 6, 1000, 12],
    "square_m": [0.04, 1e3],
    "spacing_m": [0.03, 1e3],
    "diameter_m": [0.015, 0.02],
    "family": list(FAMILIES),
    "marker_m": [0.03, 1e-6],
    "gap_m": [0.01],
    "first_id": [0, 500],
    "order": ["down", "up"],
    "turned_deg": [0, 90, 180, 270],
    "corner_squares": [True, False],
    "legacy": [True, False],
    "asymmetric": [True, False],
    "marker_id": [0, 1_000_000],
    "side_m": [0.08],
    "map_file": ["marker_map.json", "slam_map.npz"],
    "file": [
        "truth.tum",
        "truth.csv",
        "truth.kitti",
        "poses.txt",
        "vectors.txt",
        "imu.csv",
        "p*",
        "flight.bag",
    ],
    "format": list(sensors._FORMATS),
    "topic": ["/odom", "map/base", "/tf:map.base", "map/odom"],
    "convention": list(sensors._CONVENTIONS),
    "board_frame": ["opencv", "motorcade"],
    "times": ["times.txt", "gaps.txt"],
    "noise_file": ["imu.yaml"],
    "imu_T_camera": [MATRIX],
    "clock_offset_s": [0.012, -1e6, 1e6],
    "gyro_correction": [np.eye(3).tolist()],
    "accel_correction": [np.eye(3).tolist()],
}
WRONG: list[Any] = [
    -1,
    0,
    2**63,
    10**400,
    1e308,
    float("nan"),
    float("inf"),
    -1e-320,
    True,
    "",
    "x" * 5000,
    "a\nb",
    [],
    [[]],
    [1.0] * 200,
    [[1.0, 0.0, 0.0, 0.0]] * 4,
    np.diag([1.0, 1.0, -1.0, 1.0]).tolist(),
    (1e8 * np.eye(4)).tolist(),
    {},
    {"a": 1},
    {"data": MATRIX},
]
KNOBS = ("0", "1", "-1", "2", "0.5", "1e9", "-1e9", "nan", "none", "true", "auto", "imu", "")
STAGES = ("tracked", "camera_poses", "imu", "fused", "smoothed", "errors", "convergence")


def prepare(folder: Path) -> Feed:
    """A described folder and a video beside a manifest of any keys; opened, looked at, run."""
    layouts.write_images(folder, ["secret.png"])
    root = folder / "recording"
    names = _write(root)
    bare = folder / "euroc"
    bare.mkdir()
    layouts.MAKERS["euroc"](bare)
    graph = pipeline_graph()

    def feed(rng: np.random.Generator) -> str:
        local = rng.random() < 0.3
        place = one_of([root, root, root, root / "clip.mp4", bare], rng)
        found = place / "motorcade.toml" if place.is_dir() else folder / "given.toml"
        found = found if local else folder / "given.toml"
        (root / "motorcade.toml").unlink(missing_ok=True)
        (bare / "motorcade.toml").unlink(missing_ok=True)
        found.write_bytes(_manifest(rng, names, place == bare))
        given = None if local and place.is_dir() else found
        return ended(lambda: _used(place, given, rng))

    def _used(place: Path, given: Path | None, rng: np.random.Generator) -> None:
        recording = open_recording(place, given).intact()
        if given is None:
            expect_inside(recording)
        look(recording)
        json.dumps(describe(recording), allow_nan=False)
        if recording.truth is None or rng.random() < 0.5:
            return
        settings = (*recording.settings, *_settings(rng), "tracked.by=simulated")
        knobs = parse_knobs(settings, graph)
        cache = folder / "cache"
        try:
            graph.run(one_of(STAGES, rng), {"recording": recording}, cache, knobs)
        finally:
            shutil.rmtree(cache, ignore_errors=True)

    return feed


def _write(root: Path) -> tuple[str, ...]:
    """The recording, and names of the files that keys may point to."""
    images = [f"{index}.png" for index in range(COUNT)]
    for name in ("images", "right"):
        layouts.write_images(root / name, images, channels=1)
    (root / "depth").mkdir()
    for name in images:
        depth = np.full((layouts.HEIGHT, layouts.WIDTH), 1500, np.uint16)
        cv2.imwrite(str(root / "depth" / name), depth)
    (root / "made").mkdir()
    made = layouts.video_file.__wrapped__(root / "made")
    made.rename(root / "clip.mp4")
    path = smooth_path(COUNT, 0.04)
    write_trajectory(path, root / "truth.tum")
    write_trajectory(path, root / "truth.csv", "euroc")
    write_trajectory(path, root / "truth.kitti", "kitti")
    write_poses(root, "bag")
    np.savetxt(root / "poses.txt", path.motors.as_matrix().reshape(-1, 16))
    turns = path.motors.rotor.log() * -2.0
    np.savetxt(root / "vectors.txt", np.hstack([turns, path.motors.translation_m]))
    np.savetxt(root / "K.txt", [[20.0, 0.0, 11.5], [0.0, 21.0, 7.5], [0.0, 0.0, 1.0]])
    np.savetxt(root / "D.txt", [[-0.28, 0.07, 0.0002, 1e-5]])
    for name, step_s in (("stamps.txt", 0.033), ("even.txt", 0.04), ("times.txt", 0.04)):
        np.savetxt(root / name, step_s * np.arange(COUNT), fmt="%.9f")
    steps = np.resize([0.04, *STEPS_S], COUNT)
    np.savetxt(root / "gaps.txt", np.cumsum(steps), fmt="%.9f")
    imu = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 9.81], (200, 1))
    imu += 0.01 * np.random.default_rng(1).standard_normal(imu.shape)
    stamps = 5_000_000 * np.arange(200)
    rows = [f"{t},{','.join(map(repr, row))}" for t, row in zip(stamps, imu.tolist(), strict=True)]
    (root / "imu.csv").write_text("\n".join(rows))
    (root / "imu.yaml").write_text(
        "gyroscope_noise_density: 1.7e-04\ngyroscope_random_walk: 1.9e-05\n"
        "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n"
    )
    write_maps(root, path)
    names = [path.name for path in root.iterdir() if path.is_file()]
    return (*names, *write_hostile(root))


def write_maps(root: Path, path: Trajectory) -> None:
    """A small map of markers, and one of points."""
    poses = path.motors[:2]
    MarkerMap([0, 3], [0.1, 0.1], poses.rotor, poses.translation_m).save(root / "marker_map.json")
    rng, rows = np.random.default_rng(2), np.arange(30)
    MapSnapshot(
        path.time_ns[:3],
        Motor(path.motors.coefficients[:3]),
        rng.uniform(1.0, 3.0, (10, 3)),
        rng.integers(0, 256, (10, 32), dtype=np.uint8),
        rows // 10,
        rows % 10,
        rng.uniform(0.0, 15.0, (30, 2)),
        rng.uniform(1.0, 3.0, 30),
        True,
    ).save(root / "slam_map.npz")


def _manifest(rng: np.random.Generator, names: tuple[str, ...], bare: bool) -> bytes:
    """A right manifest of some of the tables, with up to three faults."""
    tables = _right(rng, bare)
    for _ in range(int(rng.choice(4, p=[0.3, 0.4, 0.2, 0.1]))):
        title = one_of([*tables, *tables, *KEYS], rng)
        table = tables.setdefault(title, {})
        key = one_of([*table, *table, *KEYS[title]] if title else ["name", "settings"], rng)
        kind = rng.random()
        if kind < 0.2:
            table.pop(key, None)
        elif key not in RIGHT or kind < 0.4:
            table[key] = one_of(WRONG, rng)
        else:
            table[key] = one_of(RIGHT[key] if kind < 0.6 else names, rng)
    lines = [f"{key} = {toml(value)}" for key, value in tables.pop("").items()]
    for title, table in tables.items():
        lines += [f"[{title}]", *(f"{key} = {toml(value)}" for key, value in table.items())]
    text = "\n".join(lines).encode("utf-8", "surrogatepass")
    return mutated(".toml", text, rng) if rng.random() < 0.1 else text


def _right(rng: np.random.Generator, bare: bool) -> dict[str, dict[str, Any]]:
    """Tables whose keys fit each other; `bare`: the recording has frames and truth of its own."""

    def some(*keys: str) -> dict[str, Any]:
        return {key: one_of(RIGHT[key], rng) for key in keys}

    made: dict[str, dict[str, Any]] = {"": some("name") if rng.random() < 0.3 else {}}
    video = not bare and rng.random() < 0.2
    if video:
        made["frames"] = some("video")
    elif not bare:
        images = {"images": "images/*.png"}
        made["frames"] = images | one_of([{"rate_hz": 25.0}, {"stamps": "gaps.txt"}], rng)
        if rng.random() < 0.3:
            made["frames"] |= some("depth", "depth_units_per_m")
    if rng.random() < 0.7:
        lens = one_of([{"fx": 20.0, "fy": 21.0, "cx": 11.5, "cy": 7.5}, {"fov_deg": 65.0}], rng)
        bent = one_of([{}, {"model": "radtan", "distortion": [-0.28, 0.07, 2e-4, 1e-5]}], rng)
        made["camera"] = lens | bent
        if "depth" in made.get("frames", {}):
            made["depth_camera"] = lens | some("colour_T_depth")
    if not video and not bare and rng.random() < 0.3:
        made["stereo"] = some("right", "baseline_m")
    if rng.random() < 0.3:
        kind = one_of(list(section.BOARD_KEYS), rng)
        made["board"] = {"type": kind} | some(*section.BOARD_KEYS[kind])
    if not bare and rng.random() < 0.2:
        made["markers"] = some("family", "side_m") | {"map_file": "marker_map.json"}
    if not bare and rng.random() < 0.2:
        made["slam"] = {"map_file": "slam_map.npz"}
    if not bare and rng.random() < 0.6:
        files = {"tum": "truth.tum", "euroc": "truth.csv", "kitti": "truth.kitti"}
        files |= {"matrix4": "poses.txt", "rotation_vector": "vectors.txt"}
        files |= {"bag": "flight.bag"}
        form = one_of(list(files), rng)
        made["truth"] = {"file": files[form], "format": form} | some("convention")
        if form == "bag":
            made["truth"] |= some("topic")
        elif form not in ("tum", "euroc"):
            made["truth"] |= one_of([{"rate_hz": 25.0}, {"times": "gaps.txt"}], rng)
    if not bare and rng.random() < 0.5:
        made["imu"] = some("noise_file", "imu_T_camera") | {"file": "imu.csv"}
    return made


def toml(value: Any) -> str:
    """A value as TOML; JSON is near enough for all but these."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str) and "\ud800" in value:
        return f'"{value}"'
    return json.dumps(value)


def _settings(rng: np.random.Generator) -> list[str]:
    """Some knobs of the stages, with values of any kind."""
    graph = pipeline_graph()
    made = []
    for _ in range(int(rng.integers(0, 4))):
        stage = one_of([name for name in STAGES if graph.stages[name].knobs], rng)
        knob = one_of(sorted(graph.stages[stage].knobs), rng)
        made.append(f"{stage}.{knob}={one_of(KNOBS, rng)}")
    return made
