"""`doctor` tells what is here as other programs tell it, and fails only for a broken install."""

import json
import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

from motorcade.ga import kernels
from motorcade.replays.cli import main
from motorcade.replays.tasks.doctor import OPTIONAL, Finding, examine, examine_packages, flags, simd

REPOSITORY = Path(__file__).resolve().parents[3]
LOADER = Path("/lib64/ld-linux-x86-64.so.2")
V2 = "cx16 lahf_lm popcnt pni sse4_1 sse4_2 ssse3"
V3 = f"{V2} avx avx2 bmi1 bmi2 f16c fma abm movbe xsave"
V4 = f"{V3} avx512f avx512bw avx512cd avx512dq avx512vl"

WITHOUT_KERNELS = """
import importlib.abc, importlib.util, sys
class Broken(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(self, name, path=None, target=None):
        if name == "motorcade.ga.kernels._compiled":
            return importlib.util.spec_from_loader(name, self)
    def create_module(self, spec):
        raise ImportError("undefined symbol: of_another_python")
    def exec_module(self, module):
        pass
sys.meta_path.insert(0, Broken())
from motorcade.replays.cli import main
sys.exit(main(["doctor", "--json"]))
"""


@pytest.fixture(scope="module")
def found() -> dict[str, Finding]:
    return {one.name: one for one in examine()}


@pytest.mark.skipif(not LOADER.exists(), reason="no loader of x86-64 here to ask")
def test_the_version_picked_is_the_best_that_the_loader_supports() -> None:
    told = subprocess.run([LOADER, "--help"], capture_output=True, text=True, check=True).stdout
    levels = re.findall(r"(x86-64-v[34]) \(supported", told)
    best = max(levels, default="x86-64 ")
    assert simd(flags()).startswith(best)


@pytest.mark.parametrize(
    ("known", "level"),
    [
        (V4, "x86-64-v4"),
        (V4.replace(" avx512dq", ""), "x86-64-v3"),
        (V3, "x86-64-v3"),
        (V3.replace(" fma", ""), "x86-64 "),
        ("", "x86-64 "),
    ],
)
def test_a_level_needs_all_its_flags(tmp_path: Path, known: str, level: str) -> None:
    file = tmp_path / "cpuinfo"
    file.write_text(f"processor\t: 0\nflags\t\t: {known} fpu vme\n")
    assert simd(flags(file), "x86_64").startswith(level)


def test_other_machines_are_named() -> None:
    assert simd(frozenset({"asimd"}), "aarch64").startswith("aarch64")


def test_what_is_found_here_agrees_with_what_the_rest_of_the_house_uses(
    found: dict[str, Finding],
) -> None:
    assert found["kernels"].detail == kernels.backend
    assert found["threads"].detail.startswith(f"{kernels.threads()} of ")
    assert found["H.264"].works
    assert version("av") in found["H.264"].detail
    assert all(one.works or one.remedy for one in found.values())


def test_every_optional_package_of_the_project_is_told_of() -> None:
    extras = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"][
        "optional-dependencies"
    ]
    for extra in set(extras) - {"dev", "docs"}:
        names = {re.split(r"[>=<\[]", entry)[0] for entry in extras[extra]} - {"motorcade"}
        assert names == set(OPTIONAL[extra]), extra
    assert {one.detail for one in examine_packages() if one.name == "scipy"} == {version("scipy")}


def test_a_missing_package_names_the_extra_that_brings_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(OPTIONAL["scale"], "no-such-package", ("no_such", "nothing"))
    (missing,) = (one for one in examine_packages() if one.name == "no-such-package")
    assert not missing.works
    assert "motorcade[scale]" in missing.remedy


def test_a_whole_install_exits_0_and_prints_each_thing(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor"]) == 0
    printed = capsys.readouterr().out
    for name in ("kernels", "C compiler", "EGL", "OSMesa", "H.264", "pyarrow"):
        assert name in printed


def test_kernels_that_do_not_load_are_a_broken_install() -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_KERNELS], capture_output=True, text=True, check=False
    )
    told = json.loads(done.stdout)
    assert done.returncode == 1
    assert not told["works"]
    assert "of_another_python" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_the_numpy_kernels_are_slower_and_not_broken() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from motorcade.replays.cli import main; main(['doctor'])"],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"MOTORCADE_KERNELS": "numpy"},
    )
    assert re.search(r"-- SIMD +MOTORCADE_KERNELS asks for NumPy", done.stdout)
