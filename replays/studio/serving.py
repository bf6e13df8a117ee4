"""The open port: where it listens, its certificate, and the server that runs until it is stopped.

This is the one place in the program that opens a port (SECURITY.md). Nobody vouches for the
certificate: whoever opens the page compares the fingerprints that terminal and browser show.
"""

from __future__ import annotations

import contextlib
import datetime
import ipaddress
import socket
import ssl
import sys
import tempfile
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

    Raises ValueError: a port that is none.
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

    Raises OSError: the port is taken, or a file of `tls` cannot be read; ValueError: a certificate
    that is none, or a key that does not fit it.
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


LASTS = datetime.timedelta(days=1)


@contextlib.contextmanager
def own_certificate(address: str) -> Iterator[tuple[tuple[Path, Path], str]]:
    """A certificate for an IP address of this machine, for as long as the block lasts.

    Returns:
        files of the certificate and of its key, PEM; and the certificate's SHA-256 fingerprint, as
        browsers write it.

    Raises ModuleNotFoundError: the package cryptography is not installed; ValueError: no address.

    >>> from motorcade.replays.studio.serving import own_certificate
    >>> with own_certificate("127.0.0.1") as (files, fingerprint):
    ...     text = files[0].read_text()
    >>> text.splitlines()[0], len(fingerprint.split(":"))
    ('-----BEGIN CERTIFICATE-----', 32)
    """
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "Motorcade on this machine")])
    now = datetime.datetime.now(datetime.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(minutes=5))
        .not_valid_after(now + LASTS)
        .add_extension(
            x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address(address))]), False
        )
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), True)
        .sign(key, hashes.SHA256())
    )
    parts = (
        certificate.public_bytes(serialization.Encoding.PEM),
        key.private_bytes(
            serialization.Encoding.PEM,
            serialization.PrivateFormat.PKCS8,
            serialization.NoEncryption(),
        ),
    )
    with tempfile.TemporaryDirectory(prefix="motorcade-") as folder:  # which is ours alone
        files = Path(folder, "certificate.pem"), Path(folder, "key.pem")
        for path, part in zip(files, parts, strict=True):
            path.touch(mode=0o600)
            path.write_bytes(part)
        yield files, certificate.fingerprint(hashes.SHA256()).hex(":").upper()
