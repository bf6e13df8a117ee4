"""TagSLAM's recordings agree with its results as they did; all of them by its command."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.end_to_end.tagslam import agrees, line, row_of, worse

MADE = {"posed": 3, "frames": 4, "seconds": 0.1, "verdict": "consistent", "denied": []}
FIGURES = {"pairs": 3, "rmse_m": 0.002, "median_m": 0.001, "rotation_rmse_deg": 0.1}


def test_a_row_says_what_agrees_and_what_got_worse() -> None:
    row = MADE | FIGURES
    assert agrees(row) is True
    assert agrees(row | {"rmse_m": 0.011}) is False
    assert agrees(row | {"rotation_rmse_deg": 0.6}) is False
    assert agrees(MADE) is None
    assert "the reference holds nothing" in line("test_0", MADE, {})
    assert "last 2.0" in line("test_0", row, FIGURES)
    assert not worse(row | {"rmse_m": 0.003}, FIGURES)
    assert worse(row | {"rmse_m": 0.0033}, FIGURES)
    assert worse(MADE, FIGURES)
    assert not worse(row, {})


@pytest.mark.slow
@pytest.mark.parametrize("test", [1, 4, 8, 16, 17, 21, 23])
def test_recordings_agree_with_their_references(data_dir: Path, test: int) -> None:
    row = row_of(data_dir / "tags" / "tagslam" / f"test_{test}")
    assert row["rmse_m"] < 0.002
    assert row["rotation_rmse_deg"] < 0.2
    assert row["verdict"] == "consistent", row["denied"]


@pytest.mark.slow
@pytest.mark.parametrize(("test", "posed"), [(15, 230), (18, 1000)])
def test_a_reference_that_holds_next_to_nothing_ends_nothing(
    data_dir: Path, test: int, posed: int
) -> None:
    row = row_of(data_dir / "tags" / "tagslam" / f"test_{test}")
    assert row["reference"] == 0
    assert row["posed"] >= posed
