"""Commands on trajectories: `motorcade smooth`, `trajectory`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import (
    Commands,
    add_choice,
    add_file,
    add_flag,
    add_number,
    add_output,
    add_stamps,
    chosen,
    shown,
    write_json,
)

if TYPE_CHECKING:
    from motorcade.ga import Motor, Similarity, Trajectory
    from motorcade.replays.io.trajectories import TrajectoryFormat
    from motorcade.replays.tasks.editing import TrajectoryEdits


def add_smooth(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        smooth_files,
        "smooth",
        "smooth trajectories of TUM, EuRoC and KITTI files, ROS bags and MCAP",
        "motorcade smooth poses.tum -o smooth.tum --method gaussian --set sigma_s=0.1",
    )
    add_file(
        parser,
        "inputs",
        "TUM, EuRoC or KITTI file; or BAG:TOPIC, BAG:PARENT/CHILD for frames of tf; several "
        "are smoothed each for itself",
        "IN",
        nargs="+",
    )
    add_output(
        parser,
        "OUT",
        "file, by whose ending it is written (.tum .txt, .csv, .kitti); of several inputs a "
        "folder: each comes as it was, of bags as TUM",
    )
    parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="T",
        help="what is read of bags without a topic: a topic, or PARENT/CHILD; may be repeated",
    )
    add_flag(parser, "--all-topics", "every topic of poses of bags without a topic")
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
    add_flag(parser, "--report", "say how far poses moved and how jitter fell, as JSON")
    add_choice(parser, "--format", ("tum", "euroc", "kitti"), "of files read and written")
    add_stamps(parser)


def smooth_files(arguments: argparse.Namespace) -> None:
    """Read, smooth, write; say what "auto" picked and, where asked, what changed."""
    from motorcade.fusion.smoothing import METHODS, REPRESENTATION_NAMES
    from motorcade.fusion.smoothing.methods import parsed_parameters
    from motorcade.fusion.smoothing.results import changes
    from motorcade.replays.cli.arguments import check_known, print_json
    from motorcade.replays.tasks.editing import refuse_inputs, trajectory_names, write_trajectories

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
        path = _read_measured(name, arguments, many=many)
        smoothed[name], reports[name], picked[name] = _smoothed(path, arguments, parameters)
        if arguments.report:
            reports[name] |= changes(path, smoothed[name])
    write_trajectories(smoothed, files, formats)
    if arguments.report:
        print_json(reports if many else reports[names[0]])
    elif many:
        for name, said in picked.items():
            as_tum = _is_only_read(name) and not arguments.format
            why = ", as TUM: bags and logs are only read" if as_tum else ""
            print(f"{name}: {said and f'{said}; '}in {files[name]}{why}")
    elif picked[names[0]]:
        print(picked[names[0]])


def _is_only_read(name: str) -> bool:
    from motorcade.replays.io.trajectories import is_only_read

    return is_only_read(name)


def _written_as(
    name: str, arguments: argparse.Namespace, *, in_folder: bool
) -> TrajectoryFormat | None:
    """The format of what is written, in a folder that of what is read; None: by the ending."""
    from motorcade.replays.io.trajectories import trajectory_format

    if arguments.format is not None or not in_folder:
        written_as: TrajectoryFormat | None = arguments.format
        return written_as
    return "tum" if _is_only_read(name) else trajectory_format(Path(name))


def _files(
    formats: dict[str, TrajectoryFormat | None], output: Path, *, in_folder: bool
) -> dict[str, Path]:
    from motorcade.replays.io.trajectories import is_bag
    from motorcade.replays.tasks.editing import output_files

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


def _read_measured(name: str, arguments: argparse.Namespace, *, many: bool) -> Trajectory:
    """One trajectory; of several, rate or stamps are those of files without."""
    from motorcade.replays.io.trajectories import read_trajectory, trajectory_format

    stamps = {"rate_hz": arguments.rate_hz, "times": arguments.times}
    if _is_only_read(name):
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
        smoothed = smooth(path, method, representation, **parameters)
        named = representation or ("rotor" if method == "auto" else "motor")
        used = {"method": method, "representation": named} | parameters
        return smoothed, used, ""
    chosen = smoothed_automatically(path, representation, **parameters)
    picked, smoothed = chosen.choice, chosen.trajectory
    used = {"method": method, "representation": picked.representation} | parameters
    used |= {"noise_m": picked.noise_m, "noise_rad": picked.noise_rad}
    used |= {"outliers": picked.outliers, "jumps": picked.jumps}
    used["even_stamps"] = picked.even_stamps
    return smoothed, used, f"auto: {picked}"


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


def add_trajectory(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        trajectory,
        "trajectory",
        "look at, edit, merge, resample, convert and plot trajectories of files and bags",
        "motorcade trajectory flight.bag:/odom -o odom.tum --reference truth.tum "
        "--align se3 --plot odom.pdf",
    )
    add_file(
        parser,
        "inputs",
        "TUM, EuRoC or KITTI file; or BAG:TOPIC, BAG:PARENT/CHILD for frames of tf; of a bag "
        "alone its trajectories are listed",
        "IN",
        nargs="+",
    )
    add_flag(parser, "--all-topics", "every topic of poses of bags without a topic")
    add_stamps(parser)
    _add_output(parser)
    _add_edits(parser)
    _add_reference(parser)
    _add_transforms(parser)


def _add_output(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("output; without, figures are printed")
    group.add_argument(
        "-o", "--output", type=Path, metavar="OUT", help="file; or a folder, with --format"
    )
    add_choice(
        group,
        "--format",
        ("tum", "euroc", "kitti"),
        "of what is written (by OUT's ending: .tum .txt, .csv, .kitti)",
    )
    add_file(group, "--json", "write the figures there")
    add_file(group, "--plot", "draw path, axes, angles, speed: .svg, .pdf, .png")
    add_choice(
        group, "--plot-plane", ("xy", "xz", "yz"), "of the path (the one in which it goes farthest)"
    )


def _add_edits(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("edits, done in this order, before those below")
    add_flag(group, "--invert", "poses are camera_T_world: make them world_T_camera")
    add_number(group, "--scale", "of positions (1)", 1.0, metavar="S")
    add_number(group, "--start-s", "leave out poses before T", metavar="T")
    add_number(group, "--end-s", "leave out poses after T", metavar="T")
    group.add_argument("--downsample", type=int, metavar="N", help="keep N poses at most")
    add_number(
        group,
        "--motion-filter",
        "leave out poses that are nearer than both to the one before",
        nargs=2,
        metavar=("M", "DEG"),
    )
    add_flag(group, "--merge", "make one trajectory of all")
    add_number(group, "--offset-s", "to add to the stamps (0)", 0.0)
    add_number(group, "--resample-hz", "poses at an even rate", metavar="HZ")
    add_file(group, "--resample-as", "poses at this trajectory's stamps")
    add_number(
        group,
        "--max-gap-s",
        "of both: leave out poses in longer gaps (all stay, and gaps are said)",
        metavar="S",
    )


def _add_reference(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("by a reference")
    add_file(group, "--reference", "trajectory of the ground truth", "REF")
    add_choice(
        group,
        "--align",
        ("none", "se3", "sim3", "yaw", "scale", "origin", "scaled_origin"),
        "bring each into the reference's world (none)",
        "none",
    )
    group.add_argument("--n-to-align", type=int, metavar="N", help="by the first N pairs (all)")
    add_number(group, "--max-difference-s", "stamps farther apart are not paired (0.01 s)", 0.01)
    add_flag(group, "--sync", "keep only poses that are paired with the reference's")
    add_flag(
        group, "--interpolate", "take the trajectory with more poses at the stamps of the other one"
    )


def _add_transforms(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "transforms, done last", "FILE: JSON (x y z qx qy qz qw, scale), or 4 by 4 text or .npy"
    )
    add_file(group, "--transform-left", "T @ pose: the world")
    add_file(group, "--transform-right", "pose @ T: the frame that moves")
    add_flag(group, "--invert-transform", "of both FILEs")
    add_flag(group, "--propagate", "--transform-right to each step: growing drift")
    add_choice(group, "--project", ("xy", "xz", "yz"), "to a plane of the world")


def trajectory(arguments: argparse.Namespace) -> None:
    """Read, edit; write, plot, print the figures."""
    from motorcade.replays.io.files import write_bytes
    from motorcade.replays.tasks.editing import (
        edit_trajectories,
        output_files,
        refuse_inputs,
        trajectory_figures,
        write_trajectories,
    )

    if arguments.format is not None and arguments.output is None:
        raise ValueError("--format: expected -o with it, which names what is written")
    if _list_bags(arguments):
        return
    trajectories = _read(arguments)
    reference = None if arguments.reference is None else _read_one(arguments.reference, arguments)
    edited, reference = edit_trajectories(trajectories, _edits(arguments), reference)
    figures = {name: trajectory_figures(one) for name, one in edited.items()}
    if arguments.output is not None:
        formats = dict.fromkeys(edited, arguments.format)
        files = output_files(formats, arguments.output)
        refuse_inputs(_named(arguments), files.values())
        write_trajectories(edited, files, formats)
    if arguments.plot is not None:
        from motorcade.render.plots import plot_paths

        write_bytes(
            arguments.plot,
            plot_paths(
                _by_stem(edited),
                reference,
                arguments.plot_plane or "",
                _plot_format(arguments.plot),
            ),
        )
    write_json(arguments.json, figures)
    if arguments.output is None and arguments.plot is None:
        _print_figures(figures)


def _list_bags(arguments: argparse.Namespace) -> bool:
    """Whether all inputs are bags without a topic, whose contents were printed."""
    from motorcade.replays.io.trajectories import split_bag_name

    named = [split_bag_name(one) for one in arguments.inputs]
    bags = [one[0] for one in named if one is not None and not one[1]]
    if arguments.all_topics or len(bags) < len(named):
        return False
    from motorcade.replays.io.readers.ros.trajectories import list_bag_trajectories

    for bag in bags:
        rows = list_bag_trajectories(bag)
        for topic, (kind, count) in rows.topics.items():
            print(f"{bag}:{topic}  {kind}, {count} messages")
        for parent, child in rows.links:
            print(f"{bag}:{parent}/{child}  frames")
        if not rows:
            print(f"{bag}  holds no trajectory")
    return True


def _read(arguments: argparse.Namespace) -> dict[str, Trajectory]:
    from motorcade.replays.tasks.editing import trajectory_names

    names = trajectory_names(arguments.inputs, every_topic=arguments.all_topics)
    return {name: _read_one(name, arguments) for name in names}


def _named(arguments: argparse.Namespace) -> list[str]:
    """Files that are read, the reference and stamps of others among them."""
    others = (arguments.reference, arguments.resample_as)
    return [str(one) for one in (*arguments.inputs, *others) if one is not None]


def _read_one(name: Path | str, arguments: argparse.Namespace) -> Trajectory:
    from motorcade.replays.io.trajectories import read_trajectory

    return read_trajectory(name, rate_hz=arguments.rate_hz, times=arguments.times)


def _edits(arguments: argparse.Namespace) -> TrajectoryEdits:
    from motorcade.replays.tasks.editing import TrajectoryEdits

    other = arguments.resample_as
    if arguments.invert_transform and not (arguments.transform_left or arguments.transform_right):
        raise ValueError("--invert-transform: expected --transform-left or --transform-right")
    same = chosen(
        arguments,
        *("invert", "scale", "start_s", "end_s", "downsample", "merge", "offset_s", "resample_hz"),
        *("max_gap_s", "align", "n_to_align", "max_difference_s", "interpolate", "propagate"),
    )
    return TrajectoryEdits(
        **same,
        motion_filter=None if arguments.motion_filter is None else tuple(arguments.motion_filter),
        resample_as=None if other is None else _read_one(other, arguments),
        paired=arguments.sync,
        left=_transform(arguments.transform_left, arguments),
        right=_transform(arguments.transform_right, arguments),
        plane=arguments.project,
    )


def _transform(path: Path | None, arguments: argparse.Namespace) -> Motor | Similarity | None:
    from motorcade.replays.io.transforms import read_transform

    if path is None:
        return None
    transform = read_transform(path)
    return transform.inverse() if arguments.invert_transform else transform


def _by_stem(trajectories: Mapping[str, Trajectory]) -> dict[str, Trajectory]:
    """The trajectories by short names, where these differ."""
    from motorcade.replays.tasks.editing import stem_of

    short = {stem_of(name): one for name, one in trajectories.items()}
    return short if len(short) == len(trajectories) else dict(trajectories)


def _plot_format(path: Path) -> str:
    if path.suffix.lower() not in (".svg", ".pdf", ".png"):
        raise ValueError(f"--plot {path}: expected a name ending in .svg, .pdf or .png")
    return path.suffix.lower().removeprefix(".")


def _print_figures(figures: Mapping[str, Mapping[str, Any]]) -> None:
    for name, values in figures.items():
        print(name)
        for key, value in values.items():
            if value is not None:
                print(f"{key:>20}  {shown(value)}")
