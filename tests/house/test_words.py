"""Words that the table in CONTRIBUTING.md retires do not come back as parts of names.

Looked at are the names that code defines, arguments and keywords, keys of dictionaries, options of
commands, fields that templates read, and names of files; in C and C++ every identifier. Names count
by their parts: `sharpen` is found in `sharpen_corners` and in `CornerSharpen`, not in `sharpened`.
"""

import ast
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.house.sources import SOURCES, parsed

pytestmark = SOURCES
REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
FOREIGN = {"plumb_bob"}
"""Names that are not ours to choose: of a model of distortion in ROS."""
TEMPLATES, NATIVE = {".html", ".jinja"}, {".c", ".cpp", ".h"}
_IDENTIFIER = re.compile(r"[A-Za-z_]\w*")
_PART = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_NOT_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.S)

if not (REPOSITORY / "CONTRIBUTING.md").exists():
    pytest.skip("no table here: an installed wheel is tested", allow_module_level=True)


def parts(name: str) -> tuple[str, ...]:
    """The words of a snake_case or CamelCase name."""
    return tuple(part.lower() for part in _PART.findall(name))


def retired() -> dict[tuple[str, ...], str]:
    """Words that are retired, and the term that took their place."""
    table = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("| term |")[2]
    found = {}
    for line in table.partition("\n\n")[0].splitlines()[2:]:
        term, _, old = (cell.strip() for cell in line.strip("|").split("|"))
        words = [one.strip() for one in re.sub(r"\(.*?\)", "", old).split(",")]
        found |= {parts(one): term for one in words if one}
    return found


RETIRED = retired()
IN_PROSE = re.compile(
    r"\b(liveliness|plumb|straighten|sharpen|diary|ladders?|spoil(ed)?|holed|ledgers?|grips?"
    r"|film[- ]stills?|pictur(e|es|ed)|sightings?)\b",
    re.I,
)
"""Those that have no other use: comments, docstrings and messages do without them too."""


def comes_back(name: str) -> str | None:
    """The retired word in a name, and what it is called now."""
    words = () if name in FOREIGN else parts(name)
    for old, term in RETIRED.items():
        if any(words[at : at + len(old)] == old for at in range(len(words))):
            return f"{name}: {' '.join(old)} is called {term}"
    return None


def names_of_python(text: str) -> Iterator[tuple[int, str]]:
    """Lines, and the names that stand there."""
    for node in ast.walk(parsed(text)):
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                yield node.lineno, node.name
            case ast.arg():
                yield node.lineno, node.arg
            case ast.keyword(arg=str(name)):
                yield node.value.lineno, name
            case ast.Name(ctx=ast.Store()):
                yield node.lineno, node.id
            case ast.Attribute(ctx=ast.Store()):
                yield node.lineno, node.attr
            case ast.Dict():
                for key in node.keys:
                    if isinstance(key, ast.Constant) and isinstance(key.value, str):
                        yield key.lineno, key.value if key.value.isidentifier() else ""
            case ast.Constant(value=str(text)) if re.fullmatch(r"--[a-z][a-z-]*", text):
                yield node.lineno, text


def names_in(path: Path) -> Iterator[tuple[int, str]]:
    """Lines of a file, and the names that stand there."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        yield from names_of_python(text)
    elif path.suffix in TEMPLATES:
        for number, line in enumerate(text.splitlines(), 1):
            for code in re.findall(r"\{[{%](.*?)[%}]\}", line):
                yield from ((number, name) for name in _IDENTIFIER.findall(code))
    else:
        bare = _NOT_CODE.sub(lambda found: "\n" * found[0].count("\n"), text)
        for number, line in enumerate(bare.splitlines(), 1):
            yield from ((number, name) for name in _IDENTIFIER.findall(line))


def files(room: str) -> list[Path]:
    """What of a room is written by hand."""
    kept = {".py", *TEMPLATES, *NATIVE}
    found = [path for path in (REPOSITORY / room).rglob("*") if path.suffix in kept]
    return sorted(path for path in found if "generated" not in path.parts)


def returned(room: str) -> list[str]:
    """Where retired words stand in a room."""
    faults = []
    for path in files(room):
        place = path.relative_to(REPOSITORY)
        if told := comes_back("_".join(place.with_suffix("").parts)):
            faults.append(f"{place}: {told}")
        found = {(line, told) for line, name in names_in(path) if (told := comes_back(name))}
        faults += [f"{place}:{line}: {told}" for line, told in sorted(found)]
    return faults


@pytest.mark.parametrize("room", ROOMS)
def test_retired_words_do_not_come_back(room: str) -> None:
    faults = returned(room)
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("room", ROOMS)
def test_the_clearest_of_them_do_not_come_back_in_prose(room: str) -> None:
    faults = []
    for path in (path for path in files(room) if path.suffix == ".py"):
        with path.open(encoding="utf-8") as file:
            for token in tokenize.generate_tokens(file.readline):
                if token.type in (tokenize.COMMENT, tokenize.STRING):
                    words = {match[0] for match in IN_PROSE.finditer(token.string)}
                    faults += [f"{path}:{token.start[0]}: {word}" for word in words]
    assert not faults, "\n".join(faults)


def test_the_table_is_read_and_parts_of_names_are_told_apart() -> None:
    assert RETIRED[("whole", "turns")] == "winding count"
    assert RETIRED[("straightened",)] == "undistort, distort"
    assert ("bend",) not in RETIRED
    assert ("carry",) not in RETIRED
    assert comes_back("sharpen_corners") == comes_back("sharpen_corners")
    assert comes_back("CornerSharpen") == "CornerSharpen: sharpen is called refine corners"
    assert comes_back("countWholeTurns") == "countWholeTurns: whole turns is called winding count"
    assert comes_back("accounting") is None
    assert comes_back("whole_half_turns") is None


def test_names_are_found_where_they_stand() -> None:
    text = (
        'def f(calm: int) -> None:\n    self.mount = g(ruler=1)\n    return {"hole": "--diary"}\n'
    )
    names = {name for _, name in names_of_python(text)}
    assert {name for name in names if comes_back(name)} == {
        "calm",
        "mount",
        "ruler",
        "hole",
        "--diary",
    }


if __name__ == "__main__":
    for one in ROOMS:
        print("\n".join(returned(one)))
