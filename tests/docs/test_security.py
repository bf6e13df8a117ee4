"""What SECURITY.md says is never done is nowhere in the source, and what it names exists."""

import ast
import re
from pathlib import Path

import pytest

from tests.house.sources import SOURCES, tree_of

pytestmark = SOURCES
REPOSITORY = Path(__file__).resolve().parents[2]
PAGE = REPOSITORY / "SECURITY.md"
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
NEVER = {"pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib"}
NETWORK = {"socket", "http", "ftplib", "requests", "urllib3", "aiohttp", "socketserver", "xmlrpc"}
PORT = "replays/studio/serving.py"
"""The one module that opens a port, and needs `socket` for it."""
OWN_CODE = "ga/codegen/runtime/by_numpy.py"
"""The one module that runs Python text, which it has written."""

if not PAGE.exists():
    pytest.skip("the source tree is not here: a wheel is tested", allow_module_level=True)


def modules(node: ast.AST) -> set[str]:
    if isinstance(node, ast.Import):
        return {alias.name for alias in node.names}
    return {node.module} if isinstance(node, ast.ImportFrom) and node.module else set()


def called(node: ast.AST) -> str:
    return ast.unparse(node.func) if isinstance(node, ast.Call) else ""


def faults(tree: ast.AST) -> list[str]:
    found = []
    for node in ast.walk(tree):
        for name in modules(node):
            if name.split(".")[0] in NEVER | NETWORK or name == "urllib.request":
                found.append(f"line {node.lineno}: imports {name}")
        name, told = called(node), {}
        if isinstance(node, ast.Call):
            told = {word.arg: ast.unparse(word.value) for word in node.keywords}
        if name in ("eval", "exec", "compile", "os.system", "os.popen", "yaml.load"):
            found.append(f"line {node.lineno}: calls {name}")
        if name == "np.load" and told.get("allow_pickle") != "False":
            found.append(f"line {node.lineno}: np.load may unpickle")
        if told.get("shell", "False") != "False":
            found.append(f"line {node.lineno}: {name} by a shell")
    return found


@pytest.mark.parametrize("room", ROOMS)
def test_no_file_runs_what_it_reads(room: str) -> None:
    for path in sorted((REPOSITORY / room).rglob("*.py")):
        found = faults(tree_of(path))
        if path == REPOSITORY / PORT:
            assert len(found) == 1
            assert found.pop().endswith("imports socket")
        if path == REPOSITORY / OWN_CODE:
            assert sorted(fault.rpartition(" ")[2] for fault in found) == ["compile", "exec"]
            continue
        assert not found, f"{path}: {found}"


@pytest.mark.parametrize(
    "text",
    [
        "import pickle",
        "from urllib.request import urlopen",
        "eval(text)",
        "yaml.load(text)",
        "np.load(path)",
        "np.load(path, allow_pickle=True)",
        "subprocess.run(line, shell=True)",
    ],
)
def test_each_of_them_would_be_found(text: str) -> None:
    assert faults(ast.parse(text))


@pytest.mark.parametrize("name", ["SECURITY.md", "CONTRIBUTING.md"])
def test_what_the_page_names_exists(name: str) -> None:
    text = (REPOSITORY / name).read_text(encoding="utf-8")
    tests = "\n".join(path.read_text() for path in (REPOSITORY / "tests").rglob("test_*.py"))
    for told in re.findall(r"`(test_\w+)`", text):
        assert f"def {told}(" in tests, told
    for told in re.findall(r"`((?:tests|animation|replays|ga|fusion|docs)/[\w./]+)`", text):
        assert (REPOSITORY / told).exists(), told
