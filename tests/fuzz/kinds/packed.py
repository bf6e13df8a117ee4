"""Characters in compressed files, whose compressed bytes are not as they should be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.animation.formats.packed import (
    DRACO,
    MESHOPT,
    add_stream,
    draco_tower,
    meshopt_streams,
    meshopt_tower,
)
from tests.animation.formats.samples import Gltf
from tests.fuzz.kinds.rigs import outcome
from tests.fuzz.mutations import changed_tree, mutated, one_of
from tests.fuzz.runner import Feed, SkippedError

DRACO_SHARE = 0.1
"""Of the inputs: each takes a process, and so as long as fifty of the others."""


def prepare(folder: Path) -> Feed:
    """Compressed towers with faults in their bytes, in what describes them, or in both."""
    makers: list[Callable[[], Gltf]] = [draco_tower, lambda: draco_tower(edgebreaker=False)]
    try:
        makers[0]()
    except ModuleNotFoundError as missing:
        raise SkippedError(str(missing)) from missing
    streams = meshopt_streams()

    def feed(rng: np.random.Generator) -> str:
        maker = one_of(makers, rng) if rng.random() < DRACO_SHARE else meshopt_tower
        made, path = maker(), folder / "given.glb"
        if maker is meshopt_tower:
            for _ in range(int(rng.integers(3))):
                add_stream(made, one_of(streams, rng))
        kind = rng.random()
        if kind < 0.8:
            _damaged(made, rng)
        if kind > 0.7:
            changed_tree(made.document, rng)
        data = made.glb()
        path.write_bytes(mutated(".glb", data, rng) if rng.random() < 0.1 else data)
        return outcome(path)

    return feed


def _damaged(made: Gltf, rng: np.random.Generator) -> None:
    """One to four bytes of a compressed view change, or its length does."""
    view = made.document["bufferViews"][one_of(_packed(made), rng)]
    view = view.get("extensions", {}).get(MESHOPT, view)
    start, size = view["byteOffset"], view["byteLength"]
    for _ in range(int(rng.integers(1, 5))):
        near = 1.0 if rng.random() < 0.5 else rng.random()  # what comes first decides most
        at = start + min(int(rng.exponential(0.3 * near * size)), size - 1)
        made.data[at] = int(
            one_of([0, 1, 127, 128, 255, made.data[at] ^ 1, rng.integers(256)], rng)
        )
    if rng.random() < 0.1:
        view["byteLength"] = int(rng.integers(1, size + 1))


def _packed(made: Gltf) -> list[int]:
    """Numbers of the views that are compressed."""
    (part,) = made.document["meshes"][0]["primitives"]
    if DRACO in part.get("extensions", {}):
        return [part["extensions"][DRACO]["bufferView"]]
    views = made.document["bufferViews"]
    return [number for number, one in enumerate(views) if MESHOPT in one.get("extensions", {})]
