"""How a trajectory in a bag is named: `flight.bag:/odom`, `flight.mcap:map/base_link`.

A bag is a file that ends in .bag, .bag.bz2, .mcap or .db3, or a ROS 2 bag's folder. What follows
the colon is a topic of poses, or two frames, which `trajectories` finds in the bag.
"""

from __future__ import annotations

from pathlib import Path

_SUFFIXES = (".bag", ".bag.bz2", ".mcap", ".db3")


def split_bag_name(name: Path | str) -> tuple[Path, str] | None:
    """The bag, and what is named in it ("" where nothing is); None where this is no bag's name.

    >>> split_bag_name("flight.bag:/odom")
    (PosixPath('flight.bag'), '/odom')
    >>> split_bag_name("flight.tum") is None
    True
    """
    text = str(name)
    if not text.lower().endswith(_SUFFIXES) and Path(text).is_file():
        return None
    places = [at for at, letter in enumerate(text) if letter == ":"]
    for at in (*places, len(text)):
        if is_bag(text[:at]):
            return Path(text[:at]), text[at + 1 :]
    return None


def is_bag(path: Path | str) -> bool:
    """Whether this is the name of a bag's file, or a ROS 2 bag's folder."""
    text = str(path)
    return text.lower().endswith(_SUFFIXES) or (Path(text) / "metadata.yaml").is_file()
