"""Which trajectories a command line names: files, and what is read of bags."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from motorcade.replays.io.readers.ros.naming import split_bag_name


def trajectory_names(
    inputs: Sequence[Path], topics: Sequence[str] = (), *, every_topic: bool = False
) -> list[str]:
    """The names of trajectories of files and bags, as `read_trajectory` takes them.

    Args:
        inputs: files; bags, alone or with what is read of them.
        topics: what is read of each bag that stands alone: topics of poses, or two frames.
        every_topic: read every topic of poses of these.

    Raises:
        RecordingError: a bag that cannot be read.
        ValueError: a trajectory that is named twice, topics without a bag that stands alone, or a
            bag without a topic of poses where every one of them is asked for.

    >>> trajectory_names([Path("run.tum"), Path("flight.bag")], ["/odom", "map/base"])
    ['run.tum', 'flight.bag:/odom', 'flight.bag:map/base']
    """
    bags = [split_bag_name(one) for one in inputs]
    alone = [one is not None and not one[1] for one in bags]
    if topics and not any(alone):
        raise ValueError(f"--topic {topics[0]}: expected a bag without a topic among the inputs")
    found: list[str] = []
    for name, is_alone in zip(inputs, alone, strict=True):
        read = list(_of_bag(name, topics, every_topic)) if is_alone else [str(name)]
        for one in read:
            if one in found:
                raise ValueError(f"{one}: expected each trajectory once, got it twice")
            found.append(one)
    return found


def refuse_inputs(names: Iterable[str], files: Iterable[Path]) -> None:
    """Refuse to write over what is read: measured poses cannot be had again.

    Args:
        names: what is read, as `trajectory_names` gives it.
        files: what is written.

    Raises:
        ValueError: a file among both, by whatever path or link.
    """
    bags = ((name, split_bag_name(name)) for name in names)
    read = [Path(name) if bag is None else bag[0] for name, bag in bags]
    for file in files:
        if file.is_file() and any(one.is_file() and one.samefile(file) for one in read):
            raise ValueError(
                f"--output {file}: this is one of the inputs; expected another file or folder"
            )


def _of_bag(bag: Path, topics: Sequence[str], every_topic: bool) -> Iterator[str]:
    """What is read of a bag that stands alone; itself where nothing says what."""
    if topics:
        yield from (f"{bag}:{topic}" for topic in topics)
    elif every_topic:
        from motorcade.replays.io.readers.ros.trajectories import list_bag_trajectories

        listed = list_bag_trajectories(bag).topics
        if not listed:
            raise ValueError(f"{bag}: expected topics of poses, got none")
        yield from (f"{bag}:{topic}" for topic in listed)
    else:
        yield str(bag)
