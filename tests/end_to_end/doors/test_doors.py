"""Pipes, devices and files beyond every limit, given to all that opens files: none may hang.

Each door is tried by the name of a function's argument, of a command's argument and of a key in a
manifest; and each file of every layout of recordings is replaced by a pipe.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from motorcade.animation.authoring import read_gestures, read_scene
from motorcade.animation.formats import read_character, read_motion
from motorcade.fusion import ImuNoise
from motorcade.ga import Trajectory
from motorcade.ga.archives import read_arrays
from motorcade.ga.codegen.generate import read_script
from motorcade.render.video import read_frames
from motorcade.replays.cli.main import main
from motorcade.replays.comparison.report.results import Results
from motorcade.replays.io.imu import read_imu, read_noise
from motorcade.replays.io.readers.calibration import read_matrix, read_numbers, read_yaml
from motorcade.replays.io.readers.frames.images import read_image
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.readers.ros.reader import read_bag
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.replays.pipeline.runs import open_run
from motorcade.tracking import MarkerMap
from motorcade.tracking.slam.mapping.map import MapSnapshot
from tests.animation.formats.samples import md5_mesh_tower
from tests.end_to_end.doors.children import Outcome, in_child
from tests.replays.conftest import MAKERS
from tests.replays.tiny_recordings import MANIFEST, write_tiny

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks, and bounds their memory")

BEYOND_ALL_LIMITS = (1 << 40) + 1


def pipe(path: Path) -> None:
    os.mkfifo(path)


def device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def giant(path: Path) -> None:
    """A file without content that is larger than any limit, and takes no room."""
    with path.open("wb") as file:
        file.truncate(BEYOND_ALL_LIMITS)


ATTACKS = (pipe, device, giant)
REASONS = (
    "expected a file, got a folder or a device",
    "bytes, got 1099511627777",
    "expected a folder or a file, got a pipe or a device",
    "expected 'mannequin' or a file",
)

FUNCTIONS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "Trajectory.load": ("a.npz", Trajectory.load),
    "MapSnapshot.load": ("a.npz", MapSnapshot.load),
    "read_arrays": ("a.npz", read_arrays),
    "MarkerMap.load": ("a.json", MarkerMap.load),
    "ImuNoise.load": ("a.yaml", ImuNoise.load),
    "read_noise": ("a.yaml", read_noise),
    "read_yaml": ("a.yaml", read_yaml),
    "read_matrix": ("a.txt", read_matrix),
    "read_numbers": ("a.txt", lambda path: read_numbers(path, 3)),
    "read_imu": ("a.csv", read_imu),
    "read_trajectory tum": ("a.tum", lambda path: read_trajectory(path, "tum")),
    "read_trajectory euroc": ("a.csv", lambda path: read_trajectory(path, "euroc")),
    "read_trajectory kitti": ("a.txt", lambda path: read_trajectory(path, "kitti", rate_hz=10.0)),
    "read_trajectory bag": ("a.bag", lambda path: read_trajectory(f"{path}:/odom")),
    "read_trajectory packed bag": ("a.bag.bz2", lambda path: read_trajectory(f"{path}:/odom")),
    "read_trajectory mcap": ("a.mcap", lambda path: read_trajectory(f"{path}:map/base_link")),
    "read_image": ("a.png", lambda path: read_image(path, "a", None)),
    "read_frames": ("a.mp4", lambda path: list(read_frames(path))),
    "read_bag": ("a.bag", lambda path: list(read_bag(path, ("tf/msg/tfMessage",)))),
    "read_bag packed": ("a.bag.bz2", lambda path: list(read_bag(path, ("tf/msg/tfMessage",)))),
    "read_script": ("a.clu", read_script),
    "read_scene": ("a.json", read_scene),
    "read_gestures": ("a.jsonl", read_gestures),
    "Results.read": ("results.json", lambda path: Results.read(path.parent)),
    "open_run": ("run.json", lambda path: open_run(path.parent)),
    **{
        f"read_character {kind}": (f"a.{kind}", read_character)
        for kind in ("glb", "gltf", "dae", "md5mesh", "bvh", "fbx")
    },
    **{
        f"read_motion {kind}": (f"a.{kind}", read_motion)
        for kind in ("glb", "gltf", "dae", "md5anim", "bvh", "fbx")
    },
    **{
        f"open_recording {kind}": (f"a.{kind}", lambda path: open_recording(path).digest())
        for kind in ("mp4", "avi", "mkv", "bag", "mcap", "db3")
    },
}

# FILE stands for what is attacked, GOOD for a short trajectory.
COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("a.mp4", "run FILE --out OUT"),
    "run --manifest": ("a.toml", "run TINY --manifest FILE --out OUT"),
    "sweep": ("a.toml", "sweep FILE --out OUT"),
    "inspect recording": ("a.mp4", "inspect FILE"),
    "inspect character": ("a.glb", "inspect FILE"),
    "inspect --manifest": ("a.toml", "inspect TINY --manifest FILE"),
    "detect": ("a.png", "detect FILE --family tag36h11"),
    "detect --camera": (
        "a.yaml",
        "detect TINY/images/0.png --family tag36h11 --size-m 0.1 --camera FILE",
    ),
    "calibrate": ("a.png", "calibrate FILE --board checkerboard_9x6_30mm -o OUT.toml"),
    "calibrate video": ("a.mp4", "calibrate FILE --board checkerboard_9x6_30mm -o OUT.toml"),
    "smooth": ("a.tum", "smooth FILE -o OUT.tum"),
    "smooth bag": ("a.bag", "smooth FILE:/odom -o OUT.tum"),
    "trajectory": ("a.tum", "trajectory FILE"),
    "trajectory bag": ("a.mcap", "trajectory FILE"),
    "trajectory --reference": ("a.tum", "trajectory GOOD --reference FILE --align se3"),
    "trajectory --resample-as": ("a.tum", "trajectory GOOD --resample-as FILE"),
    "trajectory --times": ("a.txt", "trajectory KITTI --times FILE"),
    "trajectory --transform-left": ("a.json", "trajectory GOOD --transform-left FILE"),
    "trajectory --transform-right": ("a.npy", "trajectory GOOD --transform-right FILE"),
    "evaluate estimate": ("a.tum", "evaluate FILE GOOD"),
    "evaluate reference": ("a.tum", "evaluate GOOD FILE"),
    "simulate-imu": ("a.tum", "simulate-imu FILE -o OUT.csv"),
    "simulate-imu --noise": ("a.yaml", "simulate-imu GOOD --noise FILE -o OUT.csv"),
    "allan": ("a.csv", "allan FILE"),
    "sync trajectory": ("a.tum", "sync FILE GOOD"),
    "sync imu": ("a.csv", "sync GOOD FILE"),
    "sync --noise": ("a.yaml", "sync GOOD IMU --noise FILE"),
    "orient": ("a.csv", "orient FILE -o OUT.tum"),
    "orient HDF5": ("a.hdf5", "orient FILE --magnetometer -o OUT.tum"),
    "orient --magnetometer": ("a.csv", "orient IMU --magnetometer FILE -o OUT.tum"),
    "orient --noise": ("a.yaml", "orient IMU --noise FILE -o OUT.tum"),
    "generate": ("a.clu", "generate FILE"),
    "blend": ("a.glb", "blend FILE --clips a,b --out OUT.glb"),
    "blend --motion": ("a.bvh", "blend HERO --clips wave,b --motion FILE --out OUT.glb"),
    "author": ("a.json", "author FILE --gestures GOOD"),
    "author --gestures": ("a.jsonl", "author SCENE --gestures FILE"),
    "export": ("run.json", "export HERE --gltf OUT.glb"),
    "compare --input": ("a.tum", "compare --input FILE --truth GOOD --out OUT"),
    "compare --truth": ("a.tum", "compare --input GOOD --truth FILE --out OUT"),
    "run placed.character": (
        "a.glb",
        "run TINY --out OUT --until placed --set placed.character=FILE",
    ),
}

CAMERA = "[camera]\nwidth = 24\nheight = 16\nfx = 20.0\nfy = 20.0\ncx = 11.5\ncy = 7.5\n"
IMAGES = '[frames]\nimages = "images/*.png"\nrate_hz = 20.0\n'
KEYS: dict[str, tuple[str, str]] = {
    "the manifest": ("recording.toml", ""),
    "[frames] video": ("a.mp4", '[frames]\nvideo = "a.mp4"\n'),
    "[frames] images": ("images/0.png", IMAGES + CAMERA),
    "[frames] stamps": (
        "a.txt",
        '[frames]\nimages = "images/*.png"\nstamps = "a.txt"\nstamps_unit = "s"\n' + CAMERA,
    ),
    "[camera] file": (
        "a.txt",
        IMAGES + '[camera]\nwidth = 24\nheight = 16\nmatrix_file = "a.txt"\n',
    ),
    "[camera] distortion": (
        "a.txt",
        IMAGES + CAMERA + 'model = "radtan"\ndistortion_file = "a.txt"\n',
    ),
    "[imu] file": ("a.csv", IMAGES + CAMERA + '[imu]\nfile = "a.csv"\n'),
    "[imu] noise_file": (
        "a.yaml",
        IMAGES + CAMERA + '[imu]\nfile = "imu.csv"\nnoise_file = "a.yaml"\n',
    ),
    "[truth] file": (
        "a.tum",
        IMAGES
        + CAMERA
        + '[truth]\nfile = "a.tum"\nformat = "tum"\nconvention = "world_T_camera"\n',
    ),
    "[markers] map_file": (
        "a.json",
        IMAGES + CAMERA + '[markers]\nfamily = "tag36h11"\nside_m = 0.1\nmap_file = "a.json"\n',
    ),
    "[slam] map_file": ("a.npz", IMAGES + CAMERA + '[slam]\nmap_file = "a.npz"\n'),
    "[stereo] right": (
        "right/0.png",
        IMAGES + CAMERA + '[stereo]\nright = "right/*.png"\nbaseline_m = 0.1\n',
    ),
}


def assert_refused(outcome: Outcome, file: str) -> None:
    assert outcome.ended, outcome
    assert {"ValueError", "OSError"} & set(outcome.kind), outcome
    assert "\n" not in outcome.text.strip(), outcome
    assert_told(outcome.text, file, outcome)


def assert_told(line: str, file: str, outcome: Outcome) -> None:
    """The line is about the file itself, so that no earlier refusal hides the door."""
    assert Path(file).name in line, outcome
    assert any(reason in line for reason in REASONS), outcome


@pytest.mark.parametrize("attack", ATTACKS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_no_function_waits_or_fills_the_memory(
    tmp_path: Path, name: str, attack: Callable[[Path], None]
) -> None:
    file, act = FUNCTIONS[name]
    attack(tmp_path / file)
    assert_refused(in_child(lambda: act(tmp_path / file)), file)


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording without faults, with an IMU."""
    folder = write_tiny(tmp_path_factory.mktemp("tiny") / "recording", 0.3, 5)
    (folder / "right").mkdir()
    for file in (folder / "images").iterdir():
        (folder / "right" / file.name).write_bytes(file.read_bytes())
    rows = [f"{index * 5_000_000},0,0,0,0,0,9.81" for index in range(40)]
    (folder / "imu.csv").write_text("#timestamp,wx,wy,wz,ax,ay,az\n" + "\n".join(rows) + "\n")
    (folder / "kitti.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n")
    (folder / "scene.json").write_text('{"objects": [{"name": "cup"}]}')
    (folder / "hero.md5mesh").write_bytes(md5_mesh_tower())
    return folder


@pytest.mark.parametrize("attack", ATTACKS)
@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_waits_or_fills_the_memory(
    tmp_path: Path, tiny: Path, name: str, attack: Callable[[Path], None]
) -> None:
    file, line = COMMANDS[name]
    attack(tmp_path / file)
    places = {"FILE": tmp_path / file, "HERE": tmp_path, "OUT": tmp_path / "out", "TINY": tiny}
    places |= {
        "GOOD": tiny / "truth.tum",
        "IMU": tiny / "imu.csv",
        "KITTI": tiny / "kitti.txt",
        "SCENE": tiny / "scene.json",
        "HERO": tiny / "hero.md5mesh",
    }
    for word, place in places.items():
        line = line.replace(word, str(place))
    outcome = in_child(lambda: main(line.split()))
    assert outcome.ended, outcome
    assert outcome.kind == ("value",), outcome
    status, told = outcome.text.split("\n", 1)
    assert status == "1", outcome
    assert "unexpected" not in told, outcome
    assert_told(told.splitlines()[0], file, outcome)


@pytest.mark.parametrize("attack", ATTACKS)
@pytest.mark.parametrize("name", KEYS)
def test_no_key_of_a_manifest_leads_to_what_waits_or_fills_the_memory(
    tmp_path: Path, tiny: Path, name: str, attack: Callable[[Path], None]
) -> None:
    file, text = KEYS[name]
    folder = tmp_path / "recording"
    for found in [*tiny.glob("*.*"), *tiny.glob("*/*.png")]:
        copy = folder / found.relative_to(tiny)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(found.read_bytes())
    (folder / "motorcade.toml").unlink()
    manifest = folder / "recording.toml"
    manifest.write_text(text)
    (folder / file).unlink(missing_ok=True)
    attack(folder / file)
    assert_refused(in_child(lambda: open_recording(folder, manifest).intact().digest()), file)


@pytest.mark.parametrize("layout", MAKERS)
def test_pipes_in_a_recording_are_refused_or_taken_for_missing(tmp_path: Path, layout: str) -> None:
    root = tmp_path / "recording"
    root.mkdir()
    made = MAKERS[layout](root)
    assert made.root == root
    for file in sorted(path for path in root.rglob("*") if path.is_file()):
        kept = file.read_bytes()
        file.unlink()
        os.mkfifo(file)
        outcome = in_child(lambda: open_recording(root).intact().digest())
        assert outcome.ended, (file, outcome)
        assert outcome.kind == ("value",) or "ValueError" in outcome.kind, (file, outcome)
        file.unlink()
        file.write_bytes(kept)


def test_the_children_notice_what_waits_and_what_fills_the_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tests.end_to_end.doors.children.SECONDS", 1)
    os.mkfifo(tmp_path / "pipe")
    assert not in_child((tmp_path / "pipe").read_bytes).ended
    assert "MemoryError" in in_child(lambda: bytes(2 << 30)).kind
    assert in_child(lambda: 7) == Outcome(("value",), "7\n")
    assert MANIFEST.startswith("\n[frames]")
