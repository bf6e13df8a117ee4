"""Contradictions planted in drawn recordings are named with a mend that helps; clean ones pass."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest

from motorcade.tracking.targets import find_target
from tests.end_to_end.contradictions.__main__ import drawn_base, judged
from tests.end_to_end.contradictions.drawing import Drawn
from tests.end_to_end.contradictions.kinds import BASES, Kind, kinds
from tests.end_to_end.contradictions.running import followed, run, said

CLOSING = (
    'CONTRADICTED: ids run upwards; say order = "up", rows = 3, or leave [board] out; the board\'s '
    "views fit to 0.02 px; say fx = 420.10, distortion = [-0.3000, 0.1000, 0.0000, 0.0000]; done"
)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("drawn")


def test_keys_are_read_off_a_closing_line() -> None:
    assert said(CLOSING) == {
        "order": '"up"',
        "rows": "3",
        "fx": "420.10",
        "distortion": "[-0.3000, 0.1000, 0.0000, 0.0000]",
    }
    assert said("done as far as integrity; look into out") == {}


def test_the_manifest_follows_a_closing_line() -> None:
    text = '[camera]\nfx = 500.0\n[board]\ntype = "marker_grid"\nrows = 4\n'
    mended = followed(Drawn(Path(), text), CLOSING, {}).manifest
    assert "rows = 3\n" in mended.partition("[board]")[2]
    assert "rows = 4" not in mended
    assert "fx = 420.10\n" in mended.partition("[board]")[0]


def test_there_are_sixty_kinds_and_all_have_names_of_their_own() -> None:
    names = [(kind.base, kind.name) for kind in kinds()]
    assert len(names) == len(set(names)) >= 60


def named(kind: Kind) -> object:
    """The kind as a parameter, of which an open one may fail."""
    marks = [pytest.mark.xfail(reason=kind.open, strict=False)] if kind.open else []
    return pytest.param(kind, id=f"{kind.base}: {kind.name}", marks=marks)


@pytest.mark.slow
@pytest.mark.parametrize("kind", map(named, kinds()))
def test_each_contradiction_is_named_with_a_mend_that_helps(kind: Kind, drawn: Path) -> None:
    verdict, closing = judged(kind, drawn, seed=20)
    assert verdict == "named", closing


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
def test_clean_recordings_are_not_doubted(base: str, drawn: Path) -> None:
    answer = run(drawn_base(drawn, base, 21))
    assert answer.code == 0, answer.closing


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "manifest", "mend"),
    [
        ("grid_ids_upwards/pictures", "kalibr_order.toml", 'say order = "up"'),
        ("grid_rows_columns/pictures", "swapped.toml", "say columns = 4, rows = 3"),
        ("intrinsics_of_full_size/pictures", "m.toml", "divide fx, fy, cx and cy by 2"),
        ("two_cameras_one_folder/two_cameras", "m.toml", None),
    ],
)
def test_cases_that_users_met_are_named(
    case: str, manifest: str, mend: str | None, data_dir: Path
) -> None:
    folder = data_dir / "cases" / case
    stated = Drawn(folder, (folder.parent / manifest).read_text())
    answer = run(stated)
    assert answer.code == 1, answer.closing
    if mend is None:
        assert "two_cameras" in answer.closing
        return
    assert mend in answer.closing
    if "intrinsics" not in case:  # whose images alone tell no pose
        again = run(followed(stated, answer.closing, {}))
        assert again.code == 0, again.closing


@pytest.mark.slow
def test_kalibr_s_aprilgrid_is_read_whole(data_dir: Path) -> None:
    paths = sorted((data_dir / "cases" / "kalibr_aprilgrid" / "pictures").glob("*.jpg"))
    target = find_target([cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in paths])
    assert target is not None
    assert target.family == "tag36h11_border2"
    assert len(target.marker_ids) == 12
