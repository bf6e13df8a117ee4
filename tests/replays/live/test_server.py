"""The live page's server: nobody without the link; frames that are none break nothing."""

import contextlib
import http.client
import json
import struct
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import websockets
from websockets.sync.client import ClientConnection, connect

from motorcade.replays import open_recording
from motorcade.replays.live import LiveTracker
from motorcade.replays.live import app as live_app
from motorcade.replays.live.app import HEADER, MAX_FRAME_BYTES, MAX_SIDE, BrowserClock, read_frame
from motorcade.replays.live.inertial import ImuSample
from motorcade.replays.live.session import LiveFigure, LiveRecorder, LiveSession
from motorcade.replays.stages.camera.board_poses import board_poses
from motorcade.replays.stages.inertial.imu import imu
from motorcade.replays.studio.access import Access
from tests.bench.live import running
from tests.replays.live.drawn import (
    BOARD,
    CAMERA,
    IMU_T_CAMERA,
    OFFSET_S,
    STEP_NS,
    frames,
    image_of,
    readings,
    world_T_camera,
)
from tests.replays.live.test_session import assert_replayed

PATIENCE_S = 60.0
NAN = float("nan")


def a_session(folder: Path | None = None) -> LiveSession:
    recorder = None if folder is None else LiveRecorder(folder)
    return LiveSession(LiveTracker(BOARD, CAMERA), LiveFigure("mannequin", 0.1), recorder)


@pytest.fixture
def access() -> Iterator[Access]:
    with running(a_session()) as key:
        yield key


def visit(key: Access, **options: object) -> ClientConnection:
    origin = f"http://{key.names[0]}"
    address = f"ws://{key.names[0]}/{key.token}/live"
    return connect(address, **{"origin": origin, "proxy": None, "max_size": 1 << 23} | options)


def told(browser: ClientConnection) -> dict[str, object]:
    return json.loads(browser.recv(PATIENCE_S))


def bytes_of(
    image: np.ndarray, number: int, stamp_ms: float, readings: object = np.zeros((0, 7))
) -> bytes:
    height, width = image.shape
    head = HEADER.pack(b"MLY2", number, stamp_ms, width, height, NAN, len(readings))
    return head + image.tobytes() + np.asarray(readings, "<f4").tobytes()


def frame_of(
    width: int, height: int, size: int, stamp_ms: float = 0.0, *, readings: int = 0
) -> bytes:
    return HEADER.pack(b"MLY2", 1, stamp_ms, width, height, NAN, readings) + bytes(size)


def with_readings(*rows: object) -> bytes:
    return bytes_of(np.zeros((64, 64), np.uint8), 1, 9000.0, rows)


def closed(browser: ClientConnection) -> int:
    with contextlib.suppress(websockets.ConnectionClosed):
        while True:
            browser.recv(PATIENCE_S)
    assert browser.close_code is not None
    return browser.close_code


def asked(key: Access, path: str) -> tuple[int, dict[str, str]]:
    host, _, port = key.names[0].partition(":")
    connection = http.client.HTTPConnection(host, int(port), timeout=PATIENCE_S)
    connection.request("GET", path)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status, {name.lower(): text for name, text in answer.getheaders()}


def test_frames_are_answered_with_their_poses(access: Access) -> None:
    image = image_of(world_T_camera(0, 5))
    with visit(access) as browser:
        assert told(browser) == {"hello": "film"}
        for number in range(3):
            browser.send(bytes_of(image, number, 1000.0 + 33.0 * number))
            answer = told(browser)
            assert (answer["frame"], answer["state"]) == (number, "tracking")
        off = np.array(answer["pose"][:3]) - world_T_camera(0, 5).translation_m
        assert np.linalg.norm(off) < 0.003
        assert answer["camera"]["fx"] == CAMERA.fx
        browser.send(json.dumps({"do": "stand", "frame": 2, "pixels": [[160, 120]]}))
        browser.send(bytes_of(image, 3, 1100.0))
        assert told(browser)["figure"]["motion"] == 0


def test_the_page_alone_may_have_a_camera_and_the_link_is_needed(access: Access) -> None:
    status, headers = asked(access, f"/{access.token}/")
    assert status == 200
    assert headers["permissions-policy"].startswith("camera=(self), microphone=()")
    assert "default-src 'none'" in headers["content-security-policy"]
    _, headers = asked(access, f"/{access.token}/studio/live.js")
    assert headers["permissions-policy"].startswith("camera=()")
    for path in ("/", "/live", "/wrong/", f"/{access.token[:-1]}/figure.glb"):
        assert asked(access, path)[0] == 403
    assert asked(access, f"/{access.token}/motion/0.json")[0] == 200
    for path in ("motion/99.json", "motion/-1.json", "studio/..%2fserving.py"):
        assert asked(access, f"/{access.token}/{path}")[0] == 404


@pytest.mark.parametrize("options", [{"origin": None}, {"origin": "http://stranger.example"}])
def test_a_socket_needs_our_own_page(access: Access, options: dict[str, object]) -> None:
    with pytest.raises(websockets.InvalidStatus), visit(access, **options):
        pass


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "a header"),
        (b"MLY1" + bytes(24), "a header"),
        (frame_of(8, 240, 8 * 240), "sides of 64"),
        (frame_of(65535, 65535, 0), f"64 to {MAX_SIDE}"),
        (frame_of(320, 240, 320 * 240 - 1), "76800 bytes"),
        (frame_of(320, 240, 320 * 240 + 1), "76800 bytes"),
        (frame_of(320, 240, 320 * 240, NAN), "a stamp"),
        (frame_of(320, 240, 320 * 240, -1.0), "a stamp"),
        (frame_of(320, 240, 320 * 240, 1e300), "a stamp"),
        (frame_of(320, 240, 320 * 240, readings=1), "1 readings of 28"),
        (frame_of(320, 240, 320 * 240 + 27, readings=1), "1 readings of 28"),
        (frame_of(320, 240, 320 * 240, readings=2**32 - 1), "at most 256 readings"),
        (with_readings([NAN, 0, 0, 0, 0, 0, 9.8]), "readings of a motion sensor"),
        (with_readings([0, 0, 0, 0, 0, 0, NAN]), "readings of a motion sensor"),
        (with_readings([0, 0, 0, 0, 0, 0, np.inf]), "readings of a motion sensor"),
        (with_readings([0, 1e9, 0, 0, 0, 0, 9.8]), "readings of a motion sensor"),
        (with_readings([0, 0, 0, 0, 0, -1e9, 9.8]), "readings of a motion sensor"),
        (with_readings([6000, 0, 0, 0, 0, 0, 9.8]), "readings of a motion sensor"),
        (with_readings([-6000, 0, 0, 0, 0, 0, 9.8]), "readings of a motion sensor"),
    ],
)
def test_frames_that_are_none_are_refused(data: bytes, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        read_frame(data)


def test_stamps_that_go_back_or_jump_are_refused() -> None:
    clock = BrowserClock(500, 10.0)
    assert clock.stamp_ns(1e12, 10.0) == 500
    assert clock.stamp_ns(1e12 + 33.0, 10.03) == 500 + 33_000_000
    for stamp_ms in (1e12 + 33.0, 1e12 - 5.0):
        with pytest.raises(ValueError, match="after the one before"):
            clock.stamp_ns(stamp_ms, 10.1)
    with pytest.raises(ValueError, match="a jump"):
        clock.stamp_ns(1e12 + 3.6e6, 10.2)
    assert clock.stamp_ns(1e12 + 250.0, 10.25) == 500 + 250_000_000


def test_a_browser_that_sends_rubbish_is_told_so_and_heard_again(access: Access) -> None:
    image = image_of(world_T_camera(0, 5))
    with visit(access) as browser:
        told(browser)
        for data in (b"rubbish", "no JSON", "[" * 2000, json.dumps({"do": "fly"}), "x" * 9000):
            browser.send(data)
            assert "error" in told(browser)
        browser.send(bytes_of(image, 1, 50.0))
        assert told(browser)["state"] == "tracking"
        browser.send(bytes_of(image, 2, 40.0))
        assert told(browser)["state"] == "refused"
        browser.send(bytes_of(np.zeros((480, 640), np.uint8), 3, 60.0))
        assert "expected 320 x 240" in told(browser)["why"]
        browser.send(bytes_of(image, 4, 90.0))
        assert told(browser)["state"] == "tracking"


def test_too_many_messages_too_many_faults_or_too_large_ones_end_a_visit(access: Access) -> None:
    faults = 2 + live_app.MOST_REFUSED
    for messages, codes in (
        (["drew 1"] * 600, {1008}),
        ([b"rubbish"] * faults, {1008}),
        # What was not read yet is reset with the connection, at times before the reason is read.
        ([bytes(MAX_FRAME_BYTES + 1)], {1009, 1006}),
    ):
        with visit(access) as browser:
            with contextlib.suppress(websockets.ConnectionClosed):
                for message in messages:
                    browser.send(message)
            assert closed(browser) in codes


def test_of_frames_that_wait_the_newest_is_tracked(access: Access) -> None:
    image = image_of(world_T_camera(0, 5))
    with visit(access) as browser:
        told(browser)
        for number in range(40):
            browser.send(bytes_of(image, number, 33.0 * number))
        answered = [told(browser)["frame"]]
        while answered[-1] != 39:
            answered.append(told(browser)["frame"])
        assert answered == sorted(set(answered))


def test_others_look_on_and_the_session_outlives_its_camera(access: Access) -> None:
    image = image_of(world_T_camera(0, 5))
    with visit(access) as browser, visit(access) as other:
        told(browser)
        assert told(other) == {"hello": "watch"}
        browser.send(bytes_of(image, 7, 33.0))
        told(browser)
        data = other.recv(PATIENCE_S)
        (length,) = struct.unpack_from("<I", data)
        about = json.loads(data[4 : 4 + length])
        assert (about["frame"], about["state"]) == (7, "tracking")
        assert data[4 + length :][:2] == b"\xff\xd8", "a JPEG"
        other.send("drew 7")
        other.send(b"a frame that nobody asked for")
        assert "error" in told(other)
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        with visit(access) as browser:
            if told(browser) == {"hello": "film"}:
                browser.send(bytes_of(image, 0, 1.0))  # its own clock began anew
                assert told(browser)["state"] == "tracking"
                return
    raise AssertionError("the camera's place stays taken")


def test_a_camera_that_fell_silent_gives_way(
    access: Access, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_app, "SILENT_S", 0.0)
    image = image_of(world_T_camera(0, 5))
    with visit(access) as silent:
        assert told(silent) == {"hello": "film"}
        silent.send(bytes_of(image, 0, 1.0))
        told(silent)
        with visit(access) as browser:
            assert told(browser) == {"hello": "film"}
            browser.send(bytes_of(image, 1, 9.0))
            assert told(browser)["state"] == "tracking"
            assert closed(silent) == 1013
            browser.send(bytes_of(image, 2, 50.0))
            assert told(browser)["state"] == "tracking", "the one that went took nothing with it"


def test_a_source_is_shown_to_whoever_comes_and_its_end_is_told() -> None:
    with running(a_session(), frames(4, 3)) as access, visit(access) as browser:
        assert told(browser) == {"hello": "watch"}
        last: object = None
        while not isinstance(last, str):
            last = browser.recv(PATIENCE_S)
            if isinstance(last, bytes):
                (length,) = struct.unpack_from("<I", last)
                browser.send(f"drew {json.loads(last[4 : 4 + length])['frame']}")
        assert json.loads(last) == {"ended": "the source has ended"}


RATE_HZ = 100


def felt_between(samples: list[ImuSample], from_ns: float, to_ns: float, frame_ns: int) -> object:
    """Readings as a page sends them with a frame."""
    return [
        [1e-6 * (s.time_ns - frame_ns), *np.degrees(s.rate_rad_s), *s.force_m_s2]
        for s in samples
        if from_ns < s.time_ns <= to_ns
    ]


def test_motion_sensors_carry_the_pose_once_they_are_sure_and_are_recorded(tmp_path: Path) -> None:
    seed, session = 35, a_session(tmp_path / "session")
    samples = readings(14.0, seed, RATE_HZ)
    covered, since_ns, told_of = np.full((CAMERA.height, CAMERA.width), 128, np.uint8), 0.0, []
    with running(session) as access, visit(access) as browser:
        told(browser)
        for number in range(300):
            now_ns = number * STEP_NS
            until_ns = now_ns + 1e9 * OFFSET_S
            image = covered if number >= 290 else image_of(world_T_camera(number, seed))
            felt = felt_between(samples, since_ns, until_ns, now_ns)
            browser.send(bytes_of(image, number, 5000.0 + 1e-6 * now_ns, felt))
            told_of.append(told(browser))
            since_ns = until_ns
            fit = session.tracker.inertial._fit
            if fit is not None:
                fit.exception()  # wait for it, so that the machine's load plays no part
    status = session.tracker.inertial.status
    session.close()
    assert "IMU used" in status, status
    assert all("by the IMU" in answer["why"] for answer in told_of[-10:])
    recording = open_recording(tmp_path / "session")
    assert recording.imu is not None
    assert len(recording.imu) > 0.99 * RATE_HZ * 1e-9 * 300 * STEP_NS
    turn = recording.imu_T_camera.rotor.inverse() @ IMU_T_CAMERA.rotor
    assert turn.angle() < np.radians(1.5)
    assert_replayed(recording, tmp_path / "session" / "live.jsonl")
    used = imu(recording, board_poses(recording), source="recorded")
    assert used.stream is not None


def test_what_was_felt_meanwhile_is_not_lost_with_its_frame_and_floods_are_refused() -> None:
    image = image_of(world_T_camera(0, 5))
    session = a_session()
    with running(session) as access, visit(access) as browser:
        told(browser)
        for number in range(40):
            row = [-5.0, 1.0, 2.0, 3.0, 0.0, 0.0, 9.8]
            browser.send(bytes_of(image, number, 33.0 * number, [row]))
        while told(browser)["frame"] != 39:
            pass
        assert len(session.tracker.inertial._samples) == 40
        rows = [[float(k), 1.0, 2.0, 3.0, 0.0, 0.0, 9.8] for k in range(256)]
        errors = []
        for number in range(40, 50):
            browser.send(bytes_of(image, number, 33.0 * number, rows))
            errors.append(told(browser).get("error", ""))
        assert any("readings a second" in error for error in errors)


def test_another_browser_begins_anew_and_one_that_was_cut_off_goes_on(access: Access) -> None:
    clock = BrowserClock(500, 10.0)
    assert not clock.goes_on(100.0, 10.0), "nobody came yet"
    clock.stamp_ns(1e6, 10.0)
    assert clock.goes_on(1e6 + 7000.0, 17.3)
    assert not clock.goes_on(1e6 + 7000.0, 19.0)
    assert not clock.goes_on(1e6 - 1.0, 10.1)
    assert not clock.goes_on(50.0, 17.0)
