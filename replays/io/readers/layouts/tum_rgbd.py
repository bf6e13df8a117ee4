"""TUM RGB-D layout: `rgb.txt`, `depth.txt`, `groundtruth.txt`; depth in 1/5000 m.

Each colour image gets the depth image with the nearest stamp within 0.02 s, if there is one.
Intrinsics are those published for freiburg1, 2 and 3 (the latter undistorted), known by the
folder's name; a folder of another name has no camera unless a manifest gives one. Truth is the
motion capture's pose of the colour camera, z up.
Source: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
"""

from __future__ import annotations

import logging
import re
from pathlib import Path

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.calibration import make_camera
from motorcade.replays.io.readers.frames.files import ImageFrames, inside
from motorcade.replays.io.readers.tables import Listing, read_listing
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.tracking.cameras.camera import Camera

_LOG = logging.getLogger("motorcade.replays")

DEPTH_UNITS_PER_M = 5000.0
ASSOCIATION_NS = 20_000_000
_OTHERS = ("calibration.txt", "imu.txt")
"""What ETH3D's sequences hold beside files of these names."""
_SIZE = (640, 480)
_INTRINSICS = {
    "1": (517.306408, 516.469215, 318.643040, 255.313989),
    "2": (520.908620, 521.007327, 325.141442, 249.701764),
    "3": (535.4, 539.2, 320.1, 247.6),
}
_DISTORTION = {
    "1": (0.262383, -0.953104, -0.005358, 0.002628, 1.163314),
    "2": (0.231222, -0.784899, -0.003257, -0.000105, 0.917205),
    "3": (),
}


def recognise(root: Path) -> bool:
    """Whether the folder holds `rgb.txt`."""
    return (root / "rgb.txt").is_file()


def read(root: Path, *, own_truth: bool = True) -> Recording:
    """Read a TUM RGB-D sequence.

    Raises:
        RecordingError: a listed image is missing, or whatever cannot be read.
    """
    colour = read_listing(root / "rgb.txt", separator=None, unit="s")
    camera = _camera(root)
    depth: tuple[Path | None, ...] = ()
    doubts: tuple[str, ...] = ()
    for name in _OTHERS:
        if (root / name).is_file():
            _LOG.warning("%s: not read in TUM's layout; state it in a manifest", root / name)
    if (root / "depth.txt").is_file():
        listing = read_listing(root / "depth.txt", separator=None, unit="s")
        files = _files(root, listing)
        paired = nearest(colour.time_ns, listing.time_ns, ASSOCIATION_NS)
        depth = tuple(None if index < 0 else files[index] for index in paired)
        doubts = _unpaired(colour.time_ns, listing.time_ns, paired)
    truth_file = root / "groundtruth.txt"
    frames = ImageFrames(
        _files(root, colour),
        colour.time_ns,
        None if camera is None else _SIZE,
        depth,
        DEPTH_UNITS_PER_M,
    )
    return Recording(
        name=root.resolve().name,
        root=root,
        layout="tum_rgbd",
        frames=frames,
        camera=camera,
        truth=read_trajectory(truth_file, "tum") if truth_file.is_file() and own_truth else None,
        doubts=doubts,
    )


def _unpaired(colour_ns: IntArray, depth_ns: IntArray, paired: IntArray) -> tuple[str, ...]:
    """What to say where most colour images have no depth, though there is some."""
    with_depth = int(np.count_nonzero(paired >= 0))
    if 2 * with_depth >= min(len(colour_ns), len(depth_ns)):
        return ()
    start_s, end_s = (1e-9 * float(depth_ns[end] - colour_ns[end]) for end in (0, -1))
    return (
        f"{with_depth} of {len(colour_ns)} colour images have one of depth within "
        f"{1e-9 * ASSOCIATION_NS:g} s: depth begins {start_s:+.3f} s and ends {end_s:+.3f} s from "
        "colour; if the two clocks differ, correct the stamps in depth.txt",
    )


def nearest(wanted_ns: IntArray, given_ns: IntArray, within_ns: int) -> IntArray:
    """Index of the nearest given stamp to each wanted one; -1 where none is within reach.

    Args:
        wanted_ns: ``(N,)`` stamps.
        given_ns: ``(M,)`` stamps, increasing, M at least 1.
        within_ns: largest distance allowed.
    """
    after = np.clip(np.searchsorted(given_ns, wanted_ns), 1, max(len(given_ns) - 1, 1))
    after = np.minimum(after, len(given_ns) - 1)
    before = np.maximum(after - 1, 0)
    closer = np.abs(given_ns[before] - wanted_ns) <= np.abs(given_ns[after] - wanted_ns)
    chosen = np.where(closer, before, after)
    reached = np.abs(given_ns[chosen] - wanted_ns) <= within_ns
    index: IntArray = np.where(reached, chosen, -1)
    return index


def _camera(root: Path) -> Camera | None:
    known = re.search(r"freiburg([123])", root.resolve().name)
    if known is None:
        return None
    model = "radtan" if _DISTORTION[known[1]] else "pinhole"
    return make_camera(root, _SIZE, _INTRINSICS[known[1]], model, _DISTORTION[known[1]])


def _files(root: Path, listing: Listing) -> tuple[Path, ...]:
    files = []
    for index, (name, line) in enumerate(zip(listing.names, listing.lines, strict=True)):
        path = inside(root, name, listing.path, int(line))
        if not path.is_file():
            raise refusal(
                path,
                f"the image is missing, line {line} of {listing.path} lists it",
                field=f"frame {index}",
                advice="copy it again, or remove its row",
            )
        files.append(path)
    return tuple(files)
