# SPDX-License-Identifier: MIT
"""A real ROS 2: the package built by colcon in a workspace, its nodes run on loopback, a peer that talks DDS to them.

SEATRIAL_ROS2 is a folder whose env.sh sets up ROS 2 with Cyclone DDS on loopback. The peer is Cyclone DDS from PyPI: an
implementation of its own build with ROS 2's names, types and quality of service.
"""

import fcntl
import gc
import os
import shlex
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from cpp_tools import clone_into, optimisation_option
from programs import piped
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore
from waiting import PATIENCE, go_ahead

ROOT = Path(__file__).resolve().parents[1]
PREFIX = Path(os.environ.get("SEATRIAL_ROS2", "/nowhere"))
WORKSPACE = ROOT / "build" / "ros2"
PROGRAMS = WORKSPACE / "install" / "seatrial_odometry" / "lib" / "seatrial_odometry"
DOMAINS = range(1, 41)  # below the ports of `waiting`
DEFINITIONS = get_typestore(Stores.ROS2_HUMBLE).fielddefs
LOOPBACK = """<CycloneDDS><Domain id="any">
  <General>
    <Interfaces><NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
    <Peers><Peer Address="localhost"/></Peers>
  </Discovery>
</Domain></CycloneDDS>"""  # as rmw_cyclonedds_cpp with ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
COMMAND = "colcon build --packages-up-to seatrial_odometry"  # as docs/ros.md has it

needed = [
    pytest.mark.system,
    pytest.mark.skipif(
        not (PREFIX / "env.sh").exists(),
        reason="no ROS 2: SEATRIAL_ROS2 names no folder with env.sh",
    ),
]


def shell(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """A line as a user of ROS 2 gives it, after `source setup.bash`."""
    line = f". {shlex.quote(str(PREFIX / 'env.sh'))} && export ROS_VERSION=2 && {command}"
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "LANG": "C.UTF-8"}
    for name in ("CCACHE_DIR", "CCACHE_DISABLE"):
        environment |= {name: os.environ[name]} if name in os.environ else {}
    return piped(["bash", "-c", line], cwd=folder, env=environment)


def build(*, quick: bool = True) -> Path:
    """The workspace's programs. One process at a time. quick: to test them, not to time them."""
    WORKSPACE.mkdir(parents=True, exist_ok=True)
    with (WORKSPACE.parent / "ros2.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        clone_into(WORKSPACE / "src" / "seatrial")
        options = ["-DSEATRIAL_TESTING=ON", "-DBUILD_TESTING=ON"]
        # the headers of rclcpp twice, not eight times
        options += ["-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=4"]
        options.append(optimisation_option(quick=quick))
        if not (PREFIX / "install" / "share" / "rclcpp_components").exists():
            options.append(f"-Drclcpp_components_DIR={ROOT / 'tests' / 'rclcpp_components'}")
        if shutil.which("ccache"):
            options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
        done = shell(f"MAKEFLAGS=-j2 {COMMAND} --cmake-args {shlex.join(options)}", WORKSPACE)
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-6000:]
    return PROGRAMS


def _own_domain() -> tuple[int, socket.socket]:
    """A domain that no other test has, and the port that is held as long as it is used."""
    for domain in DOMAINS:
        held = socket.socket()
        try:
            held.bind(("127.0.0.1", 18_000 + domain))
        except OSError:
            held.close()
            continue
        return domain, held
    raise RuntimeError("no ROS 2 domain is free")


class Ros2:
    """Nodes in a domain of their own. A context manager."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.domain, self._held = _own_domain()
        self.started: list[subprocess.Popen[str]] = []
        set_up = f". {PREFIX}/env.sh; . {WORKSPACE}/install/local_setup.bash; env -0"
        done = piped(["bash", "-c", set_up], check=True)
        pairs = (line.partition("=") for line in done.stdout.split("\0") if line)
        own = {name: value for name, _, value in pairs}
        self.environment = {**own, "ROS_DOMAIN_ID": str(self.domain), "HOME": str(folder),
                            "ROS_LOG_DIR": str(folder)}  # fmt: skip

    def __enter__(self) -> "Ros2":
        return self

    def __exit__(self, *_: object) -> None:
        self.end()
        self._held.close()

    def end(self) -> None:
        """What still runs: asked to end, so that others hear that it is gone, or killed."""
        left = [process for process in self.started if process.poll() is None]
        for process in left:
            process.send_signal(signal.SIGINT)
        for process in left:
            with suppress(subprocess.TimeoutExpired):
                process.wait(PATIENCE)
            process.kill()
            process.wait()

    def start(self, program: str, *arguments: object) -> subprocess.Popen[str]:
        """A program of the package; what it says goes to the file `said`."""
        path = self.folder / f"said-{len(self.started)}-{program}.txt"
        with path.open("w") as said:
            process = subprocess.Popen(
                [str(PROGRAMS / program), *map(str, arguments)], env=self.environment,
                cwd=self.folder, stdout=said, stderr=subprocess.STDOUT, text=True,
            )  # fmt: skip
        go_ahead(process.pid)
        process.said = path  # type: ignore[attr-defined]
        self.started.append(process)
        return process

    def node(self, program: str, **parameters: object) -> subprocess.Popen[str]:
        """A node with parameters; `name=...` renames it."""
        words: list[object] = ["--ros-args"]
        if "name" in parameters:
            words += ["-r", f"__node:={parameters.pop('name')}"]
        for name, value in parameters.items():
            words += ["-p", f"{name}:={value}"]
        return self.start(program, *words)

    def run(self, program: str, *arguments: object, patience: float = PATIENCE) -> str:
        """A program to its end; what it said."""
        process = self.start(program, *arguments)
        assert process.wait(patience) == 0, said(process)
        return said(process)


def said(process: subprocess.Popen[str]) -> str:
    return process.said.read_text()  # type: ignore[attr-defined]


def finish(process: subprocess.Popen[str], signal_number: int = signal.SIGINT) -> None:
    """Ask it to end, which it does without complaint."""
    process.send_signal(signal_number)
    assert process.wait(PATIENCE) == 0, said(process)


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
        own = {"string": str, "bool": bool, "byte": types.uint8, "octet": types.uint8}
        return own.get(detail[0]) or getattr(types, detail[0])
    element = _idl_member(*detail[0])
    return types.sequence[element] if node == Nodetype.SEQUENCE else types.array[element, detail[1]]


def _built(made: type, values: dict[str, Any]) -> Any:
    """An object of Cyclone's class by nested dicts; what is not given is 0 or empty."""
    kinds = made.__annotations__
    given = {name: values.get(name, _nothing(kind)) for name, kind in kinds.items()}
    return made(**{
        name: _built(kinds[name], value) if isinstance(value, dict) else value
        for name, value in given.items()
    })  # fmt: skip


def _nothing(kind: Any) -> Any:
    if kind is str:
        return ""
    if hasattr(kind, "__annotations__") and hasattr(kind, "__idl__"):
        return {}
    text = str(kind)
    if "sequence" in text:
        return []
    return [0.0] * 36 if "array" in text else 0


class Peer:
    """Cyclone's side, in this process."""

    def __init__(self, domain: int) -> None:
        from cyclonedds.domain import Domain, DomainParticipant

        with suppress(Exception):  # it was set up before
            self._domain = Domain(domain, LOOPBACK)
        self._participant = DomainParticipant(domain)
        self._classes: dict[str, type] = {}

    def _topic(self, topic: str, kind: str) -> Any:
        from cyclonedds.topic import Topic

        if kind not in self._classes:
            self._classes[kind] = idl(kind)
        return Topic(self._participant, f"rt/{topic.lstrip('/')}", self._classes[kind])

    def publisher(self, topic: str, kind: str) -> "Publisher":
        from cyclonedds.pub import DataWriter

        made = self._topic(topic, kind)
        return Publisher(
            DataWriter(self._participant, made, qos=_reliable(1000)), self._classes[kind]
        )

    def listen(self, topic: str, kind: str) -> "Heard":
        from cyclonedds.sub import DataReader

        made = self._topic(topic, kind)
        return Heard(DataReader(self._participant, made, qos=_reliable(5000)))


class Publisher:
    """Of one topic, until `end`."""

    def __init__(self, writer: Any, made: type) -> None:
        self._writer, self._made = writer, made

    def connected(self) -> bool:
        return bool(self._writer.get_matched_subscriptions())

    def publish(self, values: dict[str, Any]) -> None:
        self._writer.write(_built(self._made, values))

    def end(self) -> None:
        self._writer = None
        gc.collect()


class Heard:
    """All that was heard so far: `messages`, and `arrivals` [ns] as it was taken."""

    def __init__(self, reader: Any) -> None:
        self._reader = reader
        self.messages: list[Any] = []
        self.arrivals: list[int] = []

    def take(self) -> list[Any]:
        """What has come since."""
        new = [s for s in self._reader.take(N=5000) if s.sample_info.valid_data]
        self.messages += new
        self.arrivals += [time.time_ns()] * len(new)
        return new

    def latest(self) -> Any:
        self.take()
        return self.messages[-1] if self.messages else None


def _reliable(depth: int) -> Any:
    """ROS 2's default profile; XCDR1 and nothing else, as ROS 2's Cyclone has it."""
    from cyclonedds.core import Policy, Qos
    from cyclonedds.util import duration

    return Qos(
        Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile,
        Policy.History.KeepLast(depth), Policy.DataRepresentation(use_cdrv0_representation=True),
    )  # fmt: skip


def header(stamp: int, frame: str = "map") -> dict[str, Any]:
    """stamp: [ns]"""
    sec, nanosec = divmod(stamp, 10**9)
    return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": frame}


def stamp_of(message: Any) -> int:
    """[ns]"""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def status(heard: Heard, name: str) -> Any:
    """The last diagnosis of this name, if any."""
    heard.take()
    found: Sequence[Any] = [s for m in heard.messages for s in m.status if s.name == name]
    return found[-1] if found else None


@pytest.fixture(scope="module")
def ros(tmp_path_factory) -> Iterator[Ros2]:
    """The nodes, built."""
    build()
    with Ros2(tmp_path_factory.mktemp("ros2")) as made:
        yield made


@pytest.fixture(scope="module")
def peer(ros: Ros2) -> Peer:
    """In the nodes' domain."""
    return Peer(ros.domain)


@pytest.fixture(autouse=True)
def alone(ros: Ros2) -> Iterator[None]:
    """No node of a test runs on into the next."""
    yield
    ros.end()


FIXTURES = ros, peer, alone  # of modules that test the nodes, which name them
