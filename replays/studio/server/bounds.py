"""What one visitor may take: connections, requests under way, messages a second, bytes a message.

Nothing here waits: what is over a bound is refused and its connection closed, so that nobody else
is held up. The page sends one message at a time and stays far below.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    import h11

MAX_MESSAGE_BYTES = 64 << 10
MAX_CONNECTIONS = 96
MAX_CONNECTIONS_AN_ADDRESS = 32
FIRST_REQUEST_WITHIN_S = 10.0
MAX_EDITORS = 8
MESSAGES_A_SECOND = 250.0
MESSAGES_AT_ONCE = 500.0


class BoundedProtocol(H11Protocol):
    """HTTP/1.1 where an address has so many connections, and each begins with a request soon.

    A request's head is bounded by uvicorn (`h11_max_incomplete_event_size`). Its body is never
    read: nothing is sent to this server but the messages of a WebSocket.
    """

    def connection_made(self, transport: Any) -> None:
        """Take a connection, or hang up."""
        super().connection_made(transport)
        others = [one.client for one in self.connections if isinstance(one, BoundedProtocol)]
        of_address = sum(_host(one) == _host(self.client) for one in others)
        if of_address > MAX_CONNECTIONS_AN_ADDRESS or len(self.connections) > MAX_CONNECTIONS:
            transport.abort()
        self._awaited = self.loop.call_later(FIRST_REQUEST_WITHIN_S, transport.abort)

    def handle_events(self) -> None:
        """As uvicorn does; from the first whole request on, its own patience holds."""
        super().handle_events()
        if self.scope is not None:
            self._awaited.cancel()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """As uvicorn does; the connection is no longer one of HTTP."""
        self._awaited.cancel()
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        """As uvicorn does."""
        self._awaited.cancel()
        super().connection_lost(exc)


def _host(client: tuple[str, int] | None) -> str | None:
    return None if client is None else client[0]


@dataclass
class MessageRate:
    """Whether the messages of one connection come too fast (a token bucket).

    Args:
        clock: seconds that only grow.

    >>> from motorcade.replays.studio.server.bounds import MessageRate
    >>> still = MessageRate(clock=lambda: 0.0)
    >>> sum(still.takes() for _ in range(10_000))
    500
    """

    clock: Callable[[], float] = time.monotonic

    def __post_init__(self) -> None:
        self._left, self._seen_s = MESSAGES_AT_ONCE, self.clock()

    def takes(self) -> bool:
        """Whether one more is within the rate."""
        now = self.clock()
        grown = self._left + (now - self._seen_s) * MESSAGES_A_SECOND
        self._left, self._seen_s = min(MESSAGES_AT_ONCE, grown), now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
