"""The run under sanitizers covers every compiled module: none is built that it does not load."""

import re
from pathlib import Path

import pytest

from tests.sanitized import MODULES

REPOSITORY = Path(__file__).resolve().parents[2]
RECIPE = REPOSITORY / "CMakeLists.txt"

if not RECIPE.is_file():
    pytest.skip("the source tree is not here", allow_module_level=True)


def test_every_compiled_module_is_tried_under_sanitizers() -> None:
    installed = re.findall(
        r"install\(TARGETS (\w+) LIBRARY DESTINATION ([\w/]+)\)", RECIPE.read_text()
    )
    built = {f"{folder.replace('/', '.')}.{name}" for name, folder in installed}
    assert built == MODULES
