"""Films keep their clips' own pixels, whatever the lens, and a bent film is told."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.render import read_frames, write_video
from motorcade.replays.cli import main
from motorcade.replays.io.readers.manifest.section import camera_toml
from motorcade.tracking import Camera
from tests.end_to_end.conftest import BOARD, FRAMES, MANIFEST, truth
from tests.end_to_end.untouched import untouched

LENSES = {
    "barrel": Camera(320, 240, 260.0, 260.0, 161.0, 118.0, "radtan", (-0.25, 0.05)),
    "folds": Camera(320, 240, 260.0, 260.0, 159.5, 119.5, "radtan", (-0.7, 0.0)),
    "fisheye": Camera(320, 240, 150.0, 150.0, 159.5, 119.5, "equidistant", (0.0, 0.0, 0.0, 0.0)),
}


def photographs(camera: Camera, rng: np.random.Generator) -> list[np.ndarray]:
    """The board on a mottled table, ray by ray; the table's colour where there is no ray."""
    drawing, origin = BOARD.draw(2000.0)
    y, x = np.mgrid[: camera.height, : camera.width]
    rays = camera.unproject(np.stack([x, y], axis=-1))
    table = cv2.GaussianBlur(rng.uniform(60.0, 220.0, rays.shape[:2]), (0, 0), 2.0)
    images = []
    for pose in truth().poses:
        seen = pose.rotor.as_matrix() @ rays[..., None]
        far = -pose.translation_m[2] / seen[..., 2, 0]
        at = pose.translation_m[:2] + far[..., None] * seen[..., :2, 0]
        px = np.nan_to_num(at * (2000.0, -2000.0) + origin, nan=-1e4).astype(np.float32)
        board = cv2.remap(cv2.GaussianBlur(drawing, (0, 0), 4.0), px, None, cv2.INTER_LINEAR)
        on = cv2.remap(np.full_like(drawing, 255), px, None, cv2.INTER_NEAREST) > 0
        images.append(np.where(on, board, table).astype(np.uint8))
    return images


def write_recording(folder: Path, camera: Camera, rng: np.random.Generator) -> Path:
    """Images through a lens, and a manifest that states it."""
    folder.mkdir()
    for k, image in enumerate(photographs(camera, rng)):
        cv2.imwrite(str(folder / f"{k:03d}.png"), image)
    before, _, after = MANIFEST.partition("[camera]")
    after = "[board]" + after.partition("[board]")[2].partition("[truth]")[0]
    (folder / "motorcade.toml").write_text(before + camera_toml(camera) + after)
    return folder


@pytest.mark.slow
@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("lens", LENSES)
def test_a_film_has_its_clip_s_pixels(
    lens: str, tmp_path: Path, rng: np.random.Generator, caplog: pytest.LogCaptureFixture
) -> None:
    recording = write_recording(tmp_path / lens, LENSES[lens], rng)
    run = tmp_path / "run"
    assert main(["run", str(recording), "--out", str(run)]) == 0
    found = untouched(run)
    assert found.kept
    assert found.drawn > 0.005
    said = [one for one in caplog.messages if "nothing is drawn there" in one]
    assert len(said) == (lens != "barrel")


@pytest.mark.slow
@pytest.mark.usefixtures("opengl")
def test_footage_that_was_bent_is_told(tmp_path: Path, rng: np.random.Generator) -> None:
    recording = write_recording(tmp_path / "clip", LENSES["barrel"], rng)
    run = tmp_path / "run"
    asked = ["run", str(recording), "--out", str(run), "--set", "overlay.lens=undistort"]
    assert main(asked) == 0
    assert not untouched(run).kept
    film = [image for _, image in read_frames(run / "overlay.mp4")]
    shifted = [np.roll(one, 1, axis=1) for one in film]
    assert len(film) == FRAMES
    write_video(run / "overlay.mp4", shifted, 50_000_000 * np.arange(FRAMES))
    assert not untouched(run).kept
