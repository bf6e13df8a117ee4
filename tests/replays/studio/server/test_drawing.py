"""The film drawn from the page: one at a time, with how far it is, and ended with the server."""

import http.client
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from motorcade.animation.authoring import Scene, scene_of
from motorcade.replays.studio import desk as desk_module
from motorcade.replays.studio.desk import FilmDrawing
from tests.replays.studio.server.conftest import running
from tests.replays.studio.server.stage import Visitor, desk

SOMEBODY = scene_of({"objects": [{"name": "a", "kind": "character", "file": "mannequin"}]}, "")
DRAWS = """
import pathlib, sys, time
folder = pathlib.Path(sys.argv[1])
print("drawing: 12 of 48, 25 %, 0:05 left", file=sys.stderr, flush=True)
while not (folder / "go").exists():
    time.sleep(0.01)
if (folder / "fail").exists():
    sys.exit("motorcade: the disk is full")
(folder / "overlay.mp4").write_bytes(b"0123456789")
"""


@pytest.fixture
def film(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FilmDrawing:
    """What writes ten bytes as a film once it may."""
    monkeypatch.setattr(desk_module, "_START", DRAWS)
    made = FilmDrawing(["motorcade", str(tmp_path)], tmp_path)
    yield made
    made.stop(wait=True)


def until(film: FilmDrawing, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    end = time.monotonic() + 30.0
    while not holds(state := film.state(SOMEBODY)):
        assert time.monotonic() < end, state
        time.sleep(0.01)
    return state


def test_the_page_is_told_how_far_the_film_is(film: FilmDrawing, tmp_path: Path) -> None:
    film.start(SOMEBODY)
    state = until(film, lambda state: state["share"] is not None)
    assert (state["drawing"], state["share"], state["film"]) == (True, 0.25, None)
    with pytest.raises(ValueError, match="being drawn already"):
        FilmDrawing(film.words, tmp_path).start(SOMEBODY)
    (tmp_path / "go").touch()
    state = until(film, lambda state: not state["drawing"])
    assert state["failed"] is None
    assert state["film"]
    assert not state["stale"]
    assert film.state(Scene({}, {}))["stale"]


def test_why_a_film_is_not_drawn_is_told(film: FilmDrawing, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="Nobody is in the scene"):
        film.start(Scene({}, {}))
    (tmp_path / "fail").touch()
    (tmp_path / "go").touch()
    film.start(SOMEBODY)
    assert until(film, lambda state: not state["drawing"])["failed"] == "the disk is full"
    (tmp_path / "go").unlink()
    film.start(SOMEBODY)
    film.stop()
    assert until(film, lambda state: not state["drawing"])["failed"] == "It was stopped."


def test_a_film_is_started_by_the_page_and_fetched_in_pieces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    at = desk(tmp_path)
    visitor = Visitor(at)
    assert visitor.ask("film")["error"] == "Nobody is in the scene yet."
    visitor.put()
    out = tmp_path / "scene-film"
    out.mkdir()
    monkeypatch.setattr(desk_module, "_START", DRAWS)
    at.drawing.words = ["motorcade", str(out)]
    (out / "go").touch()
    told = visitor.done("film")
    assert told["film"]["drawing"] is True
    assert (tmp_path / "scene.json").is_file()
    until(at.drawing, lambda state: not state["drawing"])
    with running(at) as (access, port, _):
        asked = http.client.HTTPConnection("127.0.0.1", port)
        at_run, host = f"/{access.token}/run/0", {"Host": access.names[0]}
        asked.request("GET", f"{at_run}/film.json", headers=host)
        assert json.loads(asked.getresponse().read())["drawing"] is False
        asked.request("GET", f"{at_run}/film.mp4", headers={**host, "Range": "bytes=2-4"})
        answer = asked.getresponse()
        assert (answer.status, answer.read()) == (206, b"234")
        assert "media-src 'self'" in str(answer.headers["content-security-policy"])
        asked.close()


def test_the_command_draws_into_the_footage_of_the_run(tmp_path: Path) -> None:
    words = desk(tmp_path).drawing.words
    assert words[words.index("--until") + 1] == "overlay"
    assert words[words.index("--scene") + 1] == str(tmp_path / "scene.json")
