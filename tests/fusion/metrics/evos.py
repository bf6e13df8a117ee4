"""What evo's programs compute, step by step, so that one pairing serves many errors."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from evo.core import metrics
from evo.core.sync import SyncMethod
from evo.core.trajectory import Plane, PosePath3D, PoseTrajectory3D
from evo.core.units import Unit
from evo.tools import file_interface

RELATIONS = {
    "full": metrics.PoseRelation.full_transformation,
    "trans_part": metrics.PoseRelation.translation_part,
    "rot_part": metrics.PoseRelation.rotation_part,
    "angle_deg": metrics.PoseRelation.rotation_angle_deg,
    "angle_rad": metrics.PoseRelation.rotation_angle_rad,
    "point_distance": metrics.PoseRelation.point_distance,
    "point_distance_error_ratio": metrics.PoseRelation.point_distance_error_ratio,
}
UNITS = {"frames": Unit.frames, "m": Unit.meters, "deg": Unit.degrees, "rad": Unit.radians}
_ALIGN = {  # align, correct_scale, align_origin of evo.main_ape
    "none": (False, False, False),
    "se3": (True, False, False),
    "sim3": (True, True, False),
    "scale": (False, True, False),
    "origin": (False, False, True),
    "scaled_origin": (False, True, True),
}


def read(path: Path) -> PosePath3D:
    """A TUM file, or one of KITTI's."""
    if path.name.startswith("KITTI"):
        return file_interface.read_kitti_poses_file(path)
    return file_interface.read_tum_trajectory_file(path)


def in_time(
    estimate: PosePath3D, reference: PosePath3D, options: Mapping[str, Any]
) -> tuple[PosePath3D, PosePath3D]:
    """Estimate and reference pose by pose, by the options of our `match`; new ones."""
    ours, true = copy.deepcopy(estimate), copy.deepcopy(reference)
    if isinstance(true, PoseTrajectory3D):
        start_s, end_s = options.get("start_s"), options.get("end_s")
        if start_s or end_s:
            true.reduce_to_time_range(start_s, end_s)
        method = "interpolation" if options.get("interpolate") else "nearest_time"
        true, ours = true.sync_with(
            ours,
            sync_method=SyncMethod(method),
            max_diff=options.get("max_difference_s", 0.01),
            offset_2=options.get("offset_s", 0.0),
        )
    return ours, true


def in_space(
    pair: tuple[PosePath3D, PosePath3D], options: Mapping[str, Any]
) -> tuple[PosePath3D, PosePath3D]:
    """The same aligned and projected, by the options of our `match`; new ones."""
    ours, true = copy.deepcopy(pair)
    rigid, scaled, origin = _ALIGN[options.get("align", "none")]
    if rigid or scaled:
        first = options.get("n_to_align") or -1
        ours.align(true, scaled, scaled and not rigid, n=first)
    if origin:
        ours.align_origin(true)
    if options.get("plane"):
        for path in (true, ours):
            path.project(Plane(options["plane"]))
    return ours, true


def matched(
    estimate: PosePath3D, reference: PosePath3D, options: Mapping[str, Any]
) -> tuple[PosePath3D, PosePath3D]:
    """Estimate and reference as evo compares them."""
    return in_space(in_time(estimate, reference, options), options)


def absolute(pair: tuple[PosePath3D, PosePath3D], relation: str) -> np.ndarray:
    """The error array of ``evo_ape``."""
    found = metrics.APE(RELATIONS[relation])
    found.process_data(pair[::-1])
    return np.asarray(found.error)


def relative(
    pair: tuple[PosePath3D, PosePath3D], relation: str, delta: Mapping[str, Any]
) -> np.ndarray:
    """The error array of ``evo_rpe``, by the fields of our `Delta`."""
    found = metrics.RPE(
        RELATIONS[relation],
        delta["value"],
        UNITS[delta["unit"]],
        delta.get("tolerance", 0.1),
        delta.get("all_pairs", False),
        pairs_from_reference=delta.get("pairs_from", "reference") == "reference",
    )
    with redirect_stdout(StringIO()):  # it prints how far its search has come
        found.process_data(pair[::-1])
    return np.asarray(found.error)
