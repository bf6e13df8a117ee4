"""What is fed by inputs that are led by coverage: the samples that each target begins with.

A target may also name words that its format knows and no sample holds: they stand in for words of
the samples, as numbers of the samples stand in for each other (`tests.fuzz.mutations.reworded`).
"""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tests.fuzz.own import RefusedError
from tests.fuzz.runner import REPOSITORY

__all__ = ["TARGETS", "Read", "Target"]

Read = Callable[[bytes], object]


@dataclass(frozen=True)
class Target:
    """What reads an input, and what inputs are made of.

    Fields:
        samples: valid inputs; those to come are made of them.
        read: reads one.
        suffix: of such files, which says what faults are put in (`tests.fuzz.mutations.mutated`).
        words: of the format, beside those of the samples.
    """

    samples: list[bytes]
    read: Read
    suffix: str = ""
    words: tuple[bytes, ...] = ()


def _scripts(folder: Path) -> Target:
    from motorcade.ga.script import ScriptError, parse
    from motorcade.ga.script.errors import ScriptWarning

    def read(data: bytes) -> None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ScriptWarning)
                parse(data.decode("utf-8", "surrogateescape"))
        except ScriptError as refused:  # of several lines, which show the script
            raise RefusedError from refused

    places = sorted((REPOSITORY / "docs" / "scripts").glob("*.clu"))
    words = b"e1 e2 e3 e0 einf exp log sqrt sin cos dual reverse grade pow abs pragma".split()
    words += b"if else loop break unroll in2out normalize include coefficient << >> && || [".split()
    return Target([path.read_bytes() for path in places], read, ".clu", tuple(words))


def _file(
    module: str, function: str, name: str, *samples: bytes, words: str = ""
) -> Callable[[Path], Target]:
    """A target that reads a file by a function of a module."""

    def made(folder: Path) -> Target:
        found = getattr(importlib.import_module(module), function)
        path = folder / name

        def read(data: bytes) -> None:
            path.write_bytes(data)
            found(path)

        known = tuple(words.encode().split())
        return Target(list(samples) or _samples(name), read, path.suffix, known)

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


def _telemetry(folder: Path) -> Target:
    import numpy as np

    from motorcade.replays.io.readers import gopro
    from tests.replays.readers import test_gopro

    packet = test_gopro.packet(np.ones((8, 3)), np.ones((8, 3)))
    return Target([packet], lambda data: gopro._sensors(data, Path("a.mp4")), ".gpmf")


_DOOR = "motorcade.animation.formats"
_PATHS = "motorcade.replays.io.trajectories"
_TUM = b"# stamps\n0.05 1 2 3 0 0 0 1\n0.1 1 2.5 -3e-1 0 0 0.6 0.8\n0.15 0 0 0 0.5 0.5 -0.5 0.5\n"
_EUROC = b"#timestamp\n50000000,1,2,3,1,0,0,0,7\n100000000,1,2.5,-3e-1,0.8,0,0,0.6,7\n"
_CAMERA = b'[camera]\nmodel = "radtan"\nwidth = 24\nheight = 16\nfx = 20.0\nfy = 21.0\ncx = 11.5\n'
_CAMERA += b"cy = 7.5\ndistortion = [-0.28, 0.07, 0.0, 0.0]\n"
_LENS = b'[camera]\nmodel = "equidistant"\nwidth = 640\nheight = 480\nfov_deg = 95.0\n'
_LENS += b"distortion = [0.01, -0.002, 0.0003, 1e-5]\n"
_WIDE = b"[camera]\nwidth = 1_000\nheight = 0x200\nfov_deg = 65\n"
_BOARD = b'[board]\ntype = "checkerboard"\ncolumns = 9\nrows = 6\nsquare_m = 0.04\n'
_SCENE = b'{"objects": [{"name": "a", "scale": 0.5}, {"name": "b", "parent": "a"}]}'
_TURNED = (
    b'{"objects": [{"name": "a", "position_m": [0.0, 0.5, 1.0], "wxyz": [1, 0, 0, 0]},'
    b' {"name": "b", "parent": "a", "wxyz": [0.5, 0.5, 0.5, 0.5], "scale": 2},'
    b' {"name": "c", "parent": "b", "position_m": [1e-3, -2, 0], "wxyz": [0.8, 0, 0.6, 0]}]}'
)
_EULER = (
    b'{"objects": [{"name": "a", "euler_deg": [0, 90, -30.5], "position_m": [0, 0, 0.7]},'
    b' {"name": "b", "parent": "a", "euler_deg": [10, 20, 30], "scale": 1.5}]}'
)
_DRAGS = (
    b'{"object": "a", "do": "rotate", "axis": [0, 0, 1], "amounts_rad": [0.1]}\n{"do": "undo"}\n'
    b'{"object": "b", "do": "translate", "axis": [1, 0, 0], "frame": "global",'
    b' "amounts_m": [0.2, -1e-3]}\n{"object": "a", "do": "scale", "factors": [1.1, 1.3]}\n'
    b'{"do": "redo"}\n'
)
_NOISE = b"gyroscope_noise_density: 1e-4\ngyroscope_random_walk: 1e-5\n"
_NOISE += b"accelerometer_noise_density: 1e-3\naccelerometer_random_walk: 1e-3\n"
_KALIBR_IMU = b"imu0:\n  rostopic: /imu0\n  update_rate: 200.0\n" + b"".join(
    b"  " + line + b"\n" for line in _NOISE.splitlines()
)
_CHAIN = b"cam0:\n  camera_model: pinhole\n  intrinsics: [20, 21, 11, 7]\n  resolution: [24, 16]\n"
_CHAIN_OF_TWO = b"".join(
    b"cam%d:\n  T_cam_imu:\n  - [0.0, -1.0, 0.0, 0.05]\n  - [1.0, 0.0, 0.0, -0.01]\n"
    b"  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n  camera_model: pinhole\n"
    b"  distortion_coeffs: [-0.28, 0.07, 0.0001, 1.0e-05]\n  distortion_model: %s\n"
    b"  intrinsics: [458.6, 457.3, 367.2, 248.4]\n  resolution: [752, 480]\n"
    b"  rostopic: /cam%d/image_raw\n" % (number, model, number)
    for number, model in enumerate((b"radtan", b"equidistant"))
)

TARGETS: dict[str, Callable[[Path], Target]] = {
    "guided-scripts": _scripts,
    "guided-bvh": _file(_DOOR, "read_motion", "a.bvh"),
    "guided-md5mesh": _file(_DOOR, "read_character", "a.md5mesh"),
    "guided-md5anim": _file(_DOOR, "read_motion", "a.md5anim"),
    "guided-gltf": _file(_DOOR, "read_character", "a.gltf"),
    "guided-glb": _file(_DOOR, "read_character", "a.glb"),
    "guided-collada": _file(_DOOR, "read_character", "a.dae"),
    "guided-telemetry": _telemetry,
    "guided-tum": _file(_PATHS, "read_trajectory", "a", _TUM),
    "guided-euroc": _file(_PATHS, "read_trajectory", "a", _EUROC),
    "guided-scene": _file(
        "motorcade.animation.authoring.scene_file", "read_scene", "a.json", _SCENE, _TURNED, _EULER
    ),
    "guided-drags": _file(
        "motorcade.animation.authoring.gestures",
        "read_gestures",
        "a",
        _DRAGS,
        words="local global",
    ),
    "guided-camera": _file(
        "motorcade.replays.io.readers.manifest.section",
        "read_camera",
        "a.toml",
        _CAMERA + _BOARD,
        _LENS,
        _WIDE + _BOARD,
        words="pinhole radtan equidistant matrix_file distortion_file true nan inf charuco",
    ),
    "guided-noise": _file("motorcade.replays.io.imu", "read_noise", "a.yaml", _NOISE, _KALIBR_IMU),
    "guided-chain": _file(
        "motorcade.replays.io.readers.kalibr",
        "read_chain",
        "a.yaml",
        _CHAIN,
        _CHAIN_OF_TWO,
        words="T_imu_cam omni radtan equidistant none null true",
    ),
}
"""What is fed, by names."""
