"""The package above the rooms says its version, and imports none of them."""

import re
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import yaml

import motorcade

REPOSITORY = Path(__file__).resolve().parents[2]


def test_version_is_the_installed_one() -> None:
    assert motorcade.__version__ == version("motorcade")


def test_the_package_imports_no_room() -> None:
    code = "import sys, motorcade; print([n for n in sys.modules if n.startswith('motorcade.')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_changelog_and_citation_name_the_version_of_the_project() -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    cited = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text())
    latest = re.search(r"^## (\S+)", (REPOSITORY / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert latest is not None
    assert latest[1] == cited["version"] == project["version"]
    assert cited["license"] == project["license"]
