"""What the report draws of the filter is what the filter said, and the sheet is small enough."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from motorcade.fusion.filter.findings import LatencyCurve
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import write_video
from motorcade.render.video import read_frames
from motorcade.replays.pipeline.report.film import (
    MOST_BYTES,
    sheet_jpeg,
    standing_sheet,
    steps_between,
)
from motorcade.replays.pipeline.report.findings import Findings, as_drawn
from motorcade.replays.pipeline.report.images import filter_errors, filter_images
from motorcade.replays.stages.values.view import StandingPlace
from motorcade.tracking import Camera

SCREW = np.array([0.3, -0.2, 0.5, 0.4, 0.1, -0.2])
COUNT = 50


def findings(**changed: Any) -> Any:
    """A truth on a screw at 100 Hz, and a path at 20 Hz between its stamps, off by known twists."""
    rng = np.random.default_rng(11)
    truth_ns = (np.arange(300) * 10_000_000).astype(np.int64)
    truth = Trajectory(truth_ns, Motor.from_twist(1e-9 * truth_ns[:, None] * SCREW))
    stamps = (3_000_000 + np.arange(COUNT) * 50_000_000).astype(np.int64)
    sigma = rng.uniform(1e-3, 1e-2, (COUNT, 6))
    off = sigma * rng.normal(size=(COUNT, 6))
    right = Motor.from_twist(1e-9 * stamps[:, None] * SCREW)
    path = Trajectory(stamps, right @ Motor.from_twist(-off))
    nis = rng.chisquare(6, COUNT)
    nis[::5] = np.nan
    made: dict[str, Any] = {
        "recording": SimpleNamespace(truth=truth),
        "camera_poses": SimpleNamespace(
            measurements=SimpleNamespace(trajectory=path),
            frame_times_ns=stamps,
            origin="board",
            reprojection_px=np.full(COUNT, 0.2),
        ),
        "imu": SimpleNamespace(origin="recorded"),
        "fused": SimpleNamespace(
            trajectory=path,
            covariance=sigma[..., None] ** 2 * np.eye(6),
            nis=nis,
            by="imu",
            accepted=np.arange(COUNT) % 10 != 3,
            latency=None,
            noise=None,
        ),
        "errors": SimpleNamespace(align="none"),
        "convergence": SimpleNamespace(time_s=np.zeros(0)),
        "off": off,
        "sigma": sigma,
    }
    return SimpleNamespace(**(made | changed))


def test_errors_are_those_from_the_path_to_the_truth_at_its_own_stamps() -> None:
    told = findings()
    found = filter_errors(told)
    assert found is not None
    np.testing.assert_allclose(found.errors, told.off, atol=1e-9)
    np.testing.assert_allclose(found.sigma, told.sigma, rtol=1e-12)
    np.testing.assert_allclose(found.time_s, np.arange(COUNT) * 0.05, atol=1e-12)
    path = told.fused.trajectory.motors.as_matrix()
    truth = Motor.from_twist((0.003 + found.time_s[:, None]) * SCREW).as_matrix()
    turned = Rotation.from_matrix(np.swapaxes(path[:, :3, :3], 1, 2) @ truth[:, :3, :3])
    np.testing.assert_allclose(found.errors[:, :3], turned.as_rotvec(), atol=1e-9)


def test_alignment_is_that_of_the_errors() -> None:
    told = findings()
    exact = Motor.from_twist(1e-9 * told.fused.trajectory.time_ns[:, None] * SCREW)
    away = Motor.from_rotor_translation(Rotor.from_rotation_vector([0.4, 0.3, -1.0]), [1, 2, 3])
    told.fused.trajectory = Trajectory(told.fused.trajectory.time_ns, away @ exact)
    told.errors.align = "se3"
    found = filter_errors(told)
    assert found is not None
    # The ground truth's stamps lie 3 ms away: so much of the motion is left in the alignment.
    assert np.abs(found.errors).max() < 2e-3
    told.errors.align = "none"
    again = filter_errors(told)
    assert again is not None
    assert np.abs(again.errors).max() > 0.5


def test_nothing_is_told_of_a_filter_that_did_not_run_or_without_a_truth() -> None:
    assert filter_errors(findings(recording=SimpleNamespace(truth=None))) is None
    told = findings()
    told.fused.by = "nothing"
    told.fused.nis = np.full(COUNT, np.nan)
    assert filter_errors(told) is None
    assert filter_images(told) == []


def test_a_curve_of_lags_is_drawn_where_it_was_asked_for() -> None:
    told = findings()
    told.fused.latency = LatencyCurve(
        np.array([0.0, 0.5, np.inf]), np.array([9e-3, 4e-4, 0.0]), np.array([0.2, 0.1, 0.0])
    )
    *_, image = filter_images(told)
    assert image.title == "What answering later gains"
    assert "9.00 mm and 0.200° at once, 0.40 mm and 0.100° after 0.5 s" in image.caption
    assert image.svg.startswith("<svg")


def test_captions_count_what_lies_within() -> None:
    told = findings()
    rotation, position, nis = filter_images(told)
    for image, part in ((rotation, slice(0, 3)), (position, slice(3, 6))):
        share = np.mean(np.abs(told.off[:, part]) <= told.sigma[:, part])
        assert f" {100 * share:.0f} % lie within one" in image.caption
        assert image.names == ("x", "y", "z")
    low, high = chi2(6).ppf([0.025, 0.975])
    known = told.fused.nis[np.isfinite(told.fused.nis)]
    share = np.mean((known >= low) & (known <= high))
    assert f"({low:.2f} to {high:.2f})" in nis.caption
    assert f"here {100 * share:.0f} %" in nis.caption
    assert "5 were left out" in nis.caption
    strokes = re.findall(r'd="((?:M \S+ \S+ \S+ \S+\s*){20,})"', nis.svg)
    assert len(strokes) == 1
    assert strokes[0].count("M") == len(known)


def test_what_lasts_is_told_apart_from_what_does_not() -> None:
    told = findings()
    path = told.fused.trajectory
    lasting = Motor.from_twist(np.tile([0.05, 0.0, 0.0, 0.0, 0.0, 0.0], (COUNT, 1)))
    told.fused.trajectory = Trajectory(path.time_ns, path.motors @ lasting)
    found = filter_errors(told)
    assert found is not None
    centred = found.errors[:, :3] - found.errors[:, :3].mean(axis=0)
    share = np.mean(np.abs(centred) <= found.sigma[:, :3])
    caption = filter_images(told)[0].caption
    assert share > 0.5
    assert caption.endswith(f"less their mean over time, {100 * share:.0f} % lie within.")


def test_without_a_filter_nothing_is_said_of_the_noise() -> None:
    told = findings()
    told.fused.nis = np.full(COUNT, np.nan)
    assert [one.title for one in filter_images(told)] == [
        "Rotation within ±σ",
        "Position within ±σ",
    ]
    nis = Findings.nis_per_dimension.fget
    assert nis is not None
    assert nis(told) is None
    simulated = findings(imu=SimpleNamespace(origin="reference"))
    assert nis(simulated) == pytest.approx(np.nanmean(simulated.fused.nis) / 6)


@pytest.mark.parametrize(
    ("origin", "fit_px", "said"),
    [("board", 0.03, True), ("board", 0.2, False), ("slam", 0.03, False)],
)
def test_corners_that_fit_better_than_any_is_believed_are_mentioned(
    origin: str, fit_px: float, said: bool
) -> None:
    told = findings()
    told.camera_poses.origin = origin
    told.camera_poses.reprojection_px = np.full(COUNT, np.sqrt(2.0) * fit_px)
    caption = filter_images(told)[2].caption
    assert (
        "Corners fit to 0.03 px a coordinate here, and none is believed below 0.1" in caption
    ) is said


def drawn_by_slam(up: np.ndarray, **changed: Any) -> Any:
    """Findings whose character stands on a plane with that normal."""
    aside = np.cross(up, [0.3, 0.5, 0.7])
    aside /= np.linalg.norm(aside)
    turned = Rotation.from_matrix(np.column_stack([aside, np.cross(up, aside), up]))
    placement = SimpleNamespace(
        world_T_character=Motor.from_rotor_translation(
            Rotor.from_quaternion(turned.as_quat(scalar_first=True)), np.array([1.0, 2.0, 3.0])
        )
    )
    told = findings(placed=SimpleNamespace(placement=placement, stands_on="a plane"), **changed)
    told.camera_poses.origin, told.camera_poses.metric = "slam", False
    return told


@pytest.mark.parametrize(
    "up", [[0, -1, 0], [0, 0, 1], [0, 0, -1], [0.6, 0, -0.8], [0.48, 0.6, 0.64]]
)
def test_up_of_what_is_stood_on_is_drawn_upwards(up: list[float]) -> None:
    told = drawn_by_slam(np.array(up, np.float64), recording=SimpleNamespace(truth=None))
    path = told.fused.trajectory
    drawn = as_drawn(told, {"motor": path})
    before, after = path.motors.translation_m, drawn.paths["motor"].motors.translation_m
    np.testing.assert_allclose(after[:, 2], before @ up, atol=1e-12)
    np.testing.assert_allclose(after @ after.T, before @ before.T, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(np.linalg.lstsq(before, after)[0]), 1.0, atol=1e-9)
    assert drawn.unit == "units"
    assert drawn.note == "Up is the normal of a plane."


def test_ahead_is_ahead_where_the_image_s_up_is_taken() -> None:
    told = drawn_by_slam(np.array([0.0, -1.0, 0.0]), recording=SimpleNamespace(truth=None))
    ahead = Motor.from_rotor_translation(Rotor.identity((2,)), [[0.0, 0.0, 0.0], [0.1, -0.2, 5.0]])
    path = Trajectory(np.array([0, 10**9]), ahead)
    drawn = as_drawn(told, {"motor": path}).paths["motor"]
    np.testing.assert_allclose(drawn.motors.translation_m[1], [0.1, 5.0, 0.2], atol=1e-12)


def test_elsewhere_the_world_is_drawn_as_it_is() -> None:
    told = drawn_by_slam(np.array([1.0, 0.0, 0.0]), recording=SimpleNamespace(truth=None))
    told.camera_poses.origin, told.camera_poses.metric = "board", True
    path = told.fused.trajectory
    drawn = as_drawn(told, {"motor": path})
    assert drawn.paths == {"motor": path}
    assert (drawn.unit, drawn.note) == ("m", "Up is z of the world.")


def test_the_truth_is_drawn_while_the_recording_lasts_and_up_with_it() -> None:
    """Stamps of the ground truth reach from 0 to 2.99 s, those of the poses from 0.5 to 1.5 s."""
    told = drawn_by_slam(np.array([0.0, -1.0, 0.0]))
    told.camera_poses.frame_times_ns = np.arange(500, 1501, 50) * 1_000_000
    right = told.recording.truth.motors_at(told.camera_poses.frame_times_ns)
    away = Motor.from_rotor_translation(Rotor.from_rotation_vector([0.4, 0.3, -1.0]), [1, 2, 3])
    told.errors.align = "se3"
    tracked = Trajectory(told.camera_poses.frame_times_ns, away @ right)
    drawn = as_drawn(told, {"motor": tracked})
    truth, path = drawn.paths["truth"], drawn.paths["motor"]
    assert (truth.time_ns[0], truth.time_ns[-1]) == (500_000_000, 1_500_000_000)
    assert drawn.unit == "m"
    np.testing.assert_allclose(
        path.motors.translation_m, truth.motors_at(path.time_ns).translation_m, atol=1e-9
    )
    tall = path.motors.translation_m[:, 2] + tracked.motors.translation_m[:, 1]
    np.testing.assert_allclose(tall, tall[0], atol=1e-9)


@pytest.mark.parametrize("count", [2, 12, 40])
def test_the_sheet_holds_up_to_twelve_frames_and_is_small(count: int, tmp_path: Path) -> None:
    """Noise, which no JPEG makes small; each frame has a grey of its own in the middle."""
    rng = np.random.default_rng(4)
    frames = rng.integers(0, 256, (count, 240, 320, 3), dtype=np.uint8)
    for k, frame in enumerate(frames):
        frame[80:160, 100:220] = 5 * k
    film = tmp_path / "film.mp4"
    write_video(film, frames, np.arange(count, dtype=np.int64) * 50_000_000)
    every = steps_between(count)
    data = sheet_jpeg(list(read_frames(film, every)))
    assert len(data) <= MOST_BYTES
    sheet = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert every == -(-count // 12)
    chosen = list(range(0, count, every))
    assert len(chosen) <= 12
    for place, k in enumerate(chosen):
        row, column = divmod(place, 3)
        at = sheet[6 + row * 261 + 127, 6 + column * 346 + 170]
        assert np.abs(at.astype(int) - 5 * k).max() <= 14, (place, k)
    stamps = [time_ns for time_ns, _ in read_frames(film, every)]
    np.testing.assert_allclose(stamps, np.array(chosen) * 50_000_000, atol=20_000)


def test_frames_are_counted_from_one(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"read_frames\(every\): expected 1 or more, got 0"):
        next(read_frames(tmp_path / "film.mp4", 0))


@pytest.mark.parametrize("taken", [0, 1, 2])
def test_the_outline_that_stands_out_is_that_of_what_it_stands_on(taken: int) -> None:
    """Three places before a camera, of which any may be asked for by its number."""
    square = np.array([[-1.0, -0.7, 4.0], [1.0, -0.7, 4.0], [1.0, 0.7, 4.0], [-1.0, 0.7, 4.0]])
    places = tuple(StandingPlace(f"place {k}", "", square) for k in range(3))
    path = Trajectory(np.array([0, 100]), Motor.identity((2,)))
    given: Any = SimpleNamespace(
        recording=SimpleNamespace(frames=SimpleNamespace(time_ns=path.time_ns)),
        placed=SimpleNamespace(choices=places, stands_on=places[taken].name),
        camera_poses=SimpleNamespace(camera=Camera(320, 240, 300.0, 300.0, 159.5, 119.5)),
        integrity=SimpleNamespace(drawn=path),
    )
    data = standing_sheet(given, {0: np.full((240, 320, 3), 128, np.uint8)})
    sheet = cv2.cvtColor(cv2.imdecode(np.frombuffer(data, np.uint8), 1), cv2.COLOR_BGR2RGB)
    orange = (sheet[..., 0] > 200) & (sheet[..., 2] < 100)
    panels = [np.count_nonzero(part) for part in np.array_split(orange, 3, axis=1)]
    assert int(np.argmax(panels)) == taken
    assert sorted(panels)[1] == 0
