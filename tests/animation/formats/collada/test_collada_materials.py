"""Materials of Collada, MD5 and FBX files arrive as metallic-roughness has them."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, read_character
from motorcade.animation.appearance import Material, to_linear
from motorcade.animation.formats.collada.controllers import roughness_of
from motorcade.animation.formats.limits import image_beside
from tests.animation.formats.dressed import encoded
from tests.animation.formats.samples import (
    Write,
    collada_with,
    md5_mesh_tower,
    md5_motion_tower,
)

LAMBERT = "<lambert><diffuse>\n<color>0.8 0.2 0.1 1</color></diffuse></lambert>"
SAMPLER = """<newparam sid="surface"><surface type="2D"><init_from>coat</init_from></surface>
</newparam><newparam sid="sampler"><sampler2D><source>surface</source><wrap_s>MIRROR</wrap_s>
<wrap_t>CLAMP</wrap_t><magfilter>NEAREST</magfilter></sampler2D></newparam><technique sid="t">"""
IMAGE = '<library_images><image id="coat"><init_from>{}</init_from></image></library_images>'
UV = """<source id="uv"><float_array id="uva" count="24">{}</float_array><technique_common>
<accessor source="#uva" count="12" stride="2"><param name="S" type="float"/>
<param name="T" type="float"/></accessor></technique_common></source>
<vertices id="v">"""
VERTEX = '<input semantic="VERTEX" source="#v" offset="0"/>'
PLACED = VERTEX + '<input semantic="TEXCOORD" source="#uv" offset="0" set="0"/>'
"""With the polygons, not the vertices: assimp takes coordinates only there."""
COORDINATES = np.linspace(-1.0, 2.0, 24).reshape(12, 2)
PHONG = (
    "<phong>{}<specular><color>1 1 1 1</color></specular>"
    "<shininess><float>{}</float></shininess></phong>"
)
BARE = re.compile(rb'(<(?:float|Name)_array id="(\w+)" count="(\d+)">[^<]*</\w+>)(</source>)')
ACCESSOR = rb"""\1<technique_common><accessor source="#\2" count="\3" stride="1">
<param name="JOINT" type="name"/></accessor></technique_common>\4"""


def shaded(shader: str, *more: tuple[str, str]) -> bytes:
    return collada_with((LAMBERT, shader), *more)


def textured(shader: str, image: str = "coat.png") -> bytes:
    """The tower with coordinates and an image, which the shader calls `sampler`."""
    numbers = " ".join(f"{value:.9g}" for value in COORDINATES.reshape(-1))
    return shaded(
        shader,
        ('<technique sid="t">', SAMPLER),
        ("<library_effects>", IMAGE.format(image) + "<library_effects>"),
        ('<vertices id="v">', UV.format(numbers)),
        (VERTEX, PLACED),
    )


def material_of(found: Character) -> Material:
    assert found.appearance is not None
    (part,) = found.appearance.parts
    return part.material


def read(write: Write, data: bytes) -> Character:
    return read_character(write("tower.dae", data))


def test_phong_becomes_a_dielectric_of_its_colour_and_gloss(write: Write) -> None:
    diffuse = "<diffuse><color>0.8 0.2 0.1 1</color></diffuse>"
    glow = "<emission><color>0.5 0 0 1</color></emission>"
    made = material_of(read(write, shaded(PHONG.format(glow + diffuse, 7.5))))
    np.testing.assert_allclose(made.base_color, [*to_linear(np.array([0.8, 0.2, 0.1])), 1.0])
    np.testing.assert_allclose(made.emission, to_linear(np.array([0.5, 0.0, 0.0])))
    assert (made.metallic, made.alpha_mode, made.double_sided) == (0.0, "opaque", False)
    assert made.roughness == roughness_of(30.0)
    blinn = PHONG.replace("phong", "blinn").format(diffuse, 30.0)
    assert material_of(read(write, shaded(blinn))).roughness == roughness_of(30.0)
    assert material_of(read(write, collada_with())).roughness == 1.0


@pytest.mark.parametrize("exponent", [4.0, 30.0, 200.0])
def test_the_roughness_has_the_height_of_the_highlight(exponent: float) -> None:
    """Both lobes are densities of facets: their cosines sum to 1, and they peak alike."""
    angle = np.linspace(0.0, np.pi / 2.0, 200_001)
    square = roughness_of(exponent) ** 4
    blinn = (exponent + 2.0) / (2.0 * np.pi) * np.cos(angle) ** exponent
    ggx = square / np.pi / (np.cos(angle) ** 2 * (square - 1.0) + 1.0) ** 2
    for lobe in (blinn, ggx):
        whole = np.trapezoid(lobe * np.cos(angle) * 2.0 * np.pi * np.sin(angle), angle)
        np.testing.assert_allclose(whole, 1.0, atol=1e-6)
    np.testing.assert_allclose(ggx[0], blinn[0])


@pytest.mark.parametrize(
    ("given", "alpha"),
    [
        ("<transparent><color>1 1 1 0.25</color></transparent>", 0.25),
        (
            '<transparent opaque="A_ONE"><color>1 1 1 1</color></transparent>'
            "<transparency><float>0.5</float></transparency>",
            0.5,
        ),
        ('<transparent opaque="RGB_ZERO"><color>1 1 1 1</color></transparent>'
         "<transparency><float>0.25</float></transparency>", 0.75),
    ],
)  # fmt: skip
def test_transparency_is_blended(write: Write, given: str, alpha: float) -> None:
    shader = f"<lambert><diffuse><color>1 1 1 1</color></diffuse>{given}</lambert>"
    made = material_of(read(write, shaded(shader)))
    assert made.alpha_mode == "blend"
    assert made.base_color[3] == pytest.approx(alpha, abs=1e-5)


def test_what_would_hide_everything_is_drawn_and_told(write: Write) -> None:
    hidden = "<transparent><color>1 1 1 0</color></transparent>"
    shader = f"<lambert><diffuse><color>1 1 1 1</color></diffuse>{hidden}</lambert>"
    found = read(write, shaded(shader))
    assert material_of(found).alpha_mode == "opaque"
    assert any("which would hide it" in notice for notice in found.notices)


def test_images_come_with_their_samplers_and_coordinates(write: Write) -> None:
    write("coat.png", encoded("PNG", color=(10, 200, 30, 100)))
    both = '<diffuse><texture texture="sampler" texcoord="x"/></diffuse>'
    both += '<transparent><texture texture="sampler" texcoord="x"/></transparent>'
    sides = '<extra><technique profile="GOOGLEEARTH"><double_sided>1</double_sided></technique>'
    data = textured(f"<lambert>{both}</lambert>{sides}</extra>")
    found = read(write, data)
    made = material_of(found)
    assert made.base_map is not None
    assert (made.alpha_mode, made.double_sided) == ("blend", True)
    assert made.base_color == (1.0, 1.0, 1.0, 1.0)
    assert (made.base_map.wrap, made.base_map.magnify) == (("mirror", "clamp"), "nearest")
    np.testing.assert_array_equal(made.base_map.pixels[0, 0], [10, 200, 30, 100])
    assert found.appearance is not None
    placed = {tuple(row) for row in found.appearance.coordinates[0].round(5).tolist()}
    wanted = (COORDINATES * [1, -1] + [0, 1]).astype(np.float32)
    assert placed == {tuple(row) for row in wanted.round(5).tolist()}
    np.testing.assert_allclose(found.colors, np.tile([10, 200, 30], (12, 1)) / 255.0, atol=1e-9)


def test_what_is_not_drawn_is_named_once(write: Write) -> None:
    shader = PHONG.format("<diffuse><color>1 1 1 1</color></diffuse>", 3).replace(
        "<color>1 1 1 1</color></specular>", '<texture texture="sampler"/></specular>'
    )
    data = textured(shader + "<extra><technique><bump/></technique></extra>")
    told = [one for one in read(write, data).notices if "drawn without" in one]
    assert told == ["materials are drawn without bump maps, images of specular light"]


@pytest.mark.parametrize(
    "uri",
    ["coat.png", "./coat.png", "C:\\work\\coat.png", "file:///home/me/coat.png", "a/coat.png"],
)
def test_images_are_found_beside_the_file_wherever_they_were(tmp_path: Path, uri: str) -> None:
    (tmp_path / "coat.png").write_bytes(b"x")
    assert image_beside(tmp_path, uri, "texture").resolve() == (tmp_path / "coat.png").resolve()
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "coat.png").write_bytes(b"y")
    if uri.startswith("a/"):
        assert image_beside(tmp_path, uri, "texture") == tmp_path / "a" / "coat.png"


def test_md5_shows_its_images_with_or_without_their_suffix(write: Write) -> None:
    write("tower.md5anim", md5_motion_tower())
    write("tower.tga", encoded("TGA", color=(10, 200, 30, 255)))
    made = material_of(read_character(write("tower.md5mesh", md5_mesh_tower())))
    assert made.base_map is not None
    np.testing.assert_array_equal(made.base_map.pixels[0, 0], [10, 200, 30, 255])
    assert (made.name, made.metallic, made.roughness) == ("tower", 0.0, 1.0)


@pytest.fixture
def assimp() -> str:
    program = shutil.which("assimp")
    if program is None:
        pytest.skip("assimp is not installed")
    return program


def test_assimp_reads_the_same_colour_and_image(write: Write, assimp: str) -> None:
    """The witness copies numbers as they stand: sRGB."""
    write("coat.png", encoded("PNG"))
    plain = shaded(PHONG.format("<diffuse><color>0.8 0.2 0.1 1</color></diffuse>", 30))
    shown = textured('<lambert><diffuse><texture texture="sampler"/></diffuse></lambert>')
    for data in (plain, shown):
        path = write("tower.dae", BARE.sub(ACCESSOR, data))
        made = material_of(read_character(path))
        other = path.with_name("other.gltf")
        subprocess.run([assimp, "export", path, other], check=True, capture_output=True)
        document = json.loads(other.read_text())
        (theirs,) = document["materials"]
        base = theirs["pbrMetallicRoughness"]
        if data is plain:
            wanted = to_linear(np.array(base["baseColorFactor"][:3]))
            np.testing.assert_allclose(made.base_color[:3], wanted, atol=1e-6)
        else:
            texture = document["textures"][base["baseColorTexture"]["index"]]
            assert document["images"][texture["source"]]["uri"] == "coat.png"
            assert made.base_map is not None


def test_fbx_finds_its_images_beside_it_and_its_colours_are_srgb(
    write: Write, assimp: str, tmp_path: Path
) -> None:
    write("coat.png", encoded("PNG", color=(10, 200, 30, 255)))
    shown = textured('<lambert><diffuse><texture texture="sampler"/></diffuse></lambert>')
    plain = collada_with()
    for data in (plain, shown):
        given, path = write("tower.dae", BARE.sub(ACCESSOR, data)), tmp_path / "tower.fbx"
        subprocess.run([assimp, "export", given, path, "-ffbxa"], check=True, capture_output=True)
        made = material_of(read_character(path))
        if data is plain:
            wanted = to_linear(np.array([0.8, 0.2, 0.1]))
            np.testing.assert_allclose(made.base_color[:3], wanted, atol=1e-5)
        else:
            assert made.base_map is not None
            np.testing.assert_array_equal(made.base_map.pixels[0, 0], [10, 200, 30, 255])
