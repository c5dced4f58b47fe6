# SPDX-License-Identifier: MIT
"""The ROS packages without ROS running: what a package must have, its parameters, its launch files."""

import re
import runpy
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree

import pytest
import ros1_node_tools
import ros2_tools
import yaml
from conftest import ROOT
from cpp_tools import built, run
from programs import piped

sys.path.insert(0, str(ROOT / "tools"))
from ros_parameters import files

pytestmark = pytest.mark.system
NODES = ("odometry", "simulator", "mimic", "tracking")
PACKAGES = {"seatrial_core": ROOT / "core", "seatrial_odometry": ROOT / "ros"}
ONLY = {1: "$ROS_VERSION != 2", 2: "$ROS_VERSION == 2"}  # conditions in package.xml
SHELLS = {ros: ROOT / "ros" / f"ros{ros}" / "src" for ros in (1, 2)}


@pytest.mark.parametrize("name", PACKAGES)
def test_a_package_has_what_a_release_asks_for(name):
    folder = PACKAGES[name]
    root = ElementTree.parse(folder / "package.xml").getroot()
    assert root.get("format") == "3"
    assert root.findtext("name") == name
    version = re.search(r'version = "([\d.]+)"', (ROOT / "pyproject.toml").read_text())[1]
    assert root.findtext("version") == version
    assert f"project({name} VERSION {version} " in (folder / "CMakeLists.txt").read_text()
    assert root.find("maintainer").get("email")
    assert root.findtext("url")
    assert root.find("license").get("file") == "LICENSE"
    assert (folder / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert name in (folder / "README.md").read_text()
    assert f"Changelog for package {name}\n" in (folder / "CHANGELOG.rst").read_text()


@pytest.mark.parametrize("name", PACKAGES)
def test_a_package_needs_nothing_outside_its_folder(name):
    """bloom exports the folder alone."""
    for path in PACKAGES[name].rglob("*"):
        if path.suffix not in (".txt", ".cmake", ".hpp", ".cpp") or "tests" in path.parts:
            continue
        for inner in re.findall(r'["( ](\.\./[^" )]*)', path.read_text()):
            found = (path.parent / inner).resolve()
            assert PACKAGES[name] in found.parents or "bindings" in path.parts, (path, inner)


@pytest.mark.parametrize("ros", [1, 2])
def test_the_package_names_what_it_uses(ros):
    text = "".join(path.read_text() for path in SHELLS[ros].iterdir())
    common = "".join(path.read_text() for path in (ROOT / "ros/common").rglob("*.?pp"))
    used = set(re.findall(r"#include <([\w-]+)/", text)) - {"sys", "ros"}  # the system's, roscpp's
    used |= {"yaml-cpp"} if "#include <yaml-cpp/" in common else set()
    used |= {"seatrial_core"} if '#include "seatrial/' in common else set()
    used |= {"roscpp"} if ros == 1 else set()
    root = ElementTree.parse(ROOT / "ros" / "package.xml").getroot()
    named = {n.text for n in root.iter("depend") if n.get("condition") in (None, ONLY[ros])}
    assert named == used
    build = (ROOT / f"ros/ros{ros}/package.cmake").read_text()
    assert all(name in build for name in used - {"yaml-cpp", "seatrial_core"})
    own = (ROOT / "ros/CMakeLists.txt").read_text()
    assert f"set(nodes {' '.join(NODES)})" in own
    assert all(f"find_package({name} REQUIRED)" in own for name in ("yaml-cpp", "seatrial_core"))


def test_the_root_hides_no_package():
    """A CMakeLists.txt there ends colcon's search, a marker that of either tool."""
    for folder in (ROOT, ROOT / "core", ROOT / "ros"):
        assert not list(folder.glob("*_IGNORE"))
    assert not (ROOT / "CMakeLists.txt").exists()
    tracked = run("git", "ls-files", "*CMakeLists.txt").split()
    assert {path.split("/")[0] for path in tracked} == {"core", "ros"}


@dataclass(frozen=True)
class Parameter:
    kind: str
    default: str
    low: float
    high: float


@pytest.fixture(scope="module")
def printed() -> str:
    """What each node declares, as it runs."""
    return run(str(built("parameters")))


@pytest.fixture(scope="module")
def parameters(printed) -> dict[str, dict[str, Parameter]]:
    found: dict[str, dict[str, Parameter]] = {node: {} for node in NODES}
    for line in printed.splitlines():
        node, name, kind, default, low, high, _ = line.split("|")
        found[node][name] = Parameter(kind, default, float(low), float(high))
    return found


def test_parameters_begin_within_their_ranges(parameters):
    numbers = [p for own in parameters.values() for p in own.values() if p.kind == "float"]
    assert len(numbers) > 20
    assert all(p.low <= float(p.default) <= p.high for p in numbers)


def test_the_parameter_files_are_the_nodes(printed, parameters):
    """tools/ros_parameters.py writes them."""
    for path, text in files(printed).items():
        assert path.read_text() == text, path
        content = yaml.safe_load(text)
        own = content["/**"]["ros__parameters"] if "ros__parameters" in text else content
        known = parameters[path.stem]
        assert set(own) == {name for name, p in known.items() if p.kind != "list"}
        assert all(type(own[name]).__name__ == known[name].kind for name in own)


def told(words: str) -> str | None:
    """The default in a description: its last words in brackets, or in front of them "empty:"."""
    found = re.search(r"\(([^() ]+)\)$", words)
    return found[1] if found else None


def expect_told(known: dict[str, Parameter], words: dict[str, str]) -> None:
    """A description names the node's default where that is not empty."""
    for name, text in words.items():
        default = known[name].default
        if known[name].kind == "float":
            assert float(told(text)) == float(default), name
        else:
            assert (told(text) or "") == default, name


@pytest.mark.parametrize("node", NODES)
def test_the_launch_file_of_ros1_is_the_nodes(parameters, node):
    root = ElementTree.parse(ROOT / f"ros/ros1/launch/{node}.launch").getroot()
    words = {arg.get("name"): arg.get("doc") for arg in root.iter("arg")}
    own = root.find("node")
    assert (own.get("type"), own.get("name")) == (node, f"seatrial_{node}")
    for p in own.iter("param"):
        name = p.get("name")
        assert p.get("value") == f"$(arg {name})"
        assert p.get("if") == f"$(eval str({name}) != '')"
    names = {param.get("name") for param in own.iter("param")}
    remapped = {remap.get("from") for remap in own.iter("remap")}
    assert names | remapped | {"params"} == set(words)
    expect_told(parameters[node], {name: words[name] for name in names})


@pytest.mark.parametrize("node", NODES)
def test_the_launch_file_of_ros2_is_the_nodes(parameters, launched, node):
    arguments, start = launched(node)
    words = {a.name: a.description for a in arguments}
    assert {a.default_value for a in arguments if a.name in ("params", "namespace")} == {""}
    shell = (SHELLS[2] / f"{node}.cpp").read_text()
    remapped = {a.name for a in arguments if a.default_value}
    assert all(f'"{name}"' in shell for name in remapped)
    plain = start(dict.fromkeys(words, ""))
    assert (plain.package, plain.executable) == ("seatrial_odometry", node)
    assert f'rclcpp::Node("{plain.name}", options)' in shell
    assert plain.namespace.name == "namespace"
    assert plain.parameters == [{}]  # all as the node has it
    assert {name for name, _ in plain.remappings or ()} == remapped
    full = start(dict.fromkeys(words, "1"))
    path, values = full.parameters
    assert path.name == "params"
    assert all(value.value.name == name for name, value in values.items())
    kinds = {name: value.value_type for name, value in values.items()}
    assert set(kinds) | remapped | {"params", "namespace"} == set(words)
    assert kinds.pop("use_sim_time", bool) is bool
    own = parameters[node]
    assert {n: k.__name__ for n, k in kinds.items()} == {n: own[n].kind for n in kinds}
    expect_told(own, {name: words[name] for name in kinds})


def test_odometry_that_ends_is_started_again_after_a_while(launched):
    _, start = launched("odometry")
    own = start({})
    assert own.respawn is True
    assert own.respawn_delay >= 1.0  # [s]
    root = ElementTree.parse(ROOT / "ros/ros1/launch/odometry.launch").getroot().find("node")
    assert root.get("respawn") == "true"
    assert float(root.get("respawn_delay")) == own.respawn_delay


@pytest.mark.parametrize("node", ["odometry", "tracking", "simulator"])
def test_frames_and_window_are_arguments(node):
    wanted = {
        "odometry": ("odom_frame", "base_frame", "map_frame", "window"), "tracking": (),
        "simulator": ("map_frame", "base_frame", "laser_frame"),
    }[node]  # fmt: skip
    for path in (f"ros1/launch/{node}.launch", f"ros2/launch/{node}.launch.py"):
        text = (ROOT / "ros" / path).read_text()
        assert all(f'"{name}"' in text for name in wanted)
    shared = (ROOT / "ros/ros2/seatrial_odometry/node_launch.py").read_text()
    assert (
        '"params"' in shared and '"params"' in (ROOT / f"ros/ros1/launch/{node}.launch").read_text()
    )


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

    def perform(self, context: dict[str, str]) -> str:
        """Of a LaunchConfiguration."""
        return context.get(self.name, "")


def recorded(name: str, order: str, known: str = "") -> type[Recorded]:
    return type(name, (Recorded,), {"order": (*order.split(),), "known": frozenset(known.split())})


@pytest.fixture
def launched(monkeypatch):
    """Runs a launch file with the names that it takes from launch and launch_ros, which are not here."""
    names = {
        "launch": [recorded("LaunchDescription", "entities"), SimpleNamespace],
        "launch.actions": [
            recorded("DeclareLaunchArgument", "name", "default_value description"),
            recorded("OpaqueFunction", "", "function"),
        ],
        "launch.substitutions": [recorded("LaunchConfiguration", "name")],
        "launch_ros": [],
        "launch_ros.actions": [
            recorded("Node", "", "package executable name namespace output respawn respawn_delay "
                                 "remappings parameters")
        ],
        "launch_ros.parameter_descriptions": [
            recorded("ParameterValue", "value", "value_type description")
        ],
    }  # fmt: skip
    for module, classes in names.items():
        stand_in = ModuleType(module)
        for kind in classes:
            name = "LaunchContext" if kind is SimpleNamespace else kind.__name__
            setattr(stand_in, name, kind)
        monkeypatch.setitem(sys.modules, module, stand_in)
    monkeypatch.syspath_prepend(str(ROOT / "ros" / "ros2"))
    for own in ("seatrial_odometry", "seatrial_odometry.node_launch"):
        monkeypatch.delitem(sys.modules, own, raising=False)

    def run_file(node: str):
        path = ROOT / f"ros/ros2/launch/{node}.launch.py"
        made = runpy.run_path(str(path))["generate_launch_description"]()
        *arguments, opaque = made.entities
        return arguments, lambda context: opaque.function(context)[0]

    return run_file


def test_the_documented_lines_are_those_that_the_tests_build_by():
    page = (ROOT / "docs" / "ros.md").read_text()
    for tools in (ros1_node_tools, ros2_tools):
        assert f"\n{tools.COMMAND}  " in page


def test_catkin_finds_both_packages_from_the_root(tmp_path):
    """As catkin_make looks for them: by catkin_pkg, of ROS's own Python."""
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "seatrial").symlink_to(ROOT)
    python = Path("/usr/bin/python3")
    program = (
        "from catkin_pkg.packages import find_packages as f; import os\n"
        "for p in f('src', exclude_paths=['src/seatrial/build']).values():\n"
        "    p.evaluate_conditions(os.environ); print(p.name, p.get_build_type())\n"
    )
    if subprocess.run([python, "-c", "import catkin_pkg"], check=False).returncode:
        pytest.skip("catkin_pkg is not installed")
    for version, kinds in (("", "catkin"), ("1", "catkin"), ("2", "ament_cmake cmake")):
        done = piped(
            [python, "-c", program], cwd=tmp_path, env={"ROS_VERSION": version}, check=True
        )
        assert done.stderr == ""  # it would warn of what a package.xml must not have
        found = dict(line.split() for line in done.stdout.splitlines())
        assert set(found) == set(PACKAGES)
        assert " ".join(sorted(set(found.values()))) == kinds
