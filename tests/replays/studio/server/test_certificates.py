"""A certificate made on the spot serves https here, and is the one whose fingerprint is told."""

import hashlib
import io
import ssl
import stat

from motorcade.replays.studio.access import Access
from motorcade.replays.studio.serving import Listening, Notice, announce, own_certificate


def test_a_certificate_is_made_for_the_address_and_its_fingerprint_is_told() -> None:
    with own_certificate("127.0.0.1") as (files, fingerprint):
        assert [stat.S_IMODE(path.stat().st_mode) for path in files] == [0o600, 0o600]
        assert stat.S_IMODE(files[0].parent.stat().st_mode) == 0o700
        server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        server.load_cert_chain(*files)
        client = ssl.create_default_context(cafile=str(files[0]))
        shaken_hands(server, client, "127.0.0.1")
        shown = hashlib.sha256(ssl.PEM_cert_to_DER_cert(files[0].read_text())).hexdigest()
        assert fingerprint.replace(":", "").lower() == shown
        out = io.StringIO()
        access = Access(("192.168.1.5:8443",), secure=True, token="k3y")
        notice = Notice("look on", "Stop with Ctrl-C.", fingerprint)
        announce(access, Listening(lan=True, tls=files), out, notice)
        text = out.getvalue()
        assert "https://192.168.1.5:8443/k3y/" in text
        assert fingerprint in text
        assert "Whoever has the link may look on." in text
        assert "plain http" not in text
    assert not files[0].exists()


def shaken_hands(server: ssl.SSLContext, client: ssl.SSLContext, name: str) -> None:
    """A handshake in memory; raises where the certificate does not fit the name."""
    to_client, to_server = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = [
        client.wrap_bio(to_client, to_server, server_hostname=name),
        server.wrap_bio(to_server, to_client, server_side=True),
    ]
    for _ in range(4):
        for end in ends:
            try:
                end.do_handshake()
            except ssl.SSLWantReadError:
                continue
    assert ends[0].getpeercert()
