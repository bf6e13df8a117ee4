"""Command lines made of the parser's own definition, over files of every kind.

Each argument gets a value of its type, a wrong one, or a hostile name. A command must end with 0, 1
or 2; what goes wrong is told in one line, and is an error of ours or of the system.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import io
import shutil
from pathlib import Path

import numpy as np

from motorcade.fusion.smoothing.methods import METHODS as SMOOTHERS
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.trajectories import write_trajectory
from tests.animation.formats import samples
from tests.fuzz.hostile import write_hostile
from tests.fuzz.kinds.manifests import write_maps
from tests.fuzz.kinds.trajectories import smooth_path
from tests.fuzz.mutations import mutated, one_of
from tests.fuzz.own import is_own
from tests.fuzz.runner import Feed
from tests.replays.readers.bag_poses import write_poses
from tests.replays.tiny_recordings import write_tiny

__all__ = ["prepare"]

METHODS = ["auto", *SMOOTHERS, "linear"]

cli = importlib.import_module("motorcade.replays.cli.main")  # its package has a `main` of its own

SLOW = ("demo", "compare", "consistency", "doctor")
"""These take seconds whatever they are given; each is fed a quarter as often as any other."""
FED = [name for name in cli.NAMES if name not in SLOW] * 4 + list(SLOW)
SMALL = ("a.tum", "a.csv", "a.kitti", "a.npz", "long.tum", "long.csv", "imu.csv", "noise.yaml")
SMALL += ("camera.toml", "a.clu", "scene.json", "drags.jsonl", "a.glb", "a.bvh", "a.dae", "0.png")
SMALL += ("sweep.toml", "marker_map.json", "slam_map.npz", "tiny/motorcade.toml", "tiny/truth.tum")
SMALL += ("run/run.json", "poses.mcap", "transform.json", "magnetic.csv", "rig.toml", "chain.yaml")
LAST_STAGES = ("tracked", "camera_poses", "imu", "fused", "smoothed", "errors", "x")
WRITTEN = ("output", "out", "draw", "plot", "svg", "cache", "gltf", "rrd", "json", "covariance")
WRITTEN += ("deviations",)
FITTING = {
    "camera": ["camera.toml", "a.tum"],
    "config": ["sweep.toml"],
    "character": ["a.glb", "a.dae"],
    "estimate": ["a.tum", "a.csv"],
    "extrinsics": ["chain.yaml", "transform.json"],
    "gestures": ["drags.jsonl"],
    "images": ["0.png", "tiny/images"],
    "imu": ["imu.csv"],
    "input": ["a.tum", "a.csv", "a.kitti", "long.tum"],
    "inputs": ["a.tum", "long.tum", "poses.mcap:/odom", "poses.mcap:map/base", "poses.mcap"],
    "magnetometer": ["magnetic.csv"],
    "manifest": ["tiny/motorcade.toml", "camera.toml"],
    "motion": ["a.bvh", "a.glb"],
    "noise": ["noise.yaml"],
    "poses": ["a.tum", "a.csv"],
    "recording": ["tiny", "a.glb", "a.dae"],
    "recordings": ["tiny"],
    "reference": ["a.tum", "a.csv", "poses.mcap:/odom"],
    "resample_as": ["a.tum", "long.tum"],
    "rig": ["rig.toml", "camera.toml"],
    "run": ["run"],
    "scene": ["scene.json"],
    "script": ["a.clu"],
    "stream": ["imu.csv"],
    "trajectory": ["a.tum", "a.csv"],
    "transform_left": ["transform.json"],
    "transform_right": ["transform.json"],
    "truth": ["long.csv", "a.csv"],
}
"""Files that an argument of this name is meant for."""
BOUNDS = {
    "run": {"--executor": ("local",), "--until": LAST_STAGES},
    "sweep": {"--executor": ("local",)},
    "demo": {
        "--out": ("../given/demo", "../given/demo", "../given/demo", "../given/a.tum", "/proc/x"),
        "--seed": ("0", "0", "0", "-1", "x"),
        "--until": LAST_STAGES,
    },
    "compare": {
        "--executor": ("local",),
        "--trajectories": ("handheld", "gimbal_crossing", "zoom", "handheld"),
        "--degradations": ("gaussian", "outliers", "gaussian"),
        "--methods": ("gaussian", "one_euro", "exponential", "linear"),
        "--representations": ("motor", "euler", "motor"),
        "--seeds": ("1", "1", "0", "-1"),
    },
    "consistency": {
        "--executor": ("local",),
        "--motions": ("handheld", "gimbal_crossing", "zoom", "x"),
        "--filters": ("motor", "motor", "quaternion,euler", "motor,,"),
        "--runs": ("1", "1", "1", "1", "0", "x"),
        "--duration-s": ("10", "10", "11.5", "0", "nan"),
    },
}
"""What stands last in a command's line, and so counts: else jobs would take minutes."""
SUFFIXES = ("", ".tum", ".csv", ".glb", ".svg", ".json", ".toml", ".mp4", ".c", ".rrd")
NUMBERS = (
    "0",
    "1",
    "-1",
    "0.5",
    "2",
    "10",
    "200",
    "1e3",
    "1e9",
    "1e300",
    "nan",
    "inf",
    "-inf",
    "x",
)
WORDS = ("motor", "euler", "auto", "spline", "kalman", "none", "tag36h11", "walk,run", "9x6 0.04")
WORDS += (
    "fused.gate=0.99",
    "window_s=0.5",
    "sigma_s=1e300",
    "processes:2",
    "clip@0.5",
    "ü",
    "a\nb",
)


def prepare(folder: Path) -> Feed:
    """Commands with arguments of all kinds."""
    given = folder / "given"
    names = _write(given)
    whole = {path: path.read_bytes() for path in map(given.joinpath, SMALL)}
    parsers = {name: _arguments(name) for name in cli.NAMES}
    made = [entry.name for entry in (given / "demo").iterdir()]
    place = folder / "place"

    def feed(rng: np.random.Generator) -> str:
        for path, content in whole.items():
            if path.read_bytes() != content:
                path.write_bytes(content)
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        if rng.random() < 0.2:
            changed: Path = one_of(list(whole), rng)
            changed.write_bytes(mutated(changed.suffix, whole[changed], rng))
        name = one_of(FED, rng)
        line = [name, *_line(parsers[name], name, names, rng)]
        try:
            with contextlib.chdir(place):
                return _called(line)
        finally:
            if name == "demo":
                _remove_all_but(made, given / "demo")

    return feed


def _remove_all_but(names: list[str], folder: Path) -> None:
    for entry in folder.iterdir():
        if entry.name not in names:
            shutil.rmtree(entry) if entry.is_dir() else entry.unlink()


def _called(line: list[str]) -> str:
    """Run a command line; how it ended."""
    caught: list[Exception] = []
    told, errors = cli._error_text, io.StringIO()

    def kept(error: Exception) -> str:
        caught.append(error)
        return told(error)

    cli._error_text = kept
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
            status = cli.main(line)
    except SystemExit as stop:
        status = stop.code if isinstance(stop.code, int) else 1
    finally:
        cli._error_text = told
    for error in caught:
        if not (is_own(error) or _of_the_system(error)):
            told_as = f"{type(error).__name__}: {str(error)[:200]}"
            raise AssertionError(f"{told_as} of {' '.join(line)[:300]!r}") from error
    text = errors.getvalue()
    if "Traceback" in text or status not in (0, 1, 2) or len(text) > 20_000:
        raise AssertionError(f"{' '.join(line)[:300]!r}: {status}, {text[-300:]!r}")
    if caught and text.count("\n") > 30:
        raise AssertionError(f"{' '.join(line)[:300]!r}: told in {text[-300:]!r}")
    return "valid" if status == 0 else "refused"


def _of_the_system(error: Exception) -> bool:
    """Whether the system, or a package that is missing, says what is wrong."""
    if isinstance(error, ModuleNotFoundError):
        return True
    return isinstance(error, OSError) and error.filename is not None


def _arguments(name: str) -> list[argparse.Action]:
    """What a command takes."""
    parser = cli.command_parser((cli.NAMES[name],))
    commands = next(one for one in parser._actions if isinstance(one.choices, dict))
    taken: list[argparse.Action] = commands.choices[name]._actions
    return [one for one in taken if one.dest not in ("help", "verbose", "executor", "list")]


def _line(
    actions: list[argparse.Action], name: str, names: tuple[str, ...], rng: np.random.Generator
) -> list[str]:
    """Arguments in any number, most often all that are needed."""
    made: list[str] = []
    for action in actions:
        needed = action.required or not action.option_strings
        if rng.random() > (0.95 if needed else 0.25):
            continue
        option = [one_of(action.option_strings, rng)] if action.option_strings else []
        if isinstance(action.nargs, int):
            count = action.nargs
        elif action.nargs in ("+", "*"):
            count = int(rng.integers(1, 4))
        else:
            count = 1
        made += option + [_value(action, names, rng) for _ in range(count)]
    bounds = dict(BOUNDS.get(name, {}))
    if name == "compare" and "--input" in made:
        for other in ("--trajectories", "--degradations", "--seeds"):
            del bounds[other]
        bounds["--truth"] = ("../given/long.csv", "../given/long.csv", "../given/a.csv")
    elif name == "compare":
        made.append("--quick")
    for option, values in bounds.items():
        made += [option, one_of(values, rng)]
    if rng.random() < 0.03:
        made.append(one_of(["--", "-h", "--no-such-option", "more", "-v", "--version"], rng))
    return made


def _value(action: argparse.Action, names: tuple[str, ...], rng: np.random.Generator) -> str:
    kind = rng.random()
    if action.choices is not None and kind < 0.9:
        return str(one_of(list(action.choices), rng))
    if action.dest in WRITTEN:
        place = one_of(["out", "out", "new/out", "../given/folder.png/x", "/proc/x"], rng)
        return str(place) + str(one_of(SUFFIXES, rng))
    if action.type is Path or action.dest in ("noise", "board", "camera"):
        if kind < 0.8 and action.dest in FITTING:
            return "../given/" + str(one_of(FITTING[action.dest], rng))
        good = [one for one in names if "/" not in one and len(one) < 100]
        return "../given/" + str(one_of(good, rng)) if kind < 0.97 else str(one_of(names, rng))
    if action.type in (float, int):
        return str(one_of(NUMBERS, rng))
    if action.dest == "family":
        return "tag36h11"
    if action.dest in ("representation", "method") and kind < 0.9:
        return str(
            one_of(["motor", "quaternion"] if action.dest == "representation" else METHODS, rng)
        )
    return str(one_of(WORDS, rng))


def _write(given: Path) -> tuple[str, ...]:
    """Files of every kind that a command may take; their names."""
    from motorcade.fusion.imu import simulate_imu
    from motorcade.fusion.imu.noise import ADIS16448

    given.mkdir()
    path = smooth_path(80, 0.05)
    write_trajectory(path, given / "a.tum")
    write_trajectory(path, given / "a.csv", "euroc")
    write_trajectory(path, given / "a.kitti", "kitti")
    path.save(given / "a.npz")
    long = smooth_path(220, 0.05)
    write_trajectory(long, given / "long.tum")
    write_trajectory(long, given / "long.csv", "euroc")
    stream = simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(0)).stream
    write_imu(stream, given / "imu.csv")
    (given / "noise.yaml").write_text(
        "gyroscope_noise_density: 1.7e-04\ngyroscope_random_walk: 1.9e-05\n"
        "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n"
    )
    (given / "camera.toml").write_text(
        "[camera]\nwidth = 24\nheight = 16\nfx = 20.0\nfy = 20.0\ncx = 11.5\ncy = 7.5\n"
        '[board]\ntype = "checkerboard"\ncolumns = 4\nrows = 3\nsquare_m = 0.04\n'
    )
    _write_rig(given)
    (given / "a.clu").write_text("?x = e1 * (e2 + a);\n?R = exp(0.3*e1^e2);\n")
    (given / "scene.json").write_text('{"objects": [{"name": "cup"}]}')
    (given / "drags.jsonl").write_text('{"object": "cup", "do": "scale", "factors": [1.1]}\n')
    (given / "a.glb").write_bytes(samples.rich_gltf().glb())
    (given / "a.bvh").write_bytes(samples.BVH)
    (given / "a.dae").write_bytes(samples.collada_tower())
    write_maps(given, path)
    (given / "transform.json").write_text(
        '{"x": 1, "y": 2, "z": 3, "qx": 0, "qy": 0, "qz": 0.6, "qw": 0.8, "scale": 1}'
    )
    shutil.move(write_poses(given, "mcap"), given / "poses.mcap")
    write_tiny(given / "tiny", 0.3, count=8)
    shutil.copy(given / "tiny" / "images" / "0.png", given / "0.png")
    (given / "sweep.toml").write_text(
        'recordings = ["tiny"]\n[knobs]\ntracked.by = "simulated"\nconvergence.duration_s = 0.2\n'
    )
    (given / "run").mkdir()
    (given / "run" / "run.json").write_text('{"recording": "x", "manifest": null, "other": 1}')
    _write_demo(given / "demo" / "recording")
    names = tuple(sorted(one.name for one in given.iterdir()))
    hostile = [one for one in write_hostile(given) if "\0" not in one and "\ud800" not in one]
    return (*names, *names, *hostile, "\udcff")


def _write_rig(given: Path) -> None:
    """What calibrating writes, and a magnetometer's readings."""
    (given / "rig.toml").write_text(
        '[imu]\nnoise_file = "noise.yaml"\nclock_offset_s = 0.01\n'
        "gyro_correction = [[1.01, 0, 0], [0, 0.99, 0], [0, 0, 1]]\n"
        "accel_correction = [[1, 0, 0], [0.01, 1, 0], [0, 0, 1.02]]\n"
        "imu_T_camera = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.1], [0, 0, 0, 1]]\n"
    )
    (given / "chain.yaml").write_text(
        "cam0:\n  camera_model: pinhole\n  distortion_model: radtan\n"
        "  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  intrinsics: [20.0, 20.0, 11.5, 7.5]\n"
        "  resolution: [24, 16]\n  timeshift_cam_imu: 0.01\n"
        "  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.1], [0, 0, 0, 1]]\n"
    )
    stamps = [line.split(",")[0] for line in (given / "imu.csv").read_text().splitlines()[1::4]]
    rows = [f"{stamp},0.2,{0.01 * (k % 7)},-0.4" for k, stamp in enumerate(stamps)]
    (given / "magnetic.csv").write_text("\n".join(rows) + "\n")


def _write_demo(folder: Path) -> None:
    """A small recording in place of the demo's own, which takes half a minute to be drawn."""
    from motorcade.replays.demo import write_recording
    from motorcade.replays.demo.recording import MARKER, ensure_demo_recording
    from motorcade.replays.engine.store import code_digest

    folder.parent.mkdir()
    write_tiny(folder, 0.3, count=8)
    (folder / MARKER).write_text(f"{code_digest(write_recording)} seed 0\n")
    ensure_demo_recording(folder, 0)
