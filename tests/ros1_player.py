# SPDX-License-Identifier: MIT
"""A drive played to a SLAM and the odometry node, by ROS 1's own Python: scans, commands, clock, in lock-step.

Simulated time waits for the answers: odometry after every tick, the SLAM's pose after every scan. So no
scan is dropped, and a busy machine changes no result. What was answered is written as JSON.
"""

import json
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import rospy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from ros1_course import placed, transform
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Joy, LaserScan
from tf2_msgs.msg import TFMessage

EPOCH = 1_700_000_000 * 10**9  # [ns] time zero of a drive
TICK = 0.02  # [s] of simulated time, the odometry node's period
LEAD = 2.0  # [s] at rest before the drive, with one scan: map and odometry begin
PATIENCE = 0.2  # [s] of this machine's time for an answer; then simulated time goes on
ANSWERS = 50  # times PATIENCE that a scan has no pose: the SLAM gives no more
MAP_PERIOD = 10.0  # [s] between two maps
HOLD = 1.0  # [s] at most, that a velocity is taken to stay
OCCUPIED = 100

Pose = tuple[float, float, float]  # x, y [m], psi [rad]


def stamp_of(t: float) -> rospy.Time:
    nanoseconds = EPOCH + round(t * 1e9)
    return rospy.Time(nanoseconds // 10**9, nanoseconds % 10**9)


def seconds(stamp: rospy.Time) -> float:
    return (stamp.to_nsec() - EPOCH) * 1e-9


def compose(a: Pose, b: Pose) -> Pose:
    c, s = math.cos(a[2]), math.sin(a[2])
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]


def between(a: Pose, b: Pose) -> Pose:
    c, s = math.cos(a[2]), math.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    return c * dx + s * dy, -s * dx + c * dy, math.remainder(b[2] - a[2], 2.0 * math.pi)


def along(step: Pose, share: float) -> Pose:
    """A share of a step, along its arc."""
    psi = step[2]
    half = 0.5 * psi / math.tan(0.5 * psi) if abs(psi) > 1e-6 else 1.0
    u = half * step[0] + 0.5 * psi * step[1]
    v = half * step[1] - 0.5 * psi * step[0]
    psi *= share
    f = math.sin(psi) / psi if abs(psi) > 1e-6 else 1.0
    g = (1.0 - math.cos(psi)) / psi if abs(psi) > 1e-6 else 0.5 * psi
    return share * (f * u - g * v), share * (g * u + f * v), psi


def planar(p: object, q: object) -> Pose:
    return p.x, p.y, 2.0 * math.atan2(q.z, q.w)


class Player:
    """Publishers, what was heard, and the simulated time."""

    def __init__(self, job: dict) -> None:
        self.job = job
        self.now = -LEAD
        self.poses: list[list[float]] = []  # of the SLAM: t, x, y, psi
        self.odom: list[list[float]] = []
        self.map_pose: list[list[float]] = []
        self.map_to_odom: Pose | None = None
        self.corrected = -math.inf  # [s] stamp of the SLAM's newest map to odom
        self.starts: list[list[float]] = []
        self.map: OccupancyGrid | None = None
        self.ended = False  # the SLAM gives no more poses
        near = {"queue_size": 100, "tcp_nodelay": True}
        self.clock = rospy.Publisher("/clock", Clock, **near)
        self.joy = rospy.Publisher("/joy", Joy, **near)
        self.scan = rospy.Publisher("/scan", LaserScan, **near)
        self.tf = rospy.Publisher("/tf", TFMessage, **near)
        static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        static.publish([transform(stamp_of(self.now), "base_link", "laser", (0.0, 0.0, 0.0))])
        self.static = static
        self.reset = rospy.Publisher("/initialpose", PoseWithCovarianceStamped, **near)
        for topic, kind, hear in (
            ("/slam_out_pose", PoseStamped, self.hear_pose),
            ("/odom", Odometry, self.hear_odom),
            ("/map_pose", PoseWithCovarianceStamped, self.hear_map_pose),
            ("/tf", TFMessage, self.hear_tf),
            ("/map", OccupancyGrid, self.hear_map),
        ):
            rospy.Subscriber(topic, kind, hear, queue_size=100, tcp_nodelay=True)

    def hear_pose(self, m: PoseStamped) -> None:
        self.poses.append([seconds(m.header.stamp), *planar(m.pose.position, m.pose.orientation)])

    def hear_odom(self, m: Odometry) -> None:
        p = m.pose.pose
        self.odom.append([seconds(m.header.stamp), *planar(p.position, p.orientation)])

    def hear_map_pose(self, m: PoseWithCovarianceStamped) -> None:
        p = m.pose.pose
        self.map_pose.append([seconds(m.header.stamp), *planar(p.position, p.orientation)])

    def hear_tf(self, m: TFMessage) -> None:
        """What the SLAM says of the odometry frame; the player's own is of other times."""
        if m._connection_header["callerid"] != "/hector_mapping":
            return
        for t in m.transforms:
            if t.child_frame_id == "odom":
                self.map_to_odom = planar(t.transform.translation, t.transform.rotation)
                self.corrected = seconds(t.header.stamp)

    def hear_map(self, m: OccupancyGrid) -> None:
        self.map = m

    def tick(self, t: float) -> None:
        """Simulated time, and all that hangs on it."""
        self.now = t
        if self.job["relay"] and self.map_to_odom is not None:
            self.tf.publish([transform(stamp_of(t), "map", "odom", self.map_to_odom)])
        self.clock.publish(Clock(stamp_of(t)))
        if self.odom and self.job["lock_step"]:
            self.until(lambda: self.odom[-1][0] >= t - 1e-6)
        elif not self.job["lock_step"] or t < 0.0:
            time.sleep(TICK / self.job["pace"])

    def until(self, true: Callable[[], bool]) -> bool:
        """Wait for an answer."""
        end = time.monotonic() + PATIENCE
        while not true():
            if time.monotonic() > end or rospy.is_shutdown():
                return False
            time.sleep(0.0002)
        return True

    def send_scan(self, stamp: float, ranges: list[float]) -> None:
        made, form = LaserScan(), self.job["lidar"]
        made.header.stamp, made.header.frame_id = stamp_of(stamp), "laser"
        for name, value in form.items():
            setattr(made, name, value)
        made.ranges = [math.inf if r is None else r for r in ranges]
        self.scan.publish(made)

    def guess(self, stamp: float, k: int) -> None:
        """A start estimate of the player's own: where the last two matches or the truth lead."""
        kind = self.job["guess"]
        if kind is None or not self.poses:
            return
        last = tuple(self.poses[-1][1:])
        if kind == "true motion":
            start = compose(last, between(self.job["truth"][k - 1], self.job["truth"][k]))
        elif len(self.poses) < 3:  # the first is of the rest before the drive
            start = last
        else:
            before = self.poses[-2]
            share = min(stamp - self.poses[-1][0], HOLD) / (self.poses[-1][0] - before[0])
            start = compose(last, along(between(tuple(before[1:]), last), share))
        self.starts.append([stamp, *start])
        self.tf.publish([transform(stamp_of(stamp), "map", "base_link", start)])

    def force(self, offset: Pose) -> None:
        """The next match begins off the last one."""
        message = PoseWithCovarianceStamped()
        message.header.stamp, message.header.frame_id = stamp_of(self.now), "map"
        message.pose.pose = placed(*compose(tuple(self.poses[-1][1:]), offset))
        self.reset.publish(message)
        time.sleep(0.1)  # it comes by another connection than the scan

    def match(self, k: int, stamp: float, ranges: list[float]) -> None:
        """A scan, and in lock-step its pose; with the SLAM's map to odom, that too."""
        self.guess(stamp, k)
        if self.job["forced"] and k == self.job["forced"]["scan"]:
            self.force(tuple(self.job["forced"]["offset"]))
        self.send_scan(stamp, ranges)
        if not self.job["lock_step"]:
            return
        here = lambda: bool(self.poses) and self.poses[-1][0] > stamp - 1e-6  # noqa: E731
        waits = 0
        while not self.until(here):
            self.tick(self.now + TICK)
            waits += 1
            if waits > ANSWERS or rospy.is_shutdown():
                self.ended = True
                return
        if self.job["relay"]:
            self.until(lambda: self.corrected > stamp - 1e-6)
            self.tf.publish([transform(stamp_of(self.now), "map", "odom", self.map_to_odom)])

    def lead(self) -> None:
        """At rest: the first scan, until its pose has come and odometry has begun."""
        self.tick(self.now)
        first = self.job["scans"][0]
        self.send_scan(self.now, first[2])
        while self.now < -1e-6:
            self.tick(self.now + TICK)
        if not self.poses:
            raise SystemExit("no pose of the scan at rest")

    def drive(self) -> None:
        """All commands and scans by their arrival."""
        commands = iter(self.job["commands"])
        command = next(commands, None)
        ticks = 0
        for k, (arrival, stamp, ranges) in enumerate(self.job["scans"]):
            while ticks * TICK <= arrival:
                t = ticks * TICK
                while command is not None and command[0] <= t:
                    message = Joy(axes=command[2])
                    message.header.stamp = stamp_of(command[1])
                    self.joy.publish(message)
                    command = next(commands, None)
                if t > self.now + 1e-9:
                    self.tick(t)
                ticks += 1
            if arrival > self.now:
                self.now = arrival
                self.clock.publish(Clock(stamp_of(arrival)))
            if k > 0:
                self.match(k, stamp, ranges)
            if self.ended:
                return

    def last_map(self) -> OccupancyGrid:
        """The map after the drive, or the last one of a SLAM that gives no more poses."""
        if self.ended and self.map:
            return self.map
        if not self.job["lock_step"]:
            for _ in range(50):
                self.tick(self.now + TICK)
        known = seconds(self.map.header.stamp) if self.map else -math.inf
        self.clock.publish(Clock(stamp_of(self.now + 2.0 * MAP_PERIOD)))
        end = time.monotonic() + 20.0
        while not (self.map and seconds(self.map.header.stamp) > max(known, self.now)):
            if time.monotonic() > end:
                raise SystemExit("no map")
            time.sleep(0.01)
        return self.map


def main(path: Path) -> None:
    """Play the job when a line is given, and answer beside it."""
    job = json.loads(path.read_text())
    rospy.init_node("player", disable_rosout=True)
    player = Player(job)
    sys.stdin.readline()
    player.lead()
    player.drive()
    grid = player.last_map()
    found = {
        "poses": player.poses, "odom": player.odom, "map_pose": player.map_pose,
        "starts": player.starts,
        "map": {
            "resolution": grid.info.resolution, "width": grid.info.width,
            "origin": [grid.info.origin.position.x, grid.info.origin.position.y],
            "occupied": [i for i, value in enumerate(grid.data) if value == OCCUPIED],
        },
    }  # fmt: skip
    path.with_suffix(".found.json").write_text(json.dumps(found))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
