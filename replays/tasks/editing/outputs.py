"""Where edited trajectories are written: one file, or a folder of files by their own names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from motorcade.ga import Trajectory
from motorcade.replays.io.readers.ros.naming import split_bag_name
from motorcade.replays.io.trajectories import TrajectoryFormat, write_trajectory


def stem_of(name: str) -> str:
    """What a trajectory's file is called: a file's stem, or what was read of a bag.

    >>> stem_of("runs/estimate.tum"), stem_of("flight.mcap:/tf:map.base_link")
    ('estimate', 'tf_map.base_link')
    """
    named = split_bag_name(name)
    if named is None or not named[1]:
        return Path(name).stem
    return named[1].strip("/").replace(":", "_").replace("/", "_")


def output_files(formats: Mapping[str, TrajectoryFormat | None], output: Path) -> dict[str, Path]:
    """The file of each trajectory: `output` for one, or files in the folder `output`.

    Args:
        formats: of the files in a folder, by the trajectories' names.
        output: a file, or a folder: one that is there, or a name without an ending.

    Raises:
        ValueError: several for one file, no format for a folder, or two of one name.
    """
    known = all(fmt is not None for fmt in formats.values())
    if not (output.is_dir() or (not output.suffix and known)):
        if len(formats) > 1:
            raise ValueError(
                f"{output}: expected a folder for {len(formats)} trajectories, with --format; or "
                "--merge to make one of them"
            )
        return dict.fromkeys(formats, output)
    if not known:
        raise ValueError(f"{output}: expected --format for the files of a folder")
    found = {
        name: output / (stem_of(name) + (".csv" if fmt == "euroc" else f".{fmt}"))
        for name, fmt in formats.items()
    }
    for name, path in found.items():
        others = [one for one, other in found.items() if other == path and one != name]
        if others:
            raise ValueError(f"{path}: expected one trajectory, got {name} and {others[0]}")
    return found


def write_trajectories(
    trajectories: Mapping[str, Trajectory],
    files: Mapping[str, Path],
    formats: Mapping[str, TrajectoryFormat | None],
) -> None:
    """Write each to its file, each whole or not at all.

    Raises:
        OSError: a file or its folder cannot be written.
    """
    for name, path in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_trajectory(trajectories[name], path, formats[name])
