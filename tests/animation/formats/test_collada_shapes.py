"""What Collada allows besides quads and one channel: other polygons, pictures, hanging meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tests.animation.formats import samples
from tests.animation.formats.samples import Write

from motorcade.animation import Character
from motorcade.animation.formats import FormatError, read_character, read_motion
from motorcade.ga import Similarity


def document(*changes: tuple[str, str], kind: str = "LINEAR") -> bytes:
    """The tower with parts of its text replaced, each found once or more."""
    text = samples.collada_tower(kind).decode()
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text.encode()


def polylist() -> str:
    """The element that holds the tower's polygons."""
    text = samples.collada_tower().decode()
    return text[text.index("<polylist") : text.index("</polylist>") + len("</polylist>")]


def quads() -> list[list[str]]:
    """Corners of its polygons."""
    words = polylist().split("<p>")[1].split("</p>")[0].split()
    return [words[i : i + 4] for i in range(0, len(words), 4)]


INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'


def volume(character: Character) -> float:
    a, b, c = (character.vertices[character.triangles[:, corner]] for corner in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


@pytest.mark.parametrize("kind", ["polygons", "triangles"])
def test_polygons_and_triangles_make_the_same_surface(write: Write, kind: str) -> None:
    plain = read_character(write("plain.dae", document()))
    if kind == "polygons":
        inside = "".join(f"<p>{' '.join(quad)}</p>" for quad in quads())
    else:
        corners = [word for a, b, c, d in quads() for word in (a, b, c, a, c, d)]
        inside = f"<p>{' '.join(corners)}</p>"
    other = f'<{kind} material="s" count="10">{INPUT}{inside}</{kind}>'
    found = read_character(write("other.dae", document((polylist(), other))))
    np.testing.assert_allclose(found.vertices, plain.vertices, atol=1e-12)
    assert volume(found) == pytest.approx(volume(plain), rel=1e-9)
    np.testing.assert_allclose(found.colors, plain.colors)


@pytest.mark.parametrize("name", ["tristrips", "lines"])
def test_elements_of_other_kinds_and_empty_ones_are_left_out(write: Write, name: str) -> None:
    """Beside polygons that are read; those without a corner make no part."""
    more = f"{polylist()}<{name} count='0'/><triangles count='0'>{INPUT}<p/></triangles>"
    found = read_character(write("more.dae", document((polylist(), more))))
    assert len(found.vertices) == 12
    assert f"<{name}> of 'tower' is left out" in found.notices


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ([("<mesh>", "<spline>"), ("</mesh>", "</spline>")], "expected a <mesh>, got another kind"),
        ([('count="12" stride="3"', 'count="0" stride="3"')], "'tower': expected positions, got"),
        ([('semantic="POSITION"', 'semantic="OTHER"')], "'tower': expected positions, got 1"),
        ([('semantic="VERTEX"', 'semantic="OTHER"')], "expected an input VERTEX"),
        ([('offset="0"/>\n<vcount>4', 'offset="1"/>\n<vcount>4')], "counts that sum to 20"),
        ([("<vcount>4 4", "<vcount>4 5")], "counts that sum to 40, got 41"),
        ([("<vcount>4 4", "<vcount>9 -1")], "counts that sum to 40"),
        ([("<p>", "<p>0 ")], "<vcount>: expected counts that sum to 41, got 40"),
        ([("<p>0", "<p>0.5")], "<p>: expected whole numbers"),
        ([("<p>0", "<p>77")], "VERTEX: expected numbers below 12, got 77"),
        ([("<p>0", "<p>-1")], "VERTEX: expected numbers below 12"),
        ([('offset="0"/>\n<vcount>4', 'offset="x"/>\n<vcount>4')], "offset: expected a whole num"),
        ([('offset="0"/>\n<vcount>4', 'offset="64"/>\n<vcount>4')], "a number from 0 to 63"),
        ([('count="12" stride="3"', 'count="13" stride="3"')], "expected 3 of 36 numbers"),
        ([('id="pa" count="36">', 'id="pa">x ')], "expected numbers"),
        ([('source="#p"/>', 'source="#nothing"/>')], "expected the id of a <source>, got #nothing"),
        ([(">b t</Name_array>", ">b b</Name_array>")], "expected different joints, got one twice"),
        ([("<Name_array id=\"ja\"", "<x id=\"ja\""), ("b t</Name_array>", "b t</x>")],
         "expected a <Name_array> or <IDREF_array>, got none"),
        ([('count="2" stride="16"', 'count="1" stride="16"')], "expected 2 bind matrices, got 1"),
        ([('semantic="INV_BIND_MATRIX"', 'semantic="X"')], "JOINT and INV_BIND_MATRIX"),
        ([('semantic="WEIGHT"', 'semantic="X"')], "expected JOINT and WEIGHT"),
        ([("<v>0 0", "<v>7 0")], "expected joints below 2, got 7"),
        ([("<v>0 0", "<v>0 9")], "expected weights below 2, got 9"),
        ([("1 0</v>", "1 0 1 0</v>")], "expected 16 pairs, got 34"),
        ([("<vcount>1 1 1 1", "<vcount>65 1 1 1")], "expected .* pairs"),
        ([("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind", "1 0 0</bind")], "expected 16 numbers, got 3"),
        ([('id="wa" count="2">1', 'id="wa" count="2">-1')], "expected a sum above zero, got -4"),
        ([('count="2">1 0.5', 'count="2">1 -0.5')], "finite shares of 0 or more"),
        ([("<float_array id=\"wa\"", "<x id=\"wa\""), ("1 0.5</float_array>", "1 0.5</x>")],
         "expected a <float_array>, got none"),
        ([("#skin\"", "#tower\"")], "expected the id of a <controller>, got #tower"),
        ([("Z_UP", "W_UP")], "up_axis: expected X_UP"),
        ([('meter="0.5"', 'meter="-1"')], "unit: expected metres"),
        ([(">b t<", ">b x<")], "joints that are nodes of the scene, got x"),
        ([("1 1 1 1 2 2 2 2", "1 1 1 1 2 2 2 9")], "weights of 'tower': expected 23 pairs"),
        ([("<rotate sid", "<skew>1 0 0 0 0 0 0</skew><rotate sid")], "or scale, got skew"),
        ([(">0 90<", ">0 nan<")], "finite numbers"),
        ([('meter="0.5"', 'meter="half"')], "asset unit: expected metres, got half"),
        ([('semantic="OUTPUT"', 'semantic="X"')], "expected INPUT and OUTPUT"),
        ([(">0 90<", ">0 45 90<")], "sampler 's': expected 2 keys, got 3"),
        ([(">0 1</float", ">1 0</float")], "sampler 's': expected increasing seconds up to 1e6"),
        ([('id="ka" count="2">LINEAR', 'id="ka" count="2">')], "expected 2 kinds, got 1"),
        ([('<node id="base"', '<node><lookat>0</lookat></node><node id="base"')],
         "rotate or scale, got lookat"),
        ([("COLLADA xmlns", "COLLADO xmlns"), ("</COLLADA>", "</COLLADO>")], "expected COLLADA"),
    ],
)  # fmt: skip
def test_documents_that_are_not_consistent_are_refused_by_name(
    write: Write, changes: list[tuple[str, str]], message: str
) -> None:
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.dae", document(*changes)))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"<a><b></a>", "XML: mismatched tag"),
        (b"", "the file is empty"),
        (b"plain", "XML: syntax error"),
        (b'<?xml version="1.0" encoding="x-nothing"?><a/>', "XML: unknown encoding"),
        (b'<?xml version="1.0" encoding="utf-7"?><a/>', "XML: "),
        (b"<a>\xff</a>", "XML: not well-formed"),
    ],
)
def test_texts_that_are_no_xml_are_refused(write: Write, data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.dae", data))


def test_a_scene_without_nodes_is_refused(write: Write) -> None:
    text = samples.collada_tower().decode()
    start, end = text.index('<node id="base"'), text.rindex("</visual_scene>")
    with pytest.raises(FormatError, match="visual_scene: expected one node or more, got none"):
        read_character(write("bare.dae", (text[:start] + text[end:]).encode()))


def test_weights_of_fewer_vertices_than_the_mesh_has_are_refused(write: Write) -> None:
    data = document(("<vcount>1 1 1 1 2 2 2 2 1 1 1 1", "<vcount>1 1 1 1 2 2 2 2 1 1 1"),
                    ("1 0</v>", "</v>"))  # fmt: skip
    with pytest.raises(FormatError, match="expected weights of every vertex, got 11"):
        read_character(write("few.dae", data))


def test_a_skin_without_a_bind_shape_is_bound_as_it_stands(write: Write) -> None:
    shape = "<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>"
    plain = read_character(write("plain.dae", document()))
    bare = read_character(write("bare.dae", document((shape, ""))))
    np.testing.assert_array_equal(bare.vertices, plain.vertices)
    large = shape.replace("1 0 0 0 0 1 0 0 0 0 1 0", "2 0 0 0 0 2 0 0 0 0 2 0")
    grown = read_character(write("grown.dae", document((shape, large))))
    np.testing.assert_allclose(grown.vertices, 2.0 * plain.vertices, atol=1e-9)


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("<ph><p>0 1 2</p><h>3 4 5</h></ph>", "polygons without holes, got some with holes"),
        ("<p>0 1 2 3 4</p>", "a multiple of 2 numbers"),
    ],
)
def test_polygons_that_are_none_are_refused(write: Write, inside: str, message: str) -> None:
    two = '<input semantic="NORMAL" source="#p" offset="1"/>'
    other = f'<polygons count="1">{INPUT}{two}{inside}</polygons>'
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.dae", document((polylist(), other))))


@pytest.mark.parametrize(
    ("corners", "message"),
    [("0 1 2 3", "three corners a triangle, got 4"), ("0", "three corners a triangle, got 1")],
)
def test_triangles_that_are_none_are_refused(write: Write, corners: str, message: str) -> None:
    other = f'<triangles count="1">{INPUT}<p>{corners}</p></triangles>'
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.dae", document((polylist(), other))))
    uneven = other.replace(
        'offset="0"', 'offset="0"/><input semantic="NORMAL" source="#p" offset="1"'
    )
    with pytest.raises(
        FormatError, match="multiple of 2 numbers" if corners == "0" else message[:5]
    ):
        read_character(write("uneven.dae", document((polylist(), uneven))))


def test_colours_of_vertices_count_before_materials(write: Write) -> None:
    source = ('<source id="c"><float_array id="ca" count="36">' + "0.25 0.5 2 " * 12
              + '</float_array><technique_common><accessor source="#ca" count="12" stride="3"/>'
              "</technique_common></source><vertices")  # fmt: skip
    colored = '<input semantic="POSITION" source="#p"/><input semantic="COLOR" source="#c"/>'
    found = read_character(write("c.dae", document(
        ("<vertices", source), ('<input semantic="POSITION" source="#p"/>', colored)
    )))  # fmt: skip
    np.testing.assert_allclose(found.colors, np.tile([0.25, 0.5, 1.0], (12, 1)))


TEXTURE = """<newparam sid="surface"><surface type="2D"><init_from>image</init_from></surface>
</newparam><newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>
<technique"""


def _textured(picture: str, named: str = "sampler") -> bytes:
    """The tower painted by a picture; its right half is green, its upper left corner red."""
    uv = ('<source id="t2"><float_array id="ta" count="24">' + "0.75 0.25 " * 11 + "0.25 0.75"
          '</float_array><technique_common><accessor source="#ta" count="12" stride="2"/>'
          "</technique_common></source><vertices")  # fmt: skip
    return document(
        ("<vertices", uv),
        ('<input semantic="POSITION" source="#p"/>',
         '<input semantic="POSITION" source="#p"/><input semantic="TEXCOORD" source="#t2"/>'),
        ("<technique", TEXTURE),
        ("<color>0.8 0.2 0.1 1</color>", f'<texture texture="{named}" texcoord="x"/>'),
        ("<library_effects>", f'<library_images><image id="image"><init_from>{picture}</init_from>'
         "</image></library_images><library_effects>"),
    )  # fmt: skip


@pytest.mark.parametrize("named", ["sampler", "image"])
def test_textures_are_sampled_with_v_upwards(write: Write, tmp_path: Path, named: str) -> None:
    """By a sampler and its surface, or straight by the picture's id."""
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[:, 1], pixels[0, 0] = (0, 255, 0), (255, 0, 0)
    Image.fromarray(pixels).save(tmp_path / "skin.png")
    found = read_character(write("painted.dae", _textured("skin.png", named)))
    np.testing.assert_allclose(found.colors[0], [0.0, 1.0, 0.0])
    np.testing.assert_allclose(found.colors[-1], [1.0, 0.0, 0.0])
    assert not any("was not read" in notice for notice in found.notices)


@pytest.mark.parametrize(
    ("picture", "named", "told"),
    [("lost.png", "sampler", "'lost.png' was not read"), ("lost.png", "nowhere", "")],
)
def test_pictures_that_cannot_be_had_leave_a_plain_grey(
    write: Write, picture: str, named: str, told: str
) -> None:
    found = read_character(write("grey.dae", _textured(picture, named)))
    np.testing.assert_allclose(found.colors, 0.8)
    notices = [notice for notice in found.notices if "texture" in notice]
    assert len(notices) == (1 if told else 0)
    assert all(told in notice for notice in notices)


def test_a_mesh_that_hangs_on_a_joint_follows_it(write: Write) -> None:
    """Beside the skinned one, which shares its polygons."""
    data = document(('<rotate sid="turn">0 0 1 0</rotate>',
                     '<rotate sid="turn">0 0 1 0</rotate><instance_geometry url="#tower"/>',
                     ))  # fmt: skip
    found = read_character(write("hat.dae", data))
    assert len(found.vertices) == 24
    hat, tower = found.vertices[:12], found.vertices[12:]
    assert np.all(found.joints[:12, 0] == found.skeleton.index("top"))
    np.testing.assert_allclose(hat - [0.0, 0.0, 0.5], tower, atol=1e-9)


@pytest.mark.parametrize("kind", ["geometry", "controller"])
def test_splines_and_morphs_are_left_out_and_told(write: Write, kind: str) -> None:
    more = {
        "geometry": ('<library_geometries>', '<library_geometries><geometry id="line"><spline/>'
                     "</geometry>", '<node id="mesh"><instance_geometry url="#line"/>',
                     "'line' is no mesh: left out"),
        "controller": ("<library_controllers>", '<library_controllers><controller id="face">'
                       "<morph/></controller>",
                       '<node id="mesh"><instance_controller url="#face"/>',
                       "'face' morphs a mesh: left out"),
    }[kind]  # fmt: skip
    data = document((more[0], more[1]), ('<node id="mesh">', more[2]))
    found = read_character(write("more.dae", data))
    assert len(found.vertices) == 12
    assert more[3] in found.notices


def _moving(sid: str, target: str, values: str, count: int) -> bytes:
    """The tower with an element of a sid in its top, moved by a channel to two values."""
    return document(
        ('<rotate sid="turn">0 0 1 0</rotate>', f'<rotate sid="turn">0 0 1 0</rotate>{sid}'),
        ('count="2">0 90<', f'count="{count}">{values}<'),
        ('<sampler id="s">', '<technique_common/><sampler id="s">'),
        ('target="top/turn.ANGLE"', f'target="top/{target}"'),
        ('id="oa"', 'id="oa" '),
        ('</float_array></source>\n<source id="k">',
         f'</float_array><technique_common><accessor source="#oa" count="2" stride="{count // 2}"/>'
         '</technique_common></source>\n<source id="k">'),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("sid", "target", "values", "count"),
    [
        ('<translate sid="at2">0 0 0</translate>', "at2", "0 0 0 0 0 2", 6),
        ('<translate sid="at2">0 0 0</translate>', "at2.Z", "0 2", 2),
        ('<translate sid="at2">0 0 0</translate>', "at2(2)", "0 2", 2),
        ('<matrix sid="m">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>', "m(3)(2)", "0 2", 2),
        ('<matrix sid="m">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>', "m",
         "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 1 0 0 0 0 1 0 0 0 0 1 2 0 0 0 1", 32),
    ],
)  # fmt: skip
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
    sid = ('<translate sid="at2">0 0 0</translate>'
           '<matrix sid="m">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>')  # fmt: skip
    if target == "turn":
        data = _moving(sid, target, "0 0 1 0 0 0 1 90", 8)
        assert len(read_motion(write("moving.dae", data)).clips) == 1
        return
    data = _moving(sid, target, "0 2", 2)
    made = read_motion(write("still.dae", data))
    assert made.clips == ()
    assert "1 channels that move no transform of the scene are left out" in made.notices


def test_animation_clips_are_not_taken_apart_but_name_the_clip(write: Write) -> None:
    named = '<library_animation_clips><animation_clip id="walk"/></library_animation_clips>'
    found = read_character(write("clips.dae", document(("<library_visual", named + "<library_vis"
                                                        "ual"))))  # fmt: skip
    assert [clip.name for clip in found.clips] == ["walk"]
    assert any("all channels make one clip" in notice for notice in found.notices)


def test_handles_of_another_kind_leave_straight_lines(write: Write) -> None:
    """Tangents without times, as some programs write them, are no handles."""
    bare = document((">-0.3 0 0.7 90<", ">0 90<"), (">0.3 0 1.3 90<", ">0 90<"), kind="BEZIER")
    bare = bare.replace(b'count="4"', b'count="2"')
    found, straight = (read_motion(write(name, data)) for name, data in
                       (("bare.dae", bare), ("line.dae", document())))  # fmt: skip
    times = [0.1, 0.25, 0.8]
    np.testing.assert_allclose(
        found.clips[0].at(times).as_matrix(), straight.clips[0].at(times).as_matrix(), atol=1e-9
    )


def test_a_key_alone_holds(write: Write) -> None:
    data = document((">0 1</float", ">0.5</float"), (">0 90<", ">90<"), (">LINEAR LINEAR<",
                                                                       ">LINEAR<"))  # fmt: skip
    (clip,) = read_motion(write("one.dae", data)).clips
    assert len(clip.time_s) == 1
    np.testing.assert_allclose(np.degrees(clip.at(7.0).rotor.angle()[1]), 90.0, atol=1e-9)


def test_a_file_without_an_asset_is_in_metres_with_y_up(write: Write) -> None:
    text = samples.collada_tower().decode()
    start, end = text.index("<asset>"), text.index("</asset>") + len("</asset>")
    found = read_motion(write("bare.dae", (text[:start] + text[end:]).encode()))
    # The top lies one unit along the file's z, which is ahead where y is up.
    np.testing.assert_allclose(found.skeleton.rest_world.translation_m[1], [1.0, 0.0, 0.0],
                               atol=1e-9)  # fmt: skip


@pytest.mark.parametrize(
    ("module", "name", "limit", "message"),
    [
        ("library", "MAX_VALUES", 40, "sources: expected at most 40 numbers in all, got more"),
        ("geometry", "MAX_VALUES", 9, "polygons: expected at most 3 triangles, got 20"),
        ("scene", "MAX_NODES", 2, "nodes: expected at most 2, got 3"),
        ("controllers", "MAX_VERTICES", 11, "vertices and triangles: expected at most 11"),
        ("controllers", "MOST_INFLUENCES", 1, "expected at most 1 a vertex, got 2"),
        ("xml", "MAX_ELEMENTS", 5, "at most 5"),
    ],
)
def test_files_beyond_the_limits_are_refused(
    write: Write, monkeypatch: pytest.MonkeyPatch, module: str, name: str, limit: int, message: str
) -> None:
    """Limits are lowered for the test rather than files made that large."""
    monkeypatch.setattr(f"motorcade.animation.formats.collada.{module}.{name}", limit)
    with pytest.raises(FormatError, match=message):
        read_character(write("large.dae", document()))
