"""A certificate made on the spot, for browsers that give a page a camera by https alone.

Nobody vouches for it: whoever opens the page compares the fingerprint that the terminal shows with
the one that the browser shows. It lasts a day, and its key is in no file but a temporary one.
"""

from __future__ import annotations

import contextlib
import datetime
import ipaddress
import tempfile
from collections.abc import Iterator
from pathlib import Path

LASTS = datetime.timedelta(days=1)


@contextlib.contextmanager
def own_certificate(address: str) -> Iterator[tuple[tuple[Path, Path], str]]:
    """A certificate for an IP address of this machine, for as long as the block lasts.

    Returns:
        files of the certificate and of its key, PEM; and the certificate's SHA-256 fingerprint, as
        browsers write it.

    Raises:
        ModuleNotFoundError: the package cryptography is not installed.
        ValueError: no address.

    >>> from motorcade.replays.studio.certificates import own_certificate
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
