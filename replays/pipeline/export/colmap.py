"""COLMAP's text model: cameras, poses of the pictures, points.

Source: https://colmap.github.io/format.html; pixel (0.5, 0.5) is the centre of the top-left pixel
there, and poses are camera_T_world.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.replays.io.atomic import write_bytes
from motorcade.replays.pipeline.export.pictures import PosedPictures, write_pictures
from motorcade.replays.pipeline.runs import Shown, thinned
from motorcade.tracking.cameras.camera import Camera

_GREY = 128


def write_colmap(shown: Shown, folder: Path, every: int = 1) -> None:
    """Write ``images/`` and ``sparse/0/{cameras,images,points3D}.txt``, as `colmap gui` opens them.

    Mapped points have no tracks: the run keeps where they lie, not which pictures saw them.

    Args:
        shown: the run.
        folder: new, or without pictures.
        every: of how many frames one is written.

    Raises:
        ValueError: a step below 1, or a folder that holds pictures already.
        OSError: a file cannot be written.
    """
    pictures = write_pictures(shown, folder, every)
    model = folder / "sparse" / "0"
    model.mkdir(parents=True, exist_ok=True)
    write_bytes(model / "cameras.txt", _cameras(pictures.camera).encode())
    write_bytes(model / "images.txt", _images(pictures).encode())
    points = thinned(shown.points_m)
    rows = (
        f"{number} {x!r} {y!r} {z!r} {_GREY} {_GREY} {_GREY} 0"
        for number, (x, y, z) in enumerate(points.tolist(), 1)
    )
    head = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)"
    write_bytes(model / "points3D.txt", "\n".join([head, *rows, ""]).encode())


def colmap_camera(camera: Camera) -> tuple[str, list[float]]:
    """Name and parameters of COLMAP's model of a camera.

    >>> from motorcade.replays.pipeline.export.colmap import colmap_camera
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
    told = " ".join(repr(float(one)) for one in numbers)
    head = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"
    return f"{head}\n1 {model} {camera.width} {camera.height} {told}\n"


def _images(pictures: PosedPictures) -> str:
    """Two lines a picture; the second, of what is seen in it, is empty."""
    camera_T_world = pictures.world_T_camera.inverse()
    wxyz = camera_T_world.rotor.as_quaternion()
    numbers = np.concatenate([wxyz, camera_T_world.translation_m], axis=-1).tolist()
    rows = (
        f"{number} {' '.join(map(repr, row))} 1 {name.removeprefix('images/')}\n\n"
        for number, (row, name) in enumerate(zip(numbers, pictures.names, strict=True), 1)
    )
    head = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME; then POINTS2D[]"
    return head + "\n" + "".join(rows)
