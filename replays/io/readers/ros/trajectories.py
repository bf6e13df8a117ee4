"""Trajectories in bags: topics of poses, points and odometry, and chains of frames of tf.

Poses are `header.frame_id`_T_`child`, and stamps those of the headers. A chain is named by its two
frames, `map/base_link`; where a bag has several topics of tf, `/robot/tf:map/base_link` names the
one that is meant. A dot does for the slash between frames, as in evo.

Frames that hang from each other, as topics of tf tell it, and one's path in another.

Each transform says where a frame stands in its parent at a stamp; those of `tf_static` hold for all
times. As in tf2, a frame has one parent, a leading slash of its name means nothing, and between two
stamps positions are interpolated linearly, rotations about a fixed axis, each link by itself;
nothing is extrapolated.
"""

from __future__ import annotations

import logging
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import IntArray
from motorcade.ga.names import one_line
from motorcade.ga.stamps import STAMP_LIMIT_NS
from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.ros.reader import Bag, header_stamp_ns
from motorcade.replays.io.readers.tables import REACH_M, UNIT_TOLERANCE

TRANSFORM_TYPES = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
_MOST_TRANSFORMS = 10_000_000
_MOST_LINKS = 10_000
_DEEPEST = 100


class FrameTree:
    """The transforms of a bag.

    Args:
        bag: open.
        topics: of transforms; those that end in `tf_static` hold for all times.

    Raises:
        RecordingError: damaged, or more frames or transforms than are read.

    Fields:
        links: parent and child of every transform, in the order in which they were met.
    """

    def __init__(self, bag: Bag, topics: Sequence[str]) -> None:
        self._path = bag.path
        self.links: dict[tuple[str, str], None] = {}
        self._parents: dict[str, dict[str, None]] = {}
        self._moving: dict[str, StampedPoses] = {}
        self._static: dict[str, StampedPoses] = {}
        count = 0
        for topic, _, message in bag.every(topics, TRANSFORM_TYPES):
            still = topic.endswith("tf_static")
            count += len(message.transforms)
            if count > _MOST_TRANSFORMS:
                problem = f"expected at most {_MOST_TRANSFORMS} transforms, got more"
                raise refusal(self._path, problem)
            for transform in message.transforms:
                self._add(transform, still=still)

    def _add(self, value: Any, *, still: bool) -> None:
        parent, child = (
            str(name).removeprefix("/") for name in (value.header.frame_id, value.child_frame_id)
        )
        links, field = self._static if still else self._moving, one_line(f"{parent}/{child}")
        if still or child not in links:
            links[child] = StampedPoses(self._path, field)
        links[child].add(
            header_stamp_ns(value), value.transform.translation, value.transform.rotation
        )
        self._parents.setdefault(child, {})[parent] = None
        self.links[parent, child] = None
        if len(self.links) > _MOST_LINKS:
            raise refusal(self._path, f"expected at most {_MOST_LINKS} pairs of frames, got more")

    @property
    def frames(self) -> set[str]:
        """The names of all frames."""
        return {name for link in self.links for name in link}

    def trajectory(self, parent: str, child: str) -> Trajectory:
        """`parent_T_child` at the stamps of the link between them that has the most.

        A chain that never moves is one pose, at stamp 0.

        Raises:
            RecordingError: no chain joins the two, a frame on it has several parents, or its links
                have no time in common.
        """
        ups = [self._upwards(name) for name in (parent, child)]
        shared = next((frame for frame in ups[1] if frame in ups[0]), None)
        if shared is None:
            problem = f"expected transforms that join them, got none up to {one_line(ups[0][-1])}"
            problem += f" and {one_line(ups[1][-1])}"
            raise refusal(self._path, problem, field=one_line(f"{parent}/{child}"))
        to_parent, to_child = (up[: up.index(shared)] for up in ups)
        stamps = self._stamps([*to_parent, *to_child], f"{parent}/{child}")
        shared_T_parent, shared_T_child = (
            self._composed(links, stamps) for links in (to_parent, to_child)
        )
        poses = shared_T_parent.inverse() @ shared_T_child
        return Trajectory(stamps, poses, parent, child)

    def _upwards(self, frame: str) -> list[str]:
        """The frame, its parent, and so on to one that has none."""
        frames = [frame]
        while frames[-1] in self._parents:
            parents = list(self._parents[frames[-1]])
            if len(parents) > 1:
                named = " and ".join(map(one_line, parents[:4]))
                problem = f"expected one parent of {one_line(frames[-1])}, got {named}"
                raise refusal(self._path, problem)
            if parents[0] in frames or len(frames) > _DEEPEST:
                problem = f"expected a tree of at most {_DEEPEST} levels, got another"
                raise refusal(self._path, problem, field=one_line(frames[-1]))
            frames.append(parents[0])
        return frames

    def _stamps(self, links: Sequence[str], field: str) -> IntArray:
        """The stamps of the moving link that has the most, where all of them have poses."""
        every = {link: self._moving[link].ordered[0] for link in links if link in self._moving}
        if not every:
            return np.zeros(1, dtype=np.int64)
        last_start = max(every, key=lambda link: int(every[link][0]))
        first_end = min(every, key=lambda link: int(every[link][-1]))
        start, end = int(every[last_start][0]), int(every[first_end][-1])
        longest = max(every.values(), key=len)
        stamps = longest[(longest >= start) & (longest <= end)]
        if not stamps.size:
            problem = (
                f"expected transforms of one time, got those of {one_line(last_start)} from "
                f"{start} ns on and those of {one_line(first_end)} up to {end} ns"
            )
            raise refusal(self._path, problem, field=one_line(field))
        return stamps

    def _composed(self, links: Sequence[str], stamps: IntArray) -> Motor:
        """Where the first of these frames stands in the parent of the last."""
        poses = Motor.identity(stamps.shape)
        for link in links:
            poses = self._at(link, stamps) @ poses
        return poses

    def _at(self, link: str, stamps: IntArray) -> Motor:
        if link not in self._moving:
            _, still = self._static[link].ordered
            return still[np.zeros(stamps.shape, dtype=np.int64)]
        time_ns, poses = self._moving[link].ordered
        if len(time_ns) == 1:
            return poses[np.zeros(stamps.shape, dtype=np.int64)]
        after = np.clip(np.searchsorted(time_ns, stamps), 1, len(time_ns) - 1)
        step = time_ns[after] - time_ns[after - 1]
        share = (stamps - time_ns[after - 1]) / step
        turn = poses.rotor[after - 1].interpolate(poses.rotor[after], share)
        first, last = poses.translation_m[after - 1], poses.translation_m[after]
        return Motor.from_rotor_translation(turn, first + share[:, None] * (last - first))


_LOG = logging.getLogger("motorcade.replays")


class StampedPoses:
    """Poses in the order they were recorded, which need not be that of their stamps.

    Args:
        path: the bag, for what is said of it.
        field: the topic, or the two frames.
    """

    def __init__(self, path: Path, field: str) -> None:
        self._path, self._field = path, field
        self._stamps, self._numbers = array("q"), array("d")

    def __len__(self) -> int:
        return len(self._stamps)

    def add(self, stamp_ns: int, place: Any, turn: Any | None) -> None:
        """Add a pose: a message's point or vector, and its quaternion (None: not turned).

        Raises:
            RecordingError: a stamp that is 146 years or more from zero.
        """
        if abs(stamp_ns) >= STAMP_LIMIT_NS:
            raise self._refusal(len(self), f"expected a stamp within 146 years, got {stamp_ns} ns")
        self._stamps.append(stamp_ns)
        wxyz = (1.0, 0.0, 0.0, 0.0) if turn is None else (turn.w, turn.x, turn.y, turn.z)
        self._numbers.extend((place.x, place.y, place.z, *wxyz))

    @cached_property
    def ordered(self) -> tuple[IntArray, Motor]:
        """Increasing stamps ``(N,)`` and their poses ``(N,)``; of equal stamps the first's.

        Raises:
            RecordingError: no poses, no stamps, or a pose that is no finite rigid motion.
        """
        time_ns = np.frombuffer(self._stamps, np.int64)
        if not time_ns.size:
            raise refusal(self._path, "expected poses, got none", field=self._field)
        if time_ns.size > 1 and not time_ns.any():
            problem = "expected the stamps of headers, got 0 in every one"
            raise refusal(self._path, problem, field=self._field)
        numbers = np.frombuffer(self._numbers, np.float64).reshape(-1, 7)
        far = ~(np.abs(numbers[:, :3]).max(axis=1) <= REACH_M)
        self._refuse(far, numbers[:, :3], f"expected a position within {REACH_M:g} m, got")
        with np.errstate(over="ignore", invalid="ignore"):
            norm = np.sqrt(np.sum(numbers[:, 3:] ** 2, axis=1))
        askew = ~(np.abs(norm - 1.0) <= UNIT_TOLERANCE)
        self._refuse(askew, norm, "expected a unit quaternion, got one of norm")
        order = self._order(time_ns)
        wxyz = numbers[order, 3:] / norm[order, None]
        return time_ns[order], Motor.from_quaternion_translation(wxyz, numbers[order, :3])

    def _order(self, time_ns: IntArray) -> IntArray:
        """Places of the poses by their stamps, one for each; what is not used is told."""
        order = np.argsort(time_ns, kind="stable")
        late = int(np.count_nonzero(np.diff(time_ns) < 0))
        if late:
            text = "%s, %s: stamps go back %d times; poses are taken in the order of their stamps"
            _LOG.warning(text, self._path, self._field, late)
        repeats = np.flatnonzero(np.diff(time_ns[order]) == 0) + 1
        if repeats.size:
            text = "%s, %s: %d poses have the stamp of another; the first of each is kept"
            _LOG.warning(text, self._path, self._field, repeats.size)
        return np.delete(order, repeats)

    def _refuse(self, bad: Any, values: Any, problem: str) -> None:
        if np.any(bad):
            at = int(np.flatnonzero(bad)[0])
            raise self._refusal(at, f"{problem} {np.array2string(values[at], precision=6)}")

    def _refusal(self, at: int, problem: str) -> Exception:
        return refusal(self._path, problem, field=f"{self._field}, pose {at}")


_MOST_POSES = 10_000_000
_SHOWN = 20
_POINT = "geometry_msgs/msg/PointStamped"
_FIX = "sensor_msgs/msg/NavSatFix"
_NO_FIX = -1


@dataclass(frozen=True)
class BagTrajectories:
    """What a bag holds that can be read as a trajectory.

    Args:
        topics: type and count of messages of each topic of poses, by name.
        links: frames that hang from each other: (parent, child).
    """

    topics: Mapping[str, tuple[str, int]]
    links: tuple[tuple[str, str], ...]

    def __str__(self) -> str:
        """What there is, in one line."""
        names = [f"{one_line(name)} ({kind})" for name, (kind, _) in self.topics.items()]
        names += [one_line(f"{parent}/{child}") for parent, child in self.links]
        more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
        return ", ".join(names[:_SHOWN]) + more

    def __len__(self) -> int:
        return len(self.topics) + len(self.links)


def list_bag_trajectories(path: Path) -> BagTrajectories:
    """What a bag holds that can be read as a trajectory.

    Raises:
        RecordingError: missing or damaged.
    """
    with Bag(path) as bag:
        return _listed(bag)


def read_bag_trajectory(
    path: Path, name: str, parent: str | None = None, child: str | None = None
) -> Trajectory:
    """Read one trajectory of a bag.

    Args:
        path: a `.bag`, `.bag.bz2`, `.mcap`, `.db3` or a ROS 2 bag's folder.
        name: a topic of poses, or two frames that topics of tf join.
        parent: name of the frame that poses map to; by default what the bag calls it, or world.
        child: name of the frame that moves; by default what the bag calls it, or camera.

    Raises:
        RecordingError: missing, damaged, nothing of that name (the message lists what there is),
            poses that are no rigid motions, frames that change within a topic, or frames that no
            transforms join.
    """
    with Bag(path) as bag:
        topics = _pose_topics(bag)
        topic = next((entry for entry in (name, f"/{name}") if name and entry in topics), None)
        if topic is not None and topics[topic][0] == _FIX:
            return _fixes(bag, topic, parent, child)
        poses = _chain(bag, name) if topic is None else _poses(bag, topic, topics[topic][0])
    return Trajectory(poses.time_ns, poses.poses, parent or poses.parent, child or poses.child)


def _pose_topics(bag: Bag) -> dict[str, tuple[str, int]]:
    """Type and count of the messages of each topic of poses."""
    kinds = bag.kinds().items()
    return {name: kind for name, kind in kinds if kind[0] in (*_POSES, _FIX) and kind[1]}


def _listed(bag: Bag, tree: FrameTree | None = None) -> BagTrajectories:
    tree = tree or FrameTree(bag, bag.topics(TRANSFORM_TYPES))
    return BagTrajectories(_pose_topics(bag), tuple(tree.links))


def _poses(bag: Bag, topic: str, kind: str) -> Trajectory:
    """The trajectory of a topic of poses."""
    taken, field = _POSES[kind], one_line(topic)
    poses, frames = StampedPoses(bag.path, field), None
    if kind == _POINT:
        _LOG.warning("%s, %s: points do not turn; rotations are none", bag.path, field)
    for stamp, message in bag.messages([topic], (kind,)):
        place, turn = taken(message)
        poses.add(stamp, place, turn)
        named = str(message.header.frame_id), str(getattr(message, "child_frame_id", ""))
        frames = frames or named
        if named != frames:
            there, here = (one_line("_T_".join(entry)) for entry in (frames, named))
            problem = f"expected poses {there} throughout, got {here}"
            raise refusal(bag.path, problem, field=f"{field}, pose {len(poses) - 1}")
        if len(poses) > _MOST_POSES:
            raise refusal(bag.path, f"expected at most {_MOST_POSES} poses, got more", field=field)
    parent, child = (name.removeprefix("/") for name in frames or ("", ""))
    return Trajectory(*poses.ordered, parent or "world", child or "camera")


def _fixes(bag: Bag, topic: str, parent: str | None, child: str | None) -> Trajectory:
    """Positions of satellite navigation; REP 145's heights are over the ellipsoid."""
    from motorcade.replays.io.readers.positions import MOST_FIXES, geodetic_path

    rows = []
    for stamp, fix in bag.messages([topic], (_FIX,)):
        if fix.status.status > _NO_FIX:
            rows.append((stamp, fix.latitude, fix.longitude, fix.altitude))
        if len(rows) > MOST_FIXES:
            raise refusal(bag.path, f"expected at most {MOST_FIXES} fixes, got more", field=topic)
    stamps = np.array([row[0] for row in rows], dtype=np.int64)
    places = np.array([row[1:] for row in rows], dtype=np.float64).reshape(-1, 3)
    return geodetic_path(bag.path, stamps, places, None, parent, child)


def _chain(bag: Bag, name: str) -> Trajectory:
    """The trajectory of one frame in another, as `[TOPIC:]PARENT/CHILD` names them."""
    topics = bag.topics(TRANSFORM_TYPES)
    topic, colon, frames = name.partition(":")
    if colon:
        if topic not in topics:
            problem = f"expected one of {', '.join(map(one_line, topics)) or 'none'}"
            raise refusal(bag.path, f"{problem}, got {one_line(topic)}", field="topic of tf")
        topics = [entry for entry in topics if entry == topic or entry.endswith("tf_static")]
    else:
        frames = name
    tree = FrameTree(bag, topics)
    joints = [at for at, letter in enumerate(frames) if letter in "/."]
    pairs = [(frames[:at].removeprefix("/"), frames[at + 1 :].removeprefix("/")) for at in joints]
    known = [pair for pair in dict.fromkeys(pairs) if tree.frames.issuperset(pair)]
    if len(known) != 1:
        got = one_line(name) if name else "no name"
        problem = f"expected a topic of poses or two frames, got {got}"
        if known:
            problem = f"expected two frames, got {one_line(name)}, which is more than one pair"
        there = _listed(bag, tree if not colon else None)
        advice = f"name one of them as {bag.path}:NAME: {there}"
        raise refusal(bag.path, problem, advice=advice if there else "it holds none")
    return tree.trajectory(*known[0])


def _of_pose(message: Any) -> tuple[Any, Any]:
    return message.pose.position, message.pose.orientation


def _of_pose_with_covariance(message: Any) -> tuple[Any, Any]:
    return message.pose.pose.position, message.pose.pose.orientation


def _of_transform(message: Any) -> tuple[Any, Any]:
    return message.transform.translation, message.transform.rotation


def _of_point(message: Any) -> tuple[Any, None]:
    return message.point, None


_POSES: dict[str, Callable[[Any], tuple[Any, Any]]] = {
    "geometry_msgs/msg/PoseStamped": _of_pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": _of_pose_with_covariance,
    "geometry_msgs/msg/TransformStamped": _of_transform,
    "nav_msgs/msg/Odometry": _of_pose_with_covariance,
    _POINT: _of_point,
}
