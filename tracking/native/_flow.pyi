"""Corners of one image found in another; see motorcade.tracking.images."""

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.checks import GrayImage

class Pyramid:
    """An image with all that tracking corners needs of it, for one that is used again."""

    def __init__(self, image: GrayImage) -> None: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...

def follow_corners(
    before: Pyramid,
    after: Pyramid,
    px: FloatArray,
    guess: FloatArray,
    return_px: float,
    threads: int,
) -> tuple[FloatArray, NDArray[np.bool_]]: ...
