"""A scene of bodies, tags and cameras from TagSLAM's three files, and ids that change over time."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.names import one_line
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.readers.calibration import read_yaml, yaml_floats
from motorcade.replays.io.readers.tagslam.bodies import read_bodies, read_pose
from motorcade.tracking.markers.scenes import (
    CornerCoordinate,
    CornerDistance,
    MarkerBody,
    MarkerScene,
    StatedPose,
)

_LOG = logging.getLogger("motorcade.replays")
_MOST_MEASURED = 10_000
_STAMP_NS = 1000
"""Seconds of this century have no more digits in a double."""
_RIG = "rig"
_PIXEL = 1.0
_FIXED = 1e-5
"""Radians and metres: what a camera wiggles where nothing is stated, below what corners tell."""
_HIGHEST = 1e9
_LATEST_S = 1e18
"""Stamps end at 9e9 s; what is written for "for ever" may be later, but must fit in nanoseconds."""


@dataclass(frozen=True)
class MarkerRemap:
    """A tag that stands for another one between two stamps (`tag_id_remap`).

    Fields:
        marker: its printed id.
        instead: the id that it counts as.
        first_ns, last_ns: when.
        camera: of one camera alone; empty for all.
    """

    marker: int
    instead: int
    first_ns: int
    last_ns: int
    camera: str = ""

    def applies(self, marker: int, time_ns: int, camera: str) -> bool:
        """Whether a tag that was seen is meant."""
        inside = self.first_ns - _STAMP_NS <= time_ns <= self.last_ns + _STAMP_NS
        return marker == self.marker and inside and self.camera in ("", camera)


def read_scene(root: Path, odometry: Mapping[str, Trajectory]) -> MarkerScene:
    """What a folder states of bodies, tags, cameras and lengths.

    Args:
        root: the folder.
        odometry: by topic.

    Raises:
        RecordingError: a file that is missing or states what cannot be.
    """
    path = root / "tagslam.yaml"
    content = read_yaml(path)
    bodies = read_bodies(path, odometry)
    stated = _camera_poses(root / "camera_poses.yaml")
    carriers = _carriers(root / "cameras.yaml", bodies)
    names = {body.name for body in bodies}
    missing = sorted(set(carriers.values()) - names)
    bodies += tuple(MarkerBody(name, moves=True) for name in missing)
    for name in dict.fromkeys(carriers.values()):
        mine = [camera for camera, carrier in carriers.items() if carrier == name]
        if not any(camera in stated for camera in mine):
            stated[mine[0]] = StatedPose(Motor.identity(), 1e-12 * np.eye(6))
    parameters = content.get("tagslam_parameters")
    parameters = parameters if isinstance(parameters, dict) else {}
    sigma_px = _parameter(path, parameters, "pixel_noise", _PIXEL)
    if sigma_px == 0.0:
        raise refusal(path, "expected pixels above 0, got 0", field="pixel_noise")
    ignored = _ignored(content, parameters)
    for key in ignored:
        _LOG.warning("%s: %s", path, key)
    try:
        return MarkerScene(
            bodies,
            carriers,
            stated,
            _distances(path, content.get("distance_measurements")),
            _coordinates(path, content.get("coordinate_measurements"))
            + _planes(path, content.get("plane_measurements")),
            sigma_px,
            _wiggles(root / "cameras.yaml"),
            ignored,
        )
    except ValueError as fault:
        raise refusal(path, str(fault)) from fault


def _ignored(content: Mapping[str, object], parameters: Mapping[str, object]) -> tuple[str, ...]:
    """What is stated and not used."""
    texts = []
    if content.get("amnesia") is True:
        texts.append("amnesia is not heeded: frames are mapped together, none alone")
    if parameters.get("minimum_tag_area"):
        texts.append("minimum_tag_area is not heeded: small tags weigh as little as their corners")
    return tuple(texts)


def _parameter(path: Path, table: Mapping[str, object], key: str, usual: float) -> float:
    (number,) = yaml_floats(path, {key: [table.get(key, usual)]}, key, 1)
    if not 0.0 <= number <= _HIGHEST:
        raise refusal(path, f"expected 0 to {_HIGHEST:g}, got {number:g}", field=key)
    return number


def read_remaps(path: Path) -> tuple[MarkerRemap, ...]:
    """Ids that change over time.

    Raises:
        RecordingError: lists or numbers that are none.
    """
    tags = []
    for entry in _tables(path, read_yaml(path).get("tag_id_remap"), "tag_id_remap"):
        for remap in _tables(path, entry.get("remaps"), "tag_id_remap.remaps"):
            marker, instead = (
                _whole(path, table, key) for table, key in ((entry, "id"), (remap, "remap_id"))
            )
            first, last = (_stamp_ns(path, remap, key) for key in ("start_time", "end_time"))
            tags.append(MarkerRemap(marker, instead, first, last, str(remap.get("camera", ""))))
    return tuple(tags)


@dataclass(frozen=True)
class SquashedTags:
    """Tags that are left out at one stamp, badly read as they are (`squash`).

    Fields:
        time_ns: when.
        markers: their printed ids.
    """

    time_ns: int
    markers: frozenset[int]

    def leaves_out(self, marker: int, time_ns: int) -> bool:
        """Whether a tag that was seen is one of them."""
        return abs(time_ns - self.time_ns) <= _STAMP_NS and marker in self.markers


def read_squashed(path: Path) -> tuple[SquashedTags, ...]:
    """Tags that are to be left out.

    Raises:
        RecordingError: lists or numbers that are none.
    """
    bodies = []
    for entry in _tables(path, read_yaml(path).get("squash"), "squash"):
        tags = entry.get("tags")
        if not isinstance(tags, list) or len(tags) > _MOST_MEASURED:
            raise refusal(path, f"expected a list, got {one_line(tags)}", field="squash.tags")
        markers = frozenset(_whole(path, {"tags": one}, "tags") for one in tags)
        bodies.append(SquashedTags(_stamp_ns(path, entry, "time"), markers))
    return tuple(bodies)


def _stamp_ns(path: Path, table: Mapping[str, object], key: str) -> int:
    (stamp_s,) = yaml_floats(path, {key: [table.get(key, 0.0)]}, key, 1)
    if abs(stamp_s) > _LATEST_S:
        raise refusal(path, f"expected seconds up to {_LATEST_S:g}, got {stamp_s:g}", field=key)
    return round(1e9 * stamp_s)


def _camera_poses(path: Path) -> dict[str, StatedPose]:
    """Poses on their bodies by camera name; rotations are rotation vectors, radians."""
    poses = {}
    for name, entry in read_yaml(path).items():
        pose = entry.get("pose") if isinstance(entry, dict) else None
        if pose is None and isinstance(entry, dict):
            continue
        body_pose = read_pose(path, f"{one_line(name)}.pose", pose)
        if body_pose is None:
            problem = f"expected x, y and z, got {one_line(pose)}"
            raise refusal(path, problem, field=f"{one_line(name)}.pose.position")
        poses[str(name)] = body_pose
    return poses


def _carriers(path: Path, bodies: Sequence[MarkerBody]) -> dict[str, str]:
    """Name of the body that carries each camera: by default one that moves and has no tags."""
    bare = [body.name for body in bodies if body.moves and not body.markers]
    usual = bare[0] if bare else _RIG
    return {
        str(name): str(entry.get("rig_body", usual)) if isinstance(entry, dict) else usual
        for name, entry in read_yaml(path).items()
    }


def _wiggles(path: Path) -> dict[str, tuple[float, float]]:
    """How far cameras turn (rad) and move (m) from frame to frame, of those that do at all."""
    wiggles = {}
    for name, entry in read_yaml(path).items():
        table = entry if isinstance(entry, dict) else {}
        turned, moved = (
            _parameter(path, table, f"wiggle_{kind}", _FIXED)
            for kind in ("rotation", "translation")
        )
        if max(turned, moved) > _FIXED:
            wiggles[str(name)] = (max(turned, _FIXED), max(moved, _FIXED))
    return wiggles


def _distances(path: Path, value: object) -> tuple[CornerDistance, ...]:
    distances = []
    for measurement in _named(path, value, "distance_measurements"):
        a, b = (_whole(path, measurement, key) for key in ("tag1", "tag2"))
        first, second = (_corner(path, measurement, key) for key in ("corner1", "corner2"))
        length_m, sigma_m = _length(path, measurement, "distance")
        distances.append(CornerDistance((a, b), (first, second), length_m, sigma_m))
    return tuple(distances)


def _coordinates(path: Path, value: object) -> tuple[CornerCoordinate, ...]:
    coordinates = []
    for measurement in _named(path, value, "coordinate_measurements"):
        length_m, sigma_m = _length(path, measurement, "length")
        corner = (
            None
            if measurement.get("corner") in (None, -1)
            else _corner(path, measurement, "corner")
        )
        marker = _whole(path, measurement, "tag")
        coordinates.append(
            CornerCoordinate(marker, corner, _direction(path, measurement), length_m, sigma_m)
        )
    return tuple(coordinates)


def _planes(path: Path, value: object) -> tuple[CornerCoordinate, ...]:
    """Centres of tags at one coordinate."""
    planes = []
    for measurement in _named(path, value, "plane_measurements"):
        length_m, sigma_m = _length(path, measurement, "distance")
        tags = measurement.get("tags")
        if not isinstance(tags, list) or len(tags) > _MOST_MEASURED:
            raise refusal(path, f"expected a list, got {one_line(tags)}", field="tags")
        for tag in tags:
            marker = _whole(path, {"tags": tag}, "tags")
            planes.append(
                CornerCoordinate(marker, None, _direction(path, measurement), length_m, sigma_m)
            )
    return tuple(planes)


def _length(path: Path, table: Mapping[str, object], key: str) -> tuple[float, float]:
    length_m, sigma_m = (
        yaml_floats(path, {part: [table.get(part)]}, part, 1)[0] for part in (key, "noise")
    )
    if not 0.0 < sigma_m <= _HIGHEST or abs(length_m) > _HIGHEST:
        raise refusal(path, f"expected metres, got {length_m:g} ± {sigma_m:g}", field=key)
    return length_m, sigma_m


def _direction(path: Path, table: Mapping[str, object]) -> tuple[float, float, float]:
    x, y, z = yaml_floats(path, table, "direction", 3)
    if abs(np.linalg.norm([x, y, z]) - 1.0) > 1e-5:
        raise refusal(path, f"expected a unit vector, got {x:g}, {y:g}, {z:g}", field="direction")
    return x, y, z


def _corner(path: Path, table: Mapping[str, object], key: str) -> int:
    """TagSLAM counts from the bottom left, counter-clockwise; we, clockwise from the top left."""
    corner = _whole(path, table, key)
    if corner > 3:
        raise refusal(path, f"expected a corner of 0 to 3, got {corner}", field=key)
    return 3 - corner


def _named(path: Path, value: object, field: str) -> Sequence[Mapping[str, object]]:
    """Tables of a list of tables with one key each."""
    named = []
    for entry in _tables(path, value, field):
        for table in entry.values():
            if not isinstance(table, dict):
                raise refusal(path, f"expected a table, got {one_line(table)}", field=field)
            named.append(table)
    return named


def _tables(path: Path, value: object, field: str) -> Sequence[Mapping[str, object]]:
    if value is None:
        return []
    if not isinstance(value, list) or len(value) > _MOST_MEASURED:
        raise refusal(path, f"expected a list, got {one_line(value)}", field=field)
    for entry in value:
        if not isinstance(entry, dict):
            raise refusal(path, f"expected a table, got {one_line(entry)}", field=field)
    return value


def _whole(path: Path, table: Mapping[str, object], key: str) -> int:
    value = table.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 100_000:
        raise refusal(path, f"expected a whole number from 0, got {one_line(value)}", field=key)
    return value
