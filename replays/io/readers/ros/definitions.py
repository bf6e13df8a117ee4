"""Types of ROS messages by their usual definitions, with those that rosbags does not bring along.

The definitions that a bag brings along are never used.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

_APRILTAG = """
int32 id
string family
int32 hamming
int32 border
int32 bits
geometry_msgs/Point center
geometry_msgs/Point[4] corners
"""
_OF_ROS1 = {
    "apriltag_msgs/msg/Apriltag": _APRILTAG,
    "apriltag_msgs/msg/ApriltagArrayStamped": "std_msgs/Header header\nApriltag[] apriltags\n",
    "tf/msg/tfMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
}


@cache
def message_types(*, ros1: bool) -> Typestore:
    """The types of ROS 1 Noetic, TagSLAM's and tf's among them, or those of ROS 2 Humble."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    for name, text in _OF_ROS1.items() if ros1 else ():
        found = get_types_from_msg(text, name)
        store.register({key: value for key, value in found.items() if key not in store.types})
    return store
