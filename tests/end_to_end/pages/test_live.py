"""The live page in a browser whose fake camera films a drawn board: tapped, and drawn rightly."""

import json
import time
from pathlib import Path

import numpy as np
import pytest

from motorcade.replays.live import LiveTracker
from motorcade.replays.live.session import LiveFigure, LiveSession, height_on
from motorcade.tracking import Camera
from tests.bench.live import SIZE, LiveTab, fake_camera, running, write_y4m
from tests.replays.live import drawn

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/usr/bin/chromium").exists(), reason="apt-get install chromium"),
]


@pytest.mark.parametrize("width", [1200, 390])
def test_a_tap_stands_the_figure_and_another_lets_it_walk(tmp_path: Path, width: int) -> None:
    camera = Camera(*SIZE, 600.0, 600.0, 319.5, 239.5)
    images = [drawn.image_of(drawn.world_T_camera(k, 31), camera=camera) for k in range(30)]
    write_y4m(tmp_path / "camera.y4m", images, 30)
    figure = LiveFigure("mannequin", height_on(drawn.BOARD))
    session = LiveSession(LiveTracker(drawn.BOARD, camera), figure)
    with fake_camera(tmp_path / "camera.y4m") as browser, running(session) as access:
        tab = LiveTab(browser, access.link(), width, 800)
        tab.until("window.livePage && livePage.stage.hasPose")
        tab.tap_world("0.09, -0.07, 0")
        tab.until("livePage.figure.figure && livePage.figure.state")
        stood = np.array(tab.value("livePage.figure.state.pose.slice(0, 2)"))
        assert np.linalg.norm(stood - [0.09, -0.07]) < 0.03, "one frame may pass before the tap"
        tab.tap_world("0.03, -0.03, 0")
        tab.until("livePage.figure.state.motion > 0")
        tab.until("livePage.drawn > 20 && document.body.innerText.includes('px off')")
        assert tab.value("document.body.dataset.state") == "tracking"
        assert session.measure.figures()["registration_px"] < 0.3


FILM_HZ, FILM_S, SENSOR_HZ = 15, 40, 60.0
BITS = 12
FEEL = """((rows, rate) => {
  const { camera } = livePage;
  const send = camera.message.bind(camera);
  let [begun, next] = [null, 0];
  camera.message = async (shot, ...rest) => {
    const data = await send(shot, ...rest);
    const width = new DataView(data.buffer).getUint16(16, true);
    let index = 0;
    for (let bit = 0; bit < %d; bit++) {
      index |= (data[28 + 8 * width + 16 * bit + 8] > 128) << bit;
    }
    if (begun === null && camera.count > 30) {
      begun = shot.frame.timestamp / 1000 + camera.behind - (1000 * index) / rate;
      while (rows[next][0] + begun < performance.now()) next++;
    }
    return data;
  };
  setInterval(() => {
    for (; begun !== null && rows[next]?.[0] + begun < performance.now(); next++) {
      const [ms, alpha, beta, gamma, x, y, z] = rows[next];
      const rotationRate = { alpha, beta, gamma };
      const accelerationIncludingGravity = { x, y, z };
      const about = { rotationRate, accelerationIncludingGravity, interval: 16 };
      const event = new DeviceMotionEvent("devicemotion", about);
      Object.defineProperty(event, "timeStamp", { value: ms + begun });
      window.dispatchEvent(event);
      window.dispatchEvent(new DeviceMotionEvent("devicemotion")); // a device without sensors
    }
  }, 10);
})(%s, %d)"""


def numbered(index: int, seed: int) -> np.ndarray:
    """The board at a frame of the film, whose index stands in its corner."""
    image = drawn.image_of(drawn.world_T_camera(index * 1e9 / FILM_HZ / drawn.STEP_NS, seed))
    for bit in range(BITS):
        image[:16, 16 * bit : 16 * bit + 16] = 255 * (index >> bit & 1)
    return image


@pytest.mark.parametrize("seed", [31, 32])
def test_motion_sensors_of_the_page_are_used_once_they_are_sure(tmp_path: Path, seed: int) -> None:
    write_y4m(
        tmp_path / "camera.y4m", [numbered(k, seed) for k in range(FILM_S * FILM_HZ)], FILM_HZ
    )
    rows = [
        [1e-6 * sample.time_ns, *np.degrees(sample.rate_rad_s), *sample.force_m_s2]
        for sample in drawn.readings(FILM_S - 1.0, seed, SENSOR_HZ)
    ]
    tracker = LiveTracker(drawn.BOARD, drawn.CAMERA)
    session = LiveSession(tracker, LiveFigure("mannequin", 0.1))
    with fake_camera(tmp_path / "camera.y4m") as browser, running(session) as access:
        tab = LiveTab(browser, access.link(), 390, 800)
        tab.until("window.livePage && livePage.camera")
        tab.value(FEEL % (BITS, json.dumps(rows), FILM_HZ))
        tab.until("document.body.innerText.includes('IMU not used yet')")
        until = time.monotonic() + FILM_S - 3.0
        while not tracker.inertial.used and time.monotonic() < until:
            time.sleep(0.2)
        assert tracker.inertial.used, tracker.inertial.status
        tab.until("document.body.innerText.includes('IMU used: offset')")
    known = tracker.inertial.synchronised
    assert abs(known.offset_s - drawn.OFFSET_S) < 0.02, "the clock of frames is known to a frame"
    turn = known.imu_T_camera.rotor.inverse() @ drawn.IMU_T_CAMERA.rotor
    assert turn.angle() < np.radians(1.0)
    lever_m = known.imu_T_camera.translation_m - drawn.IMU_T_CAMERA.translation_m
    assert np.linalg.norm(lever_m) < 0.02, "forces with another sign would put it elsewhere"


LISTEN = """(() => {
  window.said = [];
  const changed = new MutationObserver(() => said.push(document.body.innerText));
  changed.observe(document.body, { subtree: true, childList: true, characterData: true });
})()"""


def test_a_page_that_is_cut_off_connects_again_and_says_so(tmp_path: Path) -> None:
    images = [drawn.image_of(drawn.world_T_camera(k, 31)) for k in range(30)]
    write_y4m(tmp_path / "camera.y4m", images, 15)
    session = LiveSession(LiveTracker(drawn.BOARD, drawn.CAMERA), LiveFigure("mannequin", 0.1))
    state, text = "document.body.dataset.state", "document.body.innerText"
    with fake_camera(tmp_path / "camera.y4m") as browser, running(session) as access:
        tab = LiveTab(browser, access.link(), 390, 800)
        other = LiveTab(browser, access.link(), 1200, 800)
        tab.until(f"{state} === 'tracking'")
        other.until(f"{state} === 'tracking' && livePage.drawn > 3")
        network = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
        tab.ask("Network.enable")
        tab.ask("Network.emulateNetworkConditions", offline=True, **network)
        tab.until(f"{text}.includes('trying again') && {state} === 'lost'")
        tab.ask("Network.emulateNetworkConditions", offline=False, **network)
        tab.until(f"{state} === 'tracking' && /connected again, after \\d/.test({text})")
        tab.value(LISTEN)
        tab.value("livePage.again = ''; livePage.socket.send = () => {}")  # it vanishes unsaid
        tab.until("said.some((text) => text.includes('no answer; trying again'))")
        tab.until(f"{state} === 'tracking' && /connected again, after \\d/.test({text})")
        drawn_before = other.value("livePage.drawn")
        other.until(f"livePage.drawn > {drawn_before} + 3")
