"""Drawn scenes whose board is to be counted; `python -m tests.tracking.targets.counting` judges.

Each scene is a dozen images of a sheet seen from anywhere: a checkerboard of any size with what
lies beside or upon it, or a texture that is none. `count_drawn(kind, seed)` draws one.
"""

import sys
import time
from collections.abc import Callable

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.targets.chessboards import checkerboard_seen

SQUARE = 32
PAPER, INK, TABLE = 215, 35, 120
WIDTH, HEIGHT, FOCAL = 640, 480, 600.0
IMAGES = 12
Sheet = FloatArray
Rng = np.random.Generator


def board_sheet(columns: int, rows: int, margin: int = SQUARE) -> Sheet:
    """A board of so many inner corners, a black square at the top left, on white paper."""
    colours = np.indices((rows + 1, columns + 1)).sum(axis=0) % 2
    squares = np.kron(np.where(colours == 0, INK, PAPER), np.ones((SQUARE, SQUARE)))
    return np.pad(squares.astype(np.float64), margin, constant_values=PAPER)


def with_lines(sheet: Sheet) -> Sheet:
    """Thin lines along the left and right edges of the squares, as some prints have them."""
    drawn = sheet.copy()
    drawn[SQUARE:-SQUARE, SQUARE - 1 : SQUARE + 1] = INK
    drawn[SQUARE:-SQUARE, -SQUARE - 1 : -SQUARE + 1] = INK
    return drawn


def with_frame(sheet: Sheet) -> Sheet:
    """A thick dark frame about the squares, a square away from them."""
    framed = np.pad(sheet, SQUARE, constant_values=INK)
    return np.pad(framed, SQUARE, constant_values=PAPER)


def with_keys(sheet: Sheet) -> Sheet:
    """A keyboard of dark keys close to the right of the squares, as high as they are."""
    keys = np.full((SQUARE, SQUARE), PAPER, np.float64)
    keys[3:-3, 3:-3] = INK + 20
    beside = np.kron(np.ones((len(sheet) // SQUARE, 4)), keys)
    return np.concatenate([sheet[:, : -SQUARE // 2], beside[: len(sheet)]], axis=1)


def two_boards(sheet: Sheet) -> Sheet:
    """A smaller board of another size beside the board."""
    other = cv2.resize(board_sheet(4, 3), None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA)
    beside = np.full((len(sheet), other.shape[1]), float(PAPER))
    beside[: other.shape[0]] = other[: len(sheet)]
    return np.concatenate([sheet, beside], axis=1)


def bricks(rng: Rng) -> Sheet:
    """A wall: rows of bricks, each shifted by half, with grey joints."""
    wall = np.full((12 * SQUARE, 16 * SQUARE), 170.0)
    for row in range(12):
        for place in range(-1, 9):
            left = (2 * place + row % 2) * SQUARE
            shade = rng.uniform(60.0, 110.0)
            wall[row * SQUARE + 3 : (row + 1) * SQUARE, max(left + 3, 0) : left + 2 * SQUARE] = (
                shade
            )
    return wall


def tiles(rng: Rng) -> Sheet:
    """Tiles of any shade with dark joints."""
    shades = rng.uniform(90.0, 220.0, (10, 14))
    floor = np.kron(shades, np.ones((SQUARE, SQUARE)))
    floor[::SQUARE] = floor[1::SQUARE] = 50.0
    floor[:, ::SQUARE] = floor[:, 1::SQUARE] = 50.0
    return floor


def keyboard(rng: Rng) -> Sheet:
    """Dark keys with light signs, each row shifted against the one above."""
    board = np.full((5 * SQUARE, 15 * SQUARE), 190.0)
    for row in range(5):
        for key in range(14):
            left = key * SQUARE + 7 * row % SQUARE
            board[row * SQUARE + 3 : (row + 1) * SQUARE - 2, left + 3 : left + SQUARE - 2] = 45.0
            top = row * SQUARE + rng.integers(6, 14)
            board[top : top + 8, left + 8 : left + 13] = 180.0
    return np.pad(board, SQUARE, constant_values=120.0)


def seen_from(sheet: Sheet, rng: Rng, side_px: float, tilt_deg: float, off: FloatArray) -> Sheet:
    """The sheet on a table, a square in its middle `side_px` wide, the middle off by `off` px."""
    height, width = sheet.shape
    turn, _ = cv2.Rodrigues(np.array([0.0, 0.0, rng.uniform(-0.6, 0.6)]))
    way = rng.uniform(0.0, 2.0 * np.pi)
    tilt, _ = cv2.Rodrigues(np.radians(tilt_deg) * np.array([np.cos(way), np.sin(way), 0.0]))
    rotation = tilt @ turn
    centred = np.array([[1.0, 0.0, -0.5 * width], [0.0, 1.0, -0.5 * height], [0.0, 0.0, 1.0]])
    pose = np.column_stack([rotation[:, 0], rotation[:, 1], [0.0, 0.0, FOCAL * SQUARE / side_px]])
    camera = np.array([[FOCAL, 0.0, 0.5 * WIDTH], [0.0, FOCAL, 0.5 * HEIGHT], [0.0, 0.0, 1.0]])
    camera[:2, 2] += off
    double = np.diag([3.0, 3.0, 1.0]) @ camera @ pose @ centred
    size = (3 * WIDTH, 3 * HEIGHT)
    large = cv2.warpPerspective(sheet, double, size, None, cv2.INTER_LINEAR, borderValue=TABLE)
    return cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)


def glared(image: Sheet, rng: Rng) -> Sheet:
    """A soft bright blob near the middle that leaves a seventh of the contrast."""
    y, x = np.indices(image.shape)
    at = rng.uniform(-70.0, 70.0, 2) + np.array([0.5 * WIDTH, 0.5 * HEIGHT])
    blob = np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2) / (2.0 * 45.0**2))
    return image + 0.85 * blob * (225.0 - image)


DRESSED: dict[str, Callable[[Sheet], Sheet]] = {
    "lines beside": with_lines,
    "frame": with_frame,
    "keys beside": with_keys,
    "two boards": two_boards,
}
BOARDS = (
    "plain",
    "head on",
    *DRESSED,
    "glare",
    "cut off",
    "small",
    "blurred",
    "low contrast",
    "no border",
)
TEXTURES: dict[str, Callable[[Rng], Sheet]] = {
    "bricks": bricks,
    "tiles": tiles,
    "keyboard": keyboard,
}


def drawn_scene(kind: str, seed: int) -> tuple[list[np.ndarray], tuple[int, int] | None]:
    """Images of a scene, and the board's columns and rows, the longer way first."""
    rng = np.random.default_rng([seed, *kind.encode()])
    size = None
    if kind in TEXTURES:
        sheet = TEXTURES[kind](rng)
    else:
        rows = int(rng.integers(3, 10))
        size = int(rng.integers(rows + 1, min(15, 2 * rows + 2))), rows
        sheet = board_sheet(*size, margin=0 if kind == "no border" else SQUARE)
        sheet = DRESSED.get(kind, lambda same: same)(sheet)
        sheet = sheet if rng.random() < 0.5 else np.rot90(sheet).copy()
    fitting = SQUARE * 0.62 * min(WIDTH / sheet.shape[1], HEIGHT / sheet.shape[0])
    images = []
    for number in range(IMAGES):
        side_px = fitting * rng.uniform(0.8, 1.05)
        tilt = 0.0 if kind == "head on" else rng.uniform(5.0, 45.0)
        off = rng.uniform(-15.0, 15.0, 2)
        if kind == "small":
            side_px = min(rng.uniform(11.0, 14.0), fitting)
        if kind == "cut off":  # it slides out of the image, half of the time
            off[0] += max(0.0, number - 5) * 55.0
        image = seen_from(sheet, rng, side_px, tilt, off)
        image = glared(image, rng) if kind == "glare" else image
        blur = 0.12 * side_px if kind == "blurred" else 0.7
        image = cv2.GaussianBlur(image, (0, 0), blur)
        if kind == "low contrast":
            image = 90.0 + 0.18 * (image - 120.0)
        image = image + rng.normal(0.0, 1.0 if kind == "low contrast" else 2.0, image.shape)
        images.append(np.clip(np.rint(image), 0, 255).astype(np.uint8))
    return images, size


def count_drawn(kind: str, seed: int) -> tuple[tuple[int, int] | None, tuple[int, int] | None, int]:
    """The board that a scene shows, the one that is counted, and in how many images."""
    images, size = drawn_scene(kind, seed)
    counted = checkerboard_seen(images)
    if counted is None:
        return size, None, 0
    return size, (counted.columns, counted.rows), len(counted.images)


def main(seeds: range) -> None:
    """Print how many scenes of each kind are counted right, wrong or not at all."""
    print("| kind | right | wrong | not counted | images | s a scene |\n|---|---|---|---|---|---|")
    for kind in (*BOARDS, *TEXTURES):
        start = time.process_time()
        results = [count_drawn(kind, seed) for seed in seeds]
        seconds = (time.process_time() - start) / len(results)
        right = sum(size == counted for size, counted, _ in results)
        none = sum(counted is None and size is not None for size, counted, _ in results)
        wrong = [
            f"{counted} of {size}" for size, counted, _ in results if counted not in (size, None)
        ]
        shown = np.mean([count for *_, count in results])
        said = f"{len(wrong)} {', '.join(wrong)}"
        print(f"| {kind} | {right} | {said} | {none} | {shown:.1f} | {seconds:.2f} |", flush=True)


if __name__ == "__main__":
    first = int(sys.argv[1]) if len(sys.argv) > 1 else 0
    main(range(first, first + (int(sys.argv[2]) if len(sys.argv) > 2 else 8)))
