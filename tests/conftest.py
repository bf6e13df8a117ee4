"""Fixtures shared by every room's tests: recordings, random numbers, and whether one can draw."""

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave most cases of long tests to the slow part; run each module's fixtures in one process.

    Tests that share a module's fixture are run by one process, so that it is made once.
    """
    cases: Counter[str] = Counter()
    for item in items:
        sampled = item.get_closest_marker("quick_every")
        if sampled is not None:
            test = item.nodeid.partition("[")[0]
            if cases[test] % sampled.args[0]:
                item.add_marker(pytest.mark.slow)
            cases[test] += 1
        made = getattr(item, "_fixtureinfo", None)
        shared = {
            definition.baseid
            for definitions in (made.name2fixturedefs.values() if made else ())
            for definition in definitions
            if definition.scope == "module"
        }
        if shared and item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.nodeid.split("::")[0]))


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
