"""The marker benchmark counts what each detector finds in the same images, on one thread."""

from pathlib import Path

import cv2
import pytest

from motorcade.tracking import MarkerGrid
from tests.bench.tracking import tag_markers
from tests.bench.tracking.tag_markers import (
    bench_markers,
    markers_table,
    measure_images,
)
from tests.bench.tracking.tag_recall import measure_recall, recall_table


def test_all_three_count_the_same_print(tmp_path: Path) -> None:
    image, _ = MarkerGrid("tag36h11", 3, 2, 0.04, 0.01).draw(1500.0)
    for name in ("a.png", "b.png"):
        cv2.imwrite(str(tmp_path / name), cv2.GaussianBlur(image, (0, 0), 0.8))
    threads = cv2.getNumThreads()
    found = measure_images([tmp_path / "a.png", tmp_path / "b.png"], 1)
    assert cv2.getNumThreads() == threads
    assert found["count"] == 2
    assert found["found"] == {"motorcade": 12, "apriltag": 12, "opencv": 12}
    assert found["times_apriltag"]["apriltag"] == 1.0
    assert all(ms > 0.0 for ms in found["ms_an_image"].values())


def test_the_table_has_a_row_a_detector_or_says_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTORCADE_DATA", str(tmp_path))
    assert "set MOTORCADE_DATA" in markers_table(bench_markers())
    image, _ = MarkerGrid("tag36h11", 1, 1, 0.04, 0.01, first_id=9).draw(1500.0)
    (tmp_path / "tags" / "multi").mkdir(parents=True)
    cv2.imwrite(str(tmp_path / "tags" / "multi" / "a.png"), image)
    monkeypatch.setattr(tag_markers, "ROUNDS", 1)
    table = markers_table(bench_markers())
    assert [line.split(",")[1].split()[:2] for line in table.splitlines()[1:]] == [
        ["motorcade", "1"],
        ["apriltag", "1"],
        ["opencv", "1"],
    ]


@pytest.mark.slow
def test_more_are_found_in_drawn_scenes_than_the_libraries_find_together() -> None:
    found = measure_recall(12, first_seed=500)
    assert found["right"]["motorcade"] >= found["libraries_together"] > found["right"]["apriltag"]
    assert found["false"]["motorcade"] == 0
    assert "together" in recall_table(found)
