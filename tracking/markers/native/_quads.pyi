"""Quads in images; see motorcade.tracking.markers.detection and reading."""

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import IntArray
from motorcade.tracking.checks import GrayImage

def find_quads(
    image: GrayImage, white_inside: bool, least_side: float, reach: int
) -> NDArray[np.float32]: ...

class Words:
    def __init__(self, words: NDArray[np.uint64], bits: int) -> None: ...
    def match(self, seen: NDArray[np.uint64], most_wrong: int) -> tuple[IntArray, IntArray]: ...
