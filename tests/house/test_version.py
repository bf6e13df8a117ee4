"""The package above the rooms says its version, and imports none of them."""

import subprocess
import sys
from importlib.metadata import version

import motorcade


def test_version_is_the_installed_one() -> None:
    assert motorcade.__version__ == version("motorcade")


def test_the_package_imports_no_room() -> None:
    code = "import sys, motorcade; print([n for n in sys.modules if n.startswith('motorcade.')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
