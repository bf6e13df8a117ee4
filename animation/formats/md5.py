"""MD5, the format of Doom 3 and its kin, version 10: `.md5mesh`, and motions in `.md5anim`.

A mesh has joints in world poses, and vertices as weighted points in the joints' frames. A motion
has a base pose, and of every frame the numbers that differ from it. Figures have z up; the unit is
not stated. Faces run clockwise seen from outside. Source: id Software's file layout, as described
by David Henry, MD5Mesh and MD5Anim (2005).
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from motorcade.animation.appearance import Material, TextureMap, to_linear
from motorcade.animation.formats.images import Textures, colors_at_vertices
from motorcade.animation.formats.limits import (
    MAX_NODES,
    MAX_POSES,
    MAX_TEXT_BYTES,
    FormatError,
    expected,
    image_beside,
    read_bounded,
    shown,
)
from motorcade.animation.formats.rig.values import (
    NodeTree,
    Rig,
    RigClip,
    RigSurface,
    Skin,
    Transforms,
)
from motorcade.animation.skeleton import local_poses
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import is_there

__all__ = ["read_md5_mesh", "read_md5_motion"]


WORD = re.compile(r'//[^\n]*|"([^"\n]*)"|([(){}])|([^\s(){}"]+)')


class Words:
    """Reads an MD5 file word by word; brackets around numbers are passed over."""

    def __init__(self, data: bytes) -> None:
        text = data.decode("utf-8", "replace")
        self._words = [match[0] for match in WORD.finditer(text) if not match[0].startswith("//")]
        self._at = 0

    @property
    def done(self) -> bool:
        """Whether nothing is left."""
        return self._at >= len(self._words)

    def peek(self) -> str:
        """The next word; empty at the end."""
        return "" if self.done else self._words[self._at]

    def word(self, field: str) -> str:
        """The next word, without quotes. Raises FormatError: the file ends."""
        if self.done:
            raise expected(field, "a word", "the end of the file")
        self._at += 1
        return self._words[self._at - 1].strip('"')

    def need(self, *wanted: str) -> None:
        """Pass over these words. Raises FormatError: others stand there."""
        for wanted_word in wanted:
            got = self.word(wanted_word)
            if got != wanted_word:
                raise expected("file", f"'{wanted_word}'", got)

    def integer(self, field: str, low: int, high: int) -> int:
        """A whole number in a range. Raises FormatError: anything else."""
        word = self.word(field)
        if not re.fullmatch(r"-?\d{1,9}", word, re.ASCII) or not low <= int(word) <= high:
            raise expected(field, f"a whole number from {low} to {high}", word)
        return int(word)

    def floats(self, count: int, field: str) -> FloatArray:
        """The next `count` numbers, whatever brackets stand between them.

        Raises FormatError: other words, the end of the file, NaN or infinity.
        """
        number_words: list[str] = []
        while len(number_words) < count and not self.done:
            word = self._words[self._at]
            self._at += 1
            if word not in "()":
                number_words.append(word)
        if self.peek() == ")":
            self._at += 1
        try:
            values = np.array(number_words, dtype=np.float64) if number_words else np.zeros(0)
        except ValueError as fault:
            raise FormatError(f"{field}: expected numbers, {shown(fault)}") from fault
        if len(values) != count:
            raise expected(field, f"{count} numbers", len(values))
        if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > 1e9:
            raise expected(field, "finite numbers up to 1e9", "others")
        return values


def opened(path: Path) -> Words:
    """The words of an MD5 file after its version and command line.

    Raises FormatError: a file that is too large, or of another version.
    """
    words = Words(read_bounded(path, MAX_TEXT_BYTES))
    words.need("MD5Version")
    words.integer("MD5Version", 10, 10)
    if words.peek() == "commandline":
        words.word("commandline")
        words.word("commandline")
    return words


MOST = 1 << 21
MOST_INFLUENCES = 64
PLAIN = (0.8, 0.8, 0.8)
IMAGES = (".tga", ".png", ".jpg")


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
    """A rough surface with the image that the shader's name leads to, or plain grey.

    Names come without a suffix where a script of the game says more; that is not read.
    """
    name = shader
    if shader and not Path(shader).suffix:
        names = (f"{shader}{one}" for one in IMAGES)
        name = next((one for one in names if is_there(folder / Path(one).name)), shader)
    texture = None
    if name:
        texture = textures.read(name, lambda: read_bounded(image_beside(folder, name, "shader")))
    if texture is None:
        return Material(shader[:100], (*to_linear(np.array(PLAIN)).tolist(), 1.0), 0.0)
    image = TextureMap(texture.pixels, encoded=texture.encoded)
    return Material(shader[:100], metallic=0.0, base_map=image)


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
    numbers = values.astype(np.int64)
    if not np.array_equal(numbers, values):
        raise expected(field, "whole numbers", "others")
    return numbers


def orientation(xyz: FloatArray) -> FloatArray:
    """Unit quaternions wxyz (*, 4) from their last three parts (*, 3); the first is not positive.

    Raises:
        FormatError: parts longer than 1.
    """
    rest = 1.0 - np.sum(xyz * xyz, axis=-1, keepdims=True)
    if np.any(rest < -0.01):
        raise expected("orientation", "parts of a unit quaternion", "longer ones")
    wxyz = np.concatenate([-np.sqrt(np.maximum(rest, 0.0)), xyz], axis=-1)
    unit: FloatArray = wxyz / np.linalg.norm(wxyz, axis=-1, keepdims=True)
    return unit


def read_md5_motion(path: Path) -> Rig:
    """Read a `.md5anim` alone; the rest pose is its base frame.

    Raises:
        FormatError: a file that is not consistent.
    """
    names, parents, base, clip = _motion(path)
    tree = NodeTree(names, parents, base)
    return Rig(
        tree,
        tuple(range(len(names))),
        (),
        (clip,),
        up=(0.0, 0.0, 1.0),
        forward=None,
        unit_m=None,
    )


def read_clip(path: Path, names: tuple[str, ...], parents: IntArray) -> RigClip:
    """The clip of a `.md5anim` for these joints.

    Raises:
        FormatError: other joints, or a file that is not consistent.
    """
    try:
        own, above, _, clip = _motion(path)
    except FormatError as fault:
        raise FormatError(f"{path.name}: {fault}") from fault
    if own != names or not np.array_equal(above, parents):
        raise expected(path.name, "the joints of the mesh beside it", f"{len(own)} others")
    return clip


def _motion(path: Path) -> tuple[tuple[str, ...], IntArray, Transforms, RigClip]:
    words = opened(path)
    words.need("numFrames")
    frames = words.integer("numFrames", 1, MAX_POSES)
    words.need("numJoints")
    joints = words.integer("numJoints", 1, MAX_NODES)
    words.need("frameRate")
    rate = words.integer("frameRate", 1, 10_000)
    words.need("numAnimatedComponents")
    width = words.integer("numAnimatedComponents", 0, 6 * joints)
    if frames * joints > MAX_POSES:
        raise expected("numFrames", f"at most {MAX_POSES} poses", frames * joints)
    names, parents, flags, starts = _hierarchy(words, joints, width)
    words.need("bounds", "{")
    while words.word("a closing brace") != "}":
        pass
    words.need("baseframe", "{")
    base = words.floats(6 * joints, "baseframe").reshape(joints, 6)
    words.need("}")
    values = np.repeat(base[None], frames, axis=0)
    for frame in range(frames):
        words.need("frame")
        words.integer("frame", frame, frame)
        words.need("{")
        row = words.floats(width, f"frame {frame}")
        words.need("}")
        for part in range(6):
            animated = np.flatnonzero(flags & (1 << part))
            before = np.array(
                [bin(int(flags[joint]) & ((1 << part) - 1)).count("1") for joint in animated],
                dtype=np.int64,
            )
            values[frame, animated, part] = row[starts[animated] + before]
    rest = Transforms(orientation(base[:, 3:]), base[:, :3], np.ones(joints))
    return names, parents, rest, _clip(path.stem[:200], values, rate)


def _hierarchy(
    words: Words, joints: int, width: int
) -> tuple[tuple[str, ...], IntArray, IntArray, IntArray]:
    """Names, parents, which of six numbers are animated as bits, and where these start."""
    words.need("hierarchy", "{")
    names, parents, flags, starts = [], [], [], []
    for joint in range(joints):
        names.append(words.word("joint name")[:200])
        parents.append(words.integer(f"parent of '{names[-1]}'", -1, joint - 1))
        flags.append(words.integer(f"flags of '{names[-1]}'", 0, 63))
        count = bin(flags[-1]).count("1")
        starts.append(words.integer(f"start of '{names[-1]}'", 0, max(width, 0)))
        if count and starts[-1] + count > width:
            raise expected(f"start of '{names[-1]}'", f"at most {width - count}", starts[-1])
    words.need("}")
    return tuple(names), np.array(parents), np.array(flags), np.array(starts)


def _clip(name: str, values: FloatArray, rate: int) -> RigClip:
    """A clip over frames (F, J, 6) of positions and orientations."""
    keys = np.arange(len(values)) / rate
    return RigClip.of_all_nodes(name, keys, orientation(values[..., 3:]), values[..., :3])
