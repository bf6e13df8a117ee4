"""Sheets measured by a PDF reader and an SVG's own numbers: true size, and found as described."""

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cv2
import numpy as np
import pypdfium2
import pytest

from motorcade.replays.cli import main
from motorcade.replays.io.readers.manifest.section import read_board
from motorcade.replays.tasks.printing import (
    PAPERS,
    Sheet,
    lay_out,
    manifest_lines,
    outlines_mm,
    paper_named,
    sheet_svg,
    sheets_pdf,
)
from motorcade.tracking import Board, board_named

BOARDS = (
    "checkerboard_9x6_22mm",
    "checkerboard_5x8_20.5mm",
    "charuco_aruco_5x5_100_7x5_26mm_19mm",
    "tag36h11_4x5_30mm_gap_9mm_from_0",
    "tagStandard41h12_2x2_30mm_gap_30mm_from_7",
    "tag36h11_id_7_100mm",
    "tagCustom48h12_id_3_50mm",
    "aruco_4x4_50_id_2_60mm",
)
PER_INCH = 300
PER_MM = PER_INCH / 25.4


def one_sheet(board: Board, paper: str = "a4") -> Sheet:
    [sheet] = lay_out([board], paper_named(paper))
    return sheet


def page(data: bytes, number: int = 0) -> tuple[np.ndarray, tuple[float, float]]:
    """A page as another program draws it, grey, and its size in millimetres."""
    document = pypdfium2.PdfDocument(data)
    drawn = document[number].render(scale=PER_INCH / 72.0, grayscale=True).to_numpy()
    width, height = document[number].get_size()
    return np.ascontiguousarray(drawn.squeeze()), (width * 25.4 / 72.0, height * 25.4 / 72.0)


@pytest.mark.parametrize("name", BOARDS)
def test_the_page_that_another_program_draws_holds_the_board_at_true_size(name):
    board = board_named(name)
    sheet = one_sheet(board)
    image, size_mm = page(sheets_pdf([sheet]))
    assert size_mm == pytest.approx((sheet.paper.width_mm, sheet.paper.height_mm), abs=1e-3)
    found = board.detect(image)
    assert found is not None
    assert len(found.ids) == len(board.points_m)
    printed_mm = sheet.origins_mm[0] + 1e3 * found.points_m[:, :2] * [1.0, -1.0]
    per_mm = np.array(image.shape[::-1]) / size_mm  # a page is drawn in whole pixels
    seen_mm = (found.corners_px + 0.5) / per_mm
    assert np.abs(seen_mm - printed_mm).max() < 0.06  # 0.7 px at 300 dots an inch
    spread = np.linalg.norm(seen_mm - seen_mm.mean(0)) / np.linalg.norm(
        printed_mm - printed_mm.mean(0)
    )
    assert spread == pytest.approx(1.0, abs=2e-4)


def test_rulers_measure_what_they_say():
    sheet = one_sheet(board_named("checkerboard_9x6_22mm"))
    image, _ = page(sheets_pdf([sheet]))
    long = sheet.lines[np.linalg.norm(np.diff(sheet.lines, axis=1)[:, 0], axis=1) > 20.0]
    assert len(long) == 2
    for start, end in long:
        assert np.linalg.norm(end - start) == 100.0
        for at in (start, 0.5 * (start + end), end):
            column, row = np.round(at * PER_MM - 0.5).astype(int)
            assert image[row - 2 : row + 3, column - 2 : column + 3].min() < 128
    words = [one.text for one in sheet.words]
    assert "100 mm across" in words
    assert "100 mm" in words


@pytest.mark.parametrize("name", BOARDS)
def test_the_svg_draws_the_pattern_in_millimetres(name):
    board = board_named(name)
    sheet = one_sheet(board)
    root = ElementTree.fromstring(sheet_svg(sheet))
    width, height = (float(root.attrib[key].removesuffix("mm")) for key in ("width", "height"))
    assert [float(one) for one in root.attrib["viewBox"].split()] == [0.0, 0.0, width, height]
    [black] = (one for one in root if one.attrib.get("fill-rule") == "evenodd")
    scale, sub = 4, 16  # a quarter of a millimetre a pixel
    canvas = np.full((round(height * scale), round(width * scale)), 255, np.uint8)
    shapes = [
        np.array(re.findall(r"(-?[\d.e-]+),(-?[\d.e-]+)", part), float)
        for part in black.attrib["d"].split("Z")
        if part.strip()
    ]
    cv2.fillPoly(
        canvas,
        [np.round((shape * scale - 0.5) * sub).astype(np.int32) for shape in shapes],
        0,
        shift=4,
    )
    found = board.detect(cv2.GaussianBlur(canvas, (3, 3), 0))
    assert found is not None
    assert len(found.ids) == len(board.points_m)


def test_outlines_cover_each_black_cell_once():
    pattern = board_named("tag36h11_4x5_30mm_gap_9mm_from_0").pattern
    signed = [
        0.5 * float(np.sum(s[:, 0] * np.roll(s[:, 1], -1) - np.roll(s[:, 0], -1) * s[:, 1]))
        for s in outlines_mm(pattern)
    ]
    cells = np.outer(np.diff(pattern.y_edges_m), np.diff(pattern.x_edges_m))
    assert sum(signed) == pytest.approx(1e6 * cells[~pattern.white].sum())
    assert min(signed) < 0.0 < max(signed)  # holes run the other way


def test_single_markers_share_sheets_without_touching():
    boards = [board_named(f"tag36h11_id_{number}_50mm") for number in range(14)]
    sheets = lay_out(boards, paper_named("a4"))
    assert [board for sheet in sheets for board in sheet.boards] == boards
    assert len(sheets) < len(boards) / 2
    for number, sheet in enumerate(sheets):
        image, _ = page(sheets_pdf(sheets), number)
        for board in sheet.boards:
            found = board.detect(image)
            assert found is not None
            assert len(found.ids) == 4
    assert manifest_lines(boards) == ('[markers]\nfamily = "tag36h11"\nside_m = 0.05\n',)


def test_a_board_lies_where_it_does_not_stand_and_is_refused_where_it_does_neither():
    wide, tall = board_named("checkerboard_9x6_22mm"), board_named("checkerboard_6x9_22mm")
    assert one_sheet(wide).paper.width_mm == 297.0
    assert one_sheet(tall).paper.width_mm == 210.0
    with pytest.raises(ValueError, match=r"checkerboard_9x6_40mm: needs .* print it on a2") as told:
        one_sheet(board_named("checkerboard_9x6_40mm"))
    named = re.search(r"print it on (\w+)", str(told.value))
    assert named is not None
    one_sheet(board_named("checkerboard_9x6_40mm"), named[1])
    with pytest.raises(ValueError, match="make it smaller"):
        one_sheet(board_named("checkerboard_9x6_400mm"))
    with pytest.raises(ValueError, match="expected at least one"):
        lay_out([], PAPERS["a4"])


@pytest.mark.parametrize("name", ["", "a9", "0x10mm", "1e3x5mm", "9999x10mm", "300x400"])
def test_no_paper_of_that_name(name):
    with pytest.raises(ValueError, match=r"paper: expected a4, .* 300x400mm"):
        paper_named(name)


@pytest.mark.parametrize("name", BOARDS)
def test_the_tables_beside_a_sheet_describe_its_board(name, tmp_path: Path, capsys):
    output = tmp_path / "board.pdf"
    assert main(["print", name, "-o", str(output)]) == 0
    assert read_board(str(tmp_path / "board.toml")) == board_named(name)
    assert "print at 100 %" in capsys.readouterr().out
    before = output.read_bytes()
    assert main(["print", str(tmp_path / "board.toml"), "-o", str(output)]) == 0
    assert output.read_bytes() == before  # the same sheet, the same bytes


def test_several_sheets_of_svg_have_a_file_each(tmp_path: Path):
    output = tmp_path / "tags.svg"
    line = ["print", "tag36h11_id_0_120mm", "--count", "3", "-o", str(output)]
    assert main(line) == 0
    made = sorted(one.name for one in tmp_path.iterdir())
    assert made == ["tags.toml", "tags_1.svg", "tags_2.svg", "tags_3.svg"]


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (["tag36h11_id_0_60mm", "-o", "x.png"], "ends in .pdf or .svg"),
        (["checkerboard_9x6_22mm", "--count", "2", "-o", "x.pdf"], "only single markers"),
        (["tag36h11_id_0_60mm", "--count", "0", "-o", "x.pdf"], "--count: expected 1 or more"),
        (["tag36h11_id_586_60mm", "--count", "9", "-o", "x.pdf"], "tag36h11"),
        (["nonsense", "-o", "x.pdf"], "board: expected a name such as"),
    ],
)
def test_refusals_name_the_option(line, told, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["print", *line]) == 1
    assert told in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
