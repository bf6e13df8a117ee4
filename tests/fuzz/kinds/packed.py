"""Characters in compressed files, whose compressed bytes are not as they should be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.animation.formats.packed import DRACO, draco_tower
from tests.animation.formats.samples import Gltf
from tests.fuzz.kinds.rigs import outcome
from tests.fuzz.mutations import changed_tree, mutated, one_of
from tests.fuzz.runner import Feed, SkippedError


def prepare(folder: Path) -> Feed:
    """Compressed towers with faults in their bytes, in what describes them, or in both."""
    try:
        makers: list[Callable[[], Gltf]] = [draco_tower, lambda: draco_tower(edgebreaker=False)]
        makers[0]()
    except ModuleNotFoundError as missing:
        raise SkippedError(str(missing)) from missing

    def feed(rng: np.random.Generator) -> str:
        made, path = one_of(makers, rng)(), folder / "given.glb"
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
    parts = made.document["meshes"][0]["primitives"]
    return [part["extensions"][DRACO]["bufferView"] for part in parts]
