"""Stage outputs on disk: frozen dataclasses as a JSON tree, one .npz of arrays, and files.

An artifact is a folder: `value.json` (the tree), `arrays.npz` (its arrays), `files/` (whatever the
value points to with a `Path`), `aside.json` (fields that say how the value came about, such as
seconds, and do not belong to its content) and `artifact.json` (format version, content digest, the
files that it was made from, and a seal over all that the digest does not cover), written last. The
folder is built apart and renamed: a reader sees all or nothing. One that is not as it was written
is computed again.

Reading is driven by the type asked for, never by names found in the file; nothing is unpickled.
"""

from __future__ import annotations

import atexit
import contextlib
import dataclasses
import errno
import hashlib
import json
import logging
import math
import os
import shutil
import tempfile
import types
import typing
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.archives import read_arrays
from motorcade.ga.files import EmptyFileError, off_record, open_bounded, read_bounded
from motorcade.ga.unfinished import locked, unfinished

log = logging.getLogger("motorcade.artifacts")

FORMAT_VERSION = 4
MAX_TREE_BYTES = 1 << 28
MAX_ARRAYS_BYTES = 1 << 32
MAX_FILE_BYTES = 1 << 40


class ArtifactError(ValueError):
    """A stored artifact cannot be read as the type asked for."""


@dataclass(frozen=True)
class Stored:
    """A value as it lies on disk.

    Fields:
        digest: SHA-256 of its content.
        seconds: how long it took to make.
        files: those that it was made from, with the state that they were in (see `ga.files`).
    """

    folder: Path
    digest: str
    seconds: float
    files: Mapping[Path, str]


def write_artifact(
    value: object,
    folder: Path,
    seconds: float,
    files: Mapping[Path, str] = types.MappingProxyType({}),
) -> Stored:
    """Store a frozen dataclass, which took `seconds` to make from `files`, all or nothing.

    Files that the value points to are moved into the artifact. Where another run was faster, what
    that one stored is given. Raises TypeError for a field of a kind that cannot be stored, and
    OSError naming the folder where it cannot be written.
    """
    try:
        with unfinished(folder.parent) as place:
            stored = Stored(folder, "", float(seconds), dict(files))
            return _built(value, place / "artifact", stored)
    except OSError as fault:
        problem = f"cannot be written: {fault.strerror or fault}"
        raise OSError(fault.errno or errno.EIO, problem, str(folder)) from fault


def _built(value: object, building: Path, stored: Stored) -> Stored:
    (building / "files").mkdir(parents=True)
    encoder = _Encoder(building / "files")
    tree = encoder.encode(value, "value")
    _write_json(building / "value.json", tree)
    _write_json(building / "aside.json", encoder.aside)
    np.savez(building / "arrays.npz", allow_pickle=False, **encoder.joined())
    stored = replace(stored, digest=_content_digest(building))
    about: dict[str, Any] = {
        "version": FORMAT_VERSION,
        "name": stored.folder.name,
        "digest": stored.digest,
        "seconds": stored.seconds,
        "files": {str(path): state for path, state in stored.files.items()},
    }
    _write_json(building / "artifact.json", about | {"seal": _seal(building, about)})
    return _publish(building, stored.folder) or stored


def find_artifact(folder: Path) -> Stored | None:
    """The artifact in `folder`; None where there is none, or it is not what was once written."""
    if not os.path.lexists(folder):
        return None
    stored = _as_written(folder, folder.name)
    if stored is None and _remove(folder):
        log.warning("%s: damaged, so it is computed again", folder)
    return stored


@off_record()
def _as_written(folder: Path, name: str) -> Stored | None:
    """What lies in a folder, if it is what was once written under that name."""
    try:
        about = _about(folder)
        sealed = about.pop("seal") == _seal(folder, about)
        if not sealed or about["name"] != name or _content_digest(folder) != about["digest"]:
            return None
        return _stored(folder, about)
    except _DAMAGES:
        return None


_DAMAGES = (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError)


def _about(folder: Path) -> dict[str, Any]:
    about: dict[str, Any] = json.loads(read_bounded(folder / "artifact.json", MAX_TREE_BYTES))
    return about


def _stored(folder: Path, about: Mapping[str, Any]) -> Stored:
    files = {Path(path): state for path, state in about["files"].items()}
    return Stored(folder, about["digest"], about["seconds"], files)


def discard_artifact(stored: Stored) -> None:
    """Take an artifact away in one step, unless another run has put one in its place.

    Raises OSError: the folder that it lies in cannot be written to.
    """

    @off_record()
    def is_still_there(folder: Path) -> bool:
        try:
            return replace(_stored(folder, _about(folder)), folder=stored.folder) == stored
        except _DAMAGES:
            return False

    _set_aside(stored.folder, is_still_there)


def _remove(folder: Path) -> bool:
    """Take a damaged artifact away in one step; False where another run did, or replaced it."""
    try:
        return _set_aside(folder, lambda there: _as_written(there, folder.name) is None)
    except OSError:  # it stays where nothing can be written
        return True


def _set_aside(folder: Path, is_meant: Callable[[Path], bool]) -> bool:
    """Rename a folder away, and delete it, if it is the one that is meant; False if it is not.

    Whoever takes an artifact away locks the folder that it lies in. Where there are no locks,
    another may replace it between the look and the step, so that it is looked at again, and put
    back: for so long a reader would find nothing.
    """
    with unfinished(folder.parent) as place, locked(folder.parent) as ours:
        aside = place / "aside"
        try:
            if not is_meant(folder):
                return False
            folder.rename(aside)
        except FileNotFoundError:
            return False
        if ours or is_meant(aside):
            return True
        with contextlib.suppress(OSError):  # another has put a third one there
            aside.rename(folder)
        return False


@off_record()
def read_artifact(stored: Stored, kind: Any) -> Any:
    """Read the value back as `kind`, running the constructor's checks again.

    Raises ArtifactError where the folder's content does not fit the type.
    """
    try:
        tree = json.loads(read_bounded(stored.folder / "value.json", MAX_TREE_BYTES))
        aside = json.loads(read_bounded(stored.folder / "aside.json", MAX_TREE_BYTES))
        arrays = read_arrays(stored.folder / "arrays.npz", limit_bytes=MAX_ARRAYS_BYTES)
        decoder = _Decoder(stored.folder / "files", arrays, aside)
        return decoder.decode(tree, kind, "value")
    except (OSError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise ArtifactError(
            f"{stored.folder}: cannot be read as {kind}: {error}; delete the folder to recompute it"
        ) from error


_workspace: ContextVar[Path | None] = ContextVar("workspace", default=None)


@contextmanager
def workspace(cache: Path) -> Iterator[None]:
    """Inside the block, `new_file` gives paths beside the artifacts, gone at its end."""
    with unfinished(cache) as folder:
        token = _workspace.set(folder)
        try:
            yield
        finally:
            _workspace.reset(token)


def new_file(name: str) -> Path:
    """Where a stage may write a file that its output points to.

    Outside a graph's run it is a temporary file that is gone when the program ends.
    """
    return Path(tempfile.mkdtemp(dir=_workspace.get() or _temporary_folder())) / name


@cache
def _temporary_folder() -> Path:
    """A folder of this process, removed at its end."""
    folder = tempfile.TemporaryDirectory(prefix="motorcade-")
    atexit.register(folder.cleanup)
    return Path(folder.name)


class _Encoder:
    """Walks a value; collects arrays and files; leaves a JSON tree."""

    def __init__(self, files: Path) -> None:
        self.files = files
        self.arrays: dict[str, list[np.ndarray[Any, Any]]] = {}
        self.sizes: dict[str, int] = {}
        self.aside: dict[str, Any] = {}

    def joined(self) -> dict[str, np.ndarray[Any, Any]]:
        """All elements of one kind in a row, as an archive of many small arrays is slow."""
        return {
            kind: np.concatenate([array.reshape(-1) for array in arrays])
            for kind, arrays in self.arrays.items()
        }

    def encode(self, value: object, where: str) -> Any:
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            return self._encode_fields(value, where)
        if isinstance(value, np.ndarray):
            kind = value.dtype.str
            start = self.sizes.get(kind, 0)
            self.sizes[kind] = start + value.size
            self.arrays.setdefault(kind, []).append(value)
            return {"array": kind, "start": start, "shape": list(value.shape)}
        if isinstance(value, Path):
            name = f"{len(list(self.files.iterdir()))}{value.suffix}"
            shutil.move(value, self.files / name)
            return {"file": name}
        if isinstance(value, dict):
            return {str(key): self.encode(item, f"{where}.{key}") for key, item in value.items()}
        if isinstance(value, (tuple, list)):
            return [self.encode(item, f"{where}.{i}") for i, item in enumerate(value)]
        if value is None or isinstance(value, (bool, int, float, str)):
            return value
        raise TypeError(f"{where}: a {type(value).__name__} cannot be stored as an artifact")

    def _encode_fields(self, value: Any, where: str) -> dict[str, Any]:
        tree = {}
        for field in dataclasses.fields(value):
            path = f"{where}.{field.name}"
            encoded = self.encode(getattr(value, field.name), path)
            if field.metadata.get("aside"):
                self.aside[path] = encoded
            else:
                tree[field.name] = encoded
        return tree


class _Decoder:
    """Rebuilds a value from the tree, guided by the annotations of the type asked for."""

    def __init__(
        self, files: Path, arrays: dict[str, np.ndarray[Any, Any]], aside: dict[str, Any]
    ) -> None:
        self.files = files
        self.arrays = arrays
        self.aside = aside

    def decode(self, tree: Any, kind: Any, where: str) -> Any:
        origin = typing.get_origin(kind)
        if origin in (typing.Union, types.UnionType):
            return self._decode_union(tree, kind, where)
        if origin is np.ndarray or kind is np.ndarray:
            return self._array(tree)
        if dataclasses.is_dataclass(kind):
            return self._decode_fields(tree, kind, where)
        if kind is Path:
            return self.files / Path(tree["file"]).name
        if origin is dict:
            item = typing.get_args(kind)[1]
            return {key: self.decode(value, item, f"{where}.{key}") for key, value in tree.items()}
        if origin is tuple:
            items = typing.get_args(kind)
            kinds = items[:1] * len(tree) if items[-1] is Ellipsis else items
            parts = zip(tree, kinds, strict=True)
            return tuple(self.decode(*part, f"{where}.{i}") for i, part in enumerate(parts))
        if kind is float and isinstance(tree, int) and not isinstance(tree, bool):
            return float(tree)
        if origin is typing.Literal or isinstance(tree, kind):
            return tree
        raise TypeError(f"{where}: expected {kind}, got {type(tree).__name__}")

    def _array(self, tree: Any) -> np.ndarray[Any, Any]:
        shape = tuple(map(int, tree["shape"]))
        start, size = int(tree["start"]), math.prod(shape)
        joined = self.arrays[tree["array"]]
        if min((start, *shape)) < 0 or start + size > len(joined):
            raise ValueError(f"an array of {size} elements from {start} on is not there")
        return joined[start : start + size].reshape(shape)

    def _decode_union(self, tree: Any, kind: Any, where: str) -> Any:
        """The first of the types that takes the tree; values refuse what is another type's."""
        if tree is None and types.NoneType in typing.get_args(kind):
            return None
        refusals = []
        for get_arg in typing.get_args(kind):
            try:
                if get_arg is not types.NoneType:
                    return self.decode(tree, get_arg, where)
            except (KeyError, TypeError, ValueError) as refusal:
                refusals.append(str(refusal))
        raise TypeError(f"{where}: expected {kind}, but {'; '.join(refusals)}")

    def _decode_fields(self, tree: Any, kind: Any, where: str) -> Any:
        hints = typing.get_type_hints(kind)
        values = {}
        for field in dataclasses.fields(kind):
            path = f"{where}.{field.name}"
            encoded = self.aside[path] if field.metadata.get("aside") else tree[field.name]
            values[field.name] = self.decode(encoded, hints[field.name], path)
        return kind(**values)


@off_record()
def _content_digest(folder: Path) -> str:
    content = hashlib.sha256()
    parts = [folder / "value.json", folder / "arrays.npz", *sorted((folder / "files").iterdir())]
    for path in parts:
        content.update(path.name.encode())
        with contextlib.suppress(EmptyFileError), open_bounded(path, MAX_FILE_BYTES) as file:
            content.update(hashlib.file_digest(file, "sha256").digest())
    return content.hexdigest()


@off_record()
def _seal(folder: Path, about: dict[str, Any]) -> str:
    """SHA-256 over what is told about an artifact beside its content."""
    sealed = hashlib.sha256(json.dumps(about, sort_keys=True).encode())
    sealed.update(read_bounded(folder / "aside.json", MAX_TREE_BYTES))
    return sealed.hexdigest()


def _publish(building: Path, folder: Path) -> Stored | None:
    """Rename into place; where another run was faster with the same key, give its result."""
    for path in building.rglob("*"):
        if path.is_file():
            with path.open("rb") as file:
                os.fsync(file.fileno())
    try:
        building.rename(folder)
    except OSError:
        earlier = find_artifact(folder)
        if earlier is None:
            building.rename(folder)
        return earlier
    return None


def _write_json(path: Path, tree: Any) -> None:
    path.write_text(json.dumps(tree, indent=1) + "\n")
