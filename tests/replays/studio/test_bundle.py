"""The bundle of three.js and uPlot is what its lockfile makes, and its licences go with it."""

import json
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

from motorcade.replays import web

WEB = Path(web.__file__).with_name("modules")
MADE = ("vendor.js", "vendor.css", "VENDOR_LICENSES.txt")


def test_the_licences_of_both_libraries_lie_beside_the_bundle() -> None:
    told = (WEB / "VENDOR_LICENSES.txt").read_text()
    head = (WEB / "vendor.js").read_text().split("\n", 1)[0]
    for name in ("three", "uplot"):
        assert f"{name} " in told
        assert f"{name} " in head
    assert told.count("Permission is hereby granted") == 2


def test_wheels_hold_the_modules_and_not_what_makes_them() -> None:
    paths = pytest.importorskip("scikit_build_core.build._pathutil", reason="builds wheels")
    recipe = WEB.parents[2] / "pyproject.toml"
    if not recipe.exists():
        pytest.skip("an installed wheel is tested")
    told = tomllib.loads(recipe.read_text())["tool"]["scikit-build"]["wheel"]["exclude"]
    found = paths.iter_package_files(
        packages={"motorcade/replays": str(WEB.parents[1])},
        include=[],
        src_exclude=[],
        target_exclude=told,
        build_dir="build",
        mode="default",
    )
    held = {target.name for _, target in found if "modules" in target.parts}
    assert {"vendor.js", "vendor.css", "VENDOR_LICENSES.txt", "camera.js", "studio.css"} <= held
    assert not held & {"entry.js", "build.js", "package.json", ".npmrc", "eslint.config.js"}
    assert not any(name.endswith(".test.js") for name in held)


def test_the_lockfile_pins_bytes_and_names_no_host() -> None:
    lockfile = WEB / "package-lock.json"
    if not lockfile.exists():
        pytest.skip("an installed wheel is tested")
    packages = json.loads(lockfile.read_text())["packages"]
    installed = [one for name, one in packages.items() if name]
    assert installed
    assert all(one["integrity"].startswith("sha512-") for one in installed)
    assert not any("resolved" in one for one in installed)


@pytest.mark.slow
def test_the_bundle_is_what_the_lockfile_makes(tmp_path: Path) -> None:
    npm = shutil.which("npm")
    if npm is None or not (WEB / "package-lock.json").exists():
        pytest.skip("no npm here, or an installed wheel is tested")
    for name in ("package.json", "package-lock.json"):
        shutil.copy(WEB / name, tmp_path)
    shutil.copytree(WEB / "bundle", tmp_path / "bundle")
    for told in (["ci", "--silent"], ["run", "--silent", "vendor"]):
        subprocess.run([npm, *told], cwd=tmp_path, check=True, capture_output=True)
    for name in MADE:
        assert (tmp_path / name).read_bytes() == (WEB / name).read_bytes(), name
