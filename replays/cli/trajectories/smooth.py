"""`motorcade smooth`: trajectories of files and bags in, smoother files out."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import Subparsers, add_stamps, new_command

if TYPE_CHECKING:
    from motorcade.ga import Trajectory
    from motorcade.replays.files.trajectories import TrajectoryFormat


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        smooth_files,
        name="smooth",
        summary="smooth trajectories of TUM, EuRoC and KITTI files, ROS bags and MCAP",
        example="motorcade smooth poses.tum -o smooth.tum --method gaussian --set sigma_s=0.1",
    )
    parser.add_argument(
        "inputs",
        type=Path,
        nargs="+",
        metavar="IN",
        help="TUM, EuRoC or KITTI file; or BAG:TOPIC, BAG:PARENT/CHILD for frames of tf; several "
        "are smoothed each for itself",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="OUT",
        help="file, by whose ending it is written (.tum .txt, .csv, .kitti); of several inputs a "
        "folder: each comes as it was, of bags as TUM",
    )
    parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="T",
        help="what is read of bags without a topic: a topic, or PARENT/CHILD; may be repeated",
    )
    parser.add_argument(
        "--all-topics", action="store_true", help="every topic of poses of bags without a topic"
    )
    parser.add_argument(
        "--representation", metavar="R", help="motor by default; of auto what predicts better"
    )
    parser.add_argument(
        "--method", default="auto", metavar="M", help="auto by default, which says what it picked"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter of the method, such as sigma_s=0.1; may be repeated",
    )
    parser.add_argument(
        "--list", action=_List, nargs=0, help="list methods, parameters, representations; and exit"
    )
    parser.add_argument(
        "--report", action="store_true", help="say how far poses moved and how jitter fell, as JSON"
    )
    parser.add_argument(
        "--format", choices=("tum", "euroc", "kitti"), help="of files read and written"
    )
    add_stamps(parser)


def smooth_files(arguments: argparse.Namespace) -> None:
    """Read, smooth, write; say what "auto" picked and, where asked, what changed."""
    from motorcade.fusion.smoothing import METHODS, REPRESENTATION_NAMES
    from motorcade.fusion.smoothing.changes import changes
    from motorcade.fusion.smoothing.methods import parsed_parameters
    from motorcade.replays.cli.arguments import check_known, print_json
    from motorcade.replays.editing.inputs import refuse_inputs, trajectory_names
    from motorcade.replays.editing.outputs import write_trajectories

    check_known("--method", [arguments.method], METHODS)
    if arguments.representation is not None:
        check_known("--representation", [arguments.representation], REPRESENTATION_NAMES)
    parameters = parsed_parameters(arguments.method, arguments.set, "--set")
    names = trajectory_names(arguments.inputs, arguments.topic, every_topic=arguments.all_topics)
    many = len(names) > 1 or arguments.output.is_dir()
    formats = {name: _written_as(name, arguments, in_folder=many) for name in names}
    files = _files(formats, arguments.output, in_folder=many)
    refuse_inputs(names, files.values())
    smoothed, reports, picked = {}, {}, {}
    for name in names:
        path = _read(name, arguments, many=many)
        smoothed[name], reports[name], picked[name] = _smoothed(path, arguments, parameters)
        if arguments.report:
            reports[name] |= changes(path, smoothed[name])
    write_trajectories(smoothed, files, formats)
    if arguments.report:
        print_json(reports if many else reports[names[0]])
    elif many:
        for name, said in picked.items():
            why = ", as TUM: bags are only read" if _is_bag(name) and not arguments.format else ""
            print(f"{name}: {said and f'{said}; '}in {files[name]}{why}")
    elif picked[names[0]]:
        print(picked[names[0]])


def _is_bag(name: str) -> bool:
    from motorcade.replays.readers.ros.naming import split_bag_name

    return split_bag_name(name) is not None


def _written_as(
    name: str, arguments: argparse.Namespace, *, in_folder: bool
) -> TrajectoryFormat | None:
    """The format of what is written, in a folder that of what is read; None: by the ending."""
    from motorcade.replays.files.trajectories import trajectory_format

    if arguments.format is not None or not in_folder:
        given: TrajectoryFormat | None = arguments.format
        return given
    return "tum" if _is_bag(name) else trajectory_format(Path(name))


def _files(
    formats: dict[str, TrajectoryFormat | None], output: Path, *, in_folder: bool
) -> dict[str, Path]:
    from motorcade.replays.editing.outputs import output_files
    from motorcade.replays.readers.ros.naming import is_bag

    if not in_folder:
        if is_bag(output) and None in formats.values():
            raise ValueError(
                f"--output {output}: bags are only read; expected a name ending in .tum, .txt, "
                ".csv or .kitti"
            )
        return dict.fromkeys(formats, output)
    if output.suffix and not output.is_dir():
        raise ValueError(
            f"--output {output}: expected a folder for {len(formats)} trajectories, got the name "
            "of a file"
        )
    return output_files(formats, output)


def _read(name: str, arguments: argparse.Namespace, *, many: bool) -> Trajectory:
    """One trajectory; of several, rate or stamps are those of files without."""
    from motorcade.replays.files.trajectories import read_trajectory, trajectory_format

    stamps = {"rate_hz": arguments.rate_hz, "times": arguments.times}
    if _is_bag(name):
        return read_trajectory(name, **({} if many else stamps))
    if not many:
        return read_trajectory(name, arguments.format, **stamps)
    fmt = arguments.format or trajectory_format(Path(name))
    return read_trajectory(name, fmt, **(stamps if fmt == "kitti" else {}))


def _smoothed(
    path: Trajectory, arguments: argparse.Namespace, parameters: dict[str, Any]
) -> tuple[Trajectory, dict[str, Any], str]:
    """The smoothed path, what it was smoothed by, and what "auto" picked in a line."""
    from motorcade.fusion.smoothing import smooth, smoothed_automatically

    method, representation = arguments.method, arguments.representation
    if method != "auto" or "lag_s" in parameters:
        made = smooth(path, method, representation, **parameters)
        named = representation or ("rotor" if method == "auto" else "motor")
        used = {"method": method, "representation": named} | parameters
        return made, used, ""
    found = smoothed_automatically(path, representation, **parameters)
    picked, made = found.choice, found.trajectory
    used = {"method": method, "representation": picked.representation} | parameters
    used |= {"noise_m": picked.noise_m, "noise_rad": picked.noise_rad}
    used |= {"outliers": picked.outliers, "jumps": picked.jumps}
    used["even_stamps"] = picked.even_stamps
    return made, used, f"auto: {picked}"


class _List(argparse.Action):
    """Print what there is to choose from, and exit."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        from motorcade.fusion.smoothing import METHODS, REPRESENTATION_NAMES, method_parameters

        print("methods, and their parameters where they are not given:")
        for name in METHODS:
            defaults = " ".join(f"{key}={value}" for key, value in method_parameters(name).items())
            print(f"  {name:26s} {defaults}")
        print(f"representations: {', '.join(REPRESENTATION_NAMES)}")
        parser.exit()
