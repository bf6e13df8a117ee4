"""The page of every recording at hand: characters stand in it where Python has them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Trajectory
from motorcade.replays.cli.main import main
from motorcade.replays.pipeline.look import LookedAt, look_of
from motorcade.replays.pipeline.packing import drawn_name
from motorcade.replays.pipeline.runs import open_look
from motorcade.replays.stages.view.acting import performers
from motorcade.replays.stages.view.overlay import extrapolated
from motorcade.replays.web.page import view_page
from tests.end_to_end.pages.drawn_where import Standing, apart
from tests.end_to_end.pages.test_view import READY

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("pages")]

MANIFESTS = Path(__file__).resolve().parents[3] / "docs" / "manifests"
WITHIN_PX = 0.1
FRAMES = 6
RECORDINGS = {
    "replays/vamr_board": "vamr_board.toml",
    "replays/7scenes_redkitchen": None,
    "replays/7scenes_redkitchen_200": None,
    "replays/euroc_V1_01": "euroc_v1_01.toml",
    "replays/kitti_short": None,
    "replays/gopro/karma.mp4": "gopro_karma.toml",
    "tags/tagslam/test_21": None,
    "tags/tagslam/test_23": None,
}


def path_of(run: LookedAt, name: str) -> Trajectory:
    """One of a run's paths, as far as it is drawn along."""
    measured = run.findings.camera_poses.measurements.trajectory
    paths = {"measured": measured, **run.findings.smoothed.trajectories}
    return extrapolated(paths[name], measured)


def standing(run: LookedAt, path: Trajectory) -> Standing:
    """What a page of the run has to show along a path, by Python alone."""
    stamps = run.recording.frames.time_ns
    inside = np.clip(stamps, path.time_ns[0], path.time_ns[-1])
    assert run.recording.camera is not None
    figures = performers(run.findings.placed, 1e-9 * float(np.ptp(stamps)))
    return Standing(run.recording.camera, path.motors_at(inside), stamps, figures)


def looked_at(run: LookedAt, path: Trajectory, other: Trajectory) -> list[int]:
    """Frames that a path has a pose for: spread over the run, and where another is farthest off."""
    stamps = run.recording.frames.time_ns
    first, last = (pick(path.time_ns[k], other.time_ns[k]) for pick, k in ((max, 0), (min, -1)))
    known = np.flatnonzero((stamps >= first) & (stamps <= last))
    apart_rad = (path.motors_at(stamps[known]).inverse() @ other.motors_at(stamps[known])).rotor
    farthest = np.linalg.norm(apart_rad.as_rotation_vector(), axis=-1).argmax()
    spread = np.linspace(0, len(known) - 1, FRAMES).round().astype(int)
    return [int(frame) for frame in dict.fromkeys(known[[*spread, farthest]].tolist())]


@pytest.mark.parametrize("name", RECORDINGS)
def test_characters_stand_where_python_has_them(
    name: str, data_dir: Path, tmp_path: Path, opened: Callable[..., Any]
) -> None:
    """Along the path that is drawn and along Euler angles, to a tenth of a pixel."""
    recording, manifest = data_dir / name, RECORDINGS[name]
    if not recording.exists():
        pytest.skip(f"no {name} among the recordings here")
    words = [] if manifest is None else ["--manifest", str(MANIFESTS / manifest)]
    out = tmp_path / "run"
    assert main(["run", str(recording), *words, "--out", str(out), "--until", "report"]) == 0
    run = open_look(out)
    (tmp_path / "page.html").write_text(view_page([look_of(run, [])], []), encoding="utf-8")
    page = opened(tmp_path / "page.html")
    assert page.evaluate(READY)
    rng = np.random.default_rng(11)
    drawn, euler = (path_of(run, one) for one in (drawn_name(run.findings), "euler"))
    frames = looked_at(run, drawn, euler)
    for path_name, path in ((drawn_name(run.findings), drawn), ("euler", euler)):
        page.evaluate(f"viewer.view = 1, viewer.pathOf[0] = '{path_name}', viewer.arrange()")
        found = apart(page, standing(run, path), frames, rng)
        assert min(found.vertices, found.triangles) > 0
        assert found.vertices_px <= WITHIN_PX
        assert found.triangles_px <= WITHIN_PX
    assert page.complaints() == []
