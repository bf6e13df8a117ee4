"""Counts the product, without what is generated: lines of Python and C++ of the rooms, and modules.

    python -m tests.house.size                 the working tree
    python -m tests.house.size v0.1 HEAD       revisions of git, side by side

Examples in docstrings are not counted: they are documentation, and tests run them. Of modules it
counts all, those below 60 lines (faces of packages apart), and those that one other imports.
Names in faces are those that packages list in `__all__`, and those that rooms state in stubs.
Bindings of `VAGUE` names are counted, but for those in comprehensions of one line.
"""

from __future__ import annotations

import ast
import doctest
import io
import subprocess
import sys
import tarfile
from pathlib import Path, PurePosixPath

from tests.house.sources import parsed

REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
PYTHON, NATIVE = {".py", ".pyi"}, {".c", ".cpp", ".h"}
SMALL = 60
VAGUE = {"one", "made", "found", "given", "told"}
"""Names that do not say what they hold."""


def git(*arguments: str) -> str:
    return subprocess.run(
        ["git", *arguments], cwd=REPOSITORY, check=True, capture_output=True, text=True
    ).stdout


def product_files(names: list[str]) -> list[str]:
    """Those of `names` that are code of a room and written by hand."""
    kept = [PurePosixPath(name) for name in names]
    return [
        str(path)
        for path in kept
        if path.parts[0] in ROOMS
        and path.suffix in PYTHON | NATIVE
        and "generated" not in path.parts
    ]


def example_lines(text: str) -> int:
    """Lines of docstrings' examples, what they print included."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docstrings = [
        ast.get_docstring(node) or ""
        for node in ast.walk(parsed(text))
        if isinstance(node, documented)
    ]
    examples = [one for text in docstrings for one in doctest.DocTestParser().get_examples(text)]
    return sum(one.source.count("\n") + one.want.count("\n") for one in examples)


def lines(texts: dict[str, str]) -> dict[str, int]:
    """Lines by room, and of C++ and Python over all."""
    total = dict.fromkeys((*ROOMS, "C and C++", "Python", "all"), 0)
    for name, text in texts.items():
        path = PurePosixPath(name)
        size = text.count("\n") - (example_lines(text) if path.suffix == ".py" else 0)
        for key in (path.parts[0], "Python" if path.suffix in PYTHON else "C and C++", "all"):
            total[key] += size
    return total


def vague_bindings(texts: dict[str, str]) -> int:
    """Variables and arguments that are called by one of the `VAGUE` names."""
    count = 0
    comprehensions = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
    for tree in (parsed(text) for name, text in texts.items() if name.endswith(".py")):
        short = {
            id(part)
            for node in ast.walk(tree)
            if isinstance(node, comprehensions) and node.lineno == node.end_lineno
            for generator in node.generators
            for part in ast.walk(generator.target)
        }
        for node in ast.walk(tree):
            match node:
                case ast.Name(id=name, ctx=ast.Store()) if id(node) not in short:
                    count += name in VAGUE
                case ast.arg(arg=name):
                    count += name in VAGUE
    return count


def exported(texts: dict[str, str]) -> dict[str, int]:
    """Names that packages list in `__all__`, and those of rooms whose faces stubs state."""
    listed = stated = 0
    for name, text in texts.items():
        if name.endswith("__init__.pyi"):
            imports = [node for node in ast.walk(parsed(text)) if isinstance(node, ast.ImportFrom)]
            stated += sum(len(node.names) for node in imports)
        elif name.endswith("__init__.py"):
            for node in parsed(text).body:
                match node:
                    case ast.Assign(targets=[ast.Name(id="__all__")], value=ast.List(elts=names)):
                        listed += len(names)
    return {"names in faces": listed, "and by stubs": stated}


def modules(texts: dict[str, str]) -> dict[str, int]:
    """Modules: all, small ones, and those that one other module of the product imports."""
    python = {name: text for name, text in texts.items() if name.endswith(".py")}
    dotted = {
        ".".join(("motorcade", *PurePosixPath(name).with_suffix("").parts)).removesuffix(
            ".__init__"
        ): text
        for name, text in python.items()
    }
    importers: dict[str, set[str]] = {module: set() for module in dotted}
    for module, text in dotted.items():
        for node in ast.walk(parsed(text)):
            if isinstance(node, ast.ImportFrom):
                names = {f"{node.module}.{alias.name}" for alias in node.names}
                for used in names & set(dotted) or {str(node.module)} & set(dotted):
                    importers[used].add(module)
    faces = {name for name in python if name.endswith("__init__.py")}
    small = [name for name in set(python) - faces if python[name].count("\n") < SMALL]
    return {
        "modules": len(python),
        "packages": len(faces),
        f"below {SMALL}": len(small),
        "one importer": sum(len(users) == 1 for users in importers.values()),
        "vague names": vague_bindings(python),
    }


def counts(revision: str | None) -> dict[str, int]:
    """Lines and modules of a revision, or of the working tree."""
    if revision is None:
        names = product_files(git("ls-files", "-co", "--exclude-standard").splitlines())
        present = [name for name in names if (REPOSITORY / name).exists()]
        texts = {name: (REPOSITORY / name).read_text() for name in present}
    else:
        archive = subprocess.run(
            ["git", "archive", revision, *ROOMS], cwd=REPOSITORY, check=True, capture_output=True
        ).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            texts = {
                name: file.read().decode()
                for name in product_files(files.getnames())
                if (file := files.extractfile(name)) is not None
            }
    return lines(texts) | modules(texts) | exported(texts)


def main() -> None:
    revisions: list[str | None] = [*sys.argv[1:]] or [None]
    columns = [counts(revision) for revision in revisions]
    print(f"{'lines':<14}" + "".join(f"{revision or 'here':>14}" for revision in revisions))
    for key in columns[0]:
        print(f"{key:<14}" + "".join(f"{column[key]:>14,}" for column in columns))


if __name__ == "__main__":
    main()
