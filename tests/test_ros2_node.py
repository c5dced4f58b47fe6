# SPDX-License-Identifier: MIT
"""The nodes for ROS 2 before a compiler: messages as Humble defines them, rclcpp as it is documented.

ROS 2 is not here. This finds misspelt members and calls that no overload takes; not what runs wrong.
"""

import re
import runpy
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import pytest
from conftest import ROOT
from cpp_tools import built, needs, run
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

pytestmark = pytest.mark.system
DEFINITIONS = get_typestore(Stores.ROS2_HUMBLE).fielddefs
SHELLS = ROOT / "ros" / "ros2" / "src"
NODES = ("odometry", "simulator", "mimic", "tracking")
API = ROOT / "tests" / "ros2_api"
PLAIN = {"bool": "bool", "string": "std::string", "byte": "unsigned char", "char": "unsigned char"}
TRIGGER = """#pragma once
#include <memory>
#include <string>
namespace std_srvs::srv {
struct Trigger {
  struct Request {};
  struct Response { bool success = false; std::string message; };
};
}
"""


def snake(name: str) -> str:
    """As rosidl names headers."""
    name = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", name)
    return re.sub(r"([A-Z])([A-Z][a-z])", r"\1_\2", name).lower()


def header_of(kind: str) -> str:
    package, _, name = kind.split("/")
    return f"{package}/msg/{snake(name)}.hpp"


def cpp(node: tuple) -> tuple[str, set[str]]:
    """The type of a member, and the messages that it needs."""
    tag, content = node
    if tag == Nodetype.NAME:
        return content.replace("/", "::"), {content}
    if tag == Nodetype.BASE:
        name = content[0]
        if name in PLAIN:
            return PLAIN[name], set()
        if name.startswith("float"):
            return {"float32": "float", "float64": "double"}[name], set()
        return f"std::{name}_t", set()
    inner, needs = cpp(content[0])
    if tag == Nodetype.ARRAY:
        return f"std::array<{inner}, {content[1]}>", needs
    return f"std::vector<{inner}>", needs


def write_message(kind: str, folder: Path) -> None:
    """A header as rosidl would name it, and those that it needs."""
    path = folder / header_of(kind)
    if path.exists():
        return
    _, fields = DEFINITIONS[kind]
    members, needs = [], set()
    for name, node in fields:
        text, more = cpp(node)
        members.append(f"  {text} {name}{{}};")
        needs |= more
    package, _, name = kind.split("/")
    includes = [f"#include <{part}>" for part in ("array", "cstdint", "string", "vector")]
    includes += [f"#include <{header_of(need)}>" for need in sorted(needs)]
    path.parent.mkdir(parents=True, exist_ok=True)
    body = "\n".join(members)
    path.write_text(
        "#pragma once\n" + "\n".join(includes)
        + f"\nnamespace {package}::msg {{\nstruct {name} {{\n{body}\n}};\n}}\n"
    )  # fmt: skip
    for need in needs:
        write_message(need, folder)


@pytest.fixture(scope="module")
def headers(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("ros2")
    by_header = {header_of(kind): kind for kind in DEFINITIONS if kind.count("/") == 2}
    text = "".join(path.read_text() for path in SHELLS.iterdir())
    asked = set(re.findall(r"#include <(\w+/msg/\w+\.hpp)>", text))
    assert len(asked) > 20
    for header in asked:
        write_message(by_header[header], folder)
    (folder / "std_srvs/srv").mkdir(parents=True)
    (folder / "std_srvs/srv/trigger.hpp").write_text(TRIGGER)
    return folder


def compiled(headers: Path, source: Path) -> str:
    """What the compiler complains of."""
    needs("c++", yaml=True)
    folders = (ROOT / "core/include", ROOT / "ros/common/include")
    done = subprocess.run(
        ["c++", "-std=c++17", "-fsyntax-only", "-Wall", "-Wextra", "-Werror",
         *(f"-I{folder}" for folder in folders), "-isystem", str(API), "-isystem", str(headers),
         str(source)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.stderr if done.returncode else ""


@pytest.mark.parametrize("node", NODES)
def test_the_shell_compiles_against_the_declared_interfaces(headers, node):
    assert compiled(headers, SHELLS / f"{node}.cpp") == ""


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("odometry.cpp", "std::shared_ptr<Trigger::Response> response", "int response"),
        ("simulator.cpp", "out.imu->publish(message)", "out.scan->publish(message)"),
        ("mimic.cpp", "timer_->cancel()", "timer_->stop()"),
        ("numbers.hpp", "wrench_numbers(m.wrench)", "wrench_numbers(m)"),
        ("commands.hpp", "out.twist.linear, ", "out.linear, "),
    ],
)
def test_what_is_misspelt_is_found(headers, tmp_path, file, right, wrong):
    shutil.copytree(SHELLS, tmp_path / "src")
    text = (SHELLS / file).read_text()
    assert right in text
    (tmp_path / "src" / file).write_text(text.replace(right, wrong))
    user = {"numbers.hpp": "mimic.cpp", "commands.hpp": "tracking.cpp"}.get(file, file)
    assert f"{file}:" in compiled(headers, tmp_path / "src" / user)


@pytest.mark.parametrize("version", ["ros1", "ros2"])
def test_the_package_names_what_it_uses(version):
    folder = ROOT / "ros" / version
    text = "".join(path.read_text() for path in (folder / "src").iterdir())
    used = {*re.findall(r"#include <(\w+)/", text), "yaml-cpp"} - {"sys"}  # the system's own
    used = {"roscpp" if name == "ros" else name for name in used}
    package = ElementTree.parse(folder / "package.xml").getroot()
    assert {node.text for node in package.iter("depend")} == used
    build = (folder / "CMakeLists.txt").read_text()
    assert all(name in build for name in used)
    assert f"set(nodes {' '.join(NODES)})" in build
    assert {path.stem for path in (folder / "src").glob("*.cpp")} == set(NODES)


@dataclass(frozen=True)
class Parameter:
    kind: str
    default: str
    low: float
    high: float


@pytest.fixture(scope="module")
def parameters() -> dict[str, dict[str, Parameter]]:
    """What each node declares, as it runs."""
    text = run(str(built("parameters")))
    found: dict[str, dict[str, Parameter]] = {node: {} for node in NODES}
    for line in text.splitlines():
        node, name, kind, default, low, high = line.split("|")
        found[node][name] = Parameter(kind, default, float(low), float(high))
    return found


def test_parameters_begin_within_their_ranges(parameters):
    numbers = [p for own in parameters.values() for p in own.values() if p.kind == "float"]
    assert len(numbers) > 20
    assert all(p.low <= float(p.default) <= p.high for p in numbers)


@pytest.mark.parametrize("node", NODES)
def test_the_launch_file_of_ros1_is_the_nodes(parameters, node):
    root = ElementTree.parse(ROOT / f"ros/ros1/launch/{node}.launch").getroot()
    defaults = {arg.get("name"): arg.get("default") for arg in root.iter("arg")}
    own = root.find("node")
    assert (own.get("type"), own.get("name")) == (node, f"seatrial_{node}")
    names = {param.get("name") for param in own.iter("param")}
    assert all(p.get("value") == f"$(arg {p.get('name')})" for p in own.iter("param"))
    remapped = {remap.get("from") for remap in own.iter("remap")}
    assert names | remapped == set(defaults)
    expect_same(parameters[node], {name: defaults[name] for name in names})


@pytest.mark.parametrize("node", NODES)
def test_the_launch_file_of_ros2_is_the_nodes(parameters, launched, node):
    description = launched(node)
    *arguments, own = description.entities
    assert (own.package, own.executable) == ("seatrial_odometry", node)
    assert own.name == f"seatrial_{node}"
    shell = (SHELLS / f"{node}.cpp").read_text()
    assert f'rclcpp::Node("{own.name}")' in shell
    (values,) = own.parameters
    assert all(value.value.name == name for name, value in values.items())
    kinds = {name: value.value_type for name, value in values.items()}
    assert kinds.pop("use_sim_time", bool) is bool
    assert {name: kind.__name__ for name, kind in kinds.items()} == {
        name: parameters[node][name].kind for name in kinds
    }
    remapped = dict(own.remappings or ())
    assert all(f'"{name}"' in shell and name == to.name for name, to in remapped.items())
    defaults = {a.name: a.default_value for a in arguments}
    assert set(defaults) == {*values, *remapped}
    expect_same(parameters[node], {name: defaults[name] for name in kinds})


def expect_same(own: dict[str, Parameter], defaults: dict[str, str | None]) -> None:
    """Defaults of a launch file are the node's, but where the launch file asks for a value."""
    for name, default in defaults.items():
        if default is None:
            assert own[name].default == ""
        elif own[name].kind == "float":
            assert float(default) == float(own[name].default)
        else:
            assert default == own[name].default


class Recorded:
    """Keeps what a launch file gives an action or a substitution, by the documented names."""

    order: tuple[str, ...] = ()
    known: frozenset[str] = frozenset()

    def __init__(self, *given: object, **named: object) -> None:
        assert set(named) <= self.known, type(self).__name__
        assert len(given) <= len(self.order), type(self).__name__
        for name in (*self.order, *self.known):
            setattr(self, name, None)
        for name, value in (*zip(self.order, given, strict=False), *named.items()):
            setattr(self, name, value)


def recorded(name: str, order: str, known: str = "") -> type[Recorded]:
    return type(name, (Recorded,), {"order": (*order.split(),), "known": frozenset(known.split())})


@pytest.fixture
def launched(monkeypatch):
    """Runs a launch file with the names that it takes from launch and launch_ros."""
    names = {
        "launch": [recorded("LaunchDescription", "entities")],
        "launch.actions": [recorded("DeclareLaunchArgument", "name", "default_value description")],
        "launch.substitutions": [recorded("LaunchConfiguration", "name")],
        "launch_ros": [],
        "launch_ros.actions": [
            recorded("Node", "", "package executable name output respawn remappings parameters")
        ],
        "launch_ros.parameter_descriptions": [
            recorded("ParameterValue", "value", "value_type description")
        ],
    }
    for module, classes in names.items():
        stand_in = ModuleType(module)
        for kind in classes:
            setattr(stand_in, kind.__name__, kind)
        monkeypatch.setitem(sys.modules, module, stand_in)

    def run(node: str):
        path = ROOT / f"ros/ros2/launch/{node}.launch.py"
        return runpy.run_path(str(path))["generate_launch_description"]()

    return run
