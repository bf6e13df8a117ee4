"""Nobody comes in without the link, by another name, or from another page; bounds hold."""

import contextlib
import http.client
import io
import json
import socket
import time
from pathlib import Path

import pytest
import segno
import websockets
from websockets.sync.client import ClientConnection, connect

from motorcade.replays.studio import access, serving
from motorcade.replays.studio.access import Access
from motorcade.replays.studio.serving import LOOPBACK, Listening, announce
from tests.replays.studio.server.conftest import PATIENCE_S, EchoDesk, Served, running


def asked(
    served: Served, path: str, method: str = "GET", body: bytes | None = None, **headers: str
) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of an answer; `path` is sent as it stands."""
    connection = http.client.HTTPConnection(LOOPBACK, served.port, timeout=PATIENCE_S)
    connection.putrequest(method, path, skip_host="Host" in headers)
    for name, text in headers.items():
        connection.putheader(name.replace("_", "-"), text)
    if body is not None:
        connection.putheader("Content-Length", str(len(body)))
    connection.endheaders(body)
    answer = connection.getresponse()
    found = answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read()
    connection.close()
    return found


def visit(served: Served, address: str | None = None, **options: object) -> ClientConnection:
    settings = {"origin": served.origin, "proxy": None, "open_timeout": PATIENCE_S} | options
    browser = connect(address or served.socket, **settings)
    with contextlib.suppress(websockets.ConnectionClosed):  # where it is one too many
        assert json.loads(browser.recv(PATIENCE_S)) == {"hello": True}
    return browser


def closed(browser: ClientConnection) -> int:
    """The code with which the server closed a connection."""
    with contextlib.suppress(websockets.ConnectionClosed):
        while True:
            browser.recv(PATIENCE_S)
    assert browser.close_code is not None
    return browser.close_code


def works(browser: ClientConnection) -> bool:
    """Whether a browser still gets an answer to its own message."""
    browser.send('{"n": 99, "do": "anything"}')
    while json.loads(browser.recv(PATIENCE_S)) != {"n": 99, "ok": True}:
        continue
    return True


def test_the_link_opens_the_page_with_strict_headers(served: Served) -> None:
    status, headers, body = asked(served, f"/{served.access.token}/")
    assert status == 200
    assert "table &lt;top&gt;" in body.decode(), "names are escaped"
    policy = headers["content-security-policy"]
    nonce = policy.partition("'nonce-")[2].partition("'")[0]
    assert nonce
    assert f'nonce="{nonce}"' in body.decode()
    assert "unsafe" not in policy
    assert "default-src 'none'" in policy
    assert f"ws://{served.access.names[0]}" in policy
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["x-content-type-options"] == "nosniff"
    again = asked(served, f"/{served.access.token}/")[1]["content-security-policy"]
    assert again != policy, "a nonce is used once"


@pytest.mark.parametrize(
    "path",
    [
        "/",
        "/studio/editor.css",
        "/run/0/",
        "/{wrong}/",
        "/{short}/",
        "/{token}x/",
        "//{token}/",
        "/%2e%2e/{token}/",
        "/%ff%d8/",
        "",
    ],
)
def test_no_token_no_answer(served: Served, path: str) -> None:
    token = served.access.token
    wrong = token[:-1] + ("A" if token[-1] != "A" else "B")
    path = path.format(token=token, wrong=wrong, short=token[:-1]) or "*"
    status, _, body = asked(served, path)
    assert status == 403
    assert token not in body.decode()


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "stranger.example"},
        {"Host": "127.0.0.1"},
        {"Host": "127.0.0.1:1"},
        {"Host": ""},
        {"Origin": "https://stranger.example"},
        {"Origin": "null"},
        {"Origin": "https://{name}"},
        {"Origin": "http://{name}.stranger.example"},
        {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"},
        {"Sec_Fetch_Site": "same-site", "Sec_Fetch_Mode": "no-cors"},
        {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "iframe"},
    ],
)
def test_other_names_and_pages_are_refused(served: Served, headers: dict[str, str]) -> None:
    given = {key: text.format(name=served.access.names[0]) for key, text in headers.items()}
    assert asked(served, f"/{served.access.token}/", **given)[0] == 403


def test_a_link_may_be_followed_from_elsewhere(served: Served) -> None:
    followed = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}
    path = f"/{served.access.token}/"
    assert asked(served, path, **followed, Sec_Fetch_Dest="document")[0] == 200
    assert asked(served, path, Host=f"localhost:{served.port}")[0] == 200


def test_two_hosts_in_one_request_are_refused(served: Served) -> None:
    with socket.create_connection((LOOPBACK, served.port), PATIENCE_S) as raw:
        name = served.access.names[0]
        raw.sendall(
            f"GET /{served.access.token}/ HTTP/1.1\r\nHost: {name}\r\nHost: x\r\n\r\n".encode()
        )
        assert b" 200 " not in raw.recv(4096).split(b"\r\n")[0]


@pytest.mark.parametrize(
    "path",
    [
        "../../pyproject.toml",
        "studio/../../../pyproject.toml",
        "studio/..%2f..%2f..%2fpyproject.toml",
        "studio/%2e%2e/server/app.py",
        "studio/app.py",
        "studio//etc/passwd",
        "run/0/frame/../about.json",
        "run/0/frame/2.jpg",
        "run/0/frame/-1.jpg",
        "run/0/frame/99999999999999999999999999.jpg",
        "run/0/figure/1.glb",
        "run/0/motion/1.json",
        "run/1/",
        "run/1/about.json",
        "run/" + "9" * 5000 + "/",
        "run/" + "9" * 5000 + "/about.json",
        "run/" + "0" * 5000 + "/frame/0.jpg",
        "run/0/frame/" + "9" * 5000 + ".jpg",
        "run/0/figure/" + "9" * 5000 + ".glb",
        "run/0/motion/" + "9" * 5000 + ".json",
        "run/-0/",
        "run/%D9%A0/",
        "run/0%0a/",
        "run/0x0/",
        "run/0/scene.json",
    ],
    ids=lambda path: path[:40],
)
def test_nothing_but_the_fixed_paths(served: Served, path: str) -> None:
    assert asked(served, f"/{served.access.token}/{path}")[0] == 404


def test_what_a_run_has_is_served(served: Served) -> None:
    inside = f"/{served.access.token}"
    assert asked(served, f"{inside}/run/0/frame/1.jpg")[2] == b"frame 1"
    assert asked(served, f"{inside}/run/0/figure/0.glb")[2] == b"glTF"
    assert json.loads(asked(served, f"{inside}/run/0/about.json")[2]) == {"frames": 2}
    status, headers, _ = asked(served, f"{inside}/studio/editor.css")
    assert (status, headers["content-type"]) == (200, "text/css; charset=utf-8")
    assert asked(served, f"{inside}/app.webmanifest")[0] == 200
    assert asked(served, f"{inside}/", method="POST", body=b"x")[0] == 405


@pytest.mark.parametrize("origin", [None, "http://stranger.example", "null"])
def test_a_socket_needs_our_own_page(served: Served, origin: str | None) -> None:
    with pytest.raises(websockets.InvalidStatus) as fault, visit(served, origin=origin):
        pass
    assert fault.value.response.status_code == 403


def test_a_socket_needs_the_token_and_a_run(served: Served) -> None:
    for old, new in (
        (served.access.token, "0" * 22),
        ("run/0", "run/7"),
        ("run/0", "run/" + "9" * 5000),
    ):
        with (
            pytest.raises(websockets.InvalidStatus) as fault,
            visit(served, served.socket.replace(old, new)),
        ):
            pass
        assert fault.value.response.status_code == 403


def test_messages_and_news(served: Served) -> None:
    with visit(served) as one, visit(served) as other:
        assert works(one)
        assert json.loads(other.recv(PATIENCE_S)) == {"heard": 1}
        one.close()
        assert json.loads(other.recv(PATIENCE_S)) == {"gone": True}
        assert len(served.desk.gone) == 1


BAD = [
    "",
    "no json",
    "[1, 2]",
    '{"n": NaN}',
    '{"n": Infinity}',
    '{"n": ' + "9" * 5000 + "}",
    "[" * 60_000,
    '{"do": ' * 8000,
    '{"do": "refuse"}',
    '"\\ud800"',
]


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_bad_messages_are_answered_and_disturb_nobody(served: Served, text: str) -> None:
    with visit(served) as one, visit(served) as other:
        one.send(text)
        answer = json.loads(one.recv(PATIENCE_S))
        assert (answer["n"], answer["ok"]) == (None, False)
        assert "\n" not in answer["error"]
        assert works(one)
        assert works(other)


def test_large_messages_end_their_sender_alone(served: Served) -> None:
    with visit(served) as other:
        with visit(served) as one:
            one.send('{"n": "' + "x" * (access.MAX_MESSAGE_BYTES - 20) + '"}')
            assert json.loads(one.recv(PATIENCE_S))["ok"]
        with visit(served) as one:
            one.send("x" * (access.MAX_MESSAGE_BYTES + 1))
            assert closed(one) == 1009
        with visit(served) as one:
            one.send(b"\0")
            assert closed(one) == 1003
        with visit(served) as one:
            parts = iter(["x" * (1 << 20)] * 100)  # of one message
            with pytest.raises(websockets.ConnectionClosed):
                one.send(parts)
            assert len(list(parts)) > 50, "it was cut off soon"
        assert works(other)


def test_ten_thousand_messages_at_once_end_their_sender_alone(served: Served) -> None:
    with visit(served) as other, visit(served) as one:
        with contextlib.suppress(websockets.ConnectionClosed):
            for _ in range(10_000):
                one.send("{}")
        assert closed(one) == 1008
        assert len(served.desk.heard) < 5_000
        assert works(other)


def test_so_many_browsers_in_a_scene(served: Served) -> None:
    browsers = [visit(served) for _ in range(access.MAX_EDITORS)]
    with visit(served) as one_more:
        assert closed(one_more) == 1013
    browsers.pop().close()
    until = time.monotonic() + PATIENCE_S
    while not served.desk.gone:
        assert time.monotonic() < until
        time.sleep(0.01)
    with visit(served) as instead:
        assert works(instead)
    for one in browsers:
        one.close()


def test_one_address_has_so_many_connections(served: Served) -> None:
    with visit(served) as other:
        idle = []
        for _ in range(access.MAX_CONNECTIONS_AN_ADDRESS):
            idle.append(socket.create_connection((LOOPBACK, served.port), PATIENCE_S))
        until = time.monotonic() + PATIENCE_S
        while len(served.server.server_state.connections) < len(idle):
            assert time.monotonic() < until
            time.sleep(0.01)
        one_more = socket.create_connection((LOOPBACK, served.port), PATIENCE_S)
        with one_more, contextlib.suppress(ConnectionResetError):
            assert one_more.recv(1) == b""
        assert works(other)
        for one in idle:
            one.close()


def test_a_connection_that_asks_for_nothing_is_closed(
    served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(access, "FIRST_REQUEST_WITHIN_S", 0.2)
    with socket.create_connection((LOOPBACK, served.port), PATIENCE_S) as slow:
        slow.sendall(b"GET / HTTP/1.1\r\nHost: ")
        with contextlib.suppress(ConnectionResetError):
            assert slow.recv(1) == b""


def test_long_heads_are_refused(served: Served) -> None:
    with socket.create_connection((LOOPBACK, served.port), PATIENCE_S) as raw:
        raw.sendall(b"GET /" + b"x" * (20 << 10))
        assert raw.recv(4096).startswith(b"HTTP/1.1 400 ")


def test_only_this_machine_unless_the_network_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving.opened(Listening()) as (listener, access):
        assert listener.getsockname()[0] == LOOPBACK
        assert access.link().startswith(f"http://{LOOPBACK}:")
    monkeypatch.setattr(serving, "address_in_network", lambda: "127.0.0.2")
    with serving.opened(Listening(lan=True)) as (listener, access):
        assert listener.getsockname()[0] == "127.0.0.2", "no wider than it need be"
        assert access.names == (f"127.0.0.2:{listener.getsockname()[1]}",)


def test_what_the_terminal_says(tmp_path: Path) -> None:
    access, said = Access(("10.0.0.2:8000",)), io.StringIO()
    announce(access, Listening(), said)
    assert access.link() in said.getvalue()
    assert "█" not in said.getvalue()
    said = io.StringIO()
    announce(access, Listening(lan=True), said)
    code = io.StringIO()
    segno.make(access.link(), error="m").terminal(code, compact=True)
    assert code.getvalue() in said.getvalue()
    assert "plain http" in said.getvalue()
    said = io.StringIO()
    secure = Access(("10.0.0.2:8000",), secure=True)
    announce(secure, Listening(lan=True, tls=(tmp_path, tmp_path)), said)
    assert secure.link().startswith("https://")
    assert "plain http" not in said.getvalue()


def test_tokens_are_long_and_never_told() -> None:
    one, other = Access(("a:1",)), Access(("a:1",))
    assert one.token != other.token
    assert len(one.token) >= 22, "128 bits"
    assert one.token not in repr(one)


@pytest.mark.parametrize("port", [-1, 1 << 16])
def test_ports_that_are_none_are_refused(port: int) -> None:
    with pytest.raises(ValueError, match=r"Listening\.port: expected 0 to 65535"):
        Listening(port=port)


def test_what_was_opened_is_closed_with_the_server() -> None:
    desk = EchoDesk()
    with running(desk) as (access, port, server):
        with visit(Served(access, desk, port, server)) as one:
            assert works(one)
        assert not desk.closed
    assert desk.closed


def test_a_port_that_is_taken_is_named(served: Served) -> None:
    with (
        pytest.raises(OSError, match=r"cannot listen there .* choose another --port"),
        serving.opened(Listening(port=served.port)),
    ):
        pass


def test_files_that_are_no_certificate_are_named(tmp_path: Path) -> None:
    for name in ("cert.pem", "key.pem"):
        (tmp_path / name).write_text("nothing")
    with pytest.raises(ValueError, match="--tls: expected a certificate and its key"):
        serving.configured(None, Listening(tls=(tmp_path / "cert.pem", tmp_path / "key.pem")))


def test_a_scene_that_cannot_be_shown_keeps_no_places(
    served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(visitor: int) -> dict[str, object]:
        raise ValueError("a file is gone")

    with monkeypatch.context() as gone:
        gone.setattr(served.desk, "joined", fails)
        for _ in range(access.MAX_EDITORS + 1):
            with visit(served) as one:
                assert closed(one) != 1013
    with visit(served) as one:
        assert works(one)
