"""A run's images as files, with their poses: COLMAP's text model and nerfstudio's transforms.

COLMAP: https://colmap.github.io/format.html; pixel (0.5, 0.5) is the centre of the top-left pixel
there, and poses are camera_T_world.

nerfstudio: https://docs.nerf.studio/quickstart/data_conventions.html: camera axes as OpenGL has
them (x right, y up, z back), a world with z up, pixel (0.5, 0.5) the centre of the top-left pixel.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.files import write_bytes
from motorcade.replays.pipeline.runs import Shown, thinned
from motorcade.tracking.cameras.camera import Camera

_QUALITY = 95


@dataclass(frozen=True, eq=False)
class PosedImages:
    """Images that were written, each with where the camera stood.

    Attributes:
        names: (N,) relative to the folder, such as ``images/frame_000012.jpg``.
        world_T_camera: (N,) along the path that the characters are drawn on.
        camera: as filmed, with its distortion.
    """

    names: tuple[str, ...]
    world_T_camera: Motor
    camera: Camera


def write_images(shown: Shown, folder: Path, every: int = 1) -> PosedImages:
    """Write each `every`-th frame that has a pose as a JPEG, as it was filmed.

    Raises:
        ValueError: a step below 1, or a folder that holds images already, which would be mixed.
        OSError: a file cannot be written.
    """
    import cv2

    if every < 1:
        raise ValueError(f"every: expected 1 or more, got {every}")
    place = folder / "images"
    if place.exists() and any(place.iterdir()):
        raise refusal(place, "holds files already", advice="name a new folder")
    place.mkdir(parents=True, exist_ok=True)
    names, stamps = [], []
    rows = shown.frames_posed
    for number in map(int, rows[rows % every == 0]):
        frame = shown.recording.frames[number]
        image = frame.image()
        ordered = image if image.ndim == 2 else image[..., ::-1]
        _, data = cv2.imencode(".jpg", ordered, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        names.append(f"images/frame_{number:06}.jpg")
        write_bytes(folder / names[-1], data.tobytes())
        stamps.append(frame.time_ns)
    camera = shown.recording.camera
    if camera is None:
        raise refusal(shown.recording.root, "expected a camera, got none")
    poses = shown.path.motors_at(np.array(stamps, dtype=np.int64))
    return PosedImages(tuple(names), poses, camera)


_GREY = 128


def write_colmap(shown: Shown, folder: Path, every: int = 1) -> None:
    """Write ``images/`` and ``sparse/0/{cameras,images,points3D}.txt``, as `colmap gui` opens them.

    Mapped points have no tracks: the run keeps where they lie, not which images saw them.

    Args:
        shown: the run.
        folder: new, or without images.
        every: of how many frames one is written.

    Raises:
        ValueError: a step below 1, or a folder that holds images already.
        OSError: a file cannot be written.
    """
    images = write_images(shown, folder, every)
    model = folder / "sparse" / "0"
    model.mkdir(parents=True, exist_ok=True)
    write_bytes(model / "cameras.txt", _cameras(images.camera).encode())
    write_bytes(model / "images.txt", _images(images).encode())
    points = thinned(shown.points_m)
    rows = (
        f"{number} {x!r} {y!r} {z!r} {_GREY} {_GREY} {_GREY} 0"
        for number, (x, y, z) in enumerate(points.tolist(), 1)
    )
    head = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)"
    write_bytes(model / "points3D.txt", "\n".join([head, *rows, ""]).encode())


def colmap_camera(camera: Camera) -> tuple[str, list[float]]:
    """Name and parameters of COLMAP's model of a camera.

    >>> from motorcade.replays.pipeline.export.images import colmap_camera
    >>> from motorcade.tracking import Camera
    >>> colmap_camera(Camera(640, 480, 500.0, 500.0, 319.5, 239.5))
    ('PINHOLE', [500.0, 500.0, 320.0, 240.0])
    """
    lens = [camera.fx, camera.fy, camera.cx + 0.5, camera.cy + 0.5]
    bends = list(camera.distortion)
    if camera.model == "equidistant":
        return "OPENCV_FISHEYE", lens + bends
    if not any(bends):
        return "PINHOLE", lens
    if len(bends) <= 4:
        return "OPENCV", lens + bends + [0.0] * (4 - len(bends))
    return "FULL_OPENCV", lens + bends + [0.0] * (8 - len(bends))


def _cameras(camera: Camera) -> str:
    model, numbers = colmap_camera(camera)
    text = " ".join(repr(float(one)) for one in numbers)
    head = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"
    return f"{head}\n1 {model} {camera.width} {camera.height} {text}\n"


def _images(images: PosedImages) -> str:
    """Two lines an image; the second, of what is seen in it, is empty."""
    camera_T_world = images.world_T_camera.inverse()
    wxyz = camera_T_world.rotor.as_quaternion()
    numbers = np.concatenate([wxyz, camera_T_world.translation_m], axis=-1).tolist()
    rows = (
        f"{number} {' '.join(map(repr, row))} 1 {name.removeprefix('images/')}\n\n"
        for number, (row, name) in enumerate(zip(numbers, images.names, strict=True), 1)
    )
    head = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME; then POINTS2D[]"
    return head + "\n" + "".join(rows)


OPENCV_T_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
"""From camera axes as OpenGL has them to OpenCV's."""


def write_nerfstudio(shown: Shown, folder: Path, every: int = 1) -> None:
    """Write ``transforms.json``, ``images/`` and, where points were mapped, ``points.ply``.

    Args:
        shown: the run.
        folder: new, or without images.
        every: of how many frames one is written.

    Raises:
        ValueError: a step below 1, a folder that holds images already, or a lens with more
            coefficients than nerfstudio knows.
        OSError: a file cannot be written.
    """
    camera = shown.recording.camera
    lens = _lens(camera, shown.recording.root) if camera is not None else {}
    images = write_images(shown, folder, every)
    matrices = images.world_T_camera.as_matrix() @ OPENCV_T_OPENGL
    content: dict[str, Any] = lens | {
        "frames": [
            {"file_path": name, "transform_matrix": matrix}
            for name, matrix in zip(images.names, matrices.tolist(), strict=True)
        ]
    }
    points = thinned(shown.points_m)
    if len(points):
        write_bytes(folder / "points.ply", _ply(points))
        content["ply_file_path"] = "points.ply"
    write_bytes(folder / "transforms.json", (json.dumps(content, indent=1) + "\n").encode())


def _lens(camera: Camera, root: Path) -> dict[str, Any]:
    fisheye = camera.model == "equidistant"
    names = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3", "k4")
    bends = dict(zip(names, camera.distortion, strict=False))
    if len(camera.distortion) > (4 if fisheye else 5):
        raise refusal(
            root,
            f"a lens of {len(camera.distortion)} coefficients has no name in nerfstudio",
            advice="export it with --colmap, which knows eight",
        )
    return {
        "camera_model": "OPENCV_FISHEYE" if fisheye else "OPENCV",
        "w": camera.width,
        "h": camera.height,
        "fl_x": camera.fx,
        "fl_y": camera.fy,
        "cx": camera.cx + 0.5,
        "cy": camera.cy + 0.5,
    } | bends


def _ply(points_m: FloatArray) -> bytes:
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points_m)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    )
    rows = np.empty(len(points_m), [("place", "<f4", 3), ("grey", "u1", 3)])
    rows["place"], rows["grey"] = points_m, 128
    return head.encode() + rows.tobytes()
