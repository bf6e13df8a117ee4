"""Images of characters: formats and depths that Pillow reads otherwise, and cheap bombs."""

import io
import zlib

import numpy as np
import pytest
from PIL import Image

from motorcade.animation import read_character
from motorcade.animation.appearance import TextureMap
from motorcade.animation.character import Character
from motorcade.animation.formats import FormatError, images, write_gltf
from tests.animation.formats.dressed import dressed_gltf, encoded
from tests.animation.formats.samples import Gltf, Write
from tests.fuzz.images import hostile_images, png


def base_map(found: Character) -> TextureMap:
    assert found.appearance is not None
    one = found.appearance.parts[0].material.base_map
    assert one is not None
    return one


def webp(made: Gltf, *, fallback: bool) -> Gltf:
    """Every texture by the extension, with or without another image for those without it."""
    for texture in made.document["textures"]:
        texture["extensions"] = {"EXT_texture_webp": {"source": texture.pop("source")}}
        if fallback:
            texture["source"] = 0
    made.document["extensionsUsed"] = made.document["extensionsRequired"] = ["EXT_texture_webp"]
    return made


@pytest.mark.parametrize("fallback", [False, True])
def test_webp_is_read_and_written_as_png(write: Write, fallback: bool) -> None:
    made = dressed_gltf((encoded("WEBP", color=(10, 200, 30, 255)), encoded("PNG")))
    found = read_character(write("webp.glb", webp(made, fallback=fallback).glb()))
    image = base_map(found)
    np.testing.assert_allclose(image.pixels[0, 0], [10, 200, 30, 255], atol=3)
    again = write("again.glb", b"")
    write_gltf(again, found)
    np.testing.assert_array_equal(base_map(read_character(again)).pixels, image.pixels)


@pytest.mark.parametrize("kind", ["grey", "colour"])
def test_sixteen_bits_keep_their_upper_half(write: Write, kind: str) -> None:
    values = np.arange(0, 65536, 1024, dtype=np.uint16).reshape(8, 8)
    data = io.BytesIO()
    if kind == "grey":
        Image.fromarray(values).save(data, "PNG")
    else:
        import zlib

        rows = [b"\0" + np.repeat(row[:, None], 3, 1).astype(">u2").tobytes() for row in values]
        data.write(png(8, 8, zlib.compress(b"".join(rows)), depth=16))
    found = read_character(write("deep.glb", dressed_gltf((data.getvalue(),)).glb()))
    np.testing.assert_array_equal(base_map(found).pixels[..., 0], values >> 8)
    assert (base_map(found).pixels[..., 3] == 255).all()


def test_tall_and_wide_images_are_converted_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Strips of a few rows, the last one shorter, give what one conversion gives."""
    monkeypatch.setattr(images, "STRIP_PIXELS", 33)
    pixels = np.random.default_rng(3).integers(0, 256, (23, 11, 3), np.uint8)
    data = io.BytesIO()
    Image.fromarray(pixels).save(data, "PNG")
    made = images.decode_texture(data.getvalue(), lambda width, height: 1)
    np.testing.assert_array_equal(made.pixels[..., :3], pixels)


def test_broken_images_cost_what_they_say(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else a thousand of them would each be decoded to their end."""
    monkeypatch.setattr(images, "MAX_IMAGE_PIXELS", 125_000)
    monkeypatch.setattr(images, "MAX_REDUCED_PIXELS", 125_000)
    held = images.Textures()
    broken = png(400, 300)[:-40]
    decoded = [held.read(str(k), lambda: broken) for k in range(8)]
    assert decoded == [None] * 8
    assert [("at most" in one) for one in held.notices] == [False, False, True, True, False]
    assert held.notices[-1] == "and 4 more textures were not read"
    assert held.read("small", lambda: encoded("PNG")) is not None


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "WEBP", "palette", "deep"])
def test_images_beyond_the_limit_are_kept_smaller_by_means(
    monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    """Every second or fourth pixel of stripes would be of one colour."""
    monkeypatch.setattr(images, "MAX_IMAGE_PIXELS", 90_000)
    monkeypatch.setattr(images, "SMALLER_PIXELS", 10_000)
    pixels = np.zeros((303, 290), np.uint8)
    pixels[:, ::2], pixels[200:] = 200, 60
    image, data = Image.fromarray(pixels), io.BytesIO()
    if kind == "deep":
        pixels = pixels.astype(np.uint16) << 8
        rows = [b"\0" + np.repeat(row[:, None], 3, 1).astype(">u2").tobytes() for row in pixels]
        data.write(png(290, 303, zlib.compress(b"".join(rows)), depth=16))
    elif kind == "palette":
        image.convert("P").save(data, "PNG")
    else:
        image.convert("RGB").save(data, kind, quality=95)
    held = images.Textures()
    assert held.read("first", data.getvalue) is not None
    second = held.read("second", data.getvalue)
    assert second is not None
    assert second.pixels.shape == (76, 73, 4)
    assert np.abs(second.pixels[:48, :-1, :3].astype(int) - 100).max() < 8
    assert np.abs(second.pixels[52:, :, :3].astype(int) - 60).max() < 8
    (told,) = held.notices
    assert "kept smaller are 'second' (290 x 303)" in told


def test_how_much_is_decoded_to_be_kept_smaller_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(images, "MAX_IMAGE_PIXELS", 10_000)
    monkeypatch.setattr(images, "MAX_REDUCED_PIXELS", 25_000)
    monkeypatch.setattr(images, "SMALLER_PIXELS", 100)
    held = images.Textures()
    read = [held.read(str(k), lambda: encoded("PNG", (100, 100))) for k in range(5)]
    shapes = [None if one is None else one.pixels.shape for one in read]
    assert shapes == [(100, 100, 4), (7, 7, 4), (7, 7, 4), None, None]
    assert held.read("one too large", lambda: encoded("PNG", (101, 100))) is None


def test_bytes_of_all_images_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(images, "MAX_IMAGE_BYTES", 100)
    held, asked = images.Textures(), []

    def data() -> bytes:
        asked.append(1)
        return bytes(60)

    for k in range(5):
        held.read(str(k), data)
    assert len(asked) == 2
    assert "bytes of images" in held.notices[2]


def test_hostile_images_leave_a_figure_that_is_drawn(write: Write) -> None:
    for number, image in enumerate(hostile_images()):
        found = read_character(write(f"{number}.glb", dressed_gltf((image,)).glb()))
        assert found.appearance is not None
        maps = found.appearance.parts[0].material.maps
        assert bool(maps) != any("was not read" in one for one in found.notices)


@pytest.mark.parametrize("count", [32_768, 32_769])
def test_morph_targets_are_counted(write: Write, count: int) -> None:
    made = dressed_gltf((encoded("PNG"),))
    mesh = made.document["meshes"][0]
    mesh["primitives"][0]["targets"] = [{}] * count
    mesh["weights"] = [0.0] * count
    made.document["animations"] = []
    path = write("many.glb", made.glb())
    if count <= 32_768:
        assert len(read_character(path).morphs) == count
        return
    with pytest.raises(FormatError, match="morph targets: expected at most 32768, got 32769"):
        read_character(path)


def test_weights_of_clips_unpack_to_no_more_than_the_limit(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("motorcade.animation.formats.rig.assemble.MAX_VALUES", 11)
    with pytest.raises(FormatError, match="morph weights of all clips: expected at most 5, got 6"):
        read_character(write("keys.glb", dressed_gltf((encoded("PNG"),)).glb()))
