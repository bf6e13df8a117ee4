"""Files that a run reads, one of each kind, and what is done to them.

The character is a small tower, alone in its folder; the recording is a folder of tiny images, to
whose manifest each kind of file is added.
"""

from __future__ import annotations

import json
import os
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.tracking import MapSnapshot, MarkerMap
from tests.animation.formats import samples
from tests.end_to_end.stale.containers import (
    TELEMETRY,
    moved_corner,
    repainted_message,
    turned,
    with_bag,
    with_tagslam,
    with_telemetry,
)
from tests.replays.tiny_recordings import MANIFEST

__all__ = ["CHARACTERS", "COMMENT", "CONTAINERS", "RECORDINGS", "Kind", "assimp"]


@dataclass(frozen=True)
class Kind:
    """A file that a run reads.

    Fields:
        name: what kind of file it is.
        write: writes all that is needed into a folder and gives the file.
        change: what happens to it.
        character, clip: the name of the character, whose file this is or names it, and what it
            plays; none where the file is part of the recording.
        container: what is run in place of the recording's folder, by its name there; `given.toml`
            beside it is its manifest.
    """

    name: str
    write: Callable[[Path], Path]
    change: Callable[[Path], None]
    character: str = ""
    clip: str = "bend"
    container: str = ""


def flipped(at: float = 0.5) -> Callable[[Path], None]:
    """Flips one bit of a file, so far into it."""

    def change(path: Path) -> None:
        data, before = bytearray(path.read_bytes()), path.stat()
        data[int(at * (len(data) - 1))] ^= 1
        path.write_bytes(data)
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))  # as a copy may leave it

    return change


def swapped(old: str, new: str) -> Callable[[Path], None]:
    """Writes one text in the place of another of the same length."""

    def change(path: Path) -> None:
        data = path.read_bytes()
        assert old.encode() in data
        assert len(old) == len(new)
        path.write_bytes(data.replace(old.encode(), new.encode(), 1))

    return change


def displaced(path: Path) -> None:
    """One decimal of the last pose's x is another one."""
    lines = path.read_text().splitlines()
    stamp, x, rest = lines[-1].split(" ", 2)
    place = x.index(".") + 1
    moved = x[:place] + str((int(x[place]) + 1) % 10) + x[place + 1 :]
    path.write_text("\n".join([*lines[:-1], f"{stamp} {moved} {rest}", ""]))


def png(path: Path, seed: int = 0, shape: tuple[int, ...] = (16, 24)) -> None:
    """A small image; another one for another seed."""
    rng = np.random.default_rng(seed)
    assert cv2.imwrite(str(path), rng.integers(0, 255, shape, dtype=np.uint8))


def repainted(path: Path) -> None:
    """Another image in a file's place, or the first one there."""
    png(path, 1)


def led_elsewhere(path: Path) -> None:
    """A link to another file than before; that one stays as it is."""
    other = path.with_name("other.png")
    png(other, 2)
    path.unlink()
    path.symlink_to(other.name)


def painted(made: samples.Gltf) -> samples.Gltf:
    """A document that names a texture."""
    part = made.document["meshes"][0]["primitives"][0]
    part["attributes"]["TEXCOORD_0"] = made.add(np.linspace(0, 1, 24).reshape(12, 2))
    part["material"] = 0
    made.document |= {
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "skin.png"}],
    }
    return made


def gltf(changed: str, folder: Path) -> Path:
    """A `.gltf` with a buffer and a texture beside it; gives the one of them."""
    made = painted(samples.gltf_tower())
    buffers = [{"byteLength": len(made.data), "uri": "tower.bin"}]
    (folder / "hero.gltf").write_text(json.dumps(made.document | {"buffers": buffers}))
    (folder / "tower.bin").write_bytes(made.data)
    png(folder / "skin.png")
    return folder / changed


def gltf_of_link(folder: Path) -> Path:
    path = gltf("skin.png", folder)
    path.rename(folder / "first.png")
    path.symlink_to("first.png")
    return path


def gltf_without_texture(folder: Path) -> Path:
    path = gltf("skin.png", folder)
    path.unlink()
    return path


def glb(folder: Path) -> Path:
    (folder / "hero.glb").write_bytes(samples.gltf_tower().glb())
    return folder / "hero.glb"


def dae(changed: str, folder: Path) -> Path:
    """A Collada file with a texture beside it; gives the one of them."""
    text = samples.collada_with(
        ("<color>0.8 0.2 0.1 1</color>", '<texture texture="image"/>'),
        ("<library_effects>", IMAGES),
    )
    (folder / "hero.dae").write_bytes(text)
    png(folder / "skin.png")
    return folder / changed


MD5 = ("hero.md5mesh", "hero")
IMAGES = (
    '<library_images><image id="image"><init_from>skin.png</init_from></image></library_images>'
    "<library_effects>"
)


def md5(changed: str, folder: Path) -> Path:
    """An MD5 mesh with a motion and a texture beside it; gives the one of them."""
    mesh = samples.md5_mesh_tower().replace(b'shader "tower"', b'shader "skin.png"')
    (folder / "hero.md5mesh").write_bytes(mesh)
    (folder / "hero.md5anim").write_bytes(samples.md5_motion_tower())
    png(folder / "skin.png")
    return folder / changed


def fbx(folder: Path) -> Path:
    """What the stand-in for assimp, below, takes for FBX."""
    (folder / "hero.fbx").write_bytes(samples.gltf_tower().glb())
    return folder / "hero.fbx"


@contextmanager
def assimp() -> Iterator[None]:
    """Within the block the program assimp copies a file, so that all machines have one."""
    before = os.environ["PATH"]
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "assimp"
        program.write_text('#!/bin/sh\ncp "$2" "$3"\n')
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        os.environ["PATH"] = f"{folder}:{before}"
        try:
            yield
        finally:
            os.environ["PATH"] = before


def described(changed: str, table: str, folder: Path) -> Path:
    """More tables in the recording's manifest; gives the file that they name."""
    path = folder / "motorcade.toml"
    path.write_text(path.read_text() + table + "\n")
    return folder / changed


def with_stamps(folder: Path) -> Path:
    manifest = folder / "motorcade.toml"
    manifest.write_text(MANIFEST.replace("rate_hz = 20.0", 'stamps = "stamps.txt"'))
    (folder / "stamps.txt").write_text("".join(f"{0.05 * k:.3f}\n" for k in range(41)))
    return folder / "stamps.txt"


def with_depth(folder: Path) -> Path:
    manifest = folder / "motorcade.toml"
    more = 'rate_hz = 20.0\ndepth = "depth/*.png"\ndepth_units_per_m = 1000'
    manifest.write_text(MANIFEST.replace("rate_hz = 20.0", more))
    (folder / "depth").mkdir()
    for k in range(41):
        cv2.imwrite(str(folder / "depth" / f"{k}.png"), np.full((16, 24), 900, np.uint16))
    return folder / "depth" / "7.png"


def deeper(path: Path) -> None:
    """Another depth image."""
    cv2.imwrite(str(path), np.full((16, 24), 901, np.uint16))


def with_right(folder: Path) -> Path:
    (folder / "right").mkdir()
    for k in range(41):
        png(folder / "right" / f"{k}.png", k)
    return described("right/7.png", '[stereo]\nright = "right/*.png"\nbaseline_m = 0.1', folder)


def with_matrix(folder: Path) -> Path:
    manifest = folder / "motorcade.toml"
    text = MANIFEST.replace("fx = 20.0\nfy = 20.0\ncx = 11.5\ncy = 7.5", 'matrix_file = "K.txt"')
    manifest.write_text(text)
    (folder / "K.txt").write_text("20.0 0 11.5\n0 20.0 7.5\n0 0 1\n")
    return folder / "K.txt"


def with_lens(folder: Path) -> Path:
    manifest = folder / "motorcade.toml"
    more = 'cy = 7.5\nmodel = "radtan"\ndistortion_file = "D.txt"'
    manifest.write_text(MANIFEST.replace("cy = 7.5", more))
    (folder / "D.txt").write_text("0.01 0.02 0.003 0.004\n")
    return folder / "D.txt"


UNIT = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"
NOISE = (
    "gyroscope_noise_density: 1.6e-04\ngyroscope_random_walk: 1.9e-05\n"
    "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n"
)


def with_imu(changed: str, folder: Path) -> Path:
    rows = [f"{5_000_000 * k},0.1,0.2,0.05,0.3,0.1,9.8" for k in range(401)]
    (folder / "imu.csv").write_text("\n".join(["#t,w,w,w,a,a,a", *rows]))
    (folder / "imu.yaml").write_text(NOISE)
    table = f'[imu]\nfile = "imu.csv"\nnoise_file = "imu.yaml"\nimu_T_camera = {UNIT}'
    return described(changed, table, folder)


def with_markers(folder: Path) -> Path:
    turns = Rotor.from_rotation_vector([[0.0, 0.0, 0.1], [0.0, 0.5, 0.0]])
    MarkerMap([4, 9], [0.1, 0.1], turns, [[0.5, 0.0, 0.0], [1.0, 0.0, 0.0]]).save(
        folder / "markers.json"
    )
    table = '[markers]\nfamily = "tag36h11"\nside_m = 0.1\nmap_file = "markers.json"'
    return described("markers.json", table, folder)


def slam_map(side_m: float) -> MapSnapshot:
    return MapSnapshot(
        time_ns=[0, 500_000_000],
        world_T_camera=Motor.from_translation([[0.0, 0.0, 0.0], [side_m, 0.0, 0.0]]),
        points=[[0.0, 0.0, 2.0]],
        descriptors=np.zeros((1, 32), np.uint8),
        keyframe_of=[0, 1],
        point_of=[0, 0],
        px=[[12.0, 8.0], [11.0, 8.0]],
        depth=[2.0, 2.0],
        metric=True,
    )


def with_slam_map(folder: Path) -> Path:
    slam_map(0.1).save(folder / "slam.npz")
    return described("slam.npz", '[slam]\nmap_file = "slam.npz"', folder)


def with_video(folder: Path) -> Path:
    import av

    with av.open(str(folder / "clip.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=20)
        stream.width, stream.height, stream.pix_fmt = 24, 16, "yuv420p"
        for k in range(41):
            image = np.full((16, 24, 3), 4 * k, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode(None))
    manifest = folder / "motorcade.toml"
    still = 'images = "images/*.png"\nrate_hz = 20.0'
    manifest.write_text(MANIFEST.replace(still, 'video = "clip.mp4"'))
    return folder / "clip.mp4"


def remapped(path: Path) -> None:
    """Another map in the place of the saved one."""
    slam_map(0.2).save(path)


def as_it_is(folder: Path) -> Path:
    return folder / "motorcade.toml"


def with_settings(folder: Path) -> Path:
    manifest = folder / "motorcade.toml"
    manifest.write_text('settings = ["smoothed.order=1"]\n' + manifest.read_text())
    return manifest


CHARACTERS = (
    Kind(".gltf", partial(gltf, "hero.gltf"), swapped('"top"', '"tip"'), "hero.gltf"),
    Kind(".bin of a .gltf", partial(gltf, "tower.bin"), flipped(0.1), "hero.gltf"),
    Kind("texture of a .gltf", partial(gltf, "skin.png"), flipped(), "hero.gltf"),
    Kind("texture that was missing", gltf_without_texture, repainted, "hero.gltf"),
    Kind("link to a texture", gltf_of_link, led_elsewhere, "hero.gltf"),
    Kind(".glb", glb, swapped('"top"', '"tip"'), "hero.glb"),
    Kind(".dae", partial(dae, "hero.dae"), swapped("0 90", "0 80"), "hero.dae", "animation"),
    Kind("texture of a .dae", partial(dae, "skin.png"), flipped(), "hero.dae", "animation"),
    Kind(".md5mesh", partial(md5, "hero.md5mesh"), swapped("0.5 0.5", "0.5 0.4"), *MD5),
    Kind(".md5anim of it", partial(md5, "hero.md5anim"), swapped("Rate 2", "Rate 3"), *MD5),
    Kind("texture of a .md5mesh", partial(md5, "skin.png"), flipped(), *MD5),
    Kind(".fbx", fbx, swapped('"top"', '"tip"'), "hero.fbx"),
)
RECORDINGS = (
    Kind("image", lambda folder: folder / "images" / "7.png", repainted),
    Kind("depth image", with_depth, deeper),
    Kind("right image", with_right, repainted),
    Kind("video", with_video, flipped(0.99)),
    Kind("stamps", with_stamps, swapped("0.050", "0.051")),
    Kind("camera matrix", with_matrix, swapped("11.5", "11.4")),
    Kind("distortion", with_lens, swapped("0.02", "0.03")),
    Kind("ground truth", lambda folder: folder / "truth.tum", displaced),
    Kind("IMU", partial(with_imu, "imu.csv"), swapped("9.8", "9.7")),
    Kind("IMU noise", partial(with_imu, "imu.yaml"), swapped("1.6e-04", "1.7e-04")),
    Kind("marker map", with_markers, swapped("0.5", "0.6")),
    Kind("SLAM map", with_slam_map, remapped),
    Kind(
        "value in the manifest",
        lambda folder: folder / "motorcade.toml",
        swapped("cx = 11.5", "cx = 11.3"),
    ),
    Kind("setting in the manifest", with_settings, swapped("order=1", "order=3")),
)
COMMENT = Kind(
    "comment in the manifest",
    partial(described, "motorcade.toml", "# a note"),
    swapped("# a note", "# a word"),
)
CONTAINERS = (
    Kind("bag of ROS 1", partial(with_bag, "bag"), repainted_message, container="bag/flight.bag"),
    Kind(
        "SQLite of ROS 2", partial(with_bag, "folder"), repainted_message, container="folder/flight"
    ),
    Kind(
        "MCAP of ROS 2",
        partial(with_bag, "mcap"),
        repainted_message,
        container="mcap/flight/flight.mcap",
    ),
    Kind(
        "corners of TagSLAM",
        partial(with_tagslam, "tag_detections.bag"),
        moved_corner,
        container="tagslam",
    ),
    Kind(
        "cameras of TagSLAM",
        partial(with_tagslam, "cameras.yaml"),
        swapped("400.0", "400.1"),
        container="tagslam",
    ),
    Kind(
        "tags of TagSLAM",
        partial(with_tagslam, "tagslam.yaml"),
        swapped("size: 0.2", "size: 0.3"),
        container="tagslam",
    ),
)
if TELEMETRY.is_file():
    CONTAINERS += (Kind("telemetry in a video", with_telemetry, turned, container="karma.mp4"),)
