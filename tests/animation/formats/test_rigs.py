"""The real rigs: every one loads, and stands and moves as another program says."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character
from motorcade.animation.formats import read_character, read_motion
from motorcade.ga import Motor
from tests.animation.formats.collada_witness import ColladaWitness
from tests.animation.formats.witness import Witness, fitted

SHARE = 1e-4
"""How far joints may lie from a witness, as a share of the height."""
ASTRO = "astroBoy_newSkeleton_"

CHARACTERS = {
    "astroboy/astro_max.dae": (44, 4881, 1),
    "astroboy/astro_maya.dae": (44, 4881, 1),
    "astroboy/astro_max_dae.glb": (43, 4881, 1),
    "astroboy/astro_maya_dae.glb": (43, 4881, 1),
    "arnaud/arnaud_fbx.glb": (53, 6670, 0),
    "kaykit/Knight.glb": (41, 6952, 76),
    "makehuman/mh_male_ge53_27k.glb": (53, 26756, 3),
    "makehuman/mh_male_ge53_135k_dressed.glb": (53, 134960, 3),
    "md5/Bob.md5mesh": (33, 1027, 1),
    "md5/Bob_md5mesh.glb": (32, 1027, 1),
    "sinbad/sinbad.glb": (65, 7612, 13),
}
MOTIONS = {
    "arnaud/walk_fbx.glb": (41, 1.3333),
    "arnaud/jog_fbx.glb": (53, 0.8),
    "arnaud/run_fbx.glb": (47, 0.6667),
    "bvh/01_01.bvh": (2752, 22.925),
    "bvh/fair_dab.bvh": (339, 11.267),
    "bvh/jumping_jacks.bvh": (125, 4.133),
    "md5/Bob.md5anim": (140, 5.7917),
}


@pytest.mark.parametrize("name", CHARACTERS)
def test_a_character_has_the_joints_triangles_and_clips_of_its_file(rigs: Path, name: str) -> None:
    made = read_character(rigs / name)
    found = (len(made.skeleton), len(made.triangles), len(made.clips))
    assert found == CHARACTERS[name]
    assert made.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_has_the_keys_and_the_span_of_its_file(rigs: Path, name: str) -> None:
    (clip,) = read_motion(rigs / name).clips
    keys, seconds = MOTIONS[name]
    assert clip.key_count == keys
    assert clip.duration_s == pytest.approx(seconds, abs=1e-3)


@pytest.mark.parametrize("name", CHARACTERS)
def test_a_figure_faces_x_with_its_left_at_y(rigs: Path, name: str) -> None:
    """Toes ahead of ankles; limbs called left lie at +y, but for Bob, whose sides are swapped."""
    made = read_character(rigs / name)
    places = made.skeleton.rest_world.translation_m
    names = [joint.lower() for joint in made.skeleton.names]
    toes = [
        i
        for i, joint in enumerate(names)
        if ("toe" in joint or "ball" in joint or "footthumb" in joint)
        and "ik" not in joint
        and "control" not in joint
    ]
    ahead = [places[i] - places[made.skeleton.parents[i]] for i in toes]
    assert len(toes) >= 2
    assert all(step[0] > 0.5 * np.linalg.norm(step[:2]) for step in ahead)
    sides = [
        places[i, 1]
        for i, joint in enumerate(names)
        if joint.endswith((".l", "_l")) or "left" in joint or "_l_" in f"_{joint}"
    ]
    sign = -1.0 if "Bob" in name else 1.0
    weaponless = np.median(sign * np.array(sides))
    assert weaponless > 0.0


WITNESSED = [
    ("astroboy/astro_max.dae", "astroboy/astro_max_dae.glb", ASTRO, False),
    ("astroboy/astro_maya.dae", "astroboy/astro_maya_dae.glb", ASTRO, True),
    ("md5/Bob.md5mesh", "md5/Bob_md5mesh.glb", "", False),
]


@pytest.mark.parametrize(("name", "witness", "prefix", "at_keys"), WITNESSED)
def test_joints_lie_where_the_witness_puts_them(
    rigs: Path, name: str, witness: str, prefix: str, at_keys: bool
) -> None:
    """At 20 times of the clip, after the turn of axes, the unit and the lift that were read.

    The Maya file's curves are Bézier, which the witness drops between keys: it is asked at keys,
    and the curves have a witness of their own below.
    """
    made, other = read_character(rigs / name), Witness(rigs / witness)
    clip = made.clips[0]
    times = np.linspace(clip.time_s[0], clip.time_s[-1], 20)
    if at_keys:
        keys = np.unique(other.accessor(other.document["animations"][0]["samplers"][0]["input"]))
        times = keys[np.linspace(0, len(keys) - 1, 20).astype(int)]
    ours = made.skeleton.world(clip.at(times)).translation_m
    theirs = np.array(
        [
            [at[prefix + joint][:3, 3] for joint in made.skeleton.names]
            for at in (other.world(float(time_s)) for time_s in times)
        ]
    )
    scale, turn, shift = fitted(theirs.reshape(-1, 3), ours.reshape(-1, 3))
    np.testing.assert_allclose(turn, [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-4)
    assert scale == pytest.approx(0.0254 if "Bob" in name else 1.0, rel=1e-4)
    exact = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]) * (0.0254 if "Bob" in name else 1.0)
    assert np.abs(shift[:2]).max() < SHARE * made.height_m
    off = np.linalg.norm(theirs @ exact.T + (0.0, 0.0, shift[2]) - ours, axis=-1)
    assert off.max() < SHARE * made.height_m


def test_joints_follow_the_bezier_curves_of_the_maya_file_between_its_keys(rigs: Path) -> None:
    """Each cubic solved for its time by itself, at 20 times of which 18 are no keys."""
    path = rigs / "astroboy/astro_maya.dae"
    made, other = read_character(path), ColladaWitness(path)
    times = np.linspace(*other.span(), 20)
    keys = np.concatenate([curve.keys for parts in other.curves.values() for _, curve in parts])
    assert np.abs(times[1:-1, None] - keys).min() > 1e-4
    ours = made.skeleton.world(made.clips[0].at(times)).translation_m
    worlds = [other.world(float(time_s)) for time_s in times]
    theirs = np.array(
        [[at[ASTRO + joint][:3, 3] for joint in made.skeleton.names] for at in worlds]
    )
    apart = ours - 0.01 * theirs[..., [2, 0, 1]]
    apart[..., 2] -= np.median(apart[..., 2])  # lifted so that the soles stand at 0
    assert np.linalg.norm(apart, axis=-1).max() < SHARE * made.height_m


def skinned_by_matrices(other: Witness, time_s: float) -> np.ndarray:
    """Vertices of the file's first skin by its own matrices, scale and all."""
    world = other.world(time_s)
    skin = other.document["skins"][0]
    nodes = [other.nodes[node]["name"] for node in skin["joints"]]
    binds = other.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).swapaxes(1, 2)
    palette = np.stack([world[node] for node in nodes]) @ binds
    parts = []
    for primitive in other.document["meshes"][0]["primitives"]:
        given = primitive["attributes"]
        vertices = other.accessor(given["POSITION"])
        numbers = other.accessor(given["JOINTS_0"]).astype(int)
        weights = other.accessor(given["WEIGHTS_0"])
        weights /= weights.sum(axis=1, keepdims=True)
        blended = np.einsum("vk,vkij->vij", weights, palette[numbers])
        moved = np.einsum("vij,vj->vi", blended[:, :3, :3], vertices) + blended[:, :3, 3]
        parts.append(moved)
    return np.concatenate(parts)


def posed(made: Character, time_s: float) -> tuple[np.ndarray, Motor]:
    """Vertices blended linearly by rigid motors, and the motors."""
    poses = made.clips[0].at(time_s)
    assert isinstance(poses, Motor)
    motors = made.skeleton.world(poses) @ made.skeleton.rest_world_inverse
    each = motors[made.joints].apply(made.vertices[:, None])
    return np.einsum("vk,vki->vi", made.weights, each), motors


@pytest.mark.parametrize(
    ("name", "scale"), [("astro_max_dae.glb", 0.0254), ("astro_maya_dae.glb", 0.01)]
)
def test_astroboy_is_skinned_by_rigid_motors_as_by_its_scaled_matrices(
    rigs: Path, name: str, scale: float
) -> None:
    """Its palettes carry a scale: motors made of them as they stand would lose it."""
    made, other = read_character(rigs / "astroboy" / name), Witness(rigs / "astroboy" / name)
    world = other.world(0.5)
    for node in other.document["skins"][0]["joints"]:
        block = world[other.nodes[node]["name"]][:3, :3]
        assert np.cbrt(np.linalg.det(block)) == pytest.approx(scale, rel=1e-4)
    for time_s in (0.2, 0.5, 0.9):
        ours, _ = posed(made, time_s)
        theirs = skinned_by_matrices(other, time_s)[:, [2, 0, 1]]
        lift = np.array([0.0, 0.0, np.median(ours[:, 2] - theirs[:, 2])])
        off = np.linalg.norm(theirs + lift - ours, axis=1)
        assert off.max() < 2e-4 * made.height_m
    rest = made.skeleton.rest_world.as_matrix()[:, :3, :3]
    np.testing.assert_allclose(np.linalg.det(rest), 1.0, atol=1e-9)


def test_all_keys_of_the_knight_are_decoded(rigs: Path) -> None:
    made, other = read_character(rigs / "kaykit/Knight.glb"), Witness(rigs / "kaykit/Knight.glb")
    animations = other.document["animations"]
    assert [clip.name for clip in made.clips] == [one["name"] for one in animations]
    for number in range(0, 76, 9):
        clip = made.clips[number]
        inputs = {sampler["input"] for sampler in animations[number]["samplers"]}
        keys = max((other.accessor(one)[:, 0] for one in inputs), key=len)
        assert clip.key_count == len(keys)
        assert np.all(np.isin(keys, clip.time_s))
        time_s = keys[len(keys) // 2]
        world = other.world(float(time_s), number)
        theirs = np.array([world[joint][:3, 3] for joint in made.skeleton.names])[:, [2, 0, 1]]
        ours = made.skeleton.world(clip.at(time_s)).translation_m
        off = np.linalg.norm(ours - theirs - np.median(ours - theirs, axis=0), axis=1)
        assert off.max() < 1e-5 * made.height_m


@pytest.mark.parametrize("name", ["arnaud", "walk", "jog", "run"])
def test_fbx_equals_what_was_exported_from_it(rigs: Path, name: str) -> None:
    """In metres by the unit that the FBX states."""
    import shutil

    if shutil.which("assimp") is None:
        pytest.skip("the program assimp is not installed")
    folder = rigs / "arnaud"
    ours, theirs = read_motion(folder / f"{name}.fbx"), read_motion(folder / f"{name}_fbx.glb")
    assert ours.skeleton.names == theirs.skeleton.names
    np.testing.assert_allclose(
        ours.skeleton.rest_world.translation_m, theirs.skeleton.rest_world.translation_m, atol=1e-5
    )
    assert not any("unit" in notice for notice in ours.notices)


def test_arnaud_is_as_tall_as_a_man(rigs: Path) -> None:
    made = read_character(rigs / "arnaud/arnaud_fbx.glb")
    assert 1.7 < made.height_m < 1.9
    assert any("centimetre" in notice for notice in made.notices)


@pytest.mark.parametrize(("name", "speed"), [("walk", 1.2), ("jog", 2.0), ("run", 2.7)])
def test_arnaud_moves_upright_and_ahead(rigs: Path, name: str, speed: float) -> None:
    """Exported helpers hold what the joint's own keys contain too: they must not count twice."""
    motion = read_motion(rigs / "arnaud" / f"{name}_fbx.glb")
    clip = motion.clips[0]
    world = motion.skeleton.world(clip.at(np.linspace(0.0, clip.duration_s, 60))).translation_m
    head, hips = (world[:, motion.skeleton.index(joint)] for joint in ("Head", "Pelvis"))
    assert np.all((head[:, 2] > 1.4) & (head[:, 2] < 1.8))
    assert np.all(np.linalg.norm(head[:, :2] - hips[:, :2], axis=1) < 0.4)
    steps = np.diff(hips[:, 0]) / np.diff(np.linspace(0.0, clip.duration_s, 60))
    assert steps.mean() > 0.8 * speed
    assert np.abs(np.ptp(hips[:, 1])) < 0.15
