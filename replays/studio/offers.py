"""The runs that are offered for editing, each opened when the first browser asks for it."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException

log = logging.getLogger("motorcade.studio")


@dataclass(frozen=True)
class Answer:
    """What a message leads to.

    Args:
        reply: to whoever sent it.
        news: to all others; None where nothing changed for them.
    """

    reply: Mapping[str, Any]
    news: Mapping[str, Any] | None = None


class Desk(Protocol):
    """A run whose scene is being edited: `joined`, `answer` and `left` by one thread at a time."""

    @property
    def frames(self) -> int:
        """How many images the footage has."""

    def about(self) -> dict[str, Any]:
        """What there is, for the page, as JSON."""

    def frame(self, index: int) -> bytes:
        """An image as JPEG."""

    def figure(self, number: int) -> bytes | None:
        """What is drawn of an object, as `.glb`; None where there is no such number."""

    def motion(self, number: int) -> dict[str, Any] | None:
        """What the joints of an object do, as JSON; None where there is no such number."""

    def film_state(self) -> Mapping[str, Any]:
        """How far the film is that is being drawn, as JSON."""

    def film(self) -> Path | None:
        """The film that was drawn last; None without."""

    def joined(self, visitor: int) -> Mapping[str, Any]:
        """What a browser is told when it comes."""

    def answer(self, visitor: int, message: Mapping[str, Any]) -> Answer:
        """Do what a browser asks for."""

    def left(self, visitor: int) -> Mapping[str, Any] | None:
        """A browser is gone: what it held is let go; news to all others."""

    def close(self) -> None:
        """The server ends: what is kept is written; raises `OSError` where it cannot be."""


@dataclass(frozen=True)
class Offer:
    """A run on the start page.

    Args:
        open: reads it; may take seconds.
        summary: a line on what is in it.
    """

    name: str
    open: Callable[[], Desk]
    summary: str = ""


@dataclass
class OpenedOffers:
    """Offers, and the desks of those that were opened."""

    offers: Sequence[Offer]
    _opening: dict[int, asyncio.Task[Desk]] = field(default_factory=dict)

    async def desk(self, run: int) -> Desk:
        """The desk of a run, opened once for everybody.

        Raises:
            HTTPException: 404 where there is no such run, 503 where it cannot be opened.
        """
        if not 0 <= run < len(self.offers):
            raise HTTPException(404)
        if run not in self._opening:
            opening = run_in_threadpool(self.offers[run].open)
            self._opening[run] = asyncio.ensure_future(opening)
        try:
            return await asyncio.shield(self._opening[run])
        except (ValueError, OSError, RuntimeError) as fault:
            self._opening.pop(run, None)  # it may be there the next time
            raise HTTPException(503, " ".join(str(fault).split())) from fault

    async def close(self) -> None:
        """Close the desks that were opened."""
        for run, opening in self._opening.items():
            try:
                await run_in_threadpool((await opening).close)
            except (ValueError, OSError, RuntimeError) as fault:
                log.warning("%s: %s", self.offers[run].name, fault)
