"""The scoreboard of glTF models beside three.js: none lies farther off, nearly all lie near."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from motorcade.animation import read_character, write_gltf
from tests.end_to_end import looks

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("opengl")]

FOLDER = looks.looks_folder()
OFF = {"NormalTangentTest_0"}
"""Thirty upright squares whose edges lie a quarter of a pixel from where the reference's grid of
two by two samples puts them: overlap 0.986."""

if not FOLDER.exists():
    pytest.skip("no reference images here", allow_module_level=True)


def test_images_lie_as_near_as_they_did_and_nearly_all_near() -> None:
    assert looks.main([]) == 0
    kept = json.loads(looks.KEPT.read_text(encoding="utf-8"))
    assert {name for name, row in kept.items() if not looks.passes(row)} == OFF
    assert len(kept) == 36


@pytest.mark.parametrize("name", ["Fox", "MorphStressTest", "Boxes", "MirroredDuck"])
def test_a_written_file_looks_like_the_one_that_was_read(name: str, tmp_path: Path) -> None:
    for one in looks.entries(FOLDER, [name]):
        read = read_character(FOLDER / one["model"])
        write_gltf(tmp_path / "again.glb", read)
        again = read_character(tmp_path / "again.glb")
        # Both stand alike in character space, where the camera is told by the first file.
        layer = looks.drawn(replace(again, character_T_file=read.character_T_file), one)
        image = looks.over_grey(layer, one["background_srgb8"][0])
        row = looks.scores(image, layer.rgba[..., 3] >= looks.HALF, FOLDER, one["name"])
        assert looks.passes(row), one["name"]
