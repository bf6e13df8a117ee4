"""The `[camera]` table of a manifest, and files that hold a camera alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from motorcade.replays.readers.calibration import (
    make_camera,
    read_matrix,
    read_numbers,
    yaml_camera,
)
from motorcade.replays.readers.manifest.section import Section, load_toml
from motorcade.tracking.cameras.camera import Camera

__all__ = ["CAMERA_KEYS", "camera_toml", "read_camera", "section_camera"]

CAMERA_KEYS = (
    "model",
    "width",
    "height",
    "fx",
    "fy",
    "cx",
    "cy",
    "matrix_file",
    "fov_deg",
    "distortion",
    "distortion_file",
)


def read_camera(path: Path) -> Camera:
    """Read the camera of a `.toml` file's `[camera]` table, or of an EuRoC `sensor.yaml`.

    Raises:
        RecordingError: what the table or the YAML file lacks or gets wrong.
    """
    if path.suffix.lower() != ".toml":
        return yaml_camera(path)
    tables = load_toml(path)
    if "camera" not in tables:
        raise Section(path, "", {}, ()).fault("camera", "the table is missing")
    section = Section(path, "camera", tables["camera"], CAMERA_KEYS)
    return section_camera(path, section, None, lambda key: path.parent / section.text(key))


def section_camera(
    path: Path, section: Section, size: tuple[int, int] | None, file: Callable[[str], Path]
) -> Camera:
    """Make the camera of a manifest's table.

    Args:
        path: the manifest.
        section: its table.
        size: of the pictures, where the table does not say it.
        file: the file that a key of the table names.

    Raises:
        RecordingError: naming table and key.
    """
    if size is None or "width" in section or "height" in section:
        size = (section.whole("width", 1), section.whole("height", 1))
    intrinsics = _intrinsics(section, size, file)
    section.only_one("distortion", "distortion_file")
    source, distortion = path, tuple[float, ...]()
    if "distortion" in section:
        distortion = section.numbers("distortion")
    elif "distortion_file" in section:
        source = file("distortion_file")
        distortion = tuple(float(value) for value in read_numbers(source))
    models = ("pinhole", "radtan", "equidistant")
    lensless = "model" not in section and not distortion
    model = "pinhole" if lensless else section.text("model", models)
    return make_camera(source, size, intrinsics, model, distortion)


def _intrinsics(
    section: Section, size: tuple[int, int], file: Callable[[str], Path]
) -> tuple[float, float, float, float]:
    """fx, fy, cx, cy in pixels: as given, of a matrix, or of a lens that is known by its view."""
    section.only_one("matrix_file", "fx")
    section.only_one("fov_deg", "fx")
    section.only_one("fov_deg", "matrix_file")
    if "matrix_file" in section:
        return read_matrix(file("matrix_file"))
    if "fov_deg" in section:
        half_rad = math.radians(0.5 * section.number("fov_deg", 1.0, 170.0))
        focal = 0.5 * size[0] / math.tan(half_rad)
        return focal, focal, 0.5 * (size[0] - 1), 0.5 * (size[1] - 1)
    fx, fy = (section.number(key, 1e-3, 1e9) for key in ("fx", "fy"))
    return fx, fy, section.number("cx", -1e9, 1e9), section.number("cy", -1e9, 1e9)


def camera_toml(camera: Camera) -> str:
    """Write a camera as the `[camera]` table that `read_camera` and manifests read."""
    lines = ["[camera]", f'model = "{camera.model}"']
    lines += [f"{key} = {getattr(camera, key)!r}" for key in ("width", "height")]
    lines += [f"{key} = {getattr(camera, key)!r}" for key in ("fx", "fy", "cx", "cy")]
    if camera.distortion:
        lines.append(f"distortion = [{', '.join(map(repr, camera.distortion))}]")
    return "\n".join(lines) + "\n"
