"""From a script's file to code: which files are read, which wishes are refused and how."""

from pathlib import Path

import pytest

from motorcade.ga.codegen.generate import STRATEGIES, generate, read_script
from motorcade.ga.script.syntax import MAX_SCRIPT_CHARACTERS

pytest.importorskip("casadi")
TEXT = "?y = a*b;"


@pytest.fixture
def script(tmp_path: Path) -> Path:
    path = tmp_path / "product.clu"
    path.write_text(TEXT, encoding="utf-8")
    return path


@pytest.mark.parametrize("strategy", ["program", *STRATEGIES])
def test_a_script_becomes_files_that_bear_its_name(script: Path, strategy: str) -> None:
    made = generate(script, strategy=strategy)
    assert any("product" in name for name in made.files)
    assert made.program.name == "product"
    assert "float" in "".join(
        generate(script, strategy=strategy, precision="float32").files.values()
    )


def test_the_algebra_counts_where_the_script_names_none(script: Path) -> None:
    script.write_text("?y = e1*e2*e3*e0;", encoding="utf-8")
    assert generate(script, algebra="pga3").files != generate(script).files
    with pytest.raises(ValueError, match="algebra: expected 2d, ega2"):
        generate(script, algebra="pga4")


@pytest.mark.parametrize(
    ("wishes", "message"),
    [
        ({"target": "pascal"}, r"target: expected c, .*, got 'pascal'"),
        (
            {"strategy": "none"},
            r"strategy: expected program, table, table-code, product, got 'none'",
        ),
        ({"target": "numpy", "strategy": "table"}, "target numpy: expected the strategy program"),
        ({"precision": "float16"}, r"precision: expected float32, float64, got 'float16'"),
    ],
)
def test_wishes_that_nothing_meets_are_refused(
    script: Path, wishes: dict[str, str], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        generate(script, **wishes)


def test_file_names_that_are_no_identifiers_are_refused(script: Path) -> None:
    moved = script.rename(script.with_name("a product.clu"))
    with pytest.raises(ValueError, match=r"expected a file name that is an identifier.*\.clu"):
        generate(moved)


def test_files_are_utf_8_with_or_without_a_mark_and_not_endless(tmp_path: Path) -> None:
    path = tmp_path / "text.clu"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.encode())
    assert len(read_script(path).statements) == 1
    path.write_bytes(b"// \xff\n?y = 1;")
    with pytest.raises(ValueError, match=r"expected UTF-8 text, got the byte 0xff at offset 3"):
        read_script(path)
    path.write_bytes(b"\n" * (4 * MAX_SCRIPT_CHARACTERS + 1))
    with pytest.raises(ValueError, match=rf"at most {4 * MAX_SCRIPT_CHARACTERS} bytes"):
        read_script(path)
