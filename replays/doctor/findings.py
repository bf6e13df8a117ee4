"""One thing looked for on this machine: whether it is there, what it enables, how to get it."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Finding"]


@dataclass(frozen=True)
class Finding:
    """What was found out about one thing.

    Fields:
        group: "kernels", "compiler", "OpenGL", "video" or "packages".
        name: the thing.
        works: whether it can be used here.
        found: version, device or count; what went wrong where it does not work.
        enables: what it is for.
        remedy: how to get it; empty where it works.
        needed: whether the install is broken without it.
    """

    group: str
    name: str
    works: bool
    found: str
    enables: str
    remedy: str = ""
    needed: bool = False
