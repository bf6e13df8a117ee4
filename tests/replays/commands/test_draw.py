"""`motorcade draw` writes images of scripts, and says in one line what it cannot draw."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from motorcade.replays.cli import main

SCRIPT = ":IPNS;\n:s = VecN3(0, 0, 1) - 0.5*r*r*einf;\n:p = VecN3(cos(t), sin(t), 0);\n?d = 2*r;\n"


@pytest.fixture
def script(tmp_path: Path) -> Path:
    path = tmp_path / "ball.clu"
    path.write_text(SCRIPT)
    return path


def draw(*arguments: object) -> int:
    return main(["draw", *map(str, arguments)])


def test_an_image_of_values_and_lists_of_them(script: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "ball.svg"
    size = ("--size", 400, 300, "--view", 10, 30)
    assert draw(script, "r=0.5", "t=0,1,2", "-o", out, *size) == 0
    root = ET.fromstring(out.read_text())
    assert (root.get("width"), root.get("height")) == ("400", "300")
    dots = [c for c in root.iter("{http://www.w3.org/2000/svg}circle") if c.get("r") == "4"]
    assert len(dots) == 3
    assert draw(script, "r=0.5", "t=0", "-o", tmp_path / "ball.html") == 0
    assert "<script>" in (tmp_path / "ball.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("r=1", "-o", "ball.svg"), "free variables t"),
        (("r=1", "t=0", "u=1", "-o", "ball.svg"), "expected r, t, got also u"),
        (("r=1", "r=2", "t=0", "-o", "ball.svg"), "expected each variable once"),
        (("r=1", "t=0", "-o", "ball.png"), "expected a name that ends in .svg or .html"),
        (("r=1", "t=0", "--size", 10, 10, "-o", "ball.svg"), "expected from 100 to 10000 pixels"),
    ],
)
def test_mistakes_are_told_in_one_line(
    arguments: tuple[object, ...],
    told: str,
    script: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert draw(script, *arguments) == 1
    assert told in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["ball.clu"]


@pytest.mark.parametrize("value", ["r", "r=", "=1", "r=1;2", "r=nan", "r=1,inf"])
def test_a_value_that_is_none_is_bad_usage(
    value: str, script: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        draw(script, value, "-o", "ball.svg")
    assert stopped.value.code == 2
    assert "expected NAME=VALUE or NAME=VALUE,…, got" in capsys.readouterr().err


def test_what_is_left_out_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "two.clu"
    path.write_text("?s = SphereN3(0, 0, 0, 1); ?d = 2;")
    assert draw(path, "-o", tmp_path / "two.svg") == 0
    assert "d is not drawn: it is the number 2" in capsys.readouterr().err
