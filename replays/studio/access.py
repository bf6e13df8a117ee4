"""Who may come in: a token in the link, this server's own names, and no page but its own.

Whoever can open a port on this machine or in its network can try it, and so can every page that
runs in a browser here. So each request must

* carry the token as the first part of its path, compared in constant time: the link is the key;
* name this server in `Host`, so that no name of a stranger's can be bound to our address;
* come from our own page where it says where it comes from (`Origin`, `Sec-Fetch-Site`): a browser
  always says so for a WebSocket, and there it is required.

What is refused learns no more than that: 403 and no word on which of these failed.

What one visitor may take: connections, requests under way, messages a second, bytes a message.

Nothing here waits: what is over a bound is refused and its connection closed, so that nobody else
is held up. The page sends one message at a time and stays far below.
"""

from __future__ import annotations

import hmac
import secrets
import time
from collections.abc import Callable, MutableMapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    import h11
    from starlette.types import ASGIApp, Receive, Scope, Send


TOKEN_BYTES = 16
HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self' 'nonce-{nonce}'; style-src 'self'; "
        "img-src 'self' data: blob:; media-src 'self'; connect-src 'self' blob: {sockets}; "
        "manifest-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
    "cache-control": "no-store",
}
"""Of every answer; one that may be kept says so itself."""


@dataclass(frozen=True)
class Access:
    """The key to a server and the names that it goes by.

    Args:
        names: `host:port`, as browsers write them in `Host`.
        secure: whether it is served by https.
        token: the key; letters that a link may hold.

    >>> from motorcade.replays.studio.access import Access
    >>> access = Access(("127.0.0.1:8000",), token="k3y")
    >>> access.link()
    'http://127.0.0.1:8000/k3y/'
    >>> access.admits("/k3y/edit", {"host": "127.0.0.1:8000"})
    True
    >>> access.admits("/k3y/edit", {"host": "stranger.example:8000"})
    False
    """

    names: tuple[str, ...]
    secure: bool = False
    token: str = field(default_factory=lambda: secrets.token_urlsafe(TOKEN_BYTES), repr=False)

    def link(self, name: str | None = None) -> str:
        """The address to open, of the first name or another."""
        return f"{'https' if self.secure else 'http'}://{name or self.names[0]}/{self.token}/"

    def admits(self, path: str, headers: dict[str, str], *, by_socket: bool = False) -> bool:
        """Whether a request may go on.

        Args:
            path: as asked for, with the token.
            headers: by their names in lower case.
            by_socket: whether a WebSocket is to be opened.
        """
        secret = path[1:].partition("/")[0].encode("utf-8", "surrogateescape")
        known = hmac.compare_digest(secret, self.token.encode())
        return known and headers.get("host") in self.names and self._is_ours(headers, by_socket)

    def _is_ours(self, headers: dict[str, str], by_socket: bool) -> bool:
        origin = headers.get("origin")
        if origin is not None or by_socket:
            scheme = "https" if self.secure else "http"
            return origin in {f"{scheme}://{name}" for name in self.names}
        # The one thing that may come from outside is a link that was followed.
        followed = headers.get("sec-fetch-mode") == "navigate"
        followed &= headers.get("sec-fetch-dest") == "document"
        return followed or headers.get("sec-fetch-site", "none") in ("none", "same-origin")


class Doorkeeper:
    """Lets requests through to an app that `Access` admits, with the token taken off their path."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve or refuse one request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        by_socket = scope["type"] == "websocket"
        headers: dict[str, str] = {}
        twice = False
        for name, value in scope["headers"]:
            key = name.decode("latin-1").lower()
            twice |= key in headers and key in ("host", "origin")
            headers[key] = value.decode("latin-1")
        if twice or not self._access.admits(scope["path"], headers, by_socket=by_socket):
            await _refuse(send, by_socket)
            return
        nonce = secrets.token_urlsafe(12)
        token = f"/{self._access.token}"
        inside = dict(scope) | {
            "root_path": token,
            "nonce": nonce,
            "access": self._access,
        }
        sockets = f"{'wss' if self._access.secure else 'ws'}://{headers['host']}"

        async def send_with_headers(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                present = {name.lower() for name, _ in message["headers"]}
                message["headers"] = list(message["headers"]) + [
                    (name.encode(), text.format(nonce=nonce, sockets=sockets).encode())
                    for name, text in HEADERS.items()
                    if name.encode() not in present
                ]
            await send(message)

        await self._app(inside, receive, send_with_headers)


async def _refuse(send: Send, by_socket: bool) -> None:
    if by_socket:  # before it was accepted: the browser sees 403
        await send({"type": "websocket.close", "code": 1008, "reason": ""})
        return
    plain = [(b"content-type", b"text/plain"), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": 403, "headers": plain})
    await send({"type": "http.response.body", "body": b"This is not the right link.\n"})


MAX_MESSAGE_BYTES = 64 << 10
MAX_CONNECTIONS = 96
MAX_CONNECTIONS_AN_ADDRESS = 32
FIRST_REQUEST_WITHIN_S = 10.0
MAX_EDITORS = 8
MESSAGES_A_SECOND = 250.0
MESSAGES_AT_ONCE = 500.0
WORK_FREE_S, WORK_SHARE = 1.0, 0.5
"""A second of a connection's work is free; beyond, its next message waits until it is worked off at
half a second a second, so that others have room."""


class BoundedProtocol(H11Protocol):
    """HTTP/1.1 where an address has so many connections, and each begins with a request soon.

    A request's head is bounded by uvicorn (`h11_max_incomplete_event_size`). Its body is never
    read: nothing is sent to this server but the messages of a WebSocket.
    """

    def connection_made(self, transport: Any) -> None:
        """Take a connection, or hang up."""
        super().connection_made(transport)
        others = [one.client for one in self.connections if isinstance(one, BoundedProtocol)]
        of_address = sum((client or ())[:1] == (self.client or ())[:1] for client in others)
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


@dataclass
class MessageRate:
    """Whether the messages of one connection come too fast, or take too long (a token bucket).

    Args:
        clock: seconds that only grow.
        a_second, at_once: how many (or how much) are taken in the long run, and of a burst.

    >>> from motorcade.replays.studio.access import MessageRate
    >>> still = MessageRate(clock=lambda: 0.0)
    >>> sum(still.takes() for _ in range(10_000))
    500
    >>> still.spend(250.0)
    >>> still.owed_s()
    1.0
    """

    clock: Callable[[], float] = time.monotonic
    a_second: float = MESSAGES_A_SECOND
    at_once: float = MESSAGES_AT_ONCE

    def __post_init__(self) -> None:
        self._left, self._seen_s = self.at_once, self.clock()

    def takes(self, count: int = 1) -> bool:
        """Whether so many more are within the rate."""
        self.spend(0.0)
        if self._left < count:
            return False
        self._left -= count
        return True

    def spend(self, much: float) -> None:
        """Take so much, whether it is there or not."""
        now = self.clock()
        grown = self._left + (now - self._seen_s) * self.a_second
        self._left, self._seen_s = min(self.at_once, grown) - much, now

    def owed_s(self) -> float:
        """Seconds until what was spent beyond is worked off."""
        self.spend(0.0)
        return max(0.0, -self._left) / self.a_second
