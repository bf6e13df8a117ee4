"""Fixtures shared by every room's tests: recordings, random numbers, and whether one can draw."""

import os
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder of the real recordings; tests that ask for it skip where it is absent."""
    named = os.environ.get("MOTORCADE_DATA")
    folder = Path(named) if named else REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("no real recordings here: set MOTORCADE_DATA to their folder")
    return folder


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers that are the same in every run."""
    return np.random.default_rng(20240229)


@pytest.fixture(scope="session")
def opengl() -> None:
    """Tests that draw ask for this; they skip, with the reason in one line, where none can."""
    from motorcade.render import RenderUnavailable
    from motorcade.render.backends.platform import choose_platform

    try:
        choose_platform()
    except RenderUnavailable as missing:
        pytest.skip(str(missing))
