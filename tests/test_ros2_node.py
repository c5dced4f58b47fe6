# SPDX-License-Identifier: MIT
"""The node for ROS 2 before a compiler: messages as Humble defines them, rclcpp as it is documented.

ROS 2 is not here. This finds misspelt members and calls that no overload takes; not what runs wrong.
"""

import ast
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest
from conftest import ROOT
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

DEFINITIONS = get_typestore(Stores.ROS2_HUMBLE).fielddefs
SHELL = ROOT / "ros" / "ros2" / "src" / "odometry.cpp"
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
    asked = re.findall(r"#include <(\w+/msg/\w+\.hpp)>", SHELL.read_text())
    assert len(asked) > 10
    for header in [*asked, "builtin_interfaces/msg/time.hpp"]:
        write_message(by_header[header], folder)
    (folder / "std_srvs/srv").mkdir(parents=True)
    (folder / "std_srvs/srv/trigger.hpp").write_text(TRIGGER)
    return folder


def compiled(headers: Path, source: Path) -> str:
    """What the compiler complains of."""
    if shutil.which("c++") is None or not Path("/usr/include/yaml-cpp").exists():
        pytest.skip("no C++ compiler, or no libyaml-cpp-dev")
    folders = (ROOT / "core/include", ROOT / "ros/common/include")
    done = subprocess.run(
        ["c++", "-std=c++17", "-fsyntax-only", "-Wall", "-Wextra", "-Werror",
         *(f"-I{folder}" for folder in folders), "-isystem", str(API), "-isystem", str(headers),
         str(source)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.stderr if done.returncode else ""


def test_the_shell_compiles_against_the_declared_interfaces(headers):
    assert compiled(headers, SHELL) == ""


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("m.child_frame_id", "m.child_frame"),
        ("odometry_->publish(message)", "odometry_->publish(found)"),
        ("std::shared_ptr<Trigger::Response> response", "std::shared_ptr<int> response"),
    ],
)
def test_what_is_misspelt_is_found(headers, tmp_path, right, wrong):
    text = SHELL.read_text()
    assert right in text
    (tmp_path / "odometry.cpp").write_text(text.replace(right, wrong))
    assert "error" in compiled(headers, tmp_path / "odometry.cpp")


def test_both_packages_name_what_they_use():
    for version, source in (("ros1", "ros1/src/odometry.cpp"), ("ros2", "ros2/src/odometry.cpp")):
        used = set(re.findall(r"#include <(\w+)/", (ROOT / "ros" / source).read_text()))
        used = {"roscpp" if name == "ros" else name for name in used}
        package = ElementTree.parse(ROOT / "ros" / version / "package.xml").getroot()
        declared = {node.text for node in package.iter("depend")}
        assert used <= declared, version
        build = (ROOT / "ros" / version / "CMakeLists.txt").read_text()
        assert all(name in build for name in used)


def test_the_launch_files_can_be_read():
    ElementTree.parse(ROOT / "ros/ros1/launch/odometry.launch")
    ast.parse((ROOT / "ros/ros2/launch/odometry.launch.py").read_text())
