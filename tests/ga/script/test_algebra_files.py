"""Algebras and macros from files: what they mean, how they are found, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra
from motorcade.ga.codegen.generate import read_script
from motorcade.ga.files import FileError
from motorcade.ga.script import ScriptError, algebras, evaluate, parse
from motorcade.ga.script.algebras import definition_of, definitions, read_definition
from motorcade.ga.script.errors import MAX_IMPORT_DEPTH, MAX_IMPORTS
from motorcade.ga.script.meaning import algebra_named, with_algebra

OWN = """
squares = { o1 = 0, i1 = 0, x = 1, o2 = 0, i2 = 0 }
null_pairs = [["o1", "i1"], ["o2", "i2"]]
macros = "shapes.clu"
[named]
p1 = { i1 = 0.5, o1 = -1.0 }
"""
SHAPES = "#include more/base.clu\nring = { _P(1)*p1 + base(_P(2)) }\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "own.toml").write_text(OWN)
    (tmp_path / "shapes.clu").write_text(SHAPES)
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "base.clu").write_text("base = { _P(1)*x }")
    return tmp_path


def script(folder: Path, text: str, name: str = "main.clu") -> Path:
    (folder / name).write_text(text)
    return folder / name


def test_names_of_gaalop_and_of_ours_are_one_algebra() -> None:
    for theirs, ours in [("cga", CGA3), ("3d", EGA3), ("3dpga", PGA3)]:
        assert algebra_named(theirs) is ours
    assert algebra_named("cra") == Algebra(3, 1, null_pair=True)
    assert [definitions()[n].algebra.signature for n in ("sta", "dcga", "gac", "qga", "ccga")] == [
        (1, 3, 0),
        (8, 2, 0),
        (5, 3, 0),
        (6, 3, 0),
        (9, 7, 0),
    ]


@pytest.mark.parametrize("name", ["cga", "cra", "dcga", "gac", "qga", "ccga"])
def test_points_are_null_and_their_product_tells_distance(name: str) -> None:
    """The squared distance is -2 p.q, in dcga its square: what each algebra is made for."""
    definition = definitions()[name]
    arity = max(count for macro, count in definition.macros if macro == "createPoint")
    call = f"createPoint({', '.join('abc'[:arity])})"
    text = f"?p = {call}; ?q = createPoint({', '.join('def'[:arity])}); ?on = p.p; ?far = p.q;"
    given = dict(zip("abcdef", (0.5, -1.0, 2.0, 1.5, 0.25, 3.0), strict=True))
    free = {k: v for k, v in given.items() if "abc".find(k) < arity and "def".find(k) < arity}
    made = evaluate(parse(text), definition.algebra, **free)
    ends = np.array([[given[k] for k in names[:3]] for names in ("abc", "def")])
    flat = name in ("cra", "gac", "ccga")
    squared = float(np.sum(np.square(ends[1] - ends[0])[: 2 if flat else 3]))
    expected = -0.25 * squared**2 if name == "dcga" else -0.5 * squared
    assert np.max(np.abs(made["on"].values or (0.0,))) < 1e-12
    assert made["far"].scalar_part() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("quadric", "point"),
    [
        ("Ellipsoid(1, 2, 3, 2, 3, 4)", (3, 2, 3)),
        ("Sphere(1, 2, 3, 2)", (1, 4, 3)),
        ("Toroid(3, 1)", (0, 4, 0)),
        ("CylinderZ(1, 2, 9, 2, 3, 9)", (1, 5, -7)),
        ("ConeX(0, 0, 0, 1, 1, 1)", (5, 3, 4)),
        ("ParaboloidZ(1, 2, 3, 1, 1, 1)", (2, 3, 5)),
        ("HParaboloidZ(0, 0, 0, 1, 1, 1)", (2, 1, 3)),
        ("Hyperboloid1(0, 0, 0, 1, 1, 1)", (1, 2, 2)),
        ("Hyperboloid2(0, 0, 0, 1, 1, 1)", (2, 2, 3)),
        ("Plane(0, 0, 2, 5)", (1, 2, 5)),
        ("PPlanesY(2, 7)", (1, 7, 0)),
        ("XPlanesZ(1, 1, 1, 2)", (2, 3, 9)),
        ("Line(1, 2, 3, 0, 0, 4)", (1, 2, -8)),
        ("DupinCyclide(3, 1, 1)", (0, 4, 0)),
        ("Translator(1, 2, 3)*Toroid(3, 1)*~Translator(1, 2, 3)", (1, 6, 3)),
        ("Rotor(1, 0, 0, 90)*Toroid(3, 1)*~Rotor(1, 0, 0, 90)", (0, 0, 4)),
    ],
)
def test_points_of_a_quadric_lie_on_it(quadric: str, point: tuple[int, int, int]) -> None:
    """By the equation of each: x^2/4 + … = 1 and so on; a point beside it does not."""
    x, y, z = point
    text = f"#pragma algebra dcga\nq = {quadric}; ?on = createPoint(x, y, z) . q;"
    assert _largest(evaluate(parse(text), x=x, y=y, z=z)["on"]) < 1e-9
    assert _largest(evaluate(parse(text), x=x + 0.1, y=y + 0.3, z=z + 0.3)["on"]) > 1e-3


def _largest(x: object) -> float:
    return max((abs(v) for v in x.values), default=0.0)  # type: ignore[attr-defined]


def test_conics_and_quadrics_hold_their_points() -> None:
    ellipse = "#pragma algebra gac\n?on = createPoint(x, y, 0) . Ellipse(3, 2);"
    assert abs(evaluate(parse(ellipse), x=3 * 0.6, y=2 * 0.8)["on"].scalar_part()) < 1e-12
    quadric = "#pragma algebra qga\n?on = createPoint(x, y, z) . createEllipsoid(3, 2, 1, 5, 6, 7);"
    on = evaluate(parse(quadric), x=5 + 3 * 0.6, y=6.0, z=7 + 0.8)["on"]
    assert abs(on.scalar_part()) < 1e-12


def test_nine_points_make_a_cubic() -> None:
    """Nine points of y = x^3 - x in whole numbers, and a tenth: the outer product vanishes."""
    curve = [(k / 2, (k / 2) ** 3 - k / 2) for k in range(-3, 6)]
    points = ", ".join(f"createPoint({x}, {y}, 0)" for x, y in curve)
    text = f"#pragma algebra ccga\n?on = createPoint(x, y, 0) ^ CubicFromPoints({points});"
    size = _largest(evaluate(parse(text), x=3.0, y=20.0)["on"])
    assert _largest(evaluate(parse(text), x=3.0, y=24.0)["on"]) < 1e-12 * size


def test_an_algebra_and_macros_of_ones_own(folder: Path) -> None:
    text = "#pragma algebra own.toml\n?a = ring(2, 3); ?b = a*a; ?c = o2 . i2;"
    made = evaluate(read_script(script(folder, text)))
    assert dict(made["a"].items()) == {"i1": 1.0, "o1": -2.0, "x": 3.0}
    assert dict(made["b"].items())["1"] == 4 + 9
    assert made["c"].scalar_part() == -1
    assert made["a"].algebra.named == ("p1",)


def test_a_file_is_imported_once_and_knows_the_script(folder: Path) -> None:
    text = "#include shapes2.clu\n#pragma import more/base.clu\nx = e1; ?a = twice(3) + k();"
    (folder / "shapes2.clu").write_text(
        "#include more/base.clu\ntwice = { 2*base(_P(1)) } k = { free }"
    )
    made = evaluate(read_script(script(folder, text)), free=0.5)
    assert dict(made["a"].items()) == {"1": 0.5, "e1": 6.0}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("#include none.clu", "none.clu"),
        ("#include statements.clu", "macros alone"),
        ("#include bytes.clu", "UTF-8"),
        ("#include wrong.clu", r"wrong\.clu:1:9: expected an expression"),
        ("#include link.clu", "below the folder of what names it"),
        ("#include deep0.clu", f"{MAX_IMPORT_DEPTH} in each other"),
        ("\n".join(f"#include m{k}.clu" for k in range(40)), f"at most {MAX_IMPORTS} imports"),
        ("#include again.clu\nf = { 2 }", "f is already defined"),
        ("#pragma algebra none.toml", "none.toml"),
        ("#pragma algebra unclosed.toml", "expected TOML"),
        ("#pragma algebra unknown.toml", "got also 'colour'"),
        ("#pragma algebra squares.toml", "expected 1, -1 or 0 for x"),
        ("#pragma algebra pairs.toml", "pairs of different vectors"),
        ("#pragma algebra large.toml", "1 to 16 basis vectors, got 17"),
        ("#pragma algebra nameless.toml", "distinct names|identifiers"),
        ("#pragma algebra sums.toml", "expected p as numbers"),
        ("#pragma algebra bad_macros.toml", "macros alone"),
        ("#pragma algebra own.toml\n#pragma algebra cga", "expected one algebra"),
    ],
)
def test_files_that_cannot_be_used_are_refused(folder: Path, text: str, message: str) -> None:
    for name, content in {
        "statements.clu": "x = 1;",
        "wrong.clu": "f = { * }",
        "again.clu": "f = { 1 }",
        "unclosed.toml": "squares = {",
        "unknown.toml": "squares = { x = 1 }\ncolour = 3",
        "squares.toml": "squares = { x = [2] }",
        "pairs.toml": 'squares = { x = 1, o = 0 }\nnull_pairs = [["o", "x"]]',
        "large.toml": "[squares]\n" + "".join(f"e{k} = 1\n" for k in range(17)),
        "nameless.toml": 'squares = { "a^b" = 1 }',
        "sums.toml": "squares = { x = 1 }\nnamed = { p = { y = 1.0 } }",
        "bad_macros.toml": 'squares = { x = 1 }\nmacros = "statements.clu"',
        **{f"m{k}.clu": "// none" for k in range(40)},
        **{f"deep{k}.clu": f"#include deep{k + 1}.clu" for k in range(20)},
    }.items():
        (folder / name).write_text(content)
    (folder / "bytes.clu").write_bytes(b"f = { \xff }")
    outside = folder.parent / "outside.clu"
    outside.write_text("f = { 1 }")
    (folder / "link.clu").symlink_to(outside)
    with pytest.raises(ScriptError, match=message):
        evaluate(read_script(script(folder, f"{text}\n?x = 1;")))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "the file is empty"),
        ("squares = 3", "squares: expected 1, -1 or 0 by basis vector, got 3"),
        ("names = []", "squares: expected 1, -1 or 0 by basis vector, got nothing"),
        ("squares = { x = 2 }", r"\(squares\): expected 1, -1 or 0 for x, got 2"),
        ("squares = { x = 1 }\nnamed = 3", "named: expected a table by the new names, got 3"),
        ("squares = { x = 1 }\nnamed = { y = 3 }", "named.y: expected numbers by basis vectors"),
        ("squares = { x = 1 }\nmacros = 3", "macros: expected the name of a file, got 3"),
        ("squares = { x = 1 }\nnames = [3]", "names: expected a list of names, got"),
        ("squares = { x = 1 }\nnull_pairs = 3", "null_pairs: expected a list of pairs of names"),
        (
            'squares = { o = 0 }\nnull_pairs = [["o"]]',
            r"null_pairs\[0\]: expected two names of basis vectors, got \['o'\]",
        ),
        (f"squares = {{ {'x' * 70} = 1 }}", "expected names of up to 64, got 'xxx"),
        ('squares = { x = 1 }\nmacros = "none.clu"', "none.clu: the file is missing"),
        ('squares = { x = 1 }\nmacros = "../m.clu"', "expected a file below"),
        ("x = " + "[" * 5000, "expected TOML"),
    ],
)
def test_the_field_that_is_wrong_is_named(folder: Path, content: str, message: str) -> None:
    (folder / "mine.toml").write_text(content)
    with pytest.raises(ValueError, match=message) as refused:
        with_algebra(parse("?a = 1;"), str(folder / "mine.toml"))
    assert str(refused.value).startswith(str(folder))
    assert len(str(refused.value)) < 400


def test_an_algebra_is_given_beside_the_script(folder: Path, tmp_path: Path) -> None:
    text = parse("?a = ring(2, 3); ?c = o2 . i2;")
    made = evaluate(with_algebra(text, str(folder / "own.toml")))
    assert dict(made["a"].items()) == {"i1": 1.0, "o1": -2.0, "x": 3.0}
    (tmp_path / "elsewhere.toml").symlink_to(folder / "own.toml")
    assert evaluate(with_algebra(text, str(tmp_path / "elsewhere.toml")))["c"]["1"] == -1
    with pytest.raises(ScriptError, match=r"f\.clu:1:1: expected one algebra, got"):
        evaluate(with_algebra(parse("#pragma algebra 2d\n?a = 1;", "f.clu"), "3d"))
    assert evaluate(with_algebra(parse("#pragma algebra 3d\n?a = e1*e1;"), "3 0 0"))["a"]["1"] == 1
    for name in ("none", "a.tml", "3 0", "17 0 0"):
        with pytest.raises(ValueError, match=r"algebra: expected|1 to 16 basis vectors"):
            with_algebra(text, name)


def test_a_definition_that_is_too_large_is_refused(folder: Path) -> None:
    (folder / "large.toml").write_text(OWN + "#" * 100_000)
    with pytest.raises(FileError, match="100000 bytes"):
        read_definition(folder, "large.toml")
    assert definition_of(Algebra(2, 2)).names == ()


LARGE = {
    "dcga": "t = Toroid(a, b); v = Translator(x, y, z); ?on = createPoint(x, y, z).t; ?t = v*t*~v;",
    "qga": "q = createEllipsoid(a, b, 2, x, y, z); ?on = createPoint(1, 2, 3).q; ?dual = sd(q);",
    "gac": "v = TranslatorX(x)*Rotor(y); ?e = v*Ellipse(a, b)*~v; ?d = *createPoint(x, y, z);",
    "ccga": "?c = *(createPoint(x, y, z) ^ createPoint(a, b, 0)); ?i = I();",
}


@pytest.mark.parametrize("name", LARGE)
def test_code_of_large_algebras_computes_what_evaluation_does(name: str) -> None:
    pytest.importorskip("casadi")
    from motorcade.ga.codegen.programs import compile_script
    from motorcade.ga.codegen.tape import run_tape

    read = parse(f"#pragma algebra {name}\n{LARGE[name]}")
    program = compile_script(read, "large")
    given = {"a": 1.5, "b": 0.5, "x": 0.3, "y": -0.7, "z": 1.1}
    names = [operand.name for operand in program.tape.inputs]
    expected = evaluate(read, **{k: given[k] for k in names})
    rows = run_tape(program.tape, {(k, 0): np.array(given[k]) for k in names})
    for operand, row in zip(program.tape.outputs, rows, strict=True):
        found = dict(zip(operand.components, map(float, row), strict=True))
        for blade, value in expected[operand.name].items():
            assert found.get(blade, 0.0) == pytest.approx(float(value), rel=1e-12, abs=1e-12)


def test_a_table_of_sixteen_dimensions_is_refused() -> None:
    pytest.importorskip("casadi")
    from motorcade.ga.codegen.programs import compile_script
    from motorcade.ga.codegen.strategies import table

    read = parse("#pragma algebra ccga\n?x = createPoint(a, b, 0);")
    with pytest.raises(ValueError, match="at most 10 dimensions, got 16"):
        table.write(read, compile_script(read, "large"), None)


def test_the_package_holds_a_file_for_each_algebra() -> None:
    folder = Path(algebras.__file__).parent
    found = {path.parent.name for path in folder.glob("*/definition.toml")}
    assert found == {definition.names[0] for definition in definitions().values()}
    assert len(found) == 13
