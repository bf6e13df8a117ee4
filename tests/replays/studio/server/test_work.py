"""What one browser asks for costs others little: edits off the event loop, differences, budgets."""

import http.client
import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from websockets.sync.client import connect

from motorcade.replays.studio.access import WORK_FREE_S, WORK_SHARE, MessageRate
from motorcade.replays.studio.messages import Answer
from tests.replays.studio.server.conftest import EchoDesk, running
from tests.replays.studio.server.stage import Visitor, desk, stands

SLOW_S = 0.6


class SlowDesk(EchoDesk):
    """Thinks about what it is asked for, without letting go of the interpreter."""

    def answer(self, visitor: int, message: Mapping[str, Any]) -> Answer:
        until = time.perf_counter() + (SLOW_S if message.get("do") == "think" else 0.0)
        while time.perf_counter() < until:
            pass
        return super().answer(visitor, message)


def test_an_edit_holds_up_no_other_request() -> None:
    with running(SlowDesk()) as (access, port, _):
        address = f"ws://{access.names[0]}/{access.token}/run/0/edit"
        with connect(address, origin=f"http://{access.names[0]}") as socket:
            socket.recv()
            socket.send(json.dumps({"n": 1, "do": "think"}))
            time.sleep(0.1)
            began = time.perf_counter()
            asked = http.client.HTTPConnection("127.0.0.1", port)
            image = f"/{access.token}/run/0/frame/0.jpg"
            asked.request("GET", image, headers={"Host": access.names[0]})
            assert asked.getresponse().status == 200
            asked.close()
            assert time.perf_counter() - began < 0.6 * SLOW_S
            assert json.loads(socket.recv())["n"] == 1


def test_work_beyond_the_budget_is_worked_off() -> None:
    now = [0.0]
    budget = MessageRate(lambda: now[0], WORK_SHARE, WORK_FREE_S)
    for _ in range(40):
        budget.spend(0.5)
        now[0] += budget.owed_s()
    assert now[0] == pytest.approx((20.0 - 1.0) / WORK_SHARE)
    now[0] += 100.0
    assert budget.owed_s() == 0.0


def test_a_change_is_told_alone(tmp_path: Path) -> None:
    at = desk(tmp_path)
    first, other = Visitor(at), Visitor(at, 2)
    names = [first.put() for _ in range(30)]
    told = first.done("edit", edit={"do": "set", "object": names[7], "position_m": [0.1, 0, 0]})
    assert [one["name"] for one in told["scene"]["objects"]] == [names[7]]
    assert "names" not in told["scene"]
    assert len(json.dumps(told)) < 2000
    assert first.news == {key: told[key] for key in ("scene", "holds", "version")}
    told = other.done("edit", edit={"do": "remove", "object": names[3]})
    assert told["scene"]["names"] == [name for name in names if name != names[3]]
    assert told["scene"]["objects"] == []
    told = other.done("undo")
    assert [one["name"] for one in told["scene"]["objects"]] == [names[3]]
    assert told["scene"]["names"] == names


def test_what_hangs_on_a_changed_object_is_told_too(tmp_path: Path) -> None:
    visitor = Visitor(desk(tmp_path))
    below, above, apart = visitor.put(), visitor.put(), visitor.put()
    visitor.done("hang", object=below, on=above, frame=0)
    told = visitor.done("edit", edit={"do": "set", "object": above, "position_m": [0.1, 0.1, 0.0]})
    assert {one["name"] for one in told["scene"]["objects"]} == {below, above}
    assert all("track" in one for one in told["scene"]["objects"])
    assert apart in visitor.at.session.history.scene.parents
    assert np.isfinite(stands(visitor.at, below, 0).translation_m).all()


def test_a_far_way_is_refused_before_it_is_walked(tmp_path: Path) -> None:
    visitor = Visitor(desk(tmp_path))
    name = visitor.put()
    way = (1e6 * np.random.default_rng(0).normal(size=(1000, 2))).round(1)
    line = {"do": "set", "object": name, "walk": {"path_m": way.tolist()}}
    began = time.process_time()
    refused = visitor.ask("edit", edit=line)
    assert time.process_time() - began < 0.2  # 2 s when it was curved first
    assert not refused["ok"]
    assert "done within 600 s" in str(refused["error"])
