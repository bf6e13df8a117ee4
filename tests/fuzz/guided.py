"""Inputs that are led by what they reach: parsers in Python under atheris, libFuzzer for Python.

An input that runs lines or compares values that none before did is kept and changed further, so
that words, lengths and nesting are found which no sample has. Each target begins with the samples
of its kind. Faults are what they are for every kind (see `tests.fuzz.own`).
"""

from __future__ import annotations

import importlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from tests.fuzz.own import RefusedError, ended
from tests.fuzz.runner import REPOSITORY, Result, SkippedError

__all__ = ["TARGETS", "run"]

LONGEST_BYTES = 4096
SLOWEST_S = 10
MEMORY_MIB = 3000
TELL_EVERY = 500

Read = Callable[[bytes], object]


def run(target: str, seed: int, inputs: int, seconds: float) -> Result:
    """Feed a target for so long; faults end it.

    Raises:
        SkippedError: atheris is not installed.
    """
    if find_spec("atheris") is None:
        raise SkippedError("atheris, which leads by coverage, is not installed")
    result, begun = Result(target, seed), time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        numbers = map(str, (seed, inputs, max(1, round(seconds))))
        done = subprocess.run(
            [sys.executable, "-m", "tests.fuzz.guided", target, name, *numbers],
            cwd=REPOSITORY,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        counts = folder / "counts.json"
        result.ended = Counter(json.loads(counts.read_text()) if counts.is_file() else {})
        result.inputs = result.ended.total()  # those after it was last told are not counted
        peaks = [int(one) for one in re.findall(r"rss: (\d+)Mb", done.stderr)]
        result.peak_bytes = max(peaks, default=0) << 20
        if done.returncode:
            found = next(folder.glob("fault-*"), None)
            what = b"" if found is None else found.read_bytes()[:300]
            result.ended["FAULT"] += 1
            result.faults.append(f"{target} --seed {seed}: {what!r}: {done.stderr[-1500:]}")
    result.seconds = time.monotonic() - begun
    return result


def _scripts(folder: Path) -> tuple[list[bytes], Read]:
    from motorcade.ga.script import ScriptError, parse

    def read(data: bytes) -> None:
        try:
            parse(data.decode("utf-8", "surrogateescape"))
        except ScriptError as refused:  # of several lines, which show the script
            raise RefusedError from refused

    places = sorted((REPOSITORY / "docs" / "scripts").glob("*.clu"))
    return [path.read_bytes() for path in places], read


def _file(
    module: str, function: str, name: str, *samples: bytes
) -> Callable[[Path], tuple[list[bytes], Read]]:
    """A target that reads a file by a function of a module."""

    def made(folder: Path) -> tuple[list[bytes], Read]:
        found = getattr(importlib.import_module(module), function)
        path = folder / name

        def read(data: bytes) -> None:
            path.write_bytes(data)
            found(path)

        return list(samples) or _samples(name), read

    return made


def _samples(name: str) -> list[bytes]:
    """What a character's reader begins with."""
    from tests.animation.formats import samples

    return {
        "a.bvh": [samples.BVH],
        "a.md5mesh": [samples.md5_mesh_tower()],
        "a.md5anim": [samples.md5_motion_tower()],
        "a.gltf": [samples.rich_gltf().gltf(), samples.gltf_tower().gltf()],
        "a.glb": [samples.rich_gltf().glb(), samples.gltf_tower().glb()],
        "a.dae": [samples.collada_tower("STEP")],
    }[name]


def _telemetry(folder: Path) -> tuple[list[bytes], Read]:
    import numpy as np

    from motorcade.replays.readers import gpmf
    from tests.replays.readers import test_gopro

    packet = test_gopro.packet(np.ones((8, 3)), np.ones((8, 3)))
    return [packet], lambda data: gpmf._sensors(data, Path("a.mp4"))


_DOOR = "motorcade.animation.formats.door"
_PATH = b"0.05 1 2 3 0 0 0 1\n0.1 1 2.5 -3e-1 0 0 0.6 0.8\n"
_EUROC = b"#timestamp\n50000000,1,2,3,1,0,0,0,7\n100000000,1,2.5,-3e-1,0.8,0,0,0.6,7\n"
_BOARD = b'[board]\ntype = "checkerboard"\ncolumns = 9\nrows = 6\nsquare_m = 0.04\n'
_CAMERA = b'[camera]\nmodel = "radtan"\nwidth = 24\nheight = 16\nfx = 20.0\nfy = 21.0\ncx = 11.5\n'
_CAMERA += b"cy = 7.5\ndistortion = [-0.28, 0.07, 0.0, 0.0]\n"
_SCENE = b'{"objects": [{"name": "a", "scale": 0.5}, {"name": "b", "parent": "a"}]}'
_DRAGS = b'{"object": "a", "do": "rotate", "axis": [0, 0, 1], "amounts_rad": [0.1]}\n{"do": "undo"}'
_NOISE = b"gyroscope_noise_density: 1e-4\ngyroscope_random_walk: 1e-5\n"
_NOISE += b"accelerometer_noise_density: 1e-3\naccelerometer_random_walk: 1e-3\n"
_CHAIN = b"cam0:\n  camera_model: pinhole\n  intrinsics: [20, 21, 11, 7]\n  resolution: [24, 16]\n"
_MARKERS = b'{"format": "motorcade marker map 1", "markers": [{"id": 1, "side_m": 0.1}]}'

TARGETS: dict[str, Callable[[Path], tuple[list[bytes], Read]]] = {
    "guided-scripts": _scripts,
    "guided-bvh": _file(_DOOR, "read_motion", "a.bvh"),
    "guided-md5mesh": _file(_DOOR, "read_character", "a.md5mesh"),
    "guided-md5anim": _file(_DOOR, "read_motion", "a.md5anim"),
    "guided-gltf": _file(_DOOR, "read_character", "a.gltf"),
    "guided-glb": _file(_DOOR, "read_character", "a.glb"),
    "guided-collada": _file(_DOOR, "read_character", "a.dae"),
    "guided-telemetry": _telemetry,
    "guided-tum": _file("motorcade.replays.files.trajectories", "read_trajectory", "a", _PATH),
    "guided-euroc": _file("motorcade.replays.files.trajectories", "read_trajectory", "a", _EUROC),
    "guided-scene": _file("motorcade.animation.authoring.scene", "read_scene", "a", _SCENE),
    "guided-drags": _file("motorcade.animation.authoring.editor", "read_gestures", "a", _DRAGS),
    "guided-camera": _file(
        "motorcade.replays.readers.manifest.section", "read_camera", "a.toml", _CAMERA + _BOARD
    ),
    "guided-noise": _file("motorcade.replays.files.imu", "read_noise", "a.yaml", _NOISE),
    "guided-chain": _file("motorcade.replays.readers.kalibr", "read_chain", "a.yaml", _CHAIN),
}
"""What is fed: each gives its first inputs, and what reads one."""


def _lead(target: str, folder: Path, seed: int, inputs: int, seconds: int) -> None:
    """Run atheris in this process, which it ends."""
    import logging

    import atheris

    logging.getLogger("motorcade").setLevel(logging.CRITICAL)
    with atheris.instrument_imports(include=["motorcade"]):
        samples, read = TARGETS[target](folder)
        read_once = samples[0]
        _outcome(read, read_once)  # whatever is imported on the way
    corpus = folder / "corpus"
    corpus.mkdir()
    for index, sample in enumerate(samples):
        (corpus / f"{index}").write_bytes(sample[:LONGEST_BYTES])
    counts: Counter[str] = Counter()
    kept = folder / "counts.json"

    def feed(data: bytes) -> None:
        counts[_outcome(read, data)] += 1
        if counts.total() % TELL_EVERY == 0:
            kept.write_text(json.dumps(counts))

    options = [f"-seed={seed}", f"-max_len={LONGEST_BYTES}", f"-timeout={SLOWEST_S}"]
    options += [f"-rss_limit_mb={MEMORY_MIB}", f"-max_total_time={seconds}", f"-runs={inputs}"]
    options += [f"-artifact_prefix={folder}/fault-"]
    atheris.Setup([sys.argv[0], *options, str(corpus)], feed)
    atheris.Fuzz()


def _outcome(read: Read, data: bytes) -> str:
    return ended(lambda: read(data))


if __name__ == "__main__":
    os.environ.setdefault("MOTORCADE_THREADS", "1")
    _target, _folder, *_numbers = sys.argv[1:]
    _lead(_target, Path(_folder), *map(int, _numbers))
