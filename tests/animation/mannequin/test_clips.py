"""The mannequin's clips: loops that close, bodies that move as bodies do, feet that hold."""

from dataclasses import replace

import numpy as np
import pytest

from docs.making.figure.motions.gait import GAITS
from docs.making.figure.motions.posing import clamped_curve, reach
from docs.making.figure.proportions import figure_skeleton
from motorcade.animation import Character, Clip, mannequin, skin
from motorcade.animation.blend.locomotion import split_root_motion
from motorcade.ga import Motor, Rotor

NAMES = ("idle", "walk", "jog", "run", "wave", "turn")
LOOPS = tuple(name for name in NAMES if name != "turn")
# what lies lower than this touches the ground
TOUCH_M = 0.004


@pytest.fixture(scope="module")
def figure() -> Character:
    return mannequin()


def some(figure: Character, chosen: np.ndarray) -> Character:
    """The figure with a few of its vertices only."""
    fields = ("vertices", "normals", "colors", "joints", "weights")
    return replace(
        figure,
        triangles=np.zeros((0, 3), dtype=np.int64),
        appearance=None,
        morphs=(),
        clips=tuple(replace(clip, morphs=None) for clip in figure.clips),
        **{name: getattr(figure, name)[chosen] for name in fields},
    )


@pytest.fixture(scope="module")
def sample(figure: Character) -> Character:
    return some(figure, np.arange(0, len(figure.vertices), 17))


@pytest.fixture(scope="module")
def soles(figure: Character) -> dict[str, Character]:
    made = {}
    for side in ("left", "right"):
        joints = [figure.skeleton.index(f"{side}_{part}") for part in ("foot", "toes")]
        own = np.isin(figure.joints[:, 0], joints) & (figure.vertices[:, 2] < 0.03)
        made[side] = some(figure, np.flatnonzero(own))
    return made


def over_ground(part: Character, clip: Clip, phases: np.ndarray) -> np.ndarray:
    """Vertices (F, V, 3) in the world, the figure moved ahead at the clip's own speed."""
    times = clip.time_s[0] + phases * clip.duration_s
    vertices = skin(part, clip.at(times))[0].copy()
    vertices[..., 0] += (GAITS[clip.name].speed_m_s if clip.name in GAITS else 0.0) * times[:, None]
    return np.asarray(vertices)


def test_its_clips(figure: Character) -> None:
    assert tuple(clip.name for clip in figure.clips) == NAMES
    assert tuple(clip.name for clip in figure.clips if clip.looped) == LOOPS
    assert 0.0 < GAITS["walk"].speed_m_s < GAITS["jog"].speed_m_s < GAITS["run"].speed_m_s


@pytest.mark.parametrize("name", LOOPS)
def test_loops_close_in_position_and_velocity(sample: Character, name: str) -> None:
    clip = sample.clip(name)
    step = float(np.diff(clip.time_s)[0])
    around = skin(sample, clip.at(clip.duration_s + step * np.arange(-2.0, 3.0)))[0]
    velocity = np.diff(around, axis=0) / step
    change = np.linalg.norm(np.diff(velocity, axis=0), axis=-1).max()
    inside = skin(sample, clip.at(clip.time_s))[0]
    usual = np.linalg.norm(np.diff(inside, n=2, axis=0) / step, axis=-1).max()
    assert change <= 1.05 * usual


@pytest.mark.parametrize(
    ("name", "most_m_s"),
    [("idle", 0.4), ("walk", 5.0), ("jog", 7.0), ("run", 10.0), ("wave", 4.5), ("turn", 4.0)],
)
def test_clips_move_like_a_body(sample: Character, name: str, most_m_s: float) -> None:
    clip = sample.clip(name)
    vertices = skin(sample, clip.at(clip.time_s))[0]
    speed = np.linalg.norm(np.diff(vertices, axis=0), axis=-1) / np.diff(clip.time_s)[:, None]
    assert 0.01 < speed.max() < most_m_s


@pytest.mark.parametrize("name", NAMES)
def test_soles_do_not_sink(soles: dict[str, Character], name: str) -> None:
    for part in soles.values():
        lowest = over_ground(part, part.clip(name), np.linspace(0.0, 1.0, 181))[..., 2].min()
        assert lowest > -0.010


@pytest.mark.parametrize("name", NAMES)
def test_what_touches_the_ground_does_not_slide(soles: dict[str, Character], name: str) -> None:
    """No point of a sole moves by more than 12 mm while it touches, between keys included."""
    for part in soles.values():
        # from the middle of a swing, so that no stance is cut in two
        start = {"left": -0.2, "right": 0.3}[next(s for s in soles if soles[s] is part)]
        if name not in GAITS:
            start = 0.0
        moved = over_ground(part, part.clip(name), start + np.linspace(0.0, 1.0, 361))
        down = moved[..., 2] < TOUCH_M
        assert down.any()
        for vertex in np.flatnonzero(down.any(axis=0)):
            for begin, end in runs(down[:, vertex]):
                assert np.linalg.norm(np.ptp(moved[begin:end, vertex, :2], axis=0)) <= 0.012


def runs(flags: np.ndarray) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


@pytest.mark.parametrize("name", ["walk", "jog", "run"])
def test_feet_stand_for_the_share_of_the_cycle_that_their_source_gives(
    soles: dict[str, Character], name: str
) -> None:
    phases = np.linspace(0.0, 1.0, 241)[:-1]
    low = np.stack(
        [over_ground(part, part.clip(name), phases)[..., 2].min(axis=1) for part in soles.values()]
    )
    touching = low < TOUCH_M
    assert touching.mean(axis=1) == pytest.approx(GAITS[name].stance, abs=0.05)
    in_the_air = np.mean(~touching.any(axis=0))
    both = np.mean(touching.all(axis=0))
    if name == "walk":
        assert in_the_air == 0.0
        assert both > 0.1
    else:
        assert in_the_air > 0.1
        assert both == 0.0


@pytest.mark.parametrize(("name", "clearance_m"), [("walk", 0.01), ("jog", 0.02), ("run", 0.03)])
def test_a_swinging_foot_clears_the_ground(
    soles: dict[str, Character], name: str, clearance_m: float
) -> None:
    stance = GAITS[name].stance
    phases = np.linspace(stance + 0.35 * (1.0 - stance), 1.0 - 0.35 * (1.0 - stance), 30)
    low = over_ground(soles["left"], soles["left"].clip(name), phases)[..., 2].min()
    assert low > clearance_m


@pytest.mark.parametrize("name", ["walk", "jog", "run"])
def test_knees_bend_backwards_only_and_never_snap_straight(figure: Character, name: str) -> None:
    clip = figure.clip(name)
    knee = clip.poses[:, figure.skeleton.index("left_calf")].rotor.as_rotation_vector()
    np.testing.assert_allclose(knee[:, [0, 2]], 0.0, atol=1e-9)
    assert np.rad2deg(knee[:, 1].min()) > 5.0
    assert np.rad2deg(knee[:, 1].max()) == pytest.approx(
        # people bend theirs by 62, 95 and 113; long shoes must be lifted higher
        {"walk": 70, "jog": 108, "run": 118}[name],
        abs=8.0,
    )


def test_right_is_left_half_a_cycle_later(figure: Character) -> None:
    skeleton = figure.skeleton
    for name in GAITS:
        clip = figure.clip(name)
        times = np.linspace(0.0, clip.duration_s, 20)
        here = skeleton.world(clip.at(times)).translation_m
        later = skeleton.world(clip.at(times + 0.5 * clip.duration_s)).translation_m
        for part in ("foot", "toes", "hand", "calf"):
            left, right = (skeleton.index(f"{side}_{part}") for side in ("left", "right"))
            np.testing.assert_allclose(later[:, right], here[:, left] * [1, -1, 1], atol=2e-3)


def test_standing_feet_do_not_move_at_all(figure: Character) -> None:
    for name in ("idle", "wave"):
        clip = figure.clip(name)
        world = figure.skeleton.world(clip.poses)
        for side in ("left", "right"):
            foot = world[:, figure.skeleton.index(f"{side}_foot")]
            still = (foot[:1].inverse() @ foot).as_twist()
            # turns in the file have 32 bits, and two keys' turns meet along a chain of five
            assert np.abs(still).max() < 1e-5


def test_the_turn_ends_as_it_began_a_quarter_to_the_left(figure: Character) -> None:
    clip = figure.clip("turn")
    world = figure.skeleton.world(clip.poses)
    quarter = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(np.array([0.0, 0.0, 0.5 * np.pi])), np.zeros(3)
    )
    gap = (quarter @ world[0]).inverse() @ world[-1]
    assert np.abs(gap.as_twist()).max() < 1e-6
    inside, way = split_root_motion(clip, figure.skeleton)
    assert inside.looped
    assert np.rad2deg(way.start_T_now[-1].rotor.angle()) == pytest.approx(90.0, abs=1e-4)


def test_the_wave_starts_out_of_standing_and_lifts_the_right_hand(figure: Character) -> None:
    clip, idle = figure.clip("wave"), figure.clip("idle")
    gap = clip.poses[0].inverse() @ idle.poses[0]
    assert np.abs(gap.as_twist()).max() < 1e-9
    world = figure.skeleton.world(clip.at(0.5 * clip.duration_s)).translation_m
    hand, head = (world[figure.skeleton.index(name)] for name in ("right_hand", "head"))
    assert hand[2] > head[2] - 0.1


def test_inverse_kinematics_reaches_its_target(figure: Character, rng: np.random.Generator) -> None:
    hips = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(0.2 * rng.standard_normal((50, 3))),
        np.array([0.0, 0.0, 0.55]) + 0.02 * rng.standard_normal((50, 3)),
    )
    ankle = np.array([0.05, 0.08, 0.12]) + 0.05 * rng.uniform(-1.0, 1.0, (50, 3))
    foot = Rotor.from_rotation_vector(0.3 * rng.standard_normal((50, 3)))
    skeleton = figure_skeleton()
    offset = [
        skeleton.rest[skeleton.index(f"left_{n}")].translation_m for n in ("thigh", "calf", "foot")
    ]
    leg = reach(hips, offset[0], ankle, foot, 0.3 * rng.standard_normal(50))
    chain = hips
    for rotor, at in zip((leg.thigh, leg.calf, leg.foot), offset, strict=True):
        chain = chain @ Motor.from_rotor_translation(rotor, np.broadcast_to(at, (50, 3)))
    np.testing.assert_allclose(chain.translation_m, ankle, atol=1e-12)
    assert np.max((chain.rotor.inverse() @ foot).angle()) < 1e-9


def test_an_ankle_out_of_reach_is_refused() -> None:
    with pytest.raises(ValueError, match=r"within 0\.54 m"):
        reach(Motor.identity((1,)), np.zeros(3), np.array([[0.0, 0.0, -1.0]]), Rotor.identity((1,)))


def test_the_curve_of_a_swing_is_the_clamped_cubic_spline(rng: np.random.Generator) -> None:
    from scipy.interpolate import CubicSpline

    knots, values = np.array([0.0, 0.3, 0.45, 0.8, 1.0]), rng.standard_normal(5)
    at = np.linspace(0.0, 1.0, 41)
    witness = CubicSpline(knots, values, bc_type=((1, 0.7), (1, -1.2)))
    np.testing.assert_allclose(clamped_curve(knots, values, 0.7, -1.2, at), witness(at), atol=1e-12)
