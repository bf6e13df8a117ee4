"""Characters with images, samplers, morph targets and scenes that are not as they should be.

What is read must be a valid character, and must be written and read again as the same one.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.formats import FormatError, read_character, write_gltf
from tests.animation.formats.dressed import dressed_gltf, encoded
from tests.animation.formats.samples import Gltf
from tests.fuzz.images import broken, hostile_images
from tests.fuzz.kinds.rigs import outcome
from tests.fuzz.mutations import changed_tree, mutated, one_of
from tests.fuzz.runner import Feed

WILD = (-1, 0, 1, 2, 5, 12, 13, 40, 255, 65_535, 2**31, 2**40, 1.5, "0", None, [0], True)
WRITTEN_SHARE = 0.25
LARGE_SHARE = 0.2
"""Of hostile images: how often those are among them that take a second."""
SMALL_BYTES = 5000


def prepare(folder: Path) -> Feed:
    """Dressed towers, attacked in one of several ways, read, written and read again."""
    honest = tuple(encoded(kind) for kind in ("PNG", "JPEG", "WEBP"))
    hostile = hostile_images()

    def feed(rng: np.random.Generator) -> str:
        path = folder / "given.glb"
        path.write_bytes(_attacked(honest, hostile, rng))
        ended = outcome(path)
        if ended == "character" and rng.random() < WRITTEN_SHARE:
            _written(path, folder / "again.glb")
        return ended

    return feed


def _attacked(honest: tuple[bytes, ...], hostile: list[bytes], rng: np.random.Generator) -> bytes:
    kind, small = rng.random(), [one for one in hostile if len(one) < SMALL_BYTES]
    if kind < 0.15:
        count = int(rng.integers(1, 4))
        some = hostile if rng.random() < LARGE_SHARE else small
        return dressed_gltf(tuple(one_of(some, rng) for _ in range(count))).glb()
    if kind < 0.3:
        return dressed_gltf((broken(one_of(honest, rng), rng), one_of(honest, rng))).glb()
    made = dressed_gltf(honest)
    if kind < 0.75:
        for _ in range(int(rng.integers(1, 3))):
            one_of(ATTACKS, rng)(made, rng)
    elif kind < 0.9:
        changed_tree(made.document, rng)
    else:
        return mutated(".glb", made.glb(), rng)
    return made.glb()


def _written(path: Path, again: Path) -> None:
    """What was read once can be written and read again."""
    first = read_character(path)
    try:
        write_gltf(again, first)
        second = read_character(again)
    except FormatError as fault:
        raise AssertionError(f"what was written is refused: {fault}") from fault
    if len(first.triangles) != len(second.triangles):
        raise AssertionError(f"{len(first.triangles)} triangles, then {len(second.triangles)}")
    if len(first.clips) != len(second.clips) or len(first.morphs) != len(second.morphs):
        raise AssertionError("clips or morph targets were lost in writing")


def _wild_link(made: Gltf, rng: np.random.Generator) -> None:
    """A number that points at something points elsewhere."""
    document = made.document
    texture = one_of(document["textures"], rng)
    part = one_of(one_of(document["meshes"], rng)["primitives"], rng)
    places: list[tuple[dict[str, Any], str]] = [
        (texture, "sampler"),
        (texture, "source"),
        (document["materials"][0]["normalTexture"], "index"),
        (document["materials"][0]["occlusionTexture"], "texCoord"),
        (one_of(document["images"], rng), "bufferView"),
        (part, "material"),
        (part, "mode"),
        (part["attributes"], one_of(sorted(part["attributes"]), rng)),
        (document["nodes"][4], one_of(["mesh", "skin"], rng)),
        (document, "scene"),
    ]
    holder, key = one_of(places, rng)
    holder[key] = one_of(WILD, rng)


def _samplers(made: Gltf, rng: np.random.Generator) -> None:
    """Filters and wrapping that no format knows."""
    key = one_of(["wrapS", "wrapT", "magFilter", "minFilter"], rng)
    one_of(made.document["samplers"], rng)[key] = one_of([*WILD, 9984, 9986, 10497], rng)


def _coordinates(made: Gltf, rng: np.random.Generator) -> None:
    """Sets of coordinates that are missing, of another length, or far away."""
    attributes = made.document["meshes"][0]["primitives"][0]["attributes"]
    which = one_of(["TEXCOORD_0", "TEXCOORD_1", "COLOR_0", "TANGENT", "NORMAL"], rng)
    count = int(one_of([1, 11, 12, 13], rng))
    width = int(one_of([2, 3, 4], rng))
    far = one_of([0.0, 1e5, 1e7, 1e38, np.nan, -np.inf], rng)
    if rng.random() < 0.4:
        attributes.pop(which, None)
    else:
        attributes[which] = made.add(np.full((count, width), far))


def _morphs(made: Gltf, rng: np.random.Generator) -> None:
    """Targets, weights, names and keys of other counts."""
    mesh, kind = made.document["meshes"][0], rng.random()
    count = int(one_of([0, 1, 2, 3, 200, 5000], rng))
    if kind < 0.3:
        mesh["weights"] = [one_of([0.0, 1.0, -3.0, 1e8, 1e300], rng)] * count
    elif kind < 0.6:
        part = mesh["primitives"][0]
        part["targets"] = [one_of([*part["targets"], {}], rng)] * count
        if rng.random() < 0.7:
            mesh["weights"] = [0.5] * count
    elif kind < 0.8:
        mesh["extras"]["targetNames"] = one_of([["up"], [1, None], "up", {}, ["x"] * 500], rng)
    else:
        sampler = made.document["animations"][1]["samplers"][0]
        sampler["output"] = made.add(rng.uniform(-1.0, 2.0, count + 1))
        sampler["interpolation"] = one_of(["LINEAR", "STEP", "CUBICSPLINE", "WILD"], rng)


def _hierarchy(made: Gltf, rng: np.random.Generator) -> None:
    """Circles, two parents, and chains below and beyond the limit of depth."""
    nodes, kind = made.document["nodes"], rng.random()
    if kind < 0.4:
        one_of(nodes, rng)["children"] = rng.integers(0, len(nodes), 2).tolist()
    elif kind < 0.7:
        start, count = len(nodes), int(one_of([100, 505, 511, 513, 4000], rng))
        nodes += [{"children": [start + k + 1]} for k in range(count)] + [{"mesh": 1}]
        made.document["scenes"][0]["nodes"].append(start)
    else:
        nodes[3]["skin"] = one_of([0, 1, -1], rng)
        made.document["skins"][0]["joints"] = rng.integers(0, len(nodes), 2).tolist()


def _many(made: Gltf, rng: np.random.Generator) -> None:
    """Thousands of images, materials and meshes that share what they are made of."""
    document, count = made.document, int(rng.choice([20, 100, 1500], p=[0.6, 0.35, 0.05]))
    kind = rng.random()
    if kind < 0.5:
        document["images"] *= count
        document["textures"] = [{"source": number} for number in range(len(document["images"]))]
        coat = document["materials"][0]
        document["materials"] = [
            coat | {"emissiveTexture": {"index": number}} for number in range(count)
        ]
        part = document["meshes"][0]["primitives"][0]
        part["targets"] = part.get("targets", [])[:2]  # of thousands, the file would be too large
        document["meshes"][0]["primitives"] = [part | {"material": k} for k in range(count)]
    else:
        start = len(document["nodes"])
        document["nodes"] += [{"mesh": 1, "name": f"{k}"} for k in range(count)]
        document["scenes"][0]["nodes"] += list(range(start, start + count))


def _sparse(made: Gltf, rng: np.random.Generator) -> None:
    """Sparse values of wild counts and rows."""
    accessor = one_of(made.document["accessors"], rng)
    count = int(one_of([0, 1, 2, 3, 5000], rng))
    rows = made.view(rng.integers(0, one_of([3, 12, 60_000], rng), max(count, 1)).astype(np.uint16))
    accessor["sparse"] = {
        "count": one_of([count, *WILD], rng),
        "indices": {"bufferView": rows, "componentType": one_of([5123, 5121, 5122, 5126], rng)},
        "values": {"bufferView": int(rng.integers(len(made.document["bufferViews"])))},
    }
    if rng.random() < 0.3:
        accessor.pop("bufferView", None)
        accessor["count"] = one_of([12, 2**22, 2**25, 2**40], rng)


ATTACKS: list[Callable[[Gltf, np.random.Generator], None]] = [
    *[_wild_link] * 4,
    *[_samplers, _coordinates, _morphs, _sparse] * 2,
    _hierarchy,
    _many,
]
