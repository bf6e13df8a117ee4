"""A figure in the synthetic room, painted with the room's own light: who guesses it better.

The ground truth is the room's own irradiance at every vertex of the figure, developed as the room
is. The same light in other colours and strengths is the same image developed from other amounts
of light.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorcade.animation import Character, Placement, mannequin, place_on_plane, skin
from motorcade.animation.appearance import Appearance, Material, MaterialPart, to_linear
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import Lighting, Surface, render_overlay
from motorcade.render.light import Prints, lighting_of_footage, lighting_without_depth
from motorcade.render.overlay import new_renderer
from motorcade.render.scene import DepthArray, ImageArray
from motorcade.replays.demo.furniture import BOARD, Occluders, boxes, irradiance, world_T_board
from motorcade.replays.demo.recording import CAMERA, HandheldPath
from motorcade.replays.demo.scene import developed, room

pytestmark = [pytest.mark.usefixtures("opengl"), pytest.mark.slow]

HEIGHT_M = 0.23
TIME_NS = np.array([300_000_000, 2_000_000_000, 4_400_000_000])


def chalk(figure: Character) -> Character:
    """The same without gleam, as irradiance alone paints it."""
    rows = np.ones((len(figure.vertices), 4), np.float32)
    rows[:, :3] = to_linear(figure.colors)
    part = MaterialPart(Material(metallic=0.0, roughness=1.0), 0, len(figure.triangles))
    none = np.zeros((0, len(rows), 2), np.float32)
    return replace(figure, appearance=Appearance((part,), none, rows))


FIGURE = chalk(mannequin())
CLIP = FIGURE.clip("walk")
TINTS = [(1.0, 1.0, 1.0), (1.2, 1.0, 0.7), (0.45, 0.6, 0.8), (0.4, 0.4, 0.4), (1.3, 1.3, 1.3)]


@dataclass
class Shots:
    """Linear light of every stamp's image, without the figure and with it, and where it is."""

    empty: list[FloatArray]
    true: list[FloatArray]
    there: list[NDArray[np.bool_]]
    depth_m: list[DepthArray]
    poses: Trajectory
    placement: Placement


def undeveloped(image: ImageArray) -> FloatArray:
    light = np.linspace(0.0, 1.5, 4000)
    curve = developed(np.repeat(light[:, None], 3, axis=1))[:, 0]
    return np.asarray(np.interp(np.arange(256), curve, light)[image])


@pytest.fixture(scope="module")
def shots() -> Shots:
    poses = HandheldPath.of(np.random.default_rng(0)).trajectory(TIME_NS)
    placement = place_on_plane(FIGURE, (0.0, 0.0), 2.6, height_m=HEIGHT_M)
    taken = Shots([], [], [], [], poses, placement)
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        for stamp, pose in zip(TIME_NS, poses.motors, strict=True):
            own, facing = skin(FIGURE, CLIP.at(1e-9 * (stamp - TIME_NS[0])))
            vertices = placement.apply(own)
            normals = placement.world_T_character.rotor.apply(facing)
            falling = irradiance(vertices, normals, Occluders.of(boxes()))
            painted = developed(falling * to_linear(FIGURE.colors)) / 255.0
            renderer.show(room(), None)
            without = renderer.render(CAMERA, pose)
            renderer.show([Surface(vertices, normals, FIGURE.triangles, painted), *room()], None)
            within = renderer.render(CAMERA, pose)
            taken.empty.append(undeveloped(without.rgba[..., :3]))
            taken.true.append(undeveloped(within.rgba[..., :3]))
            taken.depth_m.append(without.depth_m)
            taken.there.append(within.depth_m < without.depth_m - 1e-4)
    return taken


def errors(
    shots: Shots, empty: Sequence[ImageArray], true: Sequence[ImageArray], light: Lighting | None
) -> tuple[float, float]:
    """Of the figure's mean colour and of its pixels, bytes, means over channels and frames."""
    made = render_overlay(
        zip(TIME_NS.tolist(), empty, strict=True),
        CAMERA,
        shots.poses,
        FIGURE,
        CLIP,
        shots.placement,
        lighting=light,
    )
    apart = [
        (one[there].astype(float) - other[there])
        for one, other, there in zip(made, true, shots.there, strict=True)
    ]
    mean = np.mean([np.abs(one.mean(axis=0)).mean() for one in apart])
    return float(mean), float(np.mean([np.abs(one).mean() for one in apart]))


@pytest.mark.parametrize("tint", TINTS)
def test_paper_and_even_a_grey_world_come_nearer_than_the_fixed_light(
    shots: Shots, tint: tuple[float, float, float]
) -> None:
    empty, true = (
        [developed(light * np.array(tint)) for light in lights]
        for lights in (shots.empty, shots.true)
    )
    frames = [(int(stamp), one, None) for stamp, one in zip(TIME_NS, empty, strict=True)]
    corners = BOARD.points_m[:, :2]
    board = Prints(world_T_board().reshape(1), corners.min(axis=0)[None], corners.max(axis=0)[None])
    fixed, by_paper, by_grey = (
        errors(shots, empty, true, light)
        for light in (
            None,
            lighting_without_depth(frames, CAMERA, shots.poses, shots.placement, HEIGHT_M, board)[
                0
            ],
            lighting_without_depth(frames, CAMERA, shots.poses, shots.placement, HEIGHT_M)[0],
        )
    )
    assert by_paper[0] < 0.8 * fixed[0]
    assert by_grey[0] < 0.85 * fixed[0]
    assert by_paper[1] < 0.95 * fixed[1]
    assert by_grey[1] < 0.95 * fixed[1]
    assert by_paper[0] < 11.0


def test_with_depth_direction_and_colour_come_nearer_still(shots: Shots) -> None:
    empty, true = ([developed(light) for light in lights] for lights in (shots.empty, shots.true))
    stamps = [int(stamp) for stamp in TIME_NS]
    given = CAMERA, shots.poses, shots.placement, HEIGHT_M
    found = lighting_of_footage(zip(stamps, empty, shots.depth_m, strict=True), *given)
    assert found is not None
    assert found[1] == "light estimated from surfaces with depth"
    fixed, by_depth = (errors(shots, empty, true, light) for light in (None, found[0]))
    assert by_depth[0] < 0.5 * fixed[0]
    assert by_depth[1] < 0.9 * fixed[1]
    assert lighting_of_footage([(stamps[0], empty[0], None)], *given) is None
