"""Rendering tests share one check: whether this machine can draw at all."""

import pytest

from motorcade.render import RenderUnavailable
from motorcade.render.backends.platform import choose_platform


@pytest.fixture(scope="session")
def opengl() -> None:
    """Tests that draw ask for this; they skip, with the reason in one line, where none can."""
    try:
        choose_platform()
    except RenderUnavailable as missing:
        pytest.skip(str(missing))
