"""The viewer in a real browser: every frame the right one, and everything where Python has it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.animation import Placement, mannequin
from motorcade.ga import Motor
from motorcade.render import Performer
from motorcade.replays.cli.main import main
from motorcade.replays.pipeline.runs import write_view
from motorcade.replays.web.page import view_page
from motorcade.tracking import Camera
from tests.end_to_end.pages.drawn_where import Standing, apart
from tests.end_to_end.pages.made_looks import BITS, SIDE_PX, MadeLook, looking_at

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("pages")]

READY = """new Promise((done) => {
  const look = () => (document.documentElement.dataset.ready ? done(true) : setTimeout(look, 20));
  look();
})"""

SEEKS = f"""(async () => {{
  const wrong = [];
  const pane = viewer.stage.panes[0];
  const copy = new OffscreenCanvas({SIDE_PX * BITS}, {SIDE_PX});
  const brush = copy.getContext("2d", {{ willReadFrequently: true }});
  const told = () => {{
    brush.drawImage(pane.ground, 0, 0);
    const white = (k) => brush.getImageData({SIDE_PX} * k + 8, 8, 1, 1).data[0] > 127;
    return Array.from({{ length: {BITS} }}, (_, k) => white(k) << k).reduce((a, b) => a | b);
  }};
  for (const frame of FRAMES) {{
    viewer.timeline.go(frame);
    const until = performance.now() + 5000;
    while (pane.film.shown !== frame && performance.now() < until) {{
      await new Promise((next) => setTimeout(next, 1));
    }}
    if (told() !== frame) wrong.push([frame, told(), pane.film.shown]);
  }}
  return wrong;
}})()"""

SHOWN = """new Promise((done) => {
  const look = () => (viewer.films.every((film) => film.shown === FRAME) ? done(true)
    : setTimeout(look, 20));
  look();
})"""

# The camera's sign has its image in the world, also of a film that lies beside the page.
IMAGED = """new Promise((done) => {
  const look = () => (viewer.runs.every(({ world }) => world.sign.image.visible) ? done(true)
    : setTimeout(look, 20));
  look();
})"""

CAMERAS = {
    "pinhole": Camera(640, 480, 500.0, 505.0, 319.5, 239.5),
    "off_centre": Camera(640, 480, 520.0, 480.0, 201.0, 333.25),
    "radtan": Camera(
        752, 480, 458.7, 457.3, 367.2, 248.4, "radtan", (-0.2834, 0.0739, 2e-3, -1e-3)
    ),
    "equidistant": Camera(
        848, 800, 286.1, 286.2, 417.0, 403.0, "equidistant", (-0.009, 0.05, -0.047, 0.009)
    ),
}


def made(camera: Camera, frames: int, away_m: float = 0.0) -> MadeLook:
    """A figure of half its size that walks in place, seen from all around."""
    who = mannequin()
    stand = Motor.from_euler_translation([0.0, 0.0, 0.7], [away_m, -0.5 * away_m, 0.1 * away_m])
    figure = Performer(who, who.clip("walk"), Placement(stand, 0.5))
    phase = np.linspace(0.0, 4.0, frames)
    around = np.stack([np.cos(phase), np.sin(phase), 0.2 + 0.3 * np.sin(3 * phase)], axis=-1)
    middle = stand.apply([0.0, 0.0, 0.25 * who.height_m])
    poses = looking_at(middle + 0.05 * around, middle + 1.1 * around, 0.4 * np.sin(2 * phase))
    return MadeLook(camera, poses, figure)


@pytest.fixture(scope="module")
def run(board_recording: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of the small board."""
    out = tmp_path_factory.mktemp("looked_at") / "run"
    assert main(["run", str(board_recording), "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def view(run: Path) -> Path:
    """Its page."""
    assert main(["view", str(run), "--no-open"]) == 0
    return run / "view.html"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [360, 1400, 2560])
def test_the_page_fits_and_asks_for_nothing(
    width: int, scheme: str, view: Path, opened: Callable[..., Any]
) -> None:
    page = opened(view, width, scheme)
    assert page.evaluate(READY)
    for kind in range(4):
        page.evaluate(f"viewer.view = {kind}, viewer.arrange()")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    nameless = (
        "[...document.querySelectorAll('button, select, input')].filter((one) =>"
        " !one.ariaLabel && !one.textContent.trim()).map((one) => one.outerHTML)"
    )
    assert page.evaluate(nameless) == []
    assert page.complaints() == []


def test_keys_and_clicks_go_where_they_say(view: Path, opened: Callable[..., Any]) -> None:
    page = opened(view, 1400)
    assert page.evaluate(READY)
    last = page.evaluate("viewer.timeline.last")
    for key, frame in (("ArrowRight", 1), ("End", last), ("ArrowLeft", last - 1), ("Home", 0)):
        page.press(key)
        assert page.evaluate("viewer.timeline.frame") == frame
        assert page.evaluate(SHOWN.replace("FRAME", str(frame)))
    page.evaluate("document.querySelector('.u-over').scrollIntoView({ block: 'center' })")
    box = page.evaluate(
        "(({ left, top, width, height }) => [left, top, width, height])"
        "(document.querySelector('.u-over').getBoundingClientRect())"
    )
    page.click(box[0] + 0.5 * box[2], box[1] + 0.5 * box[3])
    middle = page.evaluate("viewer.timeline.seconds / viewer.timeline.times.at(-1)")
    assert abs(middle - 0.5) < 1.5 / last
    page.press(" ")
    page.evaluate("new Promise((done) => setTimeout(done, 1500))")
    assert page.evaluate("viewer.timeline.frame") > 0.5 * last
    assert page.complaints() == []


def test_two_runs_stand_side_by_side_with_films_beside_the_page(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, opened: Callable[..., Any]
) -> None:
    monkeypatch.setattr("motorcade.replays.pipeline.runs.INSIDE_BYTES", 50_000)
    written = write_view([run, run], tmp_path / "both.html")
    films = tuple(path.name for path in written[1:])
    assert len(films) == 2 * (1 + (run / "overlay.mp4").exists())
    page = opened(written[0], 1400)
    assert page.evaluate(READY)
    page.evaluate("viewer.view = 3, viewer.arrange(), viewer.timeline.go(5)")
    assert page.evaluate(SHOWN.replace("FRAME", "5"))
    assert page.evaluate("viewer.stage.panes.length") == 4
    assert page.evaluate("new Set(viewer.stage.panes.map((one) => one.world)).size") == 2
    assert page.evaluate(IMAGED)
    assert page.evaluate(
        "viewer.plots.charts.map(({ plot }) => plot.series.map((s) => s.run))"
    ) == [
        *(
            page.evaluate(
                "viewer.plots.charts.map(({ plot }) => plot.series.map((_, k) => "
                "Number(k >= plot.series.length / 2)))"
            )
        )
    ]
    shown = "viewer.plots.charts[0].chart.series.slice(1).filter((one) => one.show).length"
    both = page.evaluate(shown)
    page.evaluate("viewer.beside = false, viewer.arrange()")
    assert page.evaluate(shown) == both / 2
    page.evaluate("viewer.beside = true, viewer.arrange()")
    assert page.complaints(films) == []


def test_names_of_recordings_stay_words() -> None:
    """Whatever stands in a look, no browser takes it for markup."""
    hostile = "</script><script>alert(1)</script>"
    look = made(CAMERAS["pinhole"], 3).document([]) | {"name": hostile, "headline": hostile}
    assert hostile not in view_page([look], [])


def test_random_seeks_show_the_right_frame(tmp_path: Path, opened: Callable[..., Any]) -> None:
    frames = 1800
    look = made(Camera(752, 480, 458.0, 457.0, 367.0, 248.0), frames)
    page = opened(look.write(tmp_path / "minute.html", film=True))
    assert page.evaluate(READY)
    page.evaluate("viewer.view = 1, viewer.arrange()")
    rng = np.random.default_rng(3)
    asked = [0, frames - 1, *rng.integers(0, frames, 60).tolist(), *(7, 8, 7, 6, 7, 8)]
    assert page.evaluate(SEEKS.replace("FRAMES", str(asked))) == []
    assert page.complaints() == []


@pytest.mark.parametrize("name", CAMERAS)
def test_characters_stand_where_python_has_them(
    name: str, tmp_path: Path, opened: Callable[..., Any]
) -> None:
    """Vertices as the page poses them, and triangles as its graphics draw them."""
    look = made(CAMERAS[name], 12, away_m=300.0 if name == "off_centre" else 0.0)
    page = opened(look.write(tmp_path / "figure.html", film=False))
    assert page.evaluate(READY)
    page.evaluate("viewer.view = 1, viewer.arrange()")
    at = Standing(look.camera, look.world_T_camera, look.time_ns, [look.figure])
    found = apart(page, at, (0, 5, 11), np.random.default_rng(5))
    assert found.vertices > 1000
    assert found.vertices_px < 0.1
    assert found.triangles == 18
    assert found.triangles_px < 0.1
    assert page.complaints() == []
