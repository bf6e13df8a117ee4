"""What is used of torch and kornia, or the word that they are not there."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = [
    "PhotometricUnavailable",
    "best_device",
    "homography_warp",
    "one_thread",
    "require",
]


class PhotometricUnavailable(RuntimeError):
    """Torch or kornia is not installed; the message says how to get them."""


def require() -> Any:
    """The module torch.

    Raises:
        PhotometricUnavailable: it or kornia is missing.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # kornia compiles scripts in a way torch has given up
            import kornia.geometry.transform  # noqa: F401
            import torch
    except ImportError as missing:
        raise PhotometricUnavailable(
            f"photometric refinement needs torch and kornia ({missing.name} is missing): "
            'pip install "motorcade[photometric]"'
        ) from missing
    return torch


def best_device() -> str:
    """The GPU where there is one, else the processor."""
    return "cuda" if require().cuda.is_available() else "cpu"


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch compute on one thread: on batches as small as these others only wait."""
    torch = require()
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def homography_warp(*arguments: Any, **keywords: Any) -> Any:
    """Kornia's, see there."""
    require()
    from kornia.geometry.transform import homography_warp as warp

    return warp(*arguments, **keywords)
