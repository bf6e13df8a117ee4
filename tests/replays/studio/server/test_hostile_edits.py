"""What a browser may send to get round a check, and scenes that the page itself would not make."""

import json
from pathlib import Path

import pytest

from motorcade.replays.pipeline.look import gltf_bytes
from motorcade.replays.stages.view.acting import mannequin
from motorcade.replays.studio import desk as server_desk
from tests.replays.studio.server.stage import Visitor, desk, filmed


@pytest.fixture
def one(tmp_path: Path) -> Visitor:
    run = tmp_path / "run"
    run.mkdir()
    return Visitor(desk(run))


def together(*lines: dict[str, object]) -> dict[str, object]:
    return {"do": "together", "gestures": list(lines)}


def test_files_that_are_not_on_offer_come_in_by_no_way(one: Visitor, tmp_path: Path) -> None:
    (tmp_path / "secret.glb").write_bytes(gltf_bytes(mannequin()))
    who = one.put()
    add = {"do": "add", "object": {"name": "x", "kind": "prop", "file": "../secret.glb"}}
    change = {"do": "set", "object": who, "file": "../secret.glb"}
    for edit in (add, change, together(add), together(change), together(together(add))):
        assert not one.ask("edit", edit=edit)["ok"], edit
    for file in (["../secret.glb"], {"file": 1}, 1.5, True):
        assert not one.ask("edit", edit={"do": "set", "object": who, "file": file})["ok"]


def test_what_another_holds_is_changed_by_no_way(one: Visitor) -> None:
    who, other = one.put(), Visitor(one.at, 2)
    other.done("begin", object=who, gesture="turn")
    remove = {"do": "remove", "object": who}
    for edit in (remove, together(remove), {"do": "undo"}, together({"do": "undo"})):
        assert not one.ask("edit", edit=edit)["ok"], edit
    other.done("drag", amount=0.5)
    other.done("end")


def test_steps_and_places_of_anchors_are_no_edits(one: Visitor) -> None:
    one.put()
    version = one.done("place", file="mannequin")["version"]
    for edit in (
        {"do": "undo"},
        {"do": "anchors", "world_T_anchor": {}},
        together(),
        together("x"),
    ):
        assert "edit" in str(one.ask("edit", edit=edit)["error"])
    assert one.done("place", file="mannequin")["version"] == version + 1


def test_somebody_comes_into_a_scene_that_hangs_on_nothing(tmp_path: Path) -> None:
    (tmp_path / "scene.json").write_text('{"objects": [{"name": "ground"}]}')
    one = Visitor(desk(tmp_path))
    placed = one.put()
    scene = one.at.session.history.scene
    assert scene.parents[placed] == "ground 2"
    assert scene.anchors["ground 2"] == one.at.filmed.first
    one.done("undo")
    assert not one.at.session.history.scene.anchors


def test_a_file_that_cannot_be_read_is_left_out_alone(tmp_path: Path) -> None:
    (tmp_path / "junk.glb").write_bytes(b"no model")
    (tmp_path / "doll.glb").write_bytes(gltf_bytes(mannequin()))
    one = Visitor(desk(tmp_path))
    assert [each["file"] for each in one.at.about()["wardrobe"]] == ["mannequin", "doll.glb"]
    assert not one.ask("place", file="junk.glb")["ok"]


def test_a_scene_that_cannot_be_shown_is_refused_when_it_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server_desk, "open_filmed", lambda _: filmed())
    scene = {"objects": [{"name": "guide", "kind": "character", "file": "gone.glb"}]}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    with pytest.raises(ValueError, match=r"gone\.glb"):
        server_desk.open_desk(tmp_path)
