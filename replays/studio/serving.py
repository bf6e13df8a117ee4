"""The open port: where it listens, the link to it, and the server that runs until it is stopped.

This is the one place in the program that opens a port (SECURITY.md).
"""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import ssl
import sys
import webbrowser
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from motorcade.replays.io.files import admit_file
from motorcade.replays.studio.access import MAX_MESSAGE_BYTES, Access

if TYPE_CHECKING:
    import uvicorn
    from starlette.types import ASGIApp

LOOPBACK = "127.0.0.1"
PEM_LIMIT = 256 << 10
# The block for documentation: a datagram socket that is "connected" there sends nothing, but the
# system says which of its own addresses it would send from.
_NOWHERE = ("192.0.2.1", 9)


@dataclass(frozen=True)
class Listening:
    """Where to listen.

    Args:
        lan: whether other machines of the network may ask; else this one alone.
        port: 0 for any that is free.
        tls: files of a certificate and its key, PEM; None for plain http.

    Raises:
        ValueError: a port that is none.
    """

    lan: bool = False
    port: int = 0
    tls: tuple[Path, Path] | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.port < 1 << 16:
            raise ValueError(f"Listening.port: expected 0 to 65535, got {self.port}")


@contextlib.contextmanager
def opened(listening: Listening) -> Iterator[tuple[socket.socket, Access]]:
    """An open port and the key to it, for as long as the block lasts.

    Raises OSError: the port is taken, or the machine is in no network.
    """
    host = address_in_network() if listening.lan else LOOPBACK
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, listening.port))
        except OSError as fault:
            raise OSError(
                f"{host}:{listening.port}: cannot listen there ({fault.strerror}); "
                "choose another --port"
            ) from fault
        listener.listen()  # a browser that is quicker than the server waits
        port = listener.getsockname()[1]
        names: tuple[str, ...] = (f"{host}:{port}",)
        if not listening.lan:
            names += (f"localhost:{port}",)
        if port == (443 if listening.tls else 80):  # browsers leave out a scheme's own port
            names += tuple(name.rpartition(":")[0] for name in names)
        yield listener, Access(names, listening.tls is not None)


def address_in_network() -> str:
    """The address by which others in the network reach this machine.

    Raises OSError: it is in no network.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_NOWHERE)
            address = str(probe.getsockname()[0])
        except OSError as fault:
            raise OSError(f"--lan: this machine is in no network ({fault.strerror})") from fault
    if ipaddress.ip_address(address).is_unspecified:
        raise OSError("--lan: this machine is in no network")
    return address


@dataclass(frozen=True)
class Notice:
    """What is said beside the link: what whoever has it may do, and how to stop."""

    may: str = "edit"
    closing: str = "Everything is kept as you go; stop with Ctrl-C."
    fingerprint: str | None = None


def announce(access: Access, listening: Listening, out: TextIO, notice: Notice = Notice()) -> None:
    """Say where to look: the link, for phones its QR code, and what plain http gives away."""
    print(f"Open {access.link()}", file=out)
    if listening.lan:
        import segno

        print(file=out)
        segno.make(access.link(), error="m").terminal(out, compact=True)
        print(
            f"\nScan it with a phone in the same network. Whoever has the link may {notice.may}.",
            file=out,
        )
        if notice.fingerprint is not None:
            print(
                "The certificate was made just now, so browsers warn of it. Go on where they show "
                f"this SHA-256 fingerprint:\n{notice.fingerprint}",
                file=out,
            )
        if listening.tls is None:
            print(
                "This is plain http: others in the network can read the link and what you do. "
                "Where you do not trust them, use --tls CERT KEY.",
                file=out,
            )
    print(notice.closing, file=out, flush=True)


def serve(
    app: Callable[[Access], ASGIApp],
    listening: Listening,
    *,
    open_browser: bool = True,
    out: TextIO | None = None,
    notice: Notice = Notice(),
    max_message_bytes: int = MAX_MESSAGE_BYTES,
) -> None:
    """Serve an app until it is interrupted.

    Args:
        app: makes it, of the key that it is reached by.
        listening: where.
        open_browser: whether to open the page here.
        out: where the link is printed; the terminal unless told.
        notice: what is said beside it.
        max_message_bytes: of a message of a WebSocket.

    Raises:
        OSError: the port is taken, or a file of `tls` cannot be read.
        ValueError: a certificate that is none, or a key that does not fit it.
    """
    with opened(listening) as (listener, access):
        server = configured(app(access), listening, max_message_bytes)
        announce(access, listening, out or sys.stdout, notice)
        if open_browser:
            webbrowser.open(access.link())
        server.run(sockets=[listener])


def configured(
    app: ASGIApp, listening: Listening, max_message_bytes: int = MAX_MESSAGE_BYTES
) -> uvicorn.Server:
    """A server with every bound set, which has not begun; raises as `serve`."""
    import uvicorn

    from motorcade.replays.studio.access import BoundedProtocol

    certificate, key = (None, None) if listening.tls is None else _checked(*listening.tls)
    config = uvicorn.Config(
        app,
        http=BoundedProtocol,
        ws="websockets-sansio",
        ws_max_size=max_message_bytes,
        ws_per_message_deflate=False,
        h11_max_incomplete_event_size=16 << 10,
        timeout_graceful_shutdown=2,
        proxy_headers=False,
        server_header=False,
        access_log=False,  # it would tell the token
        log_level="critical",
        ssl_certfile=certificate,
        ssl_keyfile=key,
    )
    return uvicorn.Server(config)


def _checked(certificate: Path, key: Path) -> tuple[str, str]:
    """The names of both, once they were seen to fit each other."""
    for path in (certificate, key):
        admit_file(path, PEM_LIMIT)
    try:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, key, password="")  # else it would ask, and wait
    except ssl.SSLError as fault:
        raise ValueError(
            f"--tls: expected a certificate and its key, PEM, got {certificate} and {key}: "
            f"{fault.reason or fault}"
        ) from fault
    return str(certificate), str(key)
