"""Every part of a Collada document that can be wrong is refused by its name."""

from __future__ import annotations

import pytest

from motorcade.animation.formats import FormatError, read_character
from tests.animation.formats import samples
from tests.animation.formats.samples import Write, collada_polygons, collada_with

INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'


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
        (
            [('<Name_array id="ja"', '<x id="ja"'), ("b t</Name_array>", "b t</x>")],
            "expected a <Name_array> or <IDREF_array>, got none",
        ),
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
        (
            [('<float_array id="wa"', '<x id="wa"'), ("1 0.5</float_array>", "1 0.5</x>")],
            "expected a <float_array>, got none",
        ),
        ([('#skin"', '#tower"')], "expected the id of a <controller>, got #tower"),
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
        (
            [('<node id="base"', '<node><lookat>0</lookat></node><node id="base"')],
            "rotate or scale, got lookat",
        ),
        ([("COLLADA xmlns", "COLLADO xmlns"), ("</COLLADA>", "</COLLADO>")], "expected COLLADA"),
    ],
)
def test_documents_that_are_not_consistent_are_refused_by_name(
    write: Write, changes: list[tuple[str, str]], message: str
) -> None:
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.dae", collada_with(*changes)))


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
    data = collada_with(
        ("<vcount>1 1 1 1 2 2 2 2 1 1 1 1", "<vcount>1 1 1 1 2 2 2 2 1 1 1"), ("1 0</v>", "</v>")
    )
    with pytest.raises(FormatError, match="expected weights of every vertex, got 11"):
        read_character(write("few.dae", data))


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
        read_character(write("bad.dae", collada_with((collada_polygons(), other))))


@pytest.mark.parametrize(
    ("corners", "message"),
    [("0 1 2 3", "three corners a triangle, got 4"), ("0", "three corners a triangle, got 1")],
)
def test_triangles_that_are_none_are_refused(write: Write, corners: str, message: str) -> None:
    other = f'<triangles count="1">{INPUT}<p>{corners}</p></triangles>'
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.dae", collada_with((collada_polygons(), other))))
    uneven = other.replace(
        'offset="0"', 'offset="0"/><input semantic="NORMAL" source="#p" offset="1"'
    )
    with pytest.raises(
        FormatError, match="multiple of 2 numbers" if corners == "0" else message[:5]
    ):
        read_character(write("uneven.dae", collada_with((collada_polygons(), uneven))))


@pytest.mark.parametrize(
    ("module", "name", "limit", "message"),
    [
        ("library", "MAX_VALUES", 40, "sources: expected at most 40 numbers in all, got more"),
        ("controllers", "MAX_VALUES", 9, "polygons: expected at most 3 triangles, got 20"),
        ("scene", "MAX_NODES", 2, "nodes: expected at most 2, got 3"),
        ("controllers", "MAX_VERTICES", 11, "vertices and triangles: expected at most 11"),
        ("controllers", "MOST_INFLUENCES", 1, "expected at most 1 a vertex, got 2"),
        ("library", "MAX_ELEMENTS", 5, "at most 5"),
    ],
)
def test_files_beyond_the_limits_are_refused(
    write: Write, monkeypatch: pytest.MonkeyPatch, module: str, name: str, limit: int, message: str
) -> None:
    """Limits are lowered for the test rather than files made that large."""
    monkeypatch.setattr(f"motorcade.animation.formats.collada.{module}.{name}", limit)
    with pytest.raises(FormatError, match=message):
        read_character(write("large.dae", collada_with()))
