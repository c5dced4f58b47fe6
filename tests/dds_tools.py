# SPDX-License-Identifier: MIT
"""Cyclone DDS opposite seatrial's Fast DDS program, both in a network namespace with nothing but lo.

Run inside of it by itself: `dds_tools.py PROGRAM`, with an Order on the standard input.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

PATIENCE = 20.0  # [s]
TYPES = {  # of ROS 2, by the word that the program's lines begin with
    "odometry": "nav_msgs/msg/Odometry", "pose": "geometry_msgs/msg/PoseStamped",
    "joy": "sensor_msgs/msg/Joy",
}  # fmt: skip
FLOATS = {"float64": float, "float32": lambda x: float(np.float32(x))}
DEFINITIONS = get_typestore(Stores.ROS2_HUMBLE).fielddefs
LOOPBACK = """<CycloneDDS><Domain><General><Interfaces>
  <NetworkInterface name="lo" multicast="true"/>
</Interfaces></General></Domain></CycloneDDS>"""


@dataclass(frozen=True)
class Order:
    """What the two exchange."""

    verb: str  # of the program: where it has its messages from
    profile: str  # its quality of service
    model: str  # path of its file
    messages: list[tuple[str, dict[str, Any]]]  # pose or joy, and the members
    subscriber: str = ""  # Cyclone's quality of service, the program's if there is none


@dataclass(frozen=True)
class Exchange:
    """Lines of messages, every number in full."""

    sent: list[str]  # by Cyclone
    got: list[str]  # by Fast DDS
    published: list[str]  # by Fast DDS
    received: list[str]  # by Cyclone
    error: str  # the program's


def exchange(program: Path, order: Order) -> Exchange:
    """Let the two talk in a namespace of their own."""
    own_root = [] if os.geteuid() == 0 else ["--map-root-user"]
    done = subprocess.run(
        ["unshare", "--net", *own_root, sys.executable, __file__, str(program)],
        input=json.dumps(asdict(order)), capture_output=True, text=True, check=False,
        timeout=4 * PATIENCE, env={**os.environ, "CYCLONEDDS_URI": LOOPBACK},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return Exchange(**json.loads(done.stdout))


def line(kind: str, message: object) -> str:
    """A message, a dict or an object, as the program prints it: by ROS 2's definitions."""
    return " ".join([kind, *_words("", Nodetype.NAME, TYPES[kind], message)])


def _words(path: str, node: Nodetype, detail: Any, value: Any) -> Iterator[str]:
    if node == Nodetype.NAME:
        for name, (inner, more) in DEFINITIONS[detail][1]:
            member = value[name] if isinstance(value, dict) else getattr(value, name)
            yield from _words(f"{path}.{name}".lstrip("."), inner, more, member)
    elif node == Nodetype.BASE:
        yield f"{path}={FLOATS[detail[0]](value).hex() if detail[0] in FLOATS else value}"
    else:
        if node == Nodetype.SEQUENCE:
            yield f"{path}.size={len(value)}"
        for i, element in enumerate(value):
            yield from _words(f"{path}[{i}]", *detail[0], element)


def canonical(printed: str) -> str:
    """A line of C++ with its numbers as Python writes them."""
    kind, *words = printed.split()
    pairs = [word.partition("=") for word in words]
    return " ".join([kind, *(name + equals + _hexadecimal(text) for name, equals, text in pairs)])


def _hexadecimal(text: str) -> str:
    is_float = text.lstrip("-").startswith(("0x", "nan", "inf"))
    return float.fromhex(text).hex() if is_float else text


def idl(name: str) -> type:
    """Cyclone's class of a ROS 2 type, named as ROS 2 names it on DDS."""
    from cyclonedds.idl import make_idl_struct

    package, short = name.split("/msg/")
    members = {member: _idl_member(*kind) for member, kind in DEFINITIONS[name][1]}
    return make_idl_struct(f"{short}_", f"{package}::msg::dds_::{short}_", members)


def _idl_member(node: Nodetype, detail: Any) -> Any:
    from cyclonedds.idl import types

    if node == Nodetype.NAME:
        return idl(detail)
    if node == Nodetype.BASE:
        return str if detail[0] == "string" else getattr(types, detail[0])
    element = _idl_member(*detail[0])
    return types.sequence[element] if node == Nodetype.SEQUENCE else types.array[element, detail[1]]


def _built(made: type, values: dict[str, Any]) -> Any:
    """An object of Cyclone's class by nested dicts."""
    kinds = made.__annotations__
    return made(**{n: _built(kinds[n], v) if isinstance(v, dict) else v for n, v in values.items()})


class Peer:
    """Cyclone's side: subscribes to rt/odom, publishes rt/pose and rt/joy."""

    def __init__(self, order: Order) -> None:
        from cyclonedds.domain import DomainParticipant
        from cyclonedds.pub import DataWriter
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        self._participant = DomainParticipant(0)
        self._classes = {kind: idl(name) for kind, name in TYPES.items()}
        self.reader = DataReader(
            self._participant,
            Topic(self._participant, "rt/odom", self._classes["odometry"]),
            qos=_quality(order.subscriber or order.profile),
        )
        self.writers = {
            kind: DataWriter(
                self._participant,
                Topic(self._participant, f"rt/{kind}", self._classes[kind]),
                qos=_quality(order.profile),
            )
            for kind in ("pose", "joy")
        }

    def connected(self, verb: str) -> bool:
        """Whether the program is found."""
        heard = verb == "script" or all(
            w.get_matched_subscriptions() for w in self.writers.values()
        )
        return heard and bool(self.reader.get_matched_publications())

    def publish(self, kind: str, values: dict[str, Any]) -> None:
        self.writers[kind].write(_built(self._classes[kind], values))

    def take(self) -> list[str]:
        """What has come by now; that the program is gone comes as a sample, too."""
        samples = self.reader.take(N=100)
        return [line("odometry", s) for s in samples if s.sample_info.valid_data]

    def take_some(self) -> list[str]:
        """The next that come."""
        found: list[str] = []
        _until(lambda: bool(found.extend(self.take()) or found), "no odometry came")
        return found


def _quality(profile: str) -> Any:
    """ROS 2's profile; XCDR1 and nothing else, as ROS 2's Cyclone has it."""
    from cyclonedds.core import Policy, Qos
    from cyclonedds.util import duration

    reliable = profile == "default"
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=1)) if reliable
        else Policy.Reliability.BestEffort,
        Policy.Durability.Volatile,
        Policy.History.KeepLast(10 if reliable else 5),
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )  # fmt: skip


def _until(true: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end, what
        time.sleep(0.001)


def _talk(program: str, order: Order) -> Exchange:
    """One message after the other, each answered before the next."""
    subprocess.run(["ip", "link", "set", "lo", "up", "multicast", "on"], check=True)
    peer = Peer(order)
    found = Exchange([], [], [], [], "")
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(
        [program, order.verb, order.profile, order.model], encoding="utf-8", **pipes
    ) as process:
        if process.stdout.readline() == "ready\n":
            _until(lambda: peer.connected(order.verb), "Cyclone has not found the program")
            for kind, values in order.messages:
                found.sent.append(line(kind, values))
                if order.verb == "serve":
                    peer.publish(kind, values)
                else:
                    process.stdin.write(found.sent[-1] + "\n")
                    process.stdin.flush()
                found.got.append(canonical(process.stdout.readline()))
                answer = process.stdout.readline()
                if not answer:  # it has ended
                    break
                found.published.append(canonical(answer))
                found.received.extend(peer.take_some())
        rest, error = process.communicate()
    found.published.extend(map(canonical, rest.splitlines()))
    found.received.extend(peer.take())
    return Exchange(found.sent, found.got, found.published, found.received, error)


if __name__ == "__main__":
    wanted = Order(**json.load(sys.stdin))
    json.dump(asdict(_talk(sys.argv[1], wanted)), sys.stdout)
