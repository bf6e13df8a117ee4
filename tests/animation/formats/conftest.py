"""Small files in a folder of their own, and the real rigs where they lie."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.animation.formats import samples
from tests.animation.formats.samples import Write


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes bytes to a file of that name; returns its path."""

    def written(name: str, data: bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(data)
        return path

    return written


@pytest.fixture
def towers(write: Write) -> dict[str, Path]:
    """The same tower in every format that holds meshes."""
    write("tower.md5anim", samples.md5_motion_tower())
    return {
        "glb": write("tower.glb", samples.gltf_tower().glb()),
        "gltf": write("tower.gltf", samples.gltf_tower().gltf()),
        "dae": write("tower.dae", samples.collada_tower()),
        "md5mesh": write("tower.md5mesh", samples.md5_mesh_tower()),
    }


@pytest.fixture(scope="session")
def rigs(data_dir: Path) -> Path:
    """Folder of the real rigs."""
    folder = data_dir / "rigs"
    if not folder.is_dir():
        pytest.skip("no rigs here")
    return folder
