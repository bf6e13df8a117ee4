"""Scripts are drawn as they say: what is marked, in its colour, in inner or outer form."""

import numpy as np
import pytest

from motorcade.ga import PGA3
from motorcade.ga.drawing import Drawing, draw_script
from motorcade.ga.drawing.shape import Circle, Points, Sphere
from motorcade.ga.script import ScriptError, evaluate, parse

SCENE = """
// a sphere, a plane and where they meet
:IPNS;
:Blue;
:s = VecN3(0, 0, 1) - 0.5*einf;
:Orange;
:g = e3 + h*einf;
:Red;
:s ^ g;
:OPNS;
:Color(0, 0.6, 0.2);
:l = VecN3(-1, -1, 0) ^ VecN3(1, 1, 1.5) ^ einf;
_BGColor = White;
?far = s . g;
"""


def drawn(text: str, **values: object) -> Drawing:
    return draw_script(parse(text, "scene.clu"), **values)


def test_marks_words_and_expressions_are_drawn() -> None:
    image = drawn(SCENE, h=0.5)
    assert repr(image) == "Drawing(s: sphere, g: plane, circle, l: line)"
    assert [one.color for one in image.objects] == ["blue", "orange", "red", "green"]
    circle = image.objects[2].shapes[0]
    assert isinstance(circle, Circle)
    assert circle.radius == pytest.approx(0.75**0.5)


def test_a_name_is_drawn_as_it_is_there() -> None:
    image = drawn("p = VecN3(1, 0, 0); :p; p = VecN3(2, 0, 0); :p; p = VecN3(3, 0, 0);")
    shapes = [one.shapes[0] for one in image.objects]
    assert [s.positions[0, 0] for s in shapes if isinstance(s, Points)] == [1.0, 2.0]


def test_what_is_drawn_changes_nothing_of_what_is_computed() -> None:
    plain = SCENE.replace(":s ^ g;", "").replace(":Red;", "")
    made, expected = evaluate(parse(SCENE), h=0.5), evaluate(parse(plain), h=0.5)
    assert list(made) == list(expected) == ["far"]
    assert made["far"].isclose(expected["far"])
    assert list(evaluate(parse(":unknown ^ other; ?a = x*e1;"), x=1.0)) == ["a"]


def test_outputs_are_drawn_where_nothing_is_marked() -> None:
    image = drawn("?s = SphereN3(0, 0, 0, r); ?d = 2*r;", r=1.5)
    (one,) = image.objects
    assert (one.name, one.shapes[0].kind) == ("s", "sphere")
    assert image.left_out == ("d is not drawn: it is the number 3",)
    inner = drawn(":IPNS; ?s = VecN3(0, 0, 0) - 0.5*r*r*einf;", r=1.5).objects[0].shapes[0]
    assert isinstance(inner, Sphere)
    assert inner.radius == pytest.approx(1.5)


def test_batches_draw_many_and_algebras_are_the_scripts_own() -> None:
    t = np.linspace(0.0, 1.0, 7)
    image = drawn(":p = VecN3(cos(t), sin(t), t);", t=t)
    points = image.objects[0].shapes[0]
    assert isinstance(points, Points)
    np.testing.assert_allclose(points.positions, np.stack([np.cos(t), np.sin(t), t], 1), atol=1e-12)
    flat = drawn("//#pragma algebra cga2\n:IPNS; :c = e0 - 0.5*einf; :l = e1;")
    assert flat.view.flat
    plane = draw_script(parse(":a = e1 - 2*e0;"), PGA3)
    assert repr(plane) == "Drawing(a: plane)"


def test_colours_of_numbers_are_the_nearest_of_ours() -> None:
    text = ":Color(255, 0, 0); :a = VecN3(0,0,0); :Color(1, 1, 1); :b = a; :Color(0,0,0); :c = a;"
    assert [one.color for one in drawn(text).objects] == ["red", "white", "black"]


def test_mistakes_name_their_place() -> None:
    with pytest.raises(ScriptError, match=r"scene.clu:2:2: .*free variables u"):
        drawn(":e1;\n:u*e1;")
    with pytest.raises(
        ValueError, match=r"scene.clu: expected something to draw, got none: a is not"
    ):
        drawn("?a = 2;")
    with pytest.raises(ValueError, match=r"mark objects with : or \?"):
        drawn("a = 2;")


LOOP = """
k = 0;
loop {
    if (k == 3) { break; }
    if (k == 1) { :Red; } else { :Blue; }
    :p = VecN3(k, 0, 0);
    :VecN3(k, 1, 0);
    k = k + 1;
}
"""


def places(image: Drawing) -> list[list[float]]:
    shapes = [one.shapes[0] for one in image.objects]
    return [s.positions.tolist() for s in shapes if isinstance(s, Points)]


def test_each_round_of_a_loop_is_drawn() -> None:
    image = drawn(LOOP)
    assert places(image) == [[[k, y, 0.0]] for k in (0.0, 1.0, 2.0) for y in (0.0, 1.0)]
    assert [one.name for one in image.objects] == ["p", ""] * 3
    assert [one.color for one in image.objects] == ["blue"] * 2 + ["red"] * 2 + ["blue"] * 2


def test_the_branch_that_is_taken_is_drawn() -> None:
    text = "p = VecN3(x, 0, 0); if (x > 0) { :p; } else { :q = VecN3(x, 1, 0); }"
    assert places(drawn(text, x=2.0)) == [[[2.0, 0.0, 0.0]]]
    assert places(drawn(text, x=-2.0)) == [[[-2.0, 1.0, 0.0]]]


def test_of_several_values_those_are_drawn_that_take_a_branch() -> None:
    text = (
        "p = VecN3(x, 0, 0);\n"
        "if (x > 0) { :p; if (x > 2) :VecN3(x, 5, 0); } else { :q = VecN3(x, 1, 0); }\n"
        "if (x > 100 && x < 0) { :p; }"
    )
    image = drawn(text, x=np.array([1.0, -2.0, 3.0, -4.0]))
    assert [one.name for one in image.objects] == ["p", "", "q"]
    assert places(image) == [
        [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
        [[3.0, 5.0, 0.0]],
        [[-2.0, 1.0, 0.0], [-4.0, 1.0, 0.0]],
    ]


def test_what_branches_draw_changes_nothing_of_what_is_computed() -> None:
    text = "loop { :gone ^ e1; :Color(none, 1, 2); break; } ?a = x;"
    assert list(evaluate(parse(text), x=1.0)) == ["a"]
    with pytest.raises(ScriptError, match=r"scene\.clu:1:9: expected values .* gone, got none"):
        drawn(text, x=1.0)


def test_macros_draw_nothing() -> None:
    image = drawn("m = { :k = VecN3(_P(1), 0, 0); :k ^ e1; k } :p = m(1);")
    assert [one.name for one in image.objects] == ["p"]


def test_so_many_objects_are_refused() -> None:
    with pytest.raises(ScriptError, match=r"scene\.clu:1:13: expected at most 1000 objects"):
        drawn("k=0; loop {:e1; if (k == 2000) {break;} k = k + 1;}")
