"""What TagSLAM's YAML states and cannot be, or is not heeded: refused, or said so."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.tagslam.scene import read_remaps, read_scene, read_squashed

FILES = {
    "cameras.yaml": "cam0: {rig_body: rig}\n",
    "camera_poses.yaml": "cam0: {pose: POSE}\n",
    "tagslam.yaml": """
bodies:
 - lab: {type: simple, tags: [{id: 2, size: 0.5, pose: POSE}]}
""",
}
POSE = "{position: {x: 0, y: 0, z: 1}, rotation: {x: 0, y: 0, z: 0}}"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text.replace("POSE", POSE))
    return tmp_path


@pytest.mark.parametrize("rows", ["start_time: 1.0e300", "start_time: 0.0, end_time: -1.0e300"])
def test_stamps_that_no_clock_shows_are_refused(tmp_path: Path, rows: str) -> None:
    path = tmp_path / "tagslam.yaml"
    path.write_text(f"tag_id_remap: [{{id: 10, remaps: [{{remap_id: 13, {rows}}}]}}]\n")
    with pytest.raises(RecordingError, match="_time: expected seconds up to"):
        read_remaps(path)


@pytest.mark.parametrize(
    ("root", "said"),
    [
        (np.full((6, 6), 1e6), "rank 6, got rank 1"),
        (np.full((6, 6), 1e200), r"up to 1e\+12"),
        (1e200 * np.eye(6), r"up to 1e\+12"),
    ],
)
@pytest.mark.parametrize("name", ["tagslam.yaml", "camera_poses.yaml"])
def test_information_that_gives_no_covariance_is_refused(
    folder: Path, name: str, root: np.ndarray, said: str
) -> None:
    told = ", ".join(map(str, root.ravel().tolist()))
    (folder / name).write_text(FILES[name].replace("POSE", f"{POSE[:-1]}, R: [{told}]}}"))
    with pytest.raises(RecordingError, match=f"R: .*{said}"):
        read_scene(folder, {})


@pytest.mark.parametrize("deviation", [1e-6, 1e-2, 1.0])
def test_information_gives_the_covariance_that_it_states(folder: Path, deviation: float) -> None:
    told = ", ".join(map(str, (np.eye(6) / deviation).ravel().tolist()))
    text = FILES["camera_poses.yaml"].replace("POSE", f"{POSE[:-1]}, R: [{told}]}}")
    (folder / "camera_poses.yaml").write_text(text)
    stated = read_scene(folder, {}).cameras["cam0"]
    np.testing.assert_allclose(stated.covariance, deviation**2 * np.eye(6), rtol=1e-9)


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("amnesia", "amnesia: true\n"),
        ("minimum_tag_area", "tagslam_parameters: {minimum_tag_area: 2000}\n"),
    ],
)
def test_what_is_not_heeded_is_said(
    folder: Path, caplog: pytest.LogCaptureFixture, key: str, text: str
) -> None:
    assert not read_scene(folder, {}).ignored
    assert not caplog.text
    with (folder / "tagslam.yaml").open("a") as file:
        file.write(text)
    (told,) = read_scene(folder, {}).ignored
    assert f"{key} is not heeded" in told
    assert told in caplog.text


def test_squashed_tags_are_left_out_at_their_stamp(tmp_path: Path) -> None:
    path = tmp_path / "tagslam.yaml"
    path.write_text('squash: [{time: "1527206556.891942748", tags: [85, 8]}]\n')
    (one,) = read_squashed(path)
    time_ns = 1527206556891942748
    assert one.leaves_out(85, time_ns)
    assert not one.leaves_out(85, time_ns + 10_000_000)
    assert not one.leaves_out(7, time_ns)
    path.write_text('squash: [{time: "1527206556.891942748", tags: 85}]\n')
    with pytest.raises(RecordingError, match=r"squash\.tags: expected a list"):
        read_squashed(path)


def test_cameras_wiggle_as_far_as_is_stated(folder: Path) -> None:
    assert not read_scene(folder, {}).wiggle
    path = folder / "cameras.yaml"
    path.write_text("cam0: {rig_body: rig, wiggle_rotation: 0.02}\ncam1: {wiggle_rotation: 0}\n")
    assert read_scene(folder, {}).wiggle == {"cam0": (0.02, 1e-5)}
    path.write_text("cam0: {rig_body: rig, wiggle_rotation: -1}\n")
    with pytest.raises(RecordingError, match="wiggle_rotation: expected 0 to"):
        read_scene(folder, {})
