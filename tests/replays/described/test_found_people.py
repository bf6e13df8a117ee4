"""People who are found are masks as any: said, kept, dropped in doubt, asked for or left in.

A stand-in plays the nets of the wheel: what is white in an image is a person to it.
"""

from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.described import people as stage
from motorcade.replays.pipeline.described.people import BlazePose, weights_folder, with_people
from motorcade.tracking.people import SeenPerson, find_people

COUNT, SIZE = 8, (96, 128)
BODY = np.array([[64.0, 50.0], [64.0, 20.0]])
Image = np.ndarray


class WhitePeople:
    """Nets that take what is white for a person; counts how often they were made."""

    made = 0

    def __init__(self, folder: Path) -> None:
        type(self).made += 1

    def detect(self, image: Image) -> list[tuple[float, Image]]:
        return [(0.9, BODY)] if (image == 255).any() else []

    def segment(self, image: Image, body_px: Image) -> SeenPerson:
        mask = np.where(image[..., 0] == 255, 255, 0).astype(np.uint8)
        return SeenPerson(float(mask.any()), mask, BODY)


@pytest.fixture
def nets(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> type[WhitePeople]:
    monkeypatch.setattr(stage, "weights_folder", lambda: tmp_path)
    monkeypatch.setattr(stage, "BlazePose", WhitePeople)
    monkeypatch.setattr(WhitePeople, "made", 0)
    return WhitePeople


def recorded(root: Path, masks: str = "", *, textured: bool = True, seen: int = 6) -> Recording:
    """A folder of images, in the first few of which something white stands."""
    rng = np.random.default_rng(5)
    (root / "images").mkdir(parents=True)
    for row in range(COUNT):
        image = rng.integers(0, 200, SIZE) if textured else np.full(SIZE, 90)
        if row < seen:
            image[20:80, 50:70] = 255
        cv2.imwrite(str(root / "images" / f"{row:04d}.png"), image.astype(np.uint8))
    lines = f'[frames]\nimages = "images/*.png"\nrate_hz = 30\n{masks}\n'
    (root / "motorcade.toml").write_text(lines)
    return open_recording(root).intact()


def test_people_are_masked_said_and_kept(nets: type[WhitePeople], tmp_path: Path) -> None:
    bare = recorded(tmp_path / "clip")
    found = with_people(bare, tmp_path / "cache")
    assert found.people == "people in 6 of 8 frames hide the figure, untracked"
    assert found.digest() != bare.digest()
    for row, frame in enumerate(found.frames):
        mask = frame.mask()
        assert (mask is not None) == (row < 6)
        if mask is not None:
            np.testing.assert_array_equal(mask == 255, frame.image() == 255)
            assert frame.gray()[50, 60] < 200  # filled for tracking
            assert frame.image()[50, 60] == 255  # the film's stays
    again = with_people(bare, tmp_path / "cache")
    assert (nets.made, again.digest()) == (1, found.digest())
    assert with_people(found, tmp_path / "cache") is found  # masks that are there stay


@pytest.mark.parametrize(("textured", "seen"), [(True, 0), (False, 6)], ids=["nobody", "no corner"])
def test_nothing_changes_without_people_or_corners_beside_them(
    nets: type[WhitePeople], tmp_path: Path, textured: bool, seen: int
) -> None:
    bare = recorded(tmp_path / "clip", textured=textured, seen=seen)
    assert with_people(bare, tmp_path / "cache") is bare
    assert nets.made == 1


def test_people_stay_in_where_the_manifest_says_so(nets: type[WhitePeople], tmp_path: Path) -> None:
    bare = recorded(tmp_path / "clip", 'masks = "none"')
    assert with_people(bare, tmp_path / "cache") is bare
    assert nets.made == 0


def test_without_nets_nothing_changes_unless_they_are_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(stage, "weights_folder", lambda: None)
    bare = recorded(tmp_path / "clip")
    assert with_people(bare, tmp_path / "cache") is bare
    asked = recorded(tmp_path / "asked", 'masks = "people"')
    with pytest.raises(RecordingError, match=r"masks.*motorcade doctor"):
        with_people(asked, tmp_path / "cache")


@pytest.mark.skipif(weights_folder() is None, reason="the nets that find people are not installed")
def test_the_nets_find_a_person_and_neither_a_cat_nor_coffee() -> None:
    data = pytest.importorskip("skimage.data")
    folder = weights_folder()
    assert folder is not None
    nets, portrait = BlazePose(folder), cv2.resize(data.astronaut(), (300, 300))
    for scene, somebody in ((data.coffee(), True), (data.coffee(), False), (data.chelsea(), False)):
        images = []
        for step in range(8):
            image = cv2.resize(scene, (640, 400))
            if somebody:
                image[100:, 100 + 4 * step : 400 + 4 * step] = portrait
            images.append(image)
        masks = list(find_people(images, nets.detect, nets.segment))
        assert [mask is not None for mask in masks] == [somebody] * 8
        if masks[4] is not None:  # forehead and chest, by hand, and the coffee beside her
            assert min(masks[4][130, 256], masks[4][300, 256]) > 128
            assert masks[4][:, :100].max() < 128
