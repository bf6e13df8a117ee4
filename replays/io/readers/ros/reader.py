"""Bags of ROS 1 and ROS 2 opened without ROS: their topics, and messages of known types.

What a message may cost is bounded, compressed ROS 2 storage files are refused, and only message
types that are known here are taken apart. A bag that was cut short is read to its last whole chunk.
"""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Self

from motorcade.ga.names import one_line
from motorcade.replays.io.files import RecordingError, admit_file, refusal
from motorcade.replays.io.readers.ros.admission import (
    BAG_LIMIT,
    admit_bag,
    bound_chunks,
    check_overlaps,
    message_types,
    plain_bag,
)

_LOG = logging.getLogger("motorcade.replays")
_MESSAGE_LIMIT = 200_000
# Stamps are whole nanoseconds in 63 bits; MCAP has room for 64.
_LATEST_NS = 1 << 63


class Bag:
    """An open bag; close it, or use it as a context manager.

    Args:
        path: a `.bag`, one packed as `.bag.bz2`, a `.mcap`, a `.db3` or a ROS 2 bag's folder.

    Raises:
        RecordingError: missing, damaged, or of ROS 2 and compressed as a whole.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._unpacked = tempfile.TemporaryDirectory() if path.suffix.lower() == ".bz2" else None
        plain = path
        try:
            if self._unpacked is not None:
                plain = plain_bag(path, Path(self._unpacked.name))
            self._ros1 = plain.suffix.lower() == ".bag"
            admit_bag(plain)
            bound_chunks()
            try:
                self._reader, cut = _opened(plain, ros1=self._ros1)
            except Exception as fault:  # the parsers' errors have no common base
                raise self._refusal(fault) from fault
            if cut:
                _say(f"{one_line(path)}: {cut}")
            try:
                self._check_names()
                check_overlaps(self._reader)
            except RecordingError:
                self._reader.close()
                raise
        except RecordingError:
            self._remove_unpacked()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._reader.close()
        self._remove_unpacked()

    def _remove_unpacked(self) -> None:
        if self._unpacked is not None:
            self._unpacked.cleanup()

    def _check_names(self) -> None:
        """Refuse topics that a description calls by numbers, as YAML reads them."""
        for connection in self._reader.connections:
            for name in (connection.topic, connection.msgtype):
                if not isinstance(name, str):
                    problem = f"expected names of topics and types, got {one_line(name)}"
                    raise refusal(self.path, problem)

    def topics(self, types: Sequence[str]) -> list[str]:
        """Names of topics of these types that hold messages, sorted."""
        seen = {entry.topic for entry in self._reader.connections if entry.msgtype in types}
        return sorted(seen)

    def kinds(self) -> dict[str, tuple[str, int]]:
        """Type and count of the messages of every topic, by its name, sorted."""
        topics: dict[str, tuple[str, int]] = {}
        for connection in sorted(
            self._reader.connections, key=lambda entry: (entry.topic, entry.msgtype)
        ):
            kind, count = topics.get(connection.topic, (connection.msgtype, 0))
            topics[connection.topic] = kind, count + int(connection.msgcount)
        return topics

    def messages(
        self, topics: Sequence[str], types: Sequence[str], at_ns: int | None = None
    ) -> Iterator[tuple[int, Any]]:
        """Header stamps and messages; only those recorded at `at_ns` where it is given."""
        for _, stamp, message in self.recorded(topics, types, at_ns):
            yield stamp, message

    def recorded(
        self, topics: Sequence[str], types: Sequence[str], at_ns: int | None = None
    ) -> Iterator[tuple[int, int, Any]]:
        """As `messages`, each with the time it was recorded at before.

        Raises:
            RecordingError: damaged, or a type defined otherwise than usual.
        """
        for _, recorded_ns, message in self.every(topics, types, at_ns):
            yield recorded_ns, header_stamp_ns(message), message

    def every(
        self, topics: Sequence[str], types: Sequence[str], at_ns: int | None = None
    ) -> Iterator[tuple[str, int, Any]]:
        """Topic, time of recording and message, in the order recorded; raises as `recorded`."""
        wanted = [
            entry
            for entry in self._reader.connections
            if entry.topic in topics and entry.msgtype in types
        ]
        if not wanted:
            return
        store = message_types(ros1=self._ros1)
        for entry in wanted:
            if (
                self._ros1
                and entry.digest != store.generate_msgdef(entry.msgtype, ros_version=1)[1]
            ):
                problem = f"expected the usual {entry.msgtype}, got another definition"
                raise refusal(self.path, problem, field=one_line(entry.topic))
        span = {} if at_ns is None else {"start": at_ns, "stop": at_ns + 1}
        take = store.deserialize_ros1 if self._ros1 else store.deserialize_cdr
        try:
            for connection, recorded_ns, raw in self._reader.messages(wanted, **span):
                if connection.msgtype not in types:  # two connections of one number
                    problem = f"expected {' or '.join(types)}, got {one_line(connection.msgtype)}"
                    raise refusal(self.path, problem, field=one_line(connection.topic))
                if recorded_ns >= _LATEST_NS:
                    problem = f"expected times of receipt before 2262, got {recorded_ns} ns"
                    raise refusal(self.path, problem, field=one_line(connection.topic))
                message: Any = take(raw, connection.msgtype)
                yield connection.topic, recorded_ns, message
        except (RecordingError, GeneratorExit):
            raise
        except Exception as fault:  # as above
            raise self._refusal(fault) from fault

    def _refusal(self, fault: Exception) -> RecordingError:
        reason = one_line(str(fault) or type(fault).__name__, 120)
        return refusal(self.path, f"expected a whole ROS bag: {reason}")


def header_stamp_ns(message: Any) -> int:
    """The stamp in the header of a message that has one."""
    stamp = message.header.stamp
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def read_bag(path: Path, types: Sequence[str]) -> Iterator[tuple[str, str, Any]]:
    """Give topic, type and message of all messages of the given types, in the order recorded.

    Args:
        path: a ``.bag`` of at most 256 MiB, or one packed as ``.bag.bz2``, of at most 64 MiB.
        types: such as "nav_msgs/msg/Odometry"; other messages are skipped.

    Raises:
        EmptyBag: none of these types.
        RecordingError: as `Bag` and its `every`; too large; more than 200,000 messages.
    """
    admit_file(path, BAG_LIMIT)
    with Bag(path) as bag:
        kinds, topics = bag.kinds(), bag.topics(types)
        count = sum(count for _, count in kinds.values())
        if count > _MESSAGE_LIMIT:
            raise refusal(path, f"expected at most {_MESSAGE_LIMIT} messages, got {count}")
        if not topics:
            problem = f"expected messages of {' or '.join(types)}, got none"
            raise EmptyBag(str(refusal(path, problem)))
        for topic, _, message in bag.every(topics, types):
            yield topic, message.__msgtype__, message


class EmptyBag(RecordingError):
    """A whole bag that holds no message of the types that were looked for."""


@cache
def _say(text: str) -> None:
    """Warn once, however often a bag is opened."""
    _LOG.warning("%s", text)


def _opened(path: Path, *, ros1: bool) -> tuple[Any, str]:
    """The open bag, and what is said of one that was cut short."""
    from motorcade.replays.io.readers.ros.admission import CutBagReader, McapOrCutReader

    reader: Any = CutBagReader(path) if ros1 else McapOrCutReader(path)
    reader.open()
    return reader, reader.cut
