# SPDX-License-Identifier: MIT
"""A carrier and its joypad for ROS 1's own Python: cmd_vel in, odometry out; its wheels lag and lose a share of speed.

It makes simulated time, which waits for the mimic: a busy machine delays nobody's messages. Drives: a word each,
with the joypad's axes between commas.
"""

import math
import sys
import time
from contextlib import suppress

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from ros1_course import all_hear, placed
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Joy

RATE = 100  # [Hz]
LAG = 0.1  # [s]
GRIP = (0.95, 0.9, 1.05)  # share of speed that is left: forward, left, yaw
EPOCH = 1_700_000_000  # [s] of the first odometry
EACH = 5.0  # [s] a drive
BEHIND = 0.02  # [s] of the mimic's newest velocity at most: two periods of a mimic at this rate
PATIENCE = 100.0  # [s]


class Mimic:
    """What it sends: the velocity, of what time that is, and whether it knows where the carrier is."""

    def __init__(self) -> None:
        self.wanted, self.at, self.placed = [0.0, 0.0, 0.0], 0.0, False
        near = {"queue_size": 10, "tcp_nodelay": True}
        rospy.Subscriber("/cmd_vel", Twist, self.hear, **near)
        rospy.Subscriber("/virtual_boat", Odometry, self.see, **near)

    def hear(self, message: Twist) -> None:
        self.wanted = [message.linear.x, message.linear.y, message.angular.z]

    def see(self, message: Odometry) -> None:
        self.at = message.header.stamp.to_sec()
        self.placed = message.pose.pose.position.x != 0.0  # it begins at the carrier's first pose

    def wait(self, now: float) -> None:
        """Until it has answered a time that is not long ago."""
        end = time.monotonic() + PATIENCE
        while self.at < now - BEHIND and time.monotonic() < end and not rospy.is_shutdown():
            time.sleep(0.0005)


def odometry(now: rospy.Time, eta: list[float]) -> Odometry:
    message = Odometry()
    message.header.stamp, message.header.frame_id = now, "carrier_odom"
    message.pose.pose = placed(*eta)
    return message


def main(drives: list[list[float]]) -> None:
    """To the end of the drives."""
    rospy.init_node("carrier")
    near = {"queue_size": 10, "tcp_nodelay": True}
    outlet = rospy.Publisher("/odom", Odometry, **near)
    joypad = rospy.Publisher("/joy", Joy, **near)
    clock = rospy.Publisher("/clock", Clock, **near)
    mimic, speed, eta = Mimic(), [0.0, 0.0, 0.0], [1.0, 2.0, 0.5]
    while not all(all_hear(one) for one in (outlet, joypad, clock)):
        time.sleep(0.02)
    for k in range(round(len(drives) * EACH * RATE)):
        for i in range(3):
            speed[i] += (mimic.wanted[i] - speed[i]) * -math.expm1(-1.0 / (RATE * LAG))
        u, v, r = (share * s for share, s in zip(GRIP, speed, strict=True))
        c, s = math.cos(eta[2]), math.sin(eta[2])
        eta[0] += (c * u - s * v) / RATE
        eta[1] += (s * u + c * v) / RATE
        eta[2] += r / RATE
        now = rospy.Time(EPOCH) + rospy.Duration.from_sec(k / RATE)
        clock.publish(Clock(now))
        time.sleep(0.001)  # a message comes by another connection than the time
        if k % 4 == 0:
            outlet.publish(odometry(now, eta))
        if k % 5 == 2 and mimic.placed:
            message = Joy(axes=drives[int(k / (EACH * RATE))])
            message.header.stamp = now
            joypad.publish(message)
        if k > RATE // 5:
            mimic.wait(now.to_sec())
    time.sleep(1.5)  # of this machine's time, by which the mimic's diagnoses come


if __name__ == "__main__":
    with suppress(rospy.ROSInterruptException):
        main([[float(x) for x in word.split(",")] for word in sys.argv[1:]])
