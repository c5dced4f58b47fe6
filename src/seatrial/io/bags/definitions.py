# SPDX-License-Identifier: MIT
"""Message definitions for bags without them: ROS 2's .db3 before Iron."""

from functools import lru_cache
from typing import TYPE_CHECKING

from seatrial.io.bags.wire import parse_definition

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

# not in rosbags; field lists are those of the packages' .msg files
COMMON = {
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "mavros_msgs/msg/RCOut": "std_msgs/Header header\nuint16[] channels",
    "mavros_msgs/msg/RCIn": "std_msgs/Header header\nuint8 rssi\nuint16[] channels",
    "mavros_msgs/msg/ManualControl": (
        "std_msgs/Header header\nfloat32 x\nfloat32 y\nfloat32 z\nfloat32 r\nuint16 buttons\n"
        "uint16 buttons2\nuint8 enabled_extensions\nfloat32 s\nfloat32 t\nfloat32 aux1\n"
        "float32 aux2\nfloat32 aux3\nfloat32 aux4\nfloat32 aux5\nfloat32 aux6"
    ),
}


@lru_cache(maxsize=1)
def standard_definitions() -> "Typesdict":
    """ROS 2's common interfaces, tf2 and mavros."""
    from rosbags.typesys import Stores, get_typestore

    known = dict(get_typestore(Stores.ROS2_HUMBLE).fielddefs)
    for name, text in COMMON.items():
        known.update(parse_definition(text, name))
    return known
