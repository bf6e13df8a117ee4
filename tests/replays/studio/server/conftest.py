"""A server on this machine alone, on a port of the system's choice, with a run that echoes."""

import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
import uvicorn

from motorcade.replays.studio.access import Access
from motorcade.replays.studio.app import studio_app
from motorcade.replays.studio.desk import Offer, RunDesk
from motorcade.replays.studio.messages import Answer
from motorcade.replays.studio.serving import Listening, configured, opened

PATIENCE_S = 30.0


@dataclass
class EchoDesk:
    """Answers with what it was sent, and counts it."""

    frames: int = 2
    heard: list[tuple[int, Mapping[str, Any]]] = field(default_factory=list)
    gone: list[int] = field(default_factory=list)
    closed: bool = False

    def about(self) -> dict[str, Any]:
        return {"frames": self.frames}

    def frame(self, index: int) -> bytes:
        return b"frame %d" % index

    def figure(self, number: int) -> bytes | None:
        return b"glTF" if number == 0 else None

    def motion(self, number: int) -> dict[str, Any] | None:
        return {"joints": 1} if number == 0 else None

    def film_state(self) -> dict[str, Any]:
        return {"drawing": False}

    def film(self) -> Path | None:
        return None

    def joined(self, visitor: int) -> Mapping[str, Any]:
        return {"hello": True}

    def answer(self, visitor: int, message: Mapping[str, Any]) -> Answer:
        self.heard.append((visitor, message))
        if message.get("do") == "refuse":
            raise ValueError("this is refused")
        return Answer({"n": message.get("n"), "ok": True}, {"heard": len(self.heard)})

    def left(self, visitor: int) -> Mapping[str, Any] | None:
        self.gone.append(visitor)
        return {"gone": True}

    def close(self) -> None:
        self.closed = True


@dataclass
class Served:
    """A running server."""

    access: Access
    desk: EchoDesk
    port: int
    server: uvicorn.Server

    @property
    def socket(self) -> str:
        """Where the editor's messages go."""
        return f"ws://{self.access.names[0]}/{self.access.token}/run/0/edit"

    @property
    def origin(self) -> str:
        return f"http://{self.access.names[0]}"


@contextmanager
def running(desk: EchoDesk | RunDesk) -> Iterator[tuple[Access, int, uvicorn.Server]]:
    """A server of one run's desk, for as long as the block lasts: its key, its port, itself."""
    listening = Listening()
    with opened(listening) as (listener, access):
        offers = [Offer("table <top>", lambda: desk)]
        server = configured(studio_app(offers, access), listening)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
        thread.start()
        until = time.monotonic() + PATIENCE_S
        while not server.started:
            assert time.monotonic() < until, "the server does not start"
            time.sleep(0.01)
        yield access, listener.getsockname()[1], server
        server.should_exit = True
        thread.join(PATIENCE_S)
        assert not thread.is_alive()


@pytest.fixture
def served() -> Iterator[Served]:
    """A server with one run."""
    desk = EchoDesk()
    with running(desk) as (access, port, server):
        yield Served(access, desk, port, server)
