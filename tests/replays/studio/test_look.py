"""What a look says of a run: packed arrays, poses at frames, and the ground truth brought home."""

import base64
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Placement, mannequin
from motorcade.fusion.metrics.poses.alignment import Alignment
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.render import Performer
from motorcade.replays.pipeline.look import shown_character
from motorcade.replays.pipeline.packing import back_home, packed, packed_smooth, rows_at
from motorcade.replays.pipeline.runs import write_view


@pytest.mark.parametrize(("kind", "written"), [("f32", "<f4"), ("f64", "<f8"), ("u32", "<u4")])
def test_arrays_are_packed_little_endian_with_their_shape(kind: str, written: str) -> None:
    values = np.arange(12, dtype=np.int64).reshape(3, 4)[:, ::2]
    told = packed(values, kind)
    again = np.frombuffer(base64.b64decode(told[kind]), written).reshape(told["shape"])
    np.testing.assert_array_equal(again, values)


@pytest.mark.parametrize("count", [1, 2, 300])
def test_smooth_rows_come_back_to_half_a_step(count: int) -> None:
    """Added up twice, modulo 2^16, as a page does: leaps from end to end of the range too."""
    rng = np.random.default_rng(3)
    rows = np.cumsum(rng.normal(scale=0.05, size=(count, 4, 8)), axis=0)
    rows[..., 7] = 1.0
    rows[..., 6] = 0.0
    rows[..., 5] = rng.choice([-3.0, 3.0], rows.shape[:-1])
    told = packed_smooth(rows, 1e-3)
    twice = np.frombuffer(base64.b64decode(told["i16"]), "<i2").reshape(-1, count).astype(np.int16)
    summed = np.cumsum(np.cumsum(twice, axis=1, dtype=np.int16), axis=1, dtype=np.int16)
    step = np.frombuffer(base64.b64decode(told["step"]["f64"]), "<f8")
    again = (summed.T * step).reshape(told["shape"])
    assert np.abs(again - rows).max() <= 0.5 * step.max() + 1e-12
    assert step.max() <= 1e-3


@pytest.mark.parametrize("odd", [np.nan, 10.0])
def test_rows_too_large_for_16_bits_stay_as_they_are(odd: float) -> None:
    rows = np.zeros((4, 3))
    rows[2, 1] = odd
    told = packed_smooth(rows, 2e-4)
    again = np.frombuffer(base64.b64decode(told["f32"]), "<f4").reshape(told["shape"])
    np.testing.assert_array_equal(again, rows)


def test_poses_at_frames_are_the_paths_own_and_nothing_beyond_its_ends() -> None:
    rng = np.random.default_rng(2)
    stamps = np.arange(5) * 100_000_000
    path = Trajectory(stamps, Motor.random(rng, (5,)), "world", "camera")
    asked = np.array([-1, 0, 150_000_000, 400_000_000, 400_000_001])
    rows = rows_at(path, asked)
    assert np.isnan(rows[[0, 4]]).all()
    again = Motor.from_quaternion_translation(rows[1:4, 3:], rows[1:4, :3])
    apart = again.inverse() @ path.motors_at(asked[1:4])
    assert np.abs(apart.as_twist()).max() < 1e-12


def test_the_truth_comes_home_by_the_inverse_of_the_alignment() -> None:
    rng = np.random.default_rng(4)
    for scale in (1.0, 0.3, 7.0):
        fit = Alignment(Rotor.random(rng), rng.normal(size=3), scale)
        poses = Motor.random(rng, (50,))
        again = back_home(fit).apply(fit.apply(poses))
        assert np.abs((again.inverse() @ poses).as_twist()).max() < 1e-12


def test_a_figure_is_as_tall_as_it_stands_in_the_world() -> None:
    who = mannequin()
    stamps = np.array([0, 100_000_000])
    grown = Similarity.from_motor_scale(Motor.identity((2,)), np.array([3.0, 3.0]))
    path = Trajectory(stamps, grown, "ground", "character")
    figure = Performer(who, who.clip("idle"), Placement(Motor.identity(), 0.5), path)
    shown = shown_character("guide", figure, stamps)
    assert shown["height_m"] == pytest.approx(1.5 * who.height_m)
    rows = np.frombuffer(base64.b64decode(shown["world_T_character"]["f64"])).reshape(2, 8)
    np.testing.assert_allclose(rows[:, 7], 1.5)


def test_only_one_or_two_runs_become_a_page(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="one or two runs"):
        write_view([], tmp_path / "view.html")
    with pytest.raises(ValueError, match=r"ends in \.html"):
        write_view([tmp_path], tmp_path / "view.txt")
    with pytest.raises(ValueError, match=r"run\.json is not there"):
        write_view([tmp_path], tmp_path / "view.html")
    assert not list(tmp_path.iterdir())
