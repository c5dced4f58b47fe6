# SPDX-License-Identifier: MIT
"""A private ROS 1 from Debian: its master, recorders and players, all gone at the end.

Run by ROS's own Python it is also a node that drives (`drive`), and rosbag's own reader (`dump`).
"""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any
from xmlrpc.client import Fault, ServerProxy

from waiting import PATIENCE, go_ahead

BIN = Path("/usr/bin")
PYTHON = Path("/usr/lib/python3/dist-packages")
PARTS = (  # of .ci/run's packages
    BIN / "roscore", BIN / "roslaunch", BIN / "rosservice", Path("/usr/lib/rosout/rosout"), Path("/usr/lib/rosbag/record"),
    *(PYTHON / name for name in (
        "rospy", "rosbag", "nav_msgs", "sensor_msgs", "tf2_msgs", "diagnostic_msgs",
    )),
)  # fmt: skip
CALLER = "/seatrial_test"


class Ros1:
    """A master on a free port, and what is started below it. A context manager."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.logs = folder / "logs"  # in the environment of all that is started: how to find it
        self.logs.mkdir()
        # held to the end, such that the master may have it and nobody else
        self._held = socket.socket()
        self._held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._held.bind(("", 0))
        port = self._held.getsockname()[1]
        self.environment = {
            "PATH": "/usr/bin:/bin", "HOME": str(folder), "ROS_HOME": str(folder),
            "ROS_LOG_DIR": str(self.logs), "ROS_IP": "127.0.0.1",
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        }  # fmt: skip
        self._count = 0
        self._core = self.start("roscore", "-p", str(port))

    def __enter__(self) -> "Ros1":
        try:
            self.until(lambda: "/rosout" in self.subscribers("/rosout"), "roscore")
        except BaseException:
            self.end()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def start(self, program: str, *arguments: object) -> subprocess.Popen:
        """A program of ROS in the folder, in a group of its own; what it says goes to a file."""
        self._count += 1
        path = self.folder / f"said-{self._count}-{Path(program).name}.txt"
        with path.open("w") as said:
            process = subprocess.Popen(
                [str(BIN / program), *map(str, arguments)], env=self.environment, cwd=self.folder,
                stdin=subprocess.PIPE, stdout=said, stderr=subprocess.STDOUT, start_new_session=True,
            )  # fmt: skip
        go_ahead(process.pid)
        process.said = path  # type: ignore[attr-defined]
        return process

    def run(self, program: str, *arguments: object) -> str:
        """A program of ROS to its end; what it said."""
        process = self.start(program, *arguments)
        self.finish(process)
        return process.said.read_text()

    def finish(self, process: subprocess.Popen, signal_number: int | None = None) -> None:
        """Wait for the end, that a signal may ask for."""
        if signal_number is not None:
            os.killpg(process.pid, signal_number)
        process.stdin.close()
        code = process.wait(PATIENCE)
        assert code in ((0, -signal_number) if signal_number else (0,)), process.said.read_text()
        # `rosbag record` ends at once, the recorder that it has started when its bag is whole
        self.until(lambda: not _group(process.pid), str(process.args))

    def record(self, *arguments: object, topics: tuple[str, ...]) -> subprocess.Popen:
        """A recorder that has subscribed to its topics."""
        before = {topic: set(self.subscribers(topic)) for topic in topics}
        process = self.start("rosbag", "record", *arguments, *topics)
        self.until(
            lambda: all(set(self.subscribers(topic)) - before[topic] for topic in topics), "record"
        )
        return process

    def joypad(self, seconds: float, *axes: float) -> subprocess.Popen:
        """A joypad held still for so long of ROS's time; all that have subscribed hear its first message."""
        return self.start("python3", Path(__file__).parent / "ros1_joypad.py", seconds, *axes)

    def play(self, bag: Path, rate: float, counts: dict[str, int]) -> None:
        """Play a bag until every subscriber has as many messages of its topics as there are."""
        options = ("--pause", "--keep-alive", "--queue=100000", f"--rate={rate}")
        process = self.start("rosbag", "play", *options, bag)
        self.until(lambda: all(map(self.connected, counts)), "play")
        process.stdin.write(b" ")  # go on, as a person at the keyboard says it
        process.stdin.flush()
        self.until(lambda: all(self.received(*one) for one in counts.items()), "received")
        time.sleep(0.2)  # [s] from a subscriber's queue into its bag
        self.finish(process, signal.SIGINT)

    def shut_down(self, name: str) -> None:
        """Ask a node to end as the master and `rosnode kill` do."""
        self._node(name, "shutdown", "the test says so")

    def subscribers(self, topic: str) -> list[str]:
        """Nodes that have subscribed to a topic and live: the master keeps those that were killed."""
        return [name for name in dict(self._state()[1]).get(topic, []) if self._lives(name)]

    def connected(self, topic: str) -> bool:
        """Whether a topic's publishers have a connection to every subscriber."""
        publishers = dict(self._state()[0]).get(topic, [])
        wanted = len(self.subscribers(topic))
        links = [self._node(name, "getBusInfo") for name in publishers]
        counts = [sum(link[2] == "o" and link[4] == topic for link in part) for part in links]
        return bool(counts) and min(counts) >= wanted

    def hears(self, name: str, topics: tuple[str, ...]) -> bool:
        """Whether a node has a connection to a publisher of each topic."""
        links = self._node(name, "getBusInfo")
        return set(topics) <= {link[4] for link in links if link[2] == "i"}

    def received(self, topic: str, count: int) -> bool:
        """Whether every subscriber has got so many messages of a topic."""
        for name in self.subscribers(topic):
            stats = self._node(name, "getBusStats")[1]
            got = [link[2] for known, links in stats if known == topic for link in links]
            if sum(got) < count:
                return False
        return True

    def until(self, true: Callable[[], bool], what: str) -> None:
        """Wait until something is true."""
        end = time.monotonic() + PATIENCE
        while True:
            with suppress(OSError, Fault):  # not there yet, or no longer
                if true():
                    return
            said = [p.read_text()[-500:] for p in sorted(self.folder.glob("said-*"))]
            assert time.monotonic() < end, (what, said)
            time.sleep(0.02)

    def _state(self) -> list[list]:
        return ask(self.environment["ROS_MASTER_URI"], "getSystemState")

    def _lives(self, name: str) -> bool:
        """Whether a node answers at the address that the master knows."""
        with suppress(OSError, Fault):
            return bool(self._node(name, "getPid"))
        return False

    def _node(self, name: str, question: str, *arguments: object) -> Any:
        return ask(
            ask(self.environment["ROS_MASTER_URI"], "lookupNode", name), question, *arguments
        )

    def processes(self) -> list[int]:
        """All that was started here, whatever group it is in, by its environment."""
        mark = f"ROS_LOG_DIR={self.logs}".encode()
        found = []
        for path in Path("/proc").glob("[0-9]*/environ"):
            try:
                variables = path.read_bytes().split(b"\0")
            except OSError:
                continue
            if any(v == mark or v.startswith(mark + b"/") for v in variables):
                found.append(int(path.parent.name))
        return found

    def end(self) -> None:
        """The core asked to end, and then all that is left ended."""
        if self._core.poll() is None:
            self._core.send_signal(signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                self._core.wait(PATIENCE)
        self._core.stdin.close()
        for process in self.processes():
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        self._held.close()


def _group(number: int) -> list[int]:
    """What is left of a group of processes."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, _, group, *_ = path.read_text().rpartition(")")[2].split()
            if int(group) == number and state not in "ZX":
                found.append(int(path.parent.name))
    return found


def ask(uri: str, question: str, *arguments: object) -> Any:
    """A master's or a node's answer by XML-RPC (https://wiki.ros.org/ROS/Master_Slave_APIs)."""
    with ServerProxy(uri) as proxy:
        answer = getattr(proxy, question)(CALLER, *arguments)
    # roscpp answers getBusStats without code and text
    return answer[2] if isinstance(answer[0], int) else answer


def read_by_rosbag(ros: Ros1, bag: Path) -> dict[str, list]:
    """A bag's messages by rosbag's own reader: per topic [arrival, stamp, numbers]."""
    return json.loads(ros.run("python3", __file__, "dump", bag))


def _dump(path: str) -> None:
    """What read_by_rosbag returns, as JSON."""
    import rosbag

    found: dict[str, list] = {}
    with rosbag.Bag(path) as bag:
        for topic, message, arrival in bag.read_messages():
            if message._type == "sensor_msgs/Joy":
                numbers = list(message.axes)
            else:
                p, q = message.pose.position, message.pose.orientation
                numbers = [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
            stamp = message.header.stamp.to_nsec()
            found.setdefault(topic, []).append([arrival.to_nsec(), stamp, numbers])
    sys.stdout.write(json.dumps(found))


JOY_CHANGES = ((1.0, 0.5), (2.0, 0.0), (3.0, -0.5), (4.0, 0.0))  # [s], axes[1]
DRIVE = 6.0  # [s]
RATE = 20.0  # [Hz]


def _drive() -> None:
    """Publish a circle as Odometry and as tf below a static map; Joy on change; a Wrench.

    Starts when all have a subscriber.
    """
    import math

    import rospy
    from geometry_msgs.msg import Wrench
    from nav_msgs.msg import Odometry
    from ros1_course import placed, transform
    from sensor_msgs.msg import Joy
    from tf2_msgs.msg import TFMessage

    rospy.init_node("drive")
    odometry = rospy.Publisher("/odom", Odometry, queue_size=1000)
    joypad = rospy.Publisher("/joy", Joy, queue_size=1000)
    wrench = rospy.Publisher("/cmd_wrench", Wrench, queue_size=1000)
    tf = rospy.Publisher("/tf", TFMessage, queue_size=1000)
    static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)

    static.publish([transform(rospy.Time.now(), "map", "odom", (10.0, 20.0, math.pi / 2))])
    every = (odometry, joypad, wrench, tf, static)
    while not all(p.get_num_connections() for p in every) and not rospy.is_shutdown():
        time.sleep(0.02)
    begin = rospy.Time.now()
    changes = [(0.0, 0.0), *JOY_CHANGES]
    beat = rospy.Rate(RATE)
    for k in range(int(DRIVE * RATE) + 1):
        t = k / RATE
        stamp = begin + rospy.Duration.from_sec(t)
        pose = Odometry()
        pose.header.stamp, pose.header.frame_id, pose.child_frame_id = stamp, "odom", "base_link"
        pose.pose.pose = placed(*circle(t))
        odometry.publish(pose)
        tf.publish([transform(stamp, "odom", "base_link", circle(t))])
        force = Wrench()
        force.force.x, force.force.y, force.torque.z = t, -t, 0.5 * t
        wrench.publish(force)
        if changes and t >= changes[0][0]:
            sticks = Joy(axes=[0.0, changes.pop(0)[1], 0.0, 0.0])
            sticks.header.stamp = stamp
            joypad.publish(sticks)
        beat.sleep()
    rospy.sleep(0.5)  # for the last ones to leave


def circle(t: float) -> tuple[float, float, float]:
    """x, y [m] and psi [rad] of the drive at t [s]."""
    import math

    return math.cos(0.5 * t), math.sin(0.5 * t), 0.5 * t + math.pi / 2


if __name__ == "__main__":
    _dump(sys.argv[2]) if sys.argv[1] == "dump" else _drive()
