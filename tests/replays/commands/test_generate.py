"""`motorcade generate` writes code that works, and says in one line what it cannot read."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from motorcade.ga.codegen.targets import TARGETS
from motorcade.replays.cli import main
from motorcade.replays.cli.tools import TARGET_NAMES

pytest.importorskip("casadi", reason="CasADi, which only code generation needs, is missing")

SUFFIXES = {
    "c": ".c", "c-batch": ".c", "glsl": ".glsl", "cpp": ".hpp", "rust": ".rs", "javascript": ".mjs",
    "wgsl": ".wgsl", "julia": ".jl", "latex": ".tex",
}  # fmt: skip
SCRIPT = "R = RotorN3(0, 0, 1, angle);\n?p = R * createPoint(x, y, z) * ~R;\n?q = 2*p;\n"


@pytest.fixture
def script(tmp_path: Path) -> Path:
    path = tmp_path / "orbit.clu"
    path.write_text(SCRIPT)
    return path


def generate(*arguments: object) -> int:
    return main(["generate", *map(str, arguments)])


def test_the_command_offers_the_targets_there_are() -> None:
    assert list(TARGETS) == list(TARGET_NAMES)


@pytest.mark.parametrize("target", TARGET_NAMES)
def test_what_is_printed_is_what_is_written(
    target: str, script: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert generate(script, "--target", target) == 0
    told = capsys.readouterr()
    assert told.err == ""
    suffix = SUFFIXES.get(target, ".py")
    out = tmp_path / "new" / f"code{suffix}"
    assert generate(script, "--target", target, "-o", out) == 0
    assert out.read_text() == told.out
    beside = {path.name for path in out.parent.iterdir()} - {out.name}
    assert beside == ({"code.h"} if suffix == ".c" else set())


def test_the_numpy_module_turns_a_point(script: Path, tmp_path: Path) -> None:
    assert generate(script, "--target", "numpy", "-o", tmp_path / "orbit.py") == 0
    use = (
        "import json, math, orbit; made = orbit.orbit(angle=math.pi / 2, x=1, y=0, z=0)\n"
        "print(json.dumps({'outputs': list(made), 'y': made['p']['e2']}))"
    )
    told = subprocess.run(
        [sys.executable, "-c", use], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout
    assert json.loads(told) == {"outputs": ["p", "q"], "y": pytest.approx(1.0)}


@pytest.mark.parametrize("strategy", ["table", "table-code", "product"])
def test_other_strategies_write_the_same_function(
    strategy: str, script: Path, tmp_path: Path
) -> None:
    for each in ("program", strategy):
        assert generate(script, "--strategy", each, "-o", tmp_path / f"{each}.c") == 0
    declared = [
        re.findall(r"^void orbit\([^)]*\);", (tmp_path / f"{each}.h").read_text(), re.MULTILINE)
        for each in ("program", strategy)
    ]
    assert len(declared[0]) == 1
    assert declared[0] == declared[1]


def test_the_passes_are_told_on_stderr(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert generate(script, "--stats") == 0
    told = capsys.readouterr()
    assert told.err.splitlines()[0].split() == ["pass", "add", "mul", "div", "func", "ms"]
    assert told.out.startswith("/*")


def test_an_error_of_the_script_is_shown_at_its_place(
    script: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script.write_text("?a = x*e1;\n?b = (x + ;\n")
    assert generate(script) == 1
    assert capsys.readouterr().err.splitlines()[:3] == [
        f"motorcade: {script}:2:11: expected an expression, got ';'",
        "    ?b = (x + ;",
        "              ^",
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--precision", "float32", "--target", "casadi"], "expected precision float64"),
        (["--precision", "float64", "--target", "glsl"], "expected precision float32"),
        (
            ["--strategy", "table", "--target", "numpy"],
            "target numpy: expected the strategy program, got table",
        ),
        (
            ["--algebra", "cga9"],
            "sta or a signature P Q R, got 'cga9'; a definition of one's own is a file",
        ),
        (["--algebra", "9 9 0"], "got 18"),
        (["-o", "code.h"], "-o code.h: expected a name that ends in .c"),
        (["-o", "."], "-o .: expected a name that ends in .c"),
    ],
)
def test_what_a_target_lacks_is_refused(
    arguments: list[str], message: str, script: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert generate(script, *arguments) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert message in told.err


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("my-orbit.clu", b"?a = x;", "rename it to my_orbit.clu"),
        ("2d.clu", b"?a = x;", "rename it to script_2d.clu"),
        ("orbit.clu", b"a = x;", "expected a script with outputs, got none: mark them with ?"),
        ("orbit.clu", b"?a = x; // \xff", "expected UTF-8 text, got the byte 0xff at offset 11"),
        ("orbit.clu", b" " * 4_000_001, "expected at most 4000000 bytes"),
        ("main.clu", b"?a = x;", "main is reserved in C or C++: rename main to main_"),
    ],
)
def test_scripts_that_give_no_code_are_refused(
    name: str, content: bytes, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(content)
    assert generate(tmp_path / name, "-o", tmp_path / "code.c") == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert message in told
    assert not (tmp_path / "code.c").exists()


def test_files_that_cannot_be_read_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert generate(tmp_path / "gone.clu") == 1
    assert "gone.clu: the file is missing" in capsys.readouterr().err
    (tmp_path / "folder").mkdir()
    assert generate(tmp_path / "folder") == 1
    assert "folder: expected a file, got a folder" in capsys.readouterr().err


def test_bad_usage_has_its_own_status(script: Path) -> None:
    for arguments in (["--target", "fortran"], ["--precision", "half"], ["--strategy", "magic"]):
        with pytest.raises(SystemExit, match="2"):
            generate(script, *arguments)


@pytest.mark.parametrize("strategy", ["program", "table", "table-code", "product"])
def test_code_is_written_without_casadi(
    strategy: str, script: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "casadi", None)
    assert generate(script, "--strategy", strategy) == 0
    assert "void orbit(" in capsys.readouterr().out


@pytest.mark.parametrize(("algebra", "square"), [("pga2", "0"), ("1 2 0", "-1"), ("cga3", "1")])
def test_the_algebra_can_be_named_or_counted_out(
    algebra: str, square: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "squared.clu"
    path.write_text(f"?s = x*{'e0*e0' if algebra == 'pga2' else 'e3*e3'} + y;")
    assert generate(path, "--target", "numpy", "--algebra", algebra) == 0
    made: dict[str, object] = {}
    exec(capsys.readouterr().out, made)
    squared = made["squared"]
    assert callable(squared)
    assert squared(x=1.0, y=0.0)["s"].get("1", 0.0) == float(square)


@pytest.mark.parametrize("strategy", ["program", "table", "product"])
def test_the_algebra_can_be_a_file(
    strategy: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "algebras"
    folder.mkdir()
    (folder / "mine.toml").write_text('squares = { t = 1, x = -1 }\nmacros = "mine.clu"\n')
    (folder / "mine.clu").write_text("boost = { exp(_P(1)/2 * x^t) }")
    path = tmp_path / "moved.clu"
    path.write_text("?v = boost(a)*t*~boost(a);")
    assert generate(path, "--algebra", folder / "mine.toml", "--strategy", strategy) == 0
    assert "moved(" in capsys.readouterr().out
    (folder / "mine.toml").write_text("squares = { t = 3 }")
    assert generate(path, "--algebra", folder / "mine.toml") == 1
    message = capsys.readouterr().err
    assert "mine.toml: Algebra.of(squares): expected 1, -1 or 0 for t, got 3" in message


def test_the_script_is_not_written_over(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert generate(script, "--target", "numpy", "-o", script) == 1
    assert "expected another file than the script itself" in capsys.readouterr().err
    assert script.read_text() == SCRIPT


@pytest.mark.parametrize(
    ("text", "target", "told"),
    [
        (
            "?a = e1 +\n  2*int;",
            "c",
            "kept.clu:2:5: variable int is reserved in C or C++: rename int to int_",
        ),
        ("if (x) { a = fn; } else { a = 2; }\n?a;", "rust", "kept.clu:1:14: variable fn is"),
        ("#pragma return in2\nin2 = await*e1;", "javascript", "kept.clu:2:7: variable await is"),
    ],
)
def test_a_name_that_a_language_keeps_has_its_place(
    text: str, target: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "kept.clu").write_text(text)
    assert generate(tmp_path / "kept.clu", "--target", target) == 1
    assert told in capsys.readouterr().err
