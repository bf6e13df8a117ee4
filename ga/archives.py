"""Values kept in ``.npz`` files of plain arrays, each with the name of its format.

The same arrays give the same bytes; nothing is pickled.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

__all__ = ["load_arrays", "save_arrays"]

T = TypeVar("T")


def save_arrays(path: Path, owner: str, form: str, arrays: Mapping[str, Any]) -> None:
    """Write arrays and the name of their format.

    Raises:
        ValueError: a file name that does not end in ``.npz``.
        OSError: a file that cannot be written.
    """
    if path.suffix != ".npz":
        raise ValueError(f"{owner}.save(path): expected a name ending in .npz, got {path}")
    np.savez(path, allow_pickle=False, format=np.array(form), **arrays)


def load_arrays(
    path: Path, what: str, form: str, make: Callable[[Mapping[str, NDArray[Any]]], T]
) -> T:
    """A value made of what `save_arrays` wrote.

    Raises:
        ValueError: a file that holds no such value, or numbers that the value refuses.
        OSError: a file that cannot be read.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        if str(arrays["format"]) != form:
            raise ValueError(f"expected the format '{form}', got '{arrays['format']}'")
        return make(arrays)
    except (ValueError, KeyError, TypeError, EOFError, BadZipFile) as fault:
        raise ValueError(f"{path}: not {what}: {fault}") from fault
