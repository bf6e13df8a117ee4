"""Files are opened at the door alone, and SECURITY.md names each of its limits as the code does."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from tests.house.sources import SOURCES, tree_of

pytestmark = SOURCES
REPOSITORY = Path(__file__).resolve().parents[2]
PAGE = REPOSITORY / "SECURITY.md"
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
DOOR = {"read_bounded", "open_bounded", "admit_file", "read_arrays"}
# Names of calls that open a file, however they are reached: path.open, np.load, av.open, ...
OPENERS = re.compile(
    r"(.*\.)?(open|fdopen|read_bytes|read_text|fromfile|genfromtxt|loadtxt|memmap|open_memmap|mmap"
    r"|imread|imreadmulti|VideoCapture|FileStorage|ZipFile|TarFile|connect|File|ParquetFile"
    r"|read_csv|read_parquet|Reader[12]?)|(np|numpy|json|tomllib)\.load|ET\.parse"
)
# What opens files outside the door, and why it may.
ALLOWED = {
    ("ga/files.py", "path.open"): "the door",
    ("ga/files.py", "os.open"): "the door",
    ("ga/files.py", "os.fdopen"): "the door",
    ("ga/archives.py", "np.load"): "a file that the door has opened",
    ("ga/archives.py", "ZipFile"): "a file that the door has opened",
    ("ga/archives.py", "archive.open"): "a part of it",
    ("fusion/smoothing/header/__init__.py", "part.read_text"): "our own source",
    ("ga/codegen/targets/c_elementary.py", "_HEADER.read_text"): "our own source",
    ("ga/codegen/targets/c_elementary.py", "_SUPPORT.read_text"): "our own source",
    ("ga/codegen/targets/names.py", "_TABLE.read_text"): "our own source",
    (
        "ga/codegen/runtime/evaluator.py",
        "os.open",
    ): "a library of our own, looked at before it is read",
    ("ga/codegen/runtime/evaluator.py", "os.fdopen"): "a library of our own, see above",
    ("ga/codegen/runtime/evaluator.py", "library_file.read_bytes"): "what was just compiled",
    (
        "ga/drawing/svg.py",
        "(Path(__file__).parent / 'turning.js').read_text",
    ): "our own source",
    ("ga/unfinished.py", "boot.read_text"): "the system's",
    ("ga/unfinished.py", "MOUNTS.read_text"): "the system's",
    ("ga/unfinished.py", "os.open"): "a lock, which is never read, or a folder, to lock it",
    ("animation/formats/gltf/compression.py", "np.load"): "bytes in memory",
    ("tracking/markers/families.py", "np.load"): "our own table",
    ("animation/formats/images.py", "Image.open"): "bytes in memory",
    ("render/backends/programs.py", "(_SHADERS / name).read_text"): "our own source",
    ("render/backends/programs.py", "_CARRYING.read_text"): "our own source",
    ("render/video.py", "av.open"): "admitted",
    ("replays/cli/inspection.py", "webbrowser.open"): "a page, in the browser",
    ("replays/cli/runs.py", "recording.open"): "a pipe, to a bounded copy that the door admits",
    ("replays/tasks/doctor.py", "cpuinfo.read_text"): "the system's",
    ("replays/engine/artifacts.py", "path.open"): "what was just written, to have it on the disk",
    ("replays/engine/store.py", "_origin(name).read_bytes"): "our own source",
    ("replays/engine/store.py", "path.read_bytes"): "our own source",
    ("replays/engine/store.py", "file.read_text"): "our own source",
    ("replays/io/files.py", "building.open"): "what was just written",
    ("replays/io/readers/readings.py", "h5py.File"): "admitted",
    ("replays/io/readers/ros/admission.py", "sqlite3.connect"): "admitted",
    ("replays/io/readers/ros/admission.py", "self.path.open"): "a bag that was admitted",
    ("replays/io/readers/ros/admission.py", "super().open"): "a bag that was admitted",
    ("replays/io/readers/ros/reader.py", "reader.open"): "admitted",
    ("replays/io/readers/readings.py", "ZipFile"): "a file that the door has opened",
    ("replays/io/readers/readings.py", "archive.open"): "a part of it",
    ("replays/pipeline/results.py", "pages.summary.read_text"): "a cached result, found whole",
    ("replays/live/frames.py", "av.open"): "what the user named: a device, a stream or a pipe",
    ("replays/cli/runs.py", "plan.open"): "a session, of what the doors admit",
    ("replays/live/app.py", "plan.open"): "the same",
    ("replays/studio/desk.py", "offer.open"): "a run, read by the doors",
    ("replays/studio/serving.py", "probe.connect"): "no file, and nothing is sent",
    ("replays/studio/serving.py", "webbrowser.open"): "our own page",
    ("replays/studio/app.py", "path.read_bytes"): "our own source",
    ("replays/demo/scene.py", "imread"): "images of scikit-image's",
    ("replays/studio/write_ahead.py", "os.open"): "to write or lock, through no link",
}
LIMITS = re.compile(r"_?(MAX_|MOST|DEEPEST)\w*|_?[A-Z_]+_LIMIT(_\w+)?")
BOUNDED = (
    "ga/archives.py",
    "ga/plain_yaml.py",
    "animation/formats",
    "animation/authoring",
    "fusion/imu/noise.py",
    "tracking/markers/marker_map.py",
    "render/video.py",
    "replays/io/readers",
)
DEFAULTS = {
    "read_bounded": ("animation/formats/limits.py", "MAX_FILE_BYTES"),
    "read_arrays": ("ga/archives.py", "MAX_FILE_BYTES"),
}
# Of what is written, or of how large a value may be.
NO_LIMITS = {
    ("animation/formats/gltf/write.py", "MOST_KEYS"),
    ("fusion/imu/noise.py", "_MOST"),
    ("render/video.py", "MOST_APART_S"),
    ("replays/io/readers/kalibr.py", "MOST_OFFSET_S"),
}
UNITS = {"Ki": 1 << 10, "Mi": 1 << 20, "Gi": 1 << 30, "Ti": 1 << 40}

if not PAGE.exists():
    pytest.skip("the source tree is not here: a wheel is tested", allow_module_level=True)


def opened(tree: ast.AST) -> Iterator[str]:
    """Calls that open a file to read it."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call) or not OPENERS.fullmatch(called(node)):
            continue
        modes = [part.value for part in node.args[:2] if isinstance(part, ast.Constant)]
        writes = called(node).endswith("open") and any(str(mode)[:1] in "wxa" for mode in modes)
        if not writes:
            yield called(node)


@cache
def sources() -> dict[str, ast.Module]:
    found = [path for room in ROOMS for path in sorted((REPOSITORY / room).rglob("*.py"))]
    return {str(path.relative_to(REPOSITORY)): tree_of(path) for path in found}


def test_files_are_opened_at_the_door_alone() -> None:
    found = {(name, call) for name, tree in sources().items() for call in opened(tree)}
    assert found - ALLOWED.keys() == set()
    assert ALLOWED.keys() - found == set(), "no longer there"
    for (name, _), reason in ALLOWED.items():
        if reason == "admitted":
            assert any("admit" in called(node) for node in ast.walk(sources()[name])), name


@cache
def called(node: ast.AST) -> str:
    """The function that a call names; nodes are kept by `sources`, so each is told once."""
    return ast.unparse(node.func) if isinstance(node, ast.Call) else ""


@pytest.mark.parametrize(
    "text",
    [
        "open(path)",
        "path.open('rb')",
        "path.read_text(encoding='utf-8')",
        "numpy.load(path)",
        "cv2.imread(name)",
        "h5py.File(name)",
        "io.open(path, 'r')",
        "os.open(path, os.O_RDONLY)",
    ],
)
def test_each_of_them_would_be_found(text: str) -> None:
    assert list(opened(ast.parse(text)))
    assert not list(opened(ast.parse("path.open('wb')\nTrajectory.load(path)")))


def rows(title: str) -> dict[tuple[str, str], float]:
    """The limits that a section's table tells, by file and constant."""
    section = PAGE.read_text(encoding="utf-8").split(f"\n## {title}\n")[1].split("\n## ")[0]
    told = {}
    for line in section.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("| ") or cells[0] in ("file", "what"):
            continue
        names, file = [], ""
        for word in re.findall(r"`([^`]+)`", cells[2]):
            file = word if word.endswith(".py") else file
            if not word.endswith(".py"):
                names.append((file, word))
        values = [number(text) for text in cells[1].split(";")]
        told |= dict(zip(names, values, strict=True))
    return told


def number(text: str) -> float:
    found = re.fullmatch(r"([\d,.]+)(?: ?(Ki|Mi|Gi|Ti)B?)?(?: [a-z]+)?", text.strip())
    assert found, text
    return float(found[1].replace(",", "")) * UNITS.get(found[2], 1)


def constant(file: str, name: str) -> float:
    module = importlib.import_module("motorcade." + file.removesuffix(".py").replace("/", "."))
    return float(getattr(module, name))


def used_limits() -> set[tuple[str, str]]:
    """File and name of each constant that is given to the door as a limit."""
    found = set()
    for file, tree in sources().items():
        for node in ast.walk(tree):
            if not isinstance(node, ast.Call):
                continue
            name = called(node).rpartition(".")[2]
            if name in DOOR:
                given = [word.value for word in node.keywords if word.arg == "limit_bytes"]
                given += [] if name == "read_arrays" else node.args[1:2]
                text = ast.unparse(given[0]) if given else ""
                if text != "limit_bytes":  # of those that pass on what they are given
                    found.add(defined(file, tree, text) if text else DEFAULTS[name])
    return found


def defined(file: str, tree: ast.Module, text: str) -> tuple[str, str]:
    """Where a constant is defined that a module uses by this name."""
    module, _, name = text.rpartition(".")
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                if module and alias.name == module:
                    return file_of(f"{node.module}.{module}"), name
                if not module and alias.name == name:
                    return file_of(node.module), name
    return file, name


def file_of(module: str) -> str:
    return module.removeprefix("motorcade.").replace(".", "/") + ".py"


def test_the_page_names_every_door_and_its_limit() -> None:
    told = rows("File guards")
    assert {at: constant(*at) for at in told} == told
    assert used_limits() == told.keys()


def test_the_page_names_what_a_file_may_stand_for() -> None:
    told = rows("What a file may stand for")
    assert {at: constant(*at) for at in told} == told
    found = {
        (file, target.id)
        for file, tree in sources().items()
        if file.startswith(BOUNDED)
        for node in tree.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name) and LIMITS.fullmatch(target.id)
    }
    assert found - rows("File guards").keys() - NO_LIMITS == told.keys()


def test_an_unknown_unit_is_noticed() -> None:
    assert number("64 MiB") == 64 << 20
    assert number("32 Mi") == 32 << 20
    assert number("1,000 tags") == 1000
    with pytest.raises(AssertionError):
        number("4 Mo B")
