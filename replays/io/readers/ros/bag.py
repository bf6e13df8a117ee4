"""ROS 1 bags, plain or packed with bzip2, read without ROS; only message types that are known here.

The definitions of messages that a bag brings along are never used: a connection must carry the MD5
sum of ours. What a file may cost is bounded before it is read.
"""

from __future__ import annotations

import bz2
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from motorcade.ga.names import one_line
from motorcade.replays.io.errors import RecordingError, refusal
from motorcade.replays.io.files import admit_file, read_bounded
from motorcade.replays.io.readers.ros.admission import bound_chunks, message_types

PACKED_LIMIT = 2**26
BAG_LIMIT = 2**28
_MESSAGE_LIMIT = 200_000


class EmptyBag(RecordingError):
    """A whole bag that holds no message of the types that were looked for."""


def read_bag(path: Path, types: Sequence[str]) -> Iterator[tuple[str, str, Any]]:
    """Give topic, type and message of all messages of the given types, in the order recorded.

    Args:
        path: a ``.bag`` file of at most 256 MiB, or a ``.bag.bz2`` of at most 64 MiB that unpacks
            to no more than that. Chunks inside may be compressed (bz2, lz4), to no more each.
        types: such as "nav_msgs/msg/Odometry"; other messages are skipped.

    Raises:
        EmptyBag: none of these types.
        RecordingError: missing, too large, not a bag, damaged, more than 200,000 messages, or a
            type whose definition is another than the usual one.
    """
    try:
        with tempfile.TemporaryDirectory() as folder:
            yield from _messages(path, plain_bag(path, Path(folder)), types)
    except (RecordingError, GeneratorExit):
        raise
    except Exception as fault:
        # The parser meets whatever bytes a damaged file holds; its errors have no common base.
        problem = f"expected a ROS 1 bag: {one_line(str(fault) or type(fault).__name__, 100)}"
        raise refusal(path, problem) from fault


def plain_bag(path: Path, folder: Path) -> Path:
    """The bag itself, unpacked into `folder` where it is packed with bzip2.

    Raises:
        RecordingError: missing, too large, packed or plain, or damaged.
    """
    if path.suffix != ".bz2":
        admit_file(path, BAG_LIMIT)
        return path
    packed = read_bounded(path, PACKED_LIMIT)
    unpacker = bz2.BZ2Decompressor()
    try:
        content = unpacker.decompress(packed, max_length=BAG_LIMIT + 1)
    except (OSError, ValueError) as fault:
        raise refusal(path, f"expected bzip2: {fault}") from fault
    if len(content) > BAG_LIMIT:
        raise refusal(path, f"expected at most {BAG_LIMIT} bytes unpacked, got more")
    if not unpacker.eof:
        raise refusal(path, "expected a whole bzip2 file, got one that is cut short")
    plain = folder / "recording.bag"
    plain.write_bytes(content)
    return plain


def _messages(path: Path, plain: Path, types: Sequence[str]) -> Iterator[tuple[str, str, Any]]:
    from rosbags.rosbag1.reader import Reader

    store = message_types(ros1=True)
    bound_chunks()
    with Reader(plain) as bag:
        if bag.message_count > _MESSAGE_LIMIT:
            problem = f"expected at most {_MESSAGE_LIMIT} messages, got {bag.message_count}"
            raise refusal(path, problem)
        wanted = [one for one in bag.connections if one.msgtype in types]
        for one in wanted:
            if one.digest != store.generate_msgdef(one.msgtype, ros_version=1)[1]:
                problem = f"expected the usual {one.msgtype}, got another definition"
                raise refusal(path, problem, field=one_line(one.topic))
        if not wanted:
            problem = f"expected messages of {' or '.join(types)}, got none"
            raise EmptyBag(str(refusal(path, problem)))
        for connection, _, raw in bag.messages(connections=wanted):
            message = store.deserialize_ros1(raw, connection.msgtype)
            yield connection.topic, connection.msgtype, message
