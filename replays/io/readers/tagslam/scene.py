"""A scene of bodies, tags and cameras from TagSLAM's three files, and ids that change over time.

Bodies and their tags as `tagslam.yaml` states them: sizes, poses and their noise, odometry.

TagSLAM attaches tags to bodies. A tag that no body lists belongs to `default_body`; where there is
none it is ignored. A tag's frame has its origin at the centre; ours, at the printed top-left
corner. `T_body_odom` takes the odometry's coordinates to the body's, as its name says.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import refusal, refusing
from motorcade.replays.io.readers.calibration import read_yaml, yaml_floats
from motorcade.tracking.markers.scenes import (
    BodyOdometry,
    CornerCoordinate,
    CornerDistance,
    FixedMarker,
    MarkerBody,
    MarkerScene,
    StatedPose,
)
from motorcade.tracking.markers.scenes.scene import positive_definite

_MOST_TAGS = 100_000
_LARGEST_M = 100.0
_HIGHEST = 1e6
_POSITION_M, _ROTATION_RAD = 0.05, 0.01
"""Deviations of a stated pose where neither it nor `body_defaults` states them."""
_LEAST = 1e-7
_SUREST = 1e12
"""One over a deviation: nothing is placed to a picometre."""
_ACCELERATION = 5.0
_JUMP = 10.0


def read_bodies(path: Path, odometry: Mapping[str, Trajectory]) -> tuple[MarkerBody, ...]:
    """Read all bodies.

    Args:
        path: the file.
        odometry: by topic.

    Raises:
        RecordingError: not such a file, sizes that are not above 0 and up to 100 m, a tag that
            two bodies list, a default body that is not there, or numbers that are none.
    """
    content = read_yaml(path)
    tables = dict(_bodies(path, content.get("bodies")))
    default = content.get("default_body")
    if default is not None and str(default) not in tables:
        problem = f"expected the name of a body, got {one_line(default)}"
        raise refusal(path, problem, field="default_body")
    noise = _default_noise(path, content.get("body_defaults"))
    owner: dict[int, str] = {}
    bodies = []
    for name, table in tables.items():
        tags = dict(_tags(path, name, table, noise, owner))
        others = None
        if default is not None and str(default) == name and "default_tag_size" in table:
            others = _size(path, name, table, "default_tag_size")
        moves = table.get("is_static") is False
        stated = None if moves else read_pose(path, name, table.get("pose"), noise)
        bodies.append(
            MarkerBody(
                name,
                moves,
                stated,
                tags,
                others,
                frozenset(_ids(path, name, table.get("ignore_tags"))),
                _odometry(path, name, table, odometry),
                _still(path, name, table),
            )
        )
    return tuple(bodies)


def read_pose(
    path: Path, field: str, pose: object, noise: tuple[float, float] | None = None
) -> StatedPose | None:
    """A pose with position, rotation (a vector, radians), and their noise; None where none stands.

    The noise is three deviations each, or `R`, the square root of the information, rotation first.
    """
    if not isinstance(pose, dict):
        return None
    position, rotation = (_vector(path, f"{field}.{part}", pose.get(part)) for part in _PARTS)
    motor = Motor.from_rotor_translation(Rotor.from_rotation_vector(rotation), position)
    if "R" in pose:
        return StatedPose(motor, _covariance(path, field, pose))
    position_m, rotation_rad = noise or (_POSITION_M, _ROTATION_RAD)
    sigmas = []
    for part, usual in (("rotation_noise", rotation_rad), ("position_noise", position_m)):
        value = pose.get(part)
        sigmas.append(
            np.full(3, usual) if value is None else _vector(path, f"{field}.{part}", value)
        )
    spread = np.clip(np.abs(np.concatenate(sigmas)), _LEAST, _HIGHEST)
    return StatedPose(motor, np.diag(spread**2))


_PARTS = ("position", "rotation")


def _covariance(path: Path, field: str, pose: Mapping[str, object]) -> FloatArray:
    """By the square root of the information."""
    root = np.array(yaml_floats(path, pose, "R", 36)).reshape(6, 6)
    if np.abs(root).max() > _SUREST:
        problem = f"expected numbers up to {_SUREST:g}, got {np.abs(root).max():g}"
        raise refusal(path, problem, field=f"{one_line(field)}.R")
    try:
        covariance = np.linalg.inv(root.T @ root + np.eye(6) / _HIGHEST**2)
    except np.linalg.LinAlgError:
        covariance = np.full((6, 6), np.nan)
    if not positive_definite(covariance):
        problem = f"expected a matrix of rank 6, got rank {np.linalg.matrix_rank(root)}"
        raise refusal(path, problem, field=f"{one_line(field)}.R")
    return covariance


def _vector(path: Path, field: str, value: object) -> FloatArray:
    if not isinstance(value, dict):
        raise refusal(path, f"expected x, y and z, got {one_line(value)}", field=one_line(field))
    part = field.rpartition(".")[2]
    return np.array(yaml_floats(path, {part: [value.get(one) for one in "xyz"]}, part, 3))


def _bodies(path: Path, value: object) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Name and content of each body: a list of tables with one key each."""
    if not isinstance(value, list):
        raise refusal(path, f"expected a list, got {one_line(value)}", field="bodies")
    for entry in value:
        if not isinstance(entry, dict) or len(entry) != 1:
            raise refusal(path, f"expected one name a body, got {one_line(entry)}", field="bodies")
        name, body = next(iter(entry.items()))
        if not isinstance(body, dict):
            raise refusal(path, f"expected a table, got {one_line(body)}", field=str(name))
        yield str(name), body


def _tags(
    path: Path,
    name: str,
    body: Mapping[str, object],
    noise: tuple[float, float],
    owner: dict[int, str],
) -> Iterator[tuple[int, FixedMarker]]:
    """Every tag that a body lists."""
    listed = _board(path, name, body) if _is_board(body) else _loose(path, name, body, noise)
    for marker, side_m, stated in listed:
        if marker in owner:
            raise refusal(path, f"expected tag {marker} once, got it twice", field=name)
        owner[marker] = name
        if len(owner) > _MOST_TAGS:
            raise refusal(path, f"expected at most {_MOST_TAGS} tags, got more", field=name)
        yield marker, FixedMarker(side_m, _at_corner(stated, side_m))


def _at_corner(stated: StatedPose | None, side_m: float) -> StatedPose | None:
    """The same of the printed top-left corner, where ours have their origin."""
    if stated is None:
        return None
    centre_T_corner = Motor.from_translation([-0.5 * side_m, 0.5 * side_m, 0.0])
    adjoint = centre_T_corner.inverse().adjoint()
    covariance = adjoint @ stated.covariance @ adjoint.T
    return StatedPose(stated.pose @ centre_T_corner, 0.5 * (covariance + covariance.T))


def _is_board(body: Mapping[str, object]) -> bool:
    return str(body.get("type")) in ("board", "staggered_board")


def _loose(
    path: Path, name: str, body: Mapping[str, object], noise: tuple[float, float]
) -> Iterator[tuple[int, float, StatedPose | None]]:
    tags = body.get("tags") or []
    if not isinstance(tags, list):
        raise refusal(path, f"expected a list, got {one_line(tags)}", field=f"{name}.tags")
    instead = [_number(path, name, body, f"override_tag_{part}_noise") for part in _PARTS]
    for tag in tags:
        if not isinstance(tag, dict):
            raise refusal(path, f"expected a table, got {one_line(tag)}", field=f"{name}.tags")
        sized, key = ((tag, "size"), (body, "default_tag_size"))["size" not in tag]
        marker, size = _count(path, name, tag, "id"), _size(path, name, sized, key)
        stated = read_pose(path, f"{name}.tag_{marker}", tag.get("pose"), noise)
        if stated is not None and instead[0] and instead[1]:
            spread = np.repeat([instead[1], instead[0]], 3)
            stated = StatedPose(stated.pose, np.diag(spread**2))
        yield marker, size, stated


def _board(
    path: Path, name: str, body: Mapping[str, object]
) -> Iterator[tuple[int, float, StatedPose | None]]:
    """Tags in rows and columns; staggered boards leave every other place empty, as chess does."""
    kind = str(body.get("type"))
    board = body.get(kind)
    if not isinstance(board, dict):
        raise refusal(path, f"expected a table, got {one_line(board)}", field=f"{name}.{kind}")
    rows, columns, first = (
        _count(path, name, board, key) for key in ("tag_rows", "tag_columns", "tag_start_id")
    )
    if rows * columns > _MOST_TAGS:
        raise refusal(path, f"expected at most {_MOST_TAGS} tags, got more", field=name)
    size = _size(path, name, board, "tag_size")
    spacing = _number(path, name, board, "tag_spacing")
    spread = [
        max(_number(path, name, board, f"tag_{part}_noise") or 0.0, _LEAST)
        for part in ("rotation", "position")
    ]
    origin = read_pose(path, f"{name}.{kind}.pose", board.get("pose"))
    body_T_board = Motor.identity() if origin is None else origin.pose.inverse()
    staggered = kind == "staggered_board"
    places = [
        (row, column)
        for row in range(rows)
        for column in range(row % 2 if staggered else 0, columns, 2 if staggered else 1)
    ]
    for offset, (row, column) in enumerate(places):
        if spacing is None:
            yield first + offset, size, None
            continue
        pitch = size * (1.0 + spacing)
        down = -1.0 if staggered else 1.0
        at = body_T_board @ Motor.from_translation([column * pitch, down * row * pitch, 0.0])
        yield first + offset, size, StatedPose(at, np.diag(np.repeat(spread, 3) ** 2))


def _odometry(
    path: Path, name: str, body: Mapping[str, object], odometry: Mapping[str, Trajectory]
) -> BodyOdometry | None:
    if "T_body_odom" not in body and "odom_topic" not in body:
        return None
    topic = odometry.get(str(body.get("odom_topic")))
    if topic is None and len(odometry) == 1 and "odom_topic" not in body:
        topic = next(iter(odometry.values()))
    if topic is None:
        return None
    if "T_body_odom" in body:
        stated = read_pose(path, f"{name}.T_body_odom", body["T_body_odom"])
        if stated is None:
            problem = f"expected a pose, got {one_line(body['T_body_odom'])}"
            raise refusal(path, problem, field=f"{one_line(name)}.T_body_odom.position")
        body_T_odometry = stated.pose
    else:
        body_T_odometry = Motor.identity()
    least, most = [], []
    for key in ("odom_angular_acceleration", "odom_acceleration"):
        usual = _number(path, name, body, key) or _ACCELERATION
        least.append(_number(path, name, body, f"{key}_noise_min") or usual)
        most.append(_number(path, name, body, f"{key}_noise_max") or _JUMP * least[-1])
    return BodyOdometry(topic, body_T_odometry, (least[0], least[1]), (most[0], most[1]))


def _still(path: Path, name: str, body: Mapping[str, object]) -> tuple[float, float] | None:
    rotation, translation = (
        _number(path, name, body, f"fake_odom_{part}_noise") for part in ("rotation", "translation")
    )
    return (rotation, translation) if rotation and translation else None


def _default_noise(path: Path, table: object) -> tuple[float, float]:
    """Of positions and rotations."""
    if not isinstance(table, dict):
        return _POSITION_M, _ROTATION_RAD
    position, rotation = (_number(path, "body_defaults", table, f"{part}_noise") for part in _PARTS)
    return position or _POSITION_M, rotation or _ROTATION_RAD


def _ids(path: Path, name: str, value: object) -> list[int]:
    if value is None:
        return []
    if not isinstance(value, list):
        raise refusal(path, f"expected a list, got {one_line(value)}", field=f"{name}.ignore_tags")
    return [_count(path, name, {"ignore_tags": one}, "ignore_tags") for one in value]


def _number(path: Path, name: str, content: Mapping[str, object], key: str) -> float | None:
    """A number from 0; None where none is given."""
    if content.get(key) is None:
        return None
    (number,) = yaml_floats(path, {key: [content[key]]}, key, 1)
    if not 0.0 <= number <= _HIGHEST:
        problem = f"expected 0 to {_HIGHEST:g}, got {number:g}"
        raise refusal(path, problem, field=f"{name}.{key}".lstrip("."))
    return number


def _size(path: Path, name: str, content: Mapping[str, object], key: str) -> float:
    (size,) = yaml_floats(path, {key: [content.get(key)]}, key, 1)
    if not 0.0 < size <= _LARGEST_M:
        problem = f"expected metres above 0 and up to {_LARGEST_M:g}, got {size:g}"
        raise refusal(path, problem, field=f"{name}.{key}")
    return size


def _count(path: Path, name: str, content: Mapping[str, object], key: str) -> int:
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _MOST_TAGS:
        problem = f"expected a whole number of 0 to {_MOST_TAGS}, got {one_line(value)}"
        raise refusal(path, problem, field=f"{name}.{key}".lstrip("."))
    return value


_LOG = logging.getLogger("motorcade.replays")
_MOST_MEASURED = 10_000
_STAMP_NS = 1000
"""Seconds of this century have no more digits in a double."""
_RIG = "rig"
_PIXEL = 1.0
_FIXED = 1e-5
"""Radians and metres: what a camera wiggles where nothing is stated, below what corners tell."""
_FARTHEST_M = 1e9
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
    stated_px = _number(path, "", parameters, "pixel_noise")
    sigma_px = _PIXEL if stated_px is None else stated_px
    if sigma_px == 0.0:
        raise refusal(path, "expected pixels above 0, got 0", field="pixel_noise")
    ignored = _ignored(content, parameters)
    for key in ignored:
        _LOG.warning("%s: %s", path, key)
    with refusing(path):
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


def _ignored(content: Mapping[str, object], parameters: Mapping[str, object]) -> tuple[str, ...]:
    """What is stated and not used."""
    texts = []
    if content.get("amnesia") is True:
        texts.append("amnesia is not heeded: frames are mapped together, none alone")
    if parameters.get("minimum_tag_area"):
        texts.append("minimum_tag_area is not heeded: small tags weigh as little as their corners")
    return tuple(texts)


def read_remaps(path: Path) -> tuple[MarkerRemap, ...]:
    """Ids that change over time.

    Raises:
        RecordingError: lists or numbers that are none.
    """
    tags = []
    for entry in _tables(path, read_yaml(path).get("tag_id_remap"), "tag_id_remap"):
        for remap in _tables(path, entry.get("remaps"), "tag_id_remap.remaps"):
            marker, instead = (
                _count(path, "", table, key) for table, key in ((entry, "id"), (remap, "remap_id"))
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
        markers = frozenset(_count(path, "", {"tags": one}, "tags") for one in tags)
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
            _number(path, "", table, f"wiggle_{kind}") or _FIXED
            for kind in ("rotation", "translation")
        )
        if max(turned, moved) > _FIXED:
            wiggles[str(name)] = (max(turned, _FIXED), max(moved, _FIXED))
    return wiggles


def _distances(path: Path, value: object) -> tuple[CornerDistance, ...]:
    distances = []
    for measurement in _named(path, value, "distance_measurements"):
        a, b = (_count(path, "", measurement, key) for key in ("tag1", "tag2"))
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
        marker = _count(path, "", measurement, "tag")
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
            marker = _count(path, "", {"tags": tag}, "tags")
            planes.append(
                CornerCoordinate(marker, None, _direction(path, measurement), length_m, sigma_m)
            )
    return tuple(planes)


def _length(path: Path, table: Mapping[str, object], key: str) -> tuple[float, float]:
    length_m, sigma_m = (
        yaml_floats(path, {part: [table.get(part)]}, part, 1)[0] for part in (key, "noise")
    )
    if not 0.0 < sigma_m <= _FARTHEST_M or abs(length_m) > _FARTHEST_M:
        raise refusal(path, f"expected metres, got {length_m:g} ± {sigma_m:g}", field=key)
    return length_m, sigma_m


def _direction(path: Path, table: Mapping[str, object]) -> tuple[float, float, float]:
    x, y, z = yaml_floats(path, table, "direction", 3)
    if abs(np.linalg.norm([x, y, z]) - 1.0) > 1e-5:
        raise refusal(path, f"expected a unit vector, got {x:g}, {y:g}, {z:g}", field="direction")
    return x, y, z


def _corner(path: Path, table: Mapping[str, object], key: str) -> int:
    """TagSLAM counts from the bottom left, counter-clockwise; we, clockwise from the top left."""
    corner = _count(path, "", table, key)
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
