"""What Collada allows besides quads and one channel: other polygons, images, hanging meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from motorcade.animation import Character
from motorcade.animation.formats import FormatError, read_character, read_motion
from motorcade.ga import Similarity
from tests.animation.formats import samples
from tests.animation.formats.samples import Write, collada_polygons, collada_with


def quads() -> list[list[str]]:
    """Corners of the tower's polygons."""
    words = collada_polygons().split("<p>")[1].split("</p>")[0].split()
    return [words[i : i + 4] for i in range(0, len(words), 4)]


INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'


def volume(character: Character) -> float:
    a, b, c = (character.vertices[character.triangles[:, corner]] for corner in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


@pytest.mark.parametrize("kind", ["polygons", "triangles", "trifans", "tristrips"])
def test_polygons_and_triangles_make_the_same_surface(write: Write, kind: str) -> None:
    plain = read_character(write("plain.dae", collada_with()))
    if kind == "tristrips":
        inside = "".join(f"<p>{a} {b} {d} {c}</p>" for a, b, c, d in quads())
    elif kind != "triangles":
        inside = "".join(f"<p>{' '.join(quad)}</p>" for quad in quads())
    else:
        corners = [word for a, b, c, d in quads() for word in (a, b, c, a, c, d)]
        inside = f"<p>{' '.join(corners)}</p>"
    other = f'<{kind} material="s" count="10">{INPUT}{inside}</{kind}>'
    found = read_character(write("other.dae", collada_with((collada_polygons(), other))))
    np.testing.assert_allclose(found.vertices, plain.vertices, atol=1e-12)
    assert volume(found) == pytest.approx(volume(plain), rel=1e-9)
    np.testing.assert_allclose(found.colors, plain.colors)


@pytest.mark.parametrize("name", ["linestrips", "lines"])
def test_elements_of_other_kinds_and_empty_ones_are_left_out(write: Write, name: str) -> None:
    """Beside polygons that are read; those without a corner make no part."""
    more = f"{collada_polygons()}<{name} count='0'/><triangles count='0'>{INPUT}<p/></triangles>"
    found = read_character(write("more.dae", collada_with((collada_polygons(), more))))
    assert len(found.vertices) == 12
    assert f"<{name}> of 'tower' is left out" in found.notices


def test_a_skin_without_a_bind_shape_is_bound_as_it_stands(write: Write) -> None:
    shape = "<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>"
    plain = read_character(write("plain.dae", collada_with()))
    bare = read_character(write("bare.dae", collada_with((shape, ""))))
    np.testing.assert_array_equal(bare.vertices, plain.vertices)
    large = shape.replace("1 0 0 0 0 1 0 0 0 0 1 0", "2 0 0 0 0 2 0 0 0 0 2 0")
    grown = read_character(write("grown.dae", collada_with((shape, large))))
    np.testing.assert_allclose(grown.vertices, 2.0 * plain.vertices, atol=1e-9)


def test_colours_of_vertices_count_before_materials(write: Write) -> None:
    source = (
        '<source id="c"><float_array id="ca" count="36">'
        + "0.25 0.5 2 " * 12
        + '</float_array><technique_common><accessor source="#ca" count="12" stride="3"/>'
        "</technique_common></source><vertices"
    )
    colored = '<input semantic="POSITION" source="#p"/><input semantic="COLOR" source="#c"/>'
    found = read_character(
        write(
            "c.dae",
            collada_with(
                ("<vertices", source), ('<input semantic="POSITION" source="#p"/>', colored)
            ),
        )
    )
    np.testing.assert_allclose(found.colors, np.tile([0.25, 0.5, 1.0], (12, 1)))


TEXTURE = """<newparam sid="surface"><surface type="2D"><init_from>image</init_from></surface>
</newparam><newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>
<technique"""


def _textured(image: str, named: str = "sampler") -> bytes:
    """The tower painted by an image; its right half is green, its upper left corner red."""
    uv = (
        '<source id="t2"><float_array id="ta" count="24">' + "0.75 0.25 " * 11 + "0.25 0.75"
        '</float_array><technique_common><accessor source="#ta" count="12" stride="2"/>'
        "</technique_common></source><vertices"
    )
    return collada_with(
        ("<vertices", uv),
        (
            '<input semantic="POSITION" source="#p"/>',
            '<input semantic="POSITION" source="#p"/><input semantic="TEXCOORD" source="#t2"/>',
        ),
        ("<technique", TEXTURE),
        ("<color>0.8 0.2 0.1 1</color>", f'<texture texture="{named}" texcoord="x"/>'),
        (
            "<library_effects>",
            f'<library_images><image id="image"><init_from>{image}</init_from>'
            "</image></library_images><library_effects>",
        ),
    )


@pytest.mark.parametrize("named", ["sampler", "image"])
def test_textures_are_sampled_with_v_upwards(write: Write, tmp_path: Path, named: str) -> None:
    """By a sampler and its surface, or straight by the image's id."""
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[:, 1], pixels[0, 0] = (0, 255, 0), (255, 0, 0)
    Image.fromarray(pixels).save(tmp_path / "skin.png")
    found = read_character(write("painted.dae", _textured("skin.png", named)))
    np.testing.assert_allclose(found.colors[0], [0.0, 1.0, 0.0])
    np.testing.assert_allclose(found.colors[-1], [1.0, 0.0, 0.0])
    assert not any("was not read" in notice for notice in found.notices)


@pytest.mark.parametrize(
    ("image", "named", "told"),
    [("lost.png", "sampler", "'lost.png' was not read"), ("lost.png", "nowhere", "")],
)
def test_images_that_cannot_be_had_leave_a_plain_grey(
    write: Write, image: str, named: str, told: str
) -> None:
    found = read_character(write("grey.dae", _textured(image, named)))
    np.testing.assert_allclose(found.colors, 0.8)
    notices = [notice for notice in found.notices if "texture" in notice]
    assert len(notices) == (1 if told else 0)
    assert all(told in notice for notice in notices)


def test_a_mesh_that_hangs_on_a_joint_follows_it(write: Write) -> None:
    """Beside the skinned one, which shares its polygons."""
    data = collada_with(
        (
            '<rotate sid="turn">0 0 1 0</rotate>',
            '<rotate sid="turn">0 0 1 0</rotate><instance_geometry url="#tower"/>',
        )
    )
    found = read_character(write("hat.dae", data))
    assert len(found.vertices) == 24
    hat, tower = found.vertices[:12], found.vertices[12:]
    assert np.all(found.joints[:12, 0] == found.skeleton.index("top"))
    np.testing.assert_allclose(hat - [0.0, 0.0, 0.5], tower, atol=1e-9)


@pytest.mark.parametrize("kind", ["geometry", "controller"])
def test_splines_and_morphs_are_left_out_and_told(write: Write, kind: str) -> None:
    more = {
        "geometry": (
            "<library_geometries>",
            '<library_geometries><geometry id="line"><spline/></geometry>',
            '<node id="mesh"><instance_geometry url="#line"/>',
            "'line' is no mesh: left out",
        ),
        "controller": (
            "<library_controllers>",
            '<library_controllers><controller id="face"><morph/></controller>',
            '<node id="mesh"><instance_controller url="#face"/>',
            "'face' morphs a mesh: left out",
        ),
    }[kind]
    data = collada_with((more[0], more[1]), ('<node id="mesh">', more[2]))
    found = read_character(write("more.dae", data))
    assert len(found.vertices) == 12
    assert more[3] in found.notices


def _moving(sid: str, target: str, values: str, count: int) -> bytes:
    """The tower with an element of a sid in its top, moved by a channel to two values."""
    return collada_with(
        ('<rotate sid="turn">0 0 1 0</rotate>', f'<rotate sid="turn">0 0 1 0</rotate>{sid}'),
        ('count="2">0 90<', f'count="{count}">{values}<'),
        ('<sampler id="s">', '<technique_common/><sampler id="s">'),
        ('target="top/turn.ANGLE"', f'target="top/{target}"'),
        ('id="oa"', 'id="oa" '),
        (
            '</float_array></source>\n<source id="k">',
            "</float_array><technique_common>"
            f'<accessor source="#oa" count="2" stride="{count // 2}"/>'
            '</technique_common></source>\n<source id="k">',
        ),
    )


@pytest.mark.parametrize(
    ("sid", "target", "values", "count"),
    [
        ('<translate sid="at2">0 0 0</translate>', "at2", "0 0 0 0 0 2", 6),
        ('<translate sid="at2">0 0 0</translate>', "at2.Z", "0 2", 2),
        ('<translate sid="at2">0 0 0</translate>', "at2(2)", "0 2", 2),
        ('<matrix sid="m">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>', "m(3)(2)", "0 2", 2),
        (
            '<matrix sid="m">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>',
            "m",
            "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 1 0 0 0 0 1 0 0 0 0 1 2 0 0 0 1",
            32,
        ),
    ],
)
def test_channels_move_all_or_one_number_of_a_transform(
    write: Write, sid: str, target: str, values: str, count: int
) -> None:
    """Named by member, by index, by column and row, or not at all: each lifts the top by 2."""
    motion = read_motion(write("moving.dae", _moving(sid, target, values, count)))
    world = motion.skeleton.world(motion.clips[0].at([0.0, 0.5, 1.0]))
    np.testing.assert_allclose(world.translation_m[:, 1, 2], [0.5, 1.0, 1.5], atol=1e-9)


def test_channels_of_scale_make_similarities(write: Write) -> None:
    data = _moving('<scale sid="size">1 1 1</scale>', "size", "1 1 1 3 3 3", 6)
    motion = read_motion(write("growing.dae", data))
    world = motion.skeleton.world(motion.clips[0].at([0.0, 0.5, 1.0]))
    assert isinstance(world, Similarity)
    np.testing.assert_allclose(world.scale[:, 1], [1.0, 2.0, 3.0], rtol=1e-4)


def test_channels_of_uneven_scale_are_told(write: Write) -> None:
    data = _moving('<scale sid="size">1 1 1</scale>', "size", "1 1 1 1 1 3", 6)
    motion = read_motion(write("uneven.dae", data))
    assert len(motion.clips) == 1
    world = motion.skeleton.world(motion.clips[0].at(1.0))
    assert isinstance(world, Similarity)
    assert world.scale[1] == pytest.approx(5.0 / 3.0, rel=1e-4)  # the mean of the axes


@pytest.mark.parametrize(
    "target", ["turn", "turn.W", "turn(9)", "at2(1)(1)", "m.X", "m(1)", "m(4)(4)", "nothing", ""]
)
def test_channels_that_move_no_number_are_left_out_and_told(write: Write, target: str) -> None:
    """All but a whole rotation, of four numbers."""
    sid = (
        '<translate sid="at2">0 0 0</translate>'
        '<matrix sid="m">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>'
    )
    if target == "turn":
        data = _moving(sid, target, "0 0 1 0 0 0 1 90", 8)
        assert len(read_motion(write("moving.dae", data)).clips) == 1
        return
    data = _moving(sid, target, "0 2", 2)
    made = read_motion(write("still.dae", data))
    assert made.clips == ()
    assert "1 channels that move no transform of the scene are left out" in made.notices


def clips(inside: str) -> tuple[str, str]:
    return (
        "<library_visual_scenes>",
        f"<library_animation_clips>{inside}</library_animation_clips><library_visual_scenes>",
    )


def test_a_clip_of_no_animation_names_all_channels(write: Write) -> None:
    found = read_character(write("clips.dae", collada_with(clips('<animation_clip id="walk"/>'))))
    assert [clip.name for clip in found.clips] == ["walk"]


def test_animation_clips_are_taken_apart_by_their_times(write: Write) -> None:
    parts = "".join(
        f'<animation_clip id="{name}" start="{start}" end="{end}">'
        '<instance_animation url="#a"/></animation_clip>'
        for name, start, end in (("first", 0, 0.5), ("rest", 0.5, 1))
    )
    read = read_character(write("clips.dae", collada_with(clips(parts))))
    whole = read_character(write("whole.dae", collada_with())).clips[0]
    assert [clip.name for clip in read.clips] == ["first", "rest"]
    for clip, start in zip(read.clips, (0.0, 0.5), strict=True):
        assert clip.duration_s == pytest.approx(0.5)
        np.testing.assert_allclose(
            clip.at([0.0, 0.2, 0.5]).as_matrix(),
            whole.at(start + np.array([0.0, 0.2, 0.5])).as_matrix(),
            atol=1e-9,
        )


def test_instances_of_nodes_are_read_where_they_stand(write: Write) -> None:
    plain = read_character(write("plain.dae", collada_with()))
    base = '<node id="base" name="base" sid="b" type="JOINT">'
    text = collada_with().decode()
    start = text.index(base)
    end = text.index('<node id="mesh">')
    library = f"<library_nodes>{text[start:end]}</library_nodes><library_visual_scenes>"
    instanced = text[:start] + '<node id="x"><instance_node url="#base"/></node>' + text[end:]
    instanced = instanced.replace("<library_visual_scenes>", library)
    read = read_character(write("instanced.dae", instanced.encode()))
    np.testing.assert_allclose(read.vertices, plain.vertices)
    assert [clip.name for clip in read.clips] == ["animation"]
    endless = instanced.replace(base, base + '<instance_node url="#base"/>')
    with pytest.raises(FormatError, match="no instance of itself"):
        read_character(write("endless.dae", endless.encode()))


@pytest.mark.parametrize("written", ["Body Skin", "Body%20Skin"])
def test_ids_with_blanks_are_referred_to_as_viewers_read_them(write: Write, written: str) -> None:
    data = collada_with(
        ('controller id="skin"', 'controller id="Body Skin"'), ('url="#skin"', f'url="#{written}"')
    )
    assert len(read_character(write("blank.dae", data)).vertices) == 12


def test_handles_of_another_kind_leave_straight_lines(write: Write) -> None:
    """Tangents without times, as some programs write them, are no handles."""
    bare = collada_with((">-0.3 0 0.7 90<", ">0 90<"), (">0.3 0 1.3 90<", ">0 90<"), kind="BEZIER")
    bare = bare.replace(b'count="4"', b'count="2"')
    found, straight = (
        read_motion(write(name, data))
        for name, data in (("bare.dae", bare), ("line.dae", collada_with()))
    )
    times = [0.1, 0.25, 0.8]
    np.testing.assert_allclose(
        found.clips[0].at(times).as_matrix(), straight.clips[0].at(times).as_matrix(), atol=1e-9
    )


def test_a_key_alone_holds(write: Write) -> None:
    data = collada_with(
        (">0 1</float", ">0.5</float"), (">0 90<", ">90<"), (">LINEAR LINEAR<", ">LINEAR<")
    )
    (clip,) = read_motion(write("one.dae", data)).clips
    assert len(clip.time_s) == 1
    np.testing.assert_allclose(np.degrees(clip.at(7.0).rotor.angle()[1]), 90.0, atol=1e-9)


def test_a_file_without_an_asset_is_in_metres_with_y_up(write: Write) -> None:
    text = samples.collada_tower().decode()
    start, end = text.index("<asset>"), text.index("</asset>") + len("</asset>")
    found = read_motion(write("bare.dae", (text[:start] + text[end:]).encode()))
    # The top lies one unit along the file's z, which is ahead where y is up.
    np.testing.assert_allclose(
        found.skeleton.rest_world.translation_m[1], [1.0, 0.0, 0.0], atol=1e-9
    )
