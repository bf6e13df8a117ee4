"""What boards and the ground hide where no depth was measured, against rays cut with planes."""

import numpy as np
import pytest

from motorcade.animation import Character, Placement, mannequin, place_on_plane
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import render_overlay
from motorcade.render.figures import SHADOW_REACH
from motorcade.render.light import Prints, character_lighting
from motorcade.render.scene import ImageArray
from motorcade.render.shadow import ShadowLook, shade_step_m
from motorcade.render.shots import known_depth, share_beyond
from motorcade.tracking.cameras.camera import Camera

CAMERA = Camera(120, 90, 100.0, 103.0, 61.2, 43.4)
FAR_BELOW = Motor.from_translation([0.0, 0.0, -50.0])
EVERYWHERE_M = np.array([[x, y, z] for x in (-9, 9) for y in (-9, 9) for z in (-9, 9)], float)


def rays(camera: Camera) -> FloatArray:
    """(h, w, 3) through the middle of every pixel, one metre deep."""
    y, x = np.mgrid[: camera.height, : camera.width]
    return np.stack(
        [(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, np.ones_like(x, float)], axis=-1
    )


def cut(camera_T_print: Motor, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Depth where each pixel's ray meets a rectangle (0 where it does not), and how far inside its
    edges, in the rectangle's own metres.
    """
    print_T_camera = camera_T_print.inverse()
    eye, through = print_T_camera.translation_m, print_T_camera.rotor.apply(rays(CAMERA))
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = -eye[2] / through[..., 2]
    met = eye[:2] + depth[..., None] * through[..., :2]
    inside = np.minimum(met - low, high - met).min(axis=-1)
    return np.where((depth > 0.0) & (inside > 0.0), depth, 0.0), inside


@pytest.mark.parametrize("seed", range(12))
def test_a_print_has_the_depth_at_which_rays_meet_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world_T_camera = Motor.random(rng)
    print_in_camera = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(rng.uniform(-1.4, 1.4, 3)),
        rng.uniform([-0.3, -0.3, 0.3], [0.3, 0.3, 3]),
    )  # some of them reach behind the camera
    low, high = -rng.uniform(0.1, 1.5, 2), rng.uniform(0.1, 1.5, 2)
    prints = Prints((world_T_camera @ print_in_camera).reshape(1), low[None], high[None])
    ground = world_T_camera @ FAR_BELOW
    found = known_depth(CAMERA, world_T_camera, world_T_camera.apply(EVERYWHERE_M), prints, ground)
    expected, inside = cut(print_in_camera, low, high)
    assert found is not None
    sure = np.abs(inside) > 1e-9
    np.testing.assert_array_equal((found > 0.0)[sure], (expected > 0.0)[sure])
    both = (found > 0.0) & (expected > 0.0)
    assert both.any()
    np.testing.assert_allclose(found[both], expected[both], rtol=1e-6)


def test_the_paper_round_a_print_hides_as_the_print_does() -> None:
    """A print with a margin is a print as large as its paper."""
    eye = Motor.from_translation([0.0, 0.0, -2.0])
    low, high = np.full((1, 2), -0.3), np.full((1, 2), 0.2)
    prints, sheet = (
        Prints(Motor.identity().reshape(1), low, high, 0.1),
        Prints(Motor.identity().reshape(1), low - 0.1, high + 0.1),
    )
    with_margin, as_sheet = (
        known_depth(CAMERA, eye, EVERYWHERE_M, one, eye @ FAR_BELOW) for one in (prints, sheet)
    )
    np.testing.assert_array_equal(with_margin, as_sheet)
    with pytest.raises(ValueError, match="margin_m: expected 0 or more"):
        Prints(Motor.identity().reshape(1), low, high, -0.1)


def test_no_shadow_shows_on_what_stands_before_the_ground() -> None:
    ground = np.full((40, 60), 2.0, np.float32)
    known = np.zeros_like(ground)
    known[:, 20:30] = 1.5  # before the ground
    known[:, 40:50] = 2.0  # on it
    share = share_beyond(known, ground)
    assert share[:, 22:28].max() < 1e-6
    assert share[:, :17].min() == share[:, 35:].min() == 1.0


def test_what_has_the_figure_and_the_camera_on_one_side_hides_nothing() -> None:
    eye = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([np.pi, 0.0, 0.0]), [0.0, 0.0, 2.0]
    )
    prints = Prints(Motor.identity().reshape(1), np.full((1, 2), -0.3), np.full((1, 2), 0.3))
    figure_m = np.array([[-0.1, -0.1, 0.0], [0.1, 0.1, 0.5]])
    assert known_depth(CAMERA, eye, figure_m, prints, Motor.identity()) is None
    sunk = known_depth(CAMERA, eye, figure_m - [0.0, 0.0, 0.05], None, Motor.identity())
    assert sunk is not None
    np.testing.assert_allclose(sunk, 2.0, rtol=1e-6)


@pytest.mark.parametrize("height_m", [0.03, 1.75, 40.0])
def test_soles_that_sink_by_their_own_share_are_not_hidden(height_m: float) -> None:
    """Where lengths are counted in squares a figure is three of them tall, not 1.75 m."""
    eye = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([np.pi, 0.0, 0.0]), [0.0, 0.0, 4.0 * height_m]
    )
    prints = Prints(Motor.identity().reshape(1), np.full((1, 2), -0.3), np.full((1, 2), 0.3))
    figure_m = height_m * np.array([[-0.1, -0.1, -0.0006], [0.1, 0.1, 1.0]])
    assert known_depth(CAMERA, eye, figure_m, prints, Motor.identity()) is None
    deeper_m = figure_m - [0.0, 0.0, 0.005 * height_m]
    assert known_depth(CAMERA, eye, deeper_m, prints, Motor.identity()) is not None


def test_a_ground_seen_from_beneath_hides_nothing() -> None:
    eye = Motor.from_translation([0.0, 0.0, -1.0])
    assert known_depth(CAMERA, eye, EVERYWHERE_M, None, Motor.identity()) is None


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


def standing_at(figure: Character, z_m: float = 0.0) -> Placement:
    floor = Motor.from_translation([0.0, 0.0, z_m])
    return place_on_plane(figure, height_m=1.0, world_T_plane=floor)


def from_the_front() -> Trajectory:
    """A camera 2 m away on the x axis, level, 0.5 m up."""
    axes = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    pose = Motor.from_rotor_translation(Rotor.from_matrix(axes), [2.0, 0.0, 0.5])
    return Trajectory(np.array([0, 10]), Motor.stack([pose, pose]))


def drawn(figure: Character, placement: Placement, prints: Prints | None) -> ImageArray:
    frame = np.full((CAMERA.height, CAMERA.width, 3), 120, dtype=np.uint8)
    return next(
        render_overlay(
            [(0, frame)],
            CAMERA,
            from_the_front(),
            figure,
            figure.clip("idle"),
            placement,
            look=ShadowLook(strength=0.0, contact=0.0),
            prints=prints,
        )
    )


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize(("x_m", "hides"), [(0.8, True), (-0.8, False)])
def test_a_board_before_the_figure_hides_it_and_one_behind_does_not(
    figure: Character, x_m: float, hides: bool
) -> None:
    facing = Rotor.from_matrix(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    board = Motor.from_rotor_translation(facing, [x_m, 0.0, 0.2])
    prints = Prints(board.reshape(1), np.array([[-0.3, -0.1]]), np.array([[0.3, 0.3]]))
    placement = standing_at(figure)
    plain, behind = drawn(figure, placement, None), drawn(figure, placement, prints)
    if not hides:
        np.testing.assert_array_equal(behind, plain)
        return
    # Eye height 0.5 m, 1.2 m away: rows of z = 0.1 and 0.5, columns of y = ±0.3.
    top, bottom = CAMERA.cy, CAMERA.cy + 103.0 * 0.4 / 1.2
    left, right = CAMERA.cx - 25.0, CAMERA.cx + 25.0
    inside = np.s_[int(top) + 3 : int(bottom) - 2, int(left) + 3 : int(right) - 2]
    assert np.any(plain[inside] != 120)
    assert np.all(behind[inside] == 120)
    np.testing.assert_array_equal(behind[: int(top) - 2], plain[: int(top) - 2])
    np.testing.assert_array_equal(behind[int(bottom) + 4 :], plain[int(bottom) + 4 :])


@pytest.mark.usefixtures("opengl")
def test_what_sinks_into_the_ground_is_hidden_by_it(figure: Character) -> None:
    whole = drawn(figure, standing_at(figure), None)
    feet = CAMERA.cy + 103.0 * 0.5 / 2.0  # where z = 0 is seen, 2 m away
    # The same figure with its shins below its own ground: the clip sinks, the ground stays.
    sunk = figure.clip("idle")
    poses = sunk.poses.coefficients.copy()
    root = int(np.flatnonzero(figure.skeleton.parents < 0)[0])
    down = Motor.from_translation([0.0, 0.0, -0.2 * figure.height_m])
    poses[:, root] = (down @ sunk.poses[:, root]).coefficients
    lower = type(sunk)("sunk", sunk.time_s, Motor.normalize(poses))
    frame = np.full((CAMERA.height, CAMERA.width, 3), 120, dtype=np.uint8)
    seen = next(
        render_overlay(
            [(0, frame)],
            CAMERA,
            from_the_front(),
            figure,
            lower,
            standing_at(figure),
            look=ShadowLook(strength=0.0, contact=0.0),
        )
    )
    rows = np.flatnonzero(np.any(seen != 120, axis=(1, 2)))
    assert np.any(whole != 120, axis=(1, 2))[int(feet) - 4]
    assert rows.max() <= feet + 4.0
    assert rows.min() > np.flatnonzero(np.any(whole != 120, axis=(1, 2))).min() + 5


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("renderer", ["fast", "pyrender"])
def test_light_and_shadow_go_with_a_figure_that_travels(figure: Character, renderer: str) -> None:
    """Far from where it was placed it looks as if it had been placed there."""
    away = 75 * shade_step_m(SHADOW_REACH[0] * 1.0)  # three heights
    idle = figure.clip("idle")
    root = int(np.flatnonzero(figure.skeleton.parents < 0)[0])
    steps = [0.0, away * figure.height_m]
    poses = np.stack([idle.poses[0].coefficients] * 2)
    for k, x in enumerate(steps):
        gone = Motor.from_translation([x, 0.0, 0.0])
        poses[k, root] = (gone @ idle.poses[0, root]).coefficients
    travels = type(idle)("travels", np.array([0.0, 1.0]), Motor.normalize(poses))
    stands = type(idle)("stands", idle.time_s[:1], idle.poses[:1])
    here = standing_at(figure)
    there = place_on_plane(figure, (away, 0.0), height_m=1.0)
    path_here = from_the_front()
    shift = Motor.from_translation([away, 0.0, 0.0])
    moved = Trajectory(np.array([0, 1_000_000_000]), shift @ path_here.motors)
    light = character_lighting(here, path_here.motors, 1.0, np.array([-0.4, 0.3, -0.85]))
    light_there = light.translated_by(np.array([away, 0.0, 0.0]))
    frame = np.full((CAMERA.height, CAMERA.width, 3), 120, dtype=np.uint8)
    stamps = (0, 1_000_000_000)
    went = list(
        render_overlay(
            ((t, frame) for t in stamps),
            CAMERA,
            moved,
            figure,
            travels,
            here,
            lighting=light,
            renderer=renderer,
        )
    )[1]
    stood = next(
        render_overlay(
            [(0, frame)],
            CAMERA,
            moved,
            figure,
            stands,
            there,
            lighting=light_there,
            renderer=renderer,
        )
    )
    assert np.abs(went.astype(int) - stood).mean() < 0.05
    assert np.mean(np.any(stood < 100, axis=-1)) > 0.01  # a shadow is there
