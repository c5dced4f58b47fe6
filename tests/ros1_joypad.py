# SPDX-License-Identifier: MIT
"""A joypad held still, by ROS 1's own Python: its first message reaches all that have subscribed.

`rostopic pub` waits for no one: what it sends first, some hear and others miss.
"""

import sys
from contextlib import suppress

import rospy
from ros1_course import all_hear
from sensor_msgs.msg import Joy

RATE = 20.0  # [Hz]


def main(seconds: float, axes: list[float]) -> None:
    """For so many seconds of ROS's time."""
    rospy.init_node("joypad", anonymous=True)
    joypad = rospy.Publisher("/joy", Joy, queue_size=10)
    while not all_hear(joypad):
        rospy.sleep(0.05)
    beat, end = rospy.Rate(RATE), rospy.Time.now() + rospy.Duration.from_sec(seconds)
    while not rospy.is_shutdown() and rospy.Time.now() < end:
        joypad.publish(Joy(axes=axes))
        beat.sleep()


if __name__ == "__main__":
    with suppress(rospy.ROSInterruptException):
        numbers = [float(word) for word in sys.argv[1:]]
        main(numbers[0], numbers[1:])
