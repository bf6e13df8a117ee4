"""Masks of what moves before the scene: read as models write them, or refused by name."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording

COUNT, SIZE = 5, (48, 64)
HERE = np.zeros(SIZE, np.uint8)
HERE[10:30, 20:40] = 255


def recorded(
    root: Path, names: list[str], masks: dict[str, np.ndarray], keys: str = "rate_hz = 30"
) -> Callable[[], Recording]:
    """A folder of noise with masks, and what opens and checks it."""
    rng = np.random.default_rng(5)
    (root / "images").mkdir()
    (root / "masks").mkdir()
    for name in names:
        cv2.imwrite(str(root / "images" / name), rng.integers(0, 255, SIZE).astype(np.uint8))
    for name, mask in masks.items():
        cv2.imwrite(str(root / "masks" / name), mask)
    (root / "motorcade.toml").write_text(
        f'[frames]\nimages = "images/*.png"\nmasks = "masks"\n{keys}\n'
    )
    return lambda: open_recording(root).intact()


NAMES = [f"{7 + row:04d}.png" for row in range(COUNT)]


@pytest.mark.parametrize(
    "masks",
    [
        dict.fromkeys(NAMES, HERE),
        {f"{name}.png": HERE for name in NAMES},
        {f"mask_{row}.png": HERE // 255 for row in range(COUNT)},
        {f"{row}.png": np.dstack([HERE // 2, 0 * HERE, 0 * HERE]) for row in range(1, COUNT + 1)},
        {name: np.dstack([HERE // 3, HERE, HERE, HERE]) for name in NAMES},
        {name: HERE.astype(np.uint16) * 257 for name in NAMES},
    ],
    ids=["by name", "by whole name", "0 and 1 by order", "labels by order", "cut-outs", "16 bits"],
)
def test_masks_of_every_kind_are_the_same(tmp_path: Path, masks: dict[str, np.ndarray]) -> None:
    frames = recorded(tmp_path, NAMES, masks)().frames
    for frame in frames:
        mask = frame.mask()
        assert mask is not None
        np.testing.assert_array_equal(mask, HERE)
        assert np.ptp(frame.gray()[16:24, 26:34].astype(int)) < 60  # filled, where noise was
        assert np.ptp(frame.image()[16:24, 26:34].astype(int)) > 200  # the film's stays


@pytest.mark.parametrize(
    ("masks", "expected"),
    [
        ({name: HERE for name in NAMES if name != "0009.png"}, ["got 4", "missing: 0009.png"]),
        ({f"{row}.png": HERE for row in range(COUNT - 1)}, ["expected 5 masks", "got 4"]),
        ({f"m{row}.png": HERE for row in (0, 1, 3, 4, 5)}, ["missing", "what follows m1.png"]),
        (
            {name: HERE if name != "0010.png" else HERE[:40] for name in NAMES},
            ["0010.png", "64 x 48", "64 x 40"],
        ),
    ],
    ids=["one missing", "too few", "a number missing", "another size"],
)
def test_bad_masks_are_refused_by_name(
    tmp_path: Path, masks: dict[str, np.ndarray], expected: list[str]
) -> None:
    with pytest.raises(RecordingError) as refused:
        recorded(tmp_path, NAMES, masks)()
    assert "[frames] masks" in str(refused.value)
    for words in expected:
        assert words in str(refused.value)


def test_a_truncated_mask_is_refused_by_name(tmp_path: Path) -> None:
    read = recorded(tmp_path, NAMES, dict.fromkeys(NAMES, HERE))
    path = tmp_path / "masks" / "0008.png"
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(RecordingError, match=r"0008\.png.*truncated"):
        read()


def test_masks_follow_their_frames_into_a_part_and_into_the_digest(tmp_path: Path) -> None:
    masks = {name: np.roll(HERE, 3 * row, axis=1) for row, name in enumerate(NAMES)}
    recording = recorded(tmp_path, NAMES, masks, "rate_hz = 10\nstart_s = 0.15\nend_s = 0.35")()
    assert [frame.name for frame in recording.frames] == NAMES[2:4]
    for frame in recording.frames:
        np.testing.assert_array_equal(frame.mask(), masks[frame.name])
    digest = recording.digest()
    cv2.imwrite(str(tmp_path / "masks" / NAMES[2]), HERE)
    assert open_recording(tmp_path).digest() != digest


def test_inverted_masks_are_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    recorded(tmp_path, NAMES, dict.fromkeys(NAMES, 255 - HERE))()
    assert "white must be what moves" in caplog.text
