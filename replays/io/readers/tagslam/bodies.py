"""Bodies and their tags as `tagslam.yaml` states them: sizes, poses and their noise, odometry.

TagSLAM attaches tags to bodies. A tag that no body lists belongs to `default_body`; where there is
none it is ignored. A tag's frame has its origin at the centre; ours, at the printed top-left
corner. `T_body_odom` takes the odometry's coordinates to the body's, as its name says.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.names import one_line
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.readers.calibration import read_yaml, yaml_floats
from motorcade.tracking.markers.scenes import BodyOdometry, FixedMarker, MarkerBody, StatedPose
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
        raise refusal(path, f"expected 0 to {_HIGHEST:g}, got {number:g}", field=f"{name}.{key}")
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
        raise refusal(path, problem, field=f"{name}.{key}")
    return value
