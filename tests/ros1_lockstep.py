# SPDX-License-Identifier: MIT
"""A bag played to the odometry node in lock-step, by ROS 1's own Python: simulated time waits for its odometry.

So neither a busy machine nor one that stands still changes what the node hears before a tick of its timer. At
times that are given it stops until a line comes on its standard input.
"""

import select
import sys
import time
from contextlib import suppress

import rosbag
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from ros1_course import all_hear
from rosgraph_msgs.msg import Clock

TICK = 20_000_000  # [ns] the node's period
REPEAT, REPEATS = 0.05, 2000  # [s] after which a time is said again, at most so often
SOON = 0.001  # [s] a message comes by another connection than the time
WITHOUT = 0.05  # [s] for a node that did not answer before


class Player:
    """The simulated time, and the odometry that answers it."""

    def __init__(self) -> None:
        self.clock = rospy.Publisher("/clock", Clock, queue_size=100, tcp_nodelay=True)
        self.answered = 0  # [ns] stamp of the newest odometry
        self.there = False  # a node that answers
        self.diagnoses = 0
        rospy.Subscriber("/odom", Odometry, self.hear, queue_size=100, tcp_nodelay=True)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self.count, queue_size=100)

    def hear(self, message: Odometry) -> None:
        self.answered, self.there = message.header.stamp.to_nsec(), True

    def count(self, _: DiagnosticArray) -> None:
        self.diagnoses += 1

    def say(self, now: int) -> None:
        self.clock.publish(Clock(rospy.Time(now // 10**9, now % 10**9)))

    def tick(self, now: int) -> None:
        """A time at which the node's timer is due: its odometry is waited for."""
        time.sleep(SOON)
        repeats = REPEATS if self.there else 1
        for _ in range(repeats):
            self.say(now)
            end = time.monotonic() + REPEAT
            while time.monotonic() < end and not rospy.is_shutdown():
                if self.answered > now - TICK:  # its timer began with the time that it heard first
                    return
                time.sleep(0.0005)
        self.there = False

    def wait(self, now: int) -> None:
        """For a line on the standard input, at a time that stands: whoever starts meanwhile hears it."""
        while not select.select([sys.stdin], [], [], REPEAT)[0]:
            self.say(now)
        sys.stdin.readline()
        self.there = False  # the node may be another one, that has yet to hear a pose


def main(bag: str, stops: list[float]) -> None:
    """To the bag's end, and to the second diagnosis after it."""
    rospy.init_node("player", disable_rosout=True)
    player = Player()
    with rosbag.Bag(bag) as opened:
        rows = [(topic, message, at.to_nsec()) for topic, message, at in opened.read_messages()]
    near = {"queue_size": 1000, "tcp_nodelay": True}
    outlets = {topic: rospy.Publisher(topic, type(m), **near) for topic, m, _ in rows}
    while not all(all_hear(one) for one in (*outlets.values(), player.clock)):
        time.sleep(0.02)
    begin = rows[0][2] - rows[0][2] % 10**9
    now, stops = begin, [begin + round(1e9 * stop) for stop in stops]
    for topic, message, at in rows:
        while now + TICK <= at:
            now += TICK
            player.tick(now)
            if stops and now >= stops[0]:
                del stops[0]
                sys.stdout.write("stopped\n")
                sys.stdout.flush()
                player.wait(now)
        player.say(at)
        time.sleep(SOON)
        outlets[topic].publish(message)
    last = player.diagnoses
    while player.diagnoses < last + 2 and not rospy.is_shutdown():
        time.sleep(0.02)


if __name__ == "__main__":
    with suppress(rospy.ROSInterruptException):
        main(sys.argv[1], [float(word) for word in sys.argv[2:]])
