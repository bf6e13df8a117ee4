"""The live page in a browser whose fake camera films a drawn board: tapped, and drawn rightly."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.replays.live import LiveTracker
from motorcade.replays.live.session import LiveFigure, LiveSession, height_on
from motorcade.tracking import Camera
from tests.bench.live import SIZE, LiveTab, fake_camera, running, write_y4m
from tests.replays.live import drawn

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("width", [1200, 390])
def test_a_tap_stands_the_figure_and_another_lets_it_walk(tmp_path: Path, width: int) -> None:
    if not Path("/usr/bin/chromium").exists():
        pytest.skip("no Chromium here: apt-get install chromium")
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
