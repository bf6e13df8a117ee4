"""`motorcade trajectory`: trajectories of files and bags looked at, edited, converted, plotted."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import Subparsers, add_stamps, new_command, shown

if TYPE_CHECKING:
    from motorcade.ga import Motor, Similarity, Trajectory
    from motorcade.replays.editing import TrajectoryEdits


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        trajectory,
        name="trajectory",
        summary="look at, edit, merge, resample, convert and plot trajectories of files and bags",
        example="motorcade trajectory flight.bag:/odom -o odom.tum --reference truth.tum "
        "--align se3 --plot odom.pdf",
    )
    parser.add_argument(
        "inputs",
        type=Path,
        nargs="+",
        metavar="IN",
        help="TUM, EuRoC or KITTI file; or BAG:TOPIC, BAG:PARENT/CHILD for frames of tf; of a bag "
        "alone its trajectories are listed",
    )
    parser.add_argument(
        "--all-topics", action="store_true", help="every topic of poses of bags without a topic"
    )
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
    group.add_argument(
        "--format",
        choices=("tum", "euroc", "kitti"),
        help="of what is written (by OUT's ending: .tum .txt, .csv, .kitti)",
    )
    group.add_argument("--json", type=Path, metavar="FILE", help="write the figures there")
    group.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw path, axes, angles, speed: .svg, .pdf, .png"
    )
    group.add_argument(
        "--plot-plane",
        choices=("xy", "xz", "yz"),
        help="of the path (the one in which it goes farthest)",
    )


def _add_edits(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("edits, done in this order, before those below")
    group.add_argument(
        "--invert", action="store_true", help="poses are camera_T_world: make them world_T_camera"
    )
    group.add_argument("--scale", type=float, default=1.0, metavar="S", help="of positions (1)")
    group.add_argument("--start-s", type=float, metavar="T", help="leave out poses before T")
    group.add_argument("--end-s", type=float, metavar="T", help="leave out poses after T")
    group.add_argument("--downsample", type=int, metavar="N", help="keep N poses at most")
    group.add_argument(
        "--motion-filter",
        type=float,
        nargs=2,
        metavar=("M", "DEG"),
        help="leave out poses that are nearer than both to the one before",
    )
    group.add_argument("--merge", action="store_true", help="make one trajectory of all")
    group.add_argument("--offset-s", type=float, default=0.0, help="to add to the stamps (0)")
    group.add_argument("--resample-hz", type=float, metavar="HZ", help="poses at an even rate")
    group.add_argument(
        "--resample-as", type=Path, metavar="FILE", help="poses at this trajectory's stamps"
    )
    group.add_argument(
        "--max-gap-s",
        type=float,
        metavar="S",
        help="of both: leave out poses in longer gaps (all stay, and gaps are said)",
    )


def _add_reference(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("by a reference")
    group.add_argument(
        "--reference", type=Path, metavar="REF", help="trajectory of the ground truth"
    )
    group.add_argument(
        "--align",
        choices=("none", "se3", "sim3", "yaw", "scale", "origin", "scaled_origin"),
        default="none",
        help="bring each into the reference's world (none)",
    )
    group.add_argument("--n-to-align", type=int, metavar="N", help="by the first N pairs (all)")
    group.add_argument(
        "--max-difference-s",
        type=float,
        default=0.01,
        help="stamps farther apart are not paired (0.01 s)",
    )
    group.add_argument(
        "--sync", action="store_true", help="keep only poses that are paired with the reference's"
    )
    group.add_argument(
        "--interpolate",
        action="store_true",
        help="take the trajectory with more poses at the stamps of the other one",
    )


def _add_transforms(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "transforms, done last", "FILE: JSON (x y z qx qy qz qw, scale), or 4 by 4 text or .npy"
    )
    group.add_argument("--transform-left", type=Path, metavar="FILE", help="T @ pose: the world")
    group.add_argument(
        "--transform-right", type=Path, metavar="FILE", help="pose @ T: the frame that moves"
    )
    group.add_argument("--invert-transform", action="store_true", help="of both FILEs")
    group.add_argument(
        "--propagate", action="store_true", help="--transform-right to each step: growing drift"
    )
    group.add_argument("--project", choices=("xy", "xz", "yz"), help="to a plane of the world")


def trajectory(arguments: argparse.Namespace) -> None:
    """Read, edit; write, plot, print the figures."""
    from motorcade.replays.editing import TrajectorySummary, edit_trajectories
    from motorcade.replays.editing.inputs import refuse_inputs
    from motorcade.replays.editing.outputs import output_files, write_trajectories
    from motorcade.replays.files.atomic import write_bytes

    if arguments.format is not None and arguments.output is None:
        raise ValueError("--format: expected -o with it, which names what is written")
    if _list_bags(arguments):
        return
    given = _read(arguments)
    reference = None if arguments.reference is None else _one(arguments.reference, arguments)
    found, reference = edit_trajectories(given, _edits(arguments), reference)
    figures = {name: TrajectorySummary.of(one).as_dict() for name, one in found.items()}
    if arguments.output is not None:
        formats = dict.fromkeys(found, arguments.format)
        files = output_files(formats, arguments.output)
        refuse_inputs(_named(arguments), files.values())
        write_trajectories(found, files, formats)
    if arguments.plot is not None:
        from motorcade.render.plots import plot_paths

        write_bytes(
            arguments.plot,
            plot_paths(
                _by_stem(found), reference, arguments.plot_plane or "", _plot_format(arguments.plot)
            ),
        )
    if arguments.json is not None:
        write_bytes(arguments.json, (json.dumps(figures, indent=2) + "\n").encode())
    if arguments.output is None and arguments.plot is None:
        _print_figures(figures)


def _list_bags(arguments: argparse.Namespace) -> bool:
    """Whether all inputs are bags without a topic, whose contents were printed."""
    from motorcade.replays.readers.ros.naming import split_bag_name

    named = [split_bag_name(one) for one in arguments.inputs]
    bags = [one[0] for one in named if one is not None and not one[1]]
    if arguments.all_topics or len(bags) < len(named):
        return False
    from motorcade.replays.readers.ros.trajectories import list_bag_trajectories

    for bag in bags:
        found = list_bag_trajectories(bag)
        for topic, (kind, count) in found.topics.items():
            print(f"{bag}:{topic}  {kind}, {count} messages")
        for parent, child in found.links:
            print(f"{bag}:{parent}/{child}  frames")
        if not found:
            print(f"{bag}  holds no trajectory")
    return True


def _read(arguments: argparse.Namespace) -> dict[str, Trajectory]:
    from motorcade.replays.editing.inputs import trajectory_names

    names = trajectory_names(arguments.inputs, every_topic=arguments.all_topics)
    return {name: _one(name, arguments) for name in names}


def _named(arguments: argparse.Namespace) -> list[str]:
    """Files that are read, the reference and stamps of others among them."""
    others = (arguments.reference, arguments.resample_as)
    return [str(one) for one in (*arguments.inputs, *others) if one is not None]


def _one(name: Path | str, arguments: argparse.Namespace) -> Trajectory:
    from motorcade.replays.files.trajectories import read_trajectory

    return read_trajectory(name, rate_hz=arguments.rate_hz, times=arguments.times)


def _edits(arguments: argparse.Namespace) -> TrajectoryEdits:
    from motorcade.replays.editing import TrajectoryEdits

    other = arguments.resample_as
    if arguments.invert_transform and not (arguments.transform_left or arguments.transform_right):
        raise ValueError("--invert-transform: expected --transform-left or --transform-right")
    return TrajectoryEdits(
        invert=arguments.invert,
        scale=arguments.scale,
        start_s=arguments.start_s,
        end_s=arguments.end_s,
        downsample=arguments.downsample,
        motion_filter=None if arguments.motion_filter is None else tuple(arguments.motion_filter),
        merge=arguments.merge,
        offset_s=arguments.offset_s,
        resample_hz=arguments.resample_hz,
        max_gap_s=arguments.max_gap_s,
        resample_as=None if other is None else _one(other, arguments),
        align=arguments.align,
        n_to_align=arguments.n_to_align,
        max_difference_s=arguments.max_difference_s,
        interpolate=arguments.interpolate,
        paired=arguments.sync,
        left=_transform(arguments.transform_left, arguments),
        right=_transform(arguments.transform_right, arguments),
        propagate=arguments.propagate,
        plane=arguments.project,
    )


def _transform(path: Path | None, arguments: argparse.Namespace) -> Motor | Similarity | None:
    from motorcade.replays.files.transforms import read_transform

    if path is None:
        return None
    found = read_transform(path)
    return found.inverse() if arguments.invert_transform else found


def _by_stem(found: Mapping[str, Trajectory]) -> dict[str, Trajectory]:
    """The trajectories by short names, where these differ."""
    from motorcade.replays.editing.outputs import stem_of

    short = {stem_of(name): one for name, one in found.items()}
    return short if len(short) == len(found) else dict(found)


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
