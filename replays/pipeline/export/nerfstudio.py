"""nerfstudio's `transforms.json`, with pictures and points beside it.

Source: https://docs.nerf.studio/quickstart/data_conventions.html: camera axes as OpenGL has them
(x right, y up, z back), a world with z up, pixel (0.5, 0.5) the centre of the top-left pixel.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.atomic import write_bytes
from motorcade.replays.io.errors import refusal
from motorcade.replays.pipeline.export.pictures import write_pictures
from motorcade.replays.pipeline.runs import Shown, thinned
from motorcade.tracking.cameras.camera import Camera

OPENCV_T_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
"""From camera axes as OpenGL has them to OpenCV's."""


def write_nerfstudio(shown: Shown, folder: Path, every: int = 1) -> None:
    """Write ``transforms.json``, ``images/`` and, where points were mapped, ``points.ply``.

    Args:
        shown: the run.
        folder: new, or without pictures.
        every: of how many frames one is written.

    Raises:
        ValueError: a step below 1, a folder that holds pictures already, or a lens with more
            coefficients than nerfstudio knows.
        OSError: a file cannot be written.
    """
    camera = shown.recording.camera
    lens = _lens(camera, shown.recording.root) if camera is not None else {}
    pictures = write_pictures(shown, folder, every)
    matrices = pictures.world_T_camera.as_matrix() @ OPENCV_T_OPENGL
    content: dict[str, Any] = lens | {
        "frames": [
            {"file_path": name, "transform_matrix": matrix}
            for name, matrix in zip(pictures.names, matrices.tolist(), strict=True)
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
