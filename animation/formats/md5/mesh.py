"""Meshes of MD5 files: vertices as weighted points in the frames of joints, and their pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.animation.appearance import Material, TextureMap
from motorcade.animation.formats.errors import expected
from motorcade.animation.formats.images import Textures, colors_at_vertices
from motorcade.animation.formats.limits import MAX_NODES, picture_beside, read_bounded
from motorcade.animation.formats.md5.motion import orientation, read_clip
from motorcade.animation.formats.md5.words import Words, opened
from motorcade.animation.formats.rig.transforms import Transforms
from motorcade.animation.formats.rig.values import NodeTree, Rig, RigClip, RigSurface, Skin
from motorcade.animation.skeleton import local_poses
from motorcade.animation.srgb import to_linear
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import is_there

MOST = 1 << 21
MOST_INFLUENCES = 64
PLAIN = (0.8, 0.8, 0.8)
PICTURES = (".tga", ".png", ".jpg")


def read_md5_mesh(path: Path) -> Rig:
    """Read a `.md5mesh`, and as its clip the `.md5anim` of the same name beside it, if any.

    Raises:
        FormatError: a file that is not consistent, or a motion of other joints.
    """
    words = opened(path)
    words.need("numJoints")
    count = words.integer("numJoints", 1, MAX_NODES)
    words.need("numMeshes")
    meshes = words.integer("numMeshes", 0, 10_000)
    names, parents, world = _joints(words, count)
    tree = NodeTree(names, parents, _local(parents, world))
    skin = Skin(np.arange(count), world.inverse().as_matrix())
    textures = Textures()
    surfaces = []
    for number in range(meshes):
        surface = _mesh(words, number, world, skin, path.parent, textures)
        if surface is not None:
            surfaces.append(surface)
    motion = path.with_suffix(".md5anim")
    clips: tuple[RigClip, ...] = ()
    if is_there(motion):
        clips = (read_clip(motion, names, parents),)
    return Rig(
        tree,
        tuple(range(count)),
        tuple(surfaces),
        clips,
        up=(0.0, 0.0, 1.0),
        forward=None,
        unit_m=None,
        notices=tuple(textures.notices),
    )


def _joints(words: Words, count: int) -> tuple[tuple[str, ...], IntArray, Motor]:
    """Names, parents and world poses."""
    words.need("joints", "{")
    names, parents, numbers = [], [], []
    for joint in range(count):
        names.append(words.word("joint name")[:200])
        parents.append(words.integer(f"parent of joint {joint}", -1, joint - 1))
        numbers.append(words.floats(6, f"joint '{names[-1]}'"))
    words.need("}")
    values = np.stack(numbers)
    world = Motor.from_quaternion_translation(orientation(values[:, 3:]), values[:, :3])
    return tuple(names), np.array(parents), world


def _local(parents: IntArray, world: Motor) -> Transforms:
    wxyz, places = local_poses(parents, world).as_quaternion_translation()
    return Transforms(wxyz, places, np.ones(len(parents)))


def _mesh(
    words: Words,
    number: int,
    world: Motor,
    skin: Skin,
    folder: Path,
    textures: Textures,
) -> RigSurface | None:
    words.need("mesh", "{")
    shader = ""
    if words.peek() == "shader":
        words.word("shader")
        shader = words.word("shader")
    vertices = _rows(words, "numverts", "vert", 5)
    triangles = _rows(words, "numtris", "tri", 4)
    weights = _rows(words, "numweights", "weight", 6)
    words.need("}")
    if not len(vertices):
        return None
    field = f"mesh {number}"
    corners = _whole(triangles[:, 1:], field)
    if corners.size and (corners.min() < 0 or corners.max() >= len(vertices)):
        raise expected(field, f"vertices below {len(vertices)}", corners.max())
    rows, shares = _influences(vertices, weights, field)
    carriers = _whole(weights[:, 1], field)
    if carriers.min() < 0 or carriers.max() >= len(skin.nodes):
        raise expected(field, f"joints below {len(skin.nodes)}", carriers.max())
    points = world[carriers].apply(weights[:, 3:])
    total = shares.sum(axis=1, keepdims=True)
    placed = np.einsum("vk,vkj->vj", shares / total, points[rows])
    material = _material(shader, folder, textures)
    coordinates = (vertices[:, 1:3].astype(np.float32),)
    if not np.abs(coordinates[0]).max() <= 1e6:
        raise expected(field, "texture coordinates up to 1e6", "farther ones")
    return RigSurface(
        shader or field,
        0,
        placed,
        None,
        corners[:, ::-1],
        colors_at_vertices(material, coordinates, None, len(placed)),
        skin,
        np.where(shares > 0.0, carriers[rows], 0),
        shares,
        material,
        coordinates,
    )


def _material(shader: str, folder: Path, textures: Textures) -> Material:
    """A rough surface with the picture that the shader's name leads to, or plain grey.

    Names come without a suffix where a script of the game says more; that is not read.
    """
    name = shader
    if shader and not Path(shader).suffix:
        found = (f"{shader}{one}" for one in PICTURES)
        name = next((one for one in found if is_there(folder / Path(one).name)), shader)
    texture = None
    if name:
        texture = textures.read(name, lambda: read_bounded(picture_beside(folder, name, "shader")))
    if texture is None:
        return Material(shader[:100], (*to_linear(np.array(PLAIN)).tolist(), 1.0), 0.0)
    picture = TextureMap(texture.pixels, encoded=texture.encoded)
    return Material(shader[:100], metallic=0.0, base_map=picture)


def _influences(
    vertices: FloatArray, weights: FloatArray, field: str
) -> tuple[IntArray, FloatArray]:
    """Rows (V, K) of the weights that each vertex takes, and their shares (V, K)."""
    first, counts = _whole(vertices[:, 3], field), _whole(vertices[:, 4], field)
    if counts.min() < 1 or counts.max() > MOST_INFLUENCES:
        raise expected(field, f"1 to {MOST_INFLUENCES} weights a vertex", counts.max())
    if first.min() < 0 or (first + counts).max() > len(weights):
        raise expected(field, f"weights below {len(weights)}", (first + counts).max())
    slots = np.arange(int(counts.max()))
    rows = np.minimum(first[:, None] + slots, len(weights) - 1)
    shares = np.where(slots < counts[:, None], weights[rows, 2], 0.0)
    if np.any(shares < 0.0) or np.any(shares.sum(axis=1) <= 1e-6):
        raise expected(field, "weights of 0 or more with a sum above 0", "others")
    return rows, shares


def _rows(words: Words, count_name: str, name: str, width: int) -> FloatArray:
    """Numbers (n, width) of `n` rows that open with a name; the first is the row's number."""
    words.need(count_name)
    count = words.integer(count_name, 0, MOST)
    rows = []
    for row in range(count):
        words.need(name)
        values = words.floats(width, f"{name} {row}")
        if values[0] != row:
            raise expected(f"{name} {row}", f"number {row}", values[0])
        rows.append(values)
    return np.stack(rows) if rows else np.zeros((0, width))


def _whole(values: FloatArray, field: str) -> IntArray:
    made = values.astype(np.int64)
    if not np.array_equal(made, values):
        raise expected(field, "whole numbers", "others")
    return made
