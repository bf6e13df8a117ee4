"""The pages' cameras (camera.js) against `Camera`: every model, in the image and beyond it."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from motorcade.replays import web
from motorcade.tracking import Camera

WEB = Path(web.__file__).with_name("modules")
CAMERAS = {
    "pinhole": Camera(640, 480, 500.0, 505.0, 319.5, 239.5),
    "off centre": Camera(640, 480, 500.0, 480.0, 130.0, 421.25),
    "barrel": Camera(752, 480, 458.7, 457.3, 367.2, 248.4, "radtan", (-0.2834, 0.0739)),
    "tangential": Camera(
        752, 480, 458.7, 457.3, 367.2, 248.4, "radtan", (-0.28, 0.07, 2e-3, -1e-3)
    ),
    "five": Camera(640, 480, 517.3, 516.5, 318.6, 255.3, "radtan", (0.26, -0.95, -5e-3, 3e-3, 1.2)),
    "rational": Camera(
        640, 480, 600.0, 601.0, 320.0, 240.0, "radtan", (0.4, 0.1, 1e-4, 2e-4, 0.01, 0.7, 0.2, 0.02)
    ),
    "equidistant": Camera(
        848, 800, 286.1, 286.2, 417.0, 403.0, "equidistant", (-0.009, 0.05, -0.047, 0.009)
    ),
}
SCRIPT = """
import { readFileSync } from "node:fs";
import { project, unproject } from "studio/camera.js";
const asked = JSON.parse(readFileSync(0, "utf8"));
console.log(JSON.stringify(asked.map(({ camera, points, pixels }) => ({
  pixels: points.map((one) => project(camera, one)),
  rays: pixels.map((one) => unproject(camera, one)),
}))));
"""

node = shutil.which("node")
if node is None or not (WEB / "package.json").exists():
    pytest.skip("no Node.js here, or an installed wheel is tested", allow_module_level=True)


def asked_of(camera: Camera, rng: np.random.Generator) -> dict[str, object]:
    """Points near, far, beside and behind; pixels all over the image and outside it."""
    size = np.array([camera.width, camera.height])
    points = rng.normal(size=(200, 3)) * np.exp(rng.uniform(-3, 3, (200, 1)))
    points[0], points[1], points[2] = (0, 0, 1), (0, 0, -1), (1e-9, 0, 2)
    about = {
        "model": camera.model,
        "coefficients": camera.distortion,
        **{name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")},
    }
    pixels = rng.uniform(-0.3, 1.3, (200, 2)) * size
    pixels[0] = camera.cx, camera.cy
    return {"camera": about, "points": points.tolist(), "pixels": pixels.tolist()}


def told(rows: list[list[float] | None], width: int) -> np.ndarray:
    return np.array([[np.nan] * width if row is None else row for row in rows])


def test_pages_project_as_cameras_do() -> None:
    rng = np.random.default_rng(0)
    asked = [asked_of(camera, rng) for camera in CAMERAS.values()]
    found = subprocess.run(
        [str(node), "--input-type=module", "-e", SCRIPT],
        input=json.dumps(asked),
        capture_output=True,
        text=True,
        check=True,
        cwd=WEB,
    )
    for camera, question, answer in zip(
        CAMERAS.values(), asked, json.loads(found.stdout), strict=True
    ):
        expected = camera.project(question["points"])
        np.testing.assert_allclose(told(answer["pixels"], 2), expected, rtol=1e-11, atol=1e-9)
        rays = camera.unproject(question["pixels"])[:, :2]
        np.testing.assert_allclose(told(answer["rays"], 3)[:, :2], rays, rtol=1e-9, atol=1e-11)
        assert np.isfinite(rays).all(axis=1).sum() > 50
