# SPDX-License-Identifier: MIT
"""ros/ros1/config and ros/ros2/config: every parameter of the nodes with its default and what it is.

python tools/ros_parameters.py       # after a change of a node's parameters
"""

import json
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WIDTH = 100
LAUNCHED = {
    1: "roslaunch seatrial_odometry {0}.launch",
    2: "ros2 launch seatrial_odometry {0}.launch.py",
}


def files(printed: str) -> dict[Path, str]:
    """Their text, by what `ros/common/tests/parameters.cpp` prints."""
    rows = [line.split("|") for line in printed.splitlines()]
    found = {}
    for ros in (1, 2):
        for node in dict.fromkeys(row[0] for row in rows):
            own = [row[1:] for row in rows if row[0] == node]
            path = ROOT / "ros" / f"ros{ros}" / "config" / f"{node}.yaml"
            found[path] = "\n".join(_lines(ros, node, own)) + "\n"
    return found


def _lines(ros: int, node: str, rows: list[list[str]]) -> Iterator[str]:
    yield f"# Parameters of the node {node}, with their defaults: copy this file, change it, and"
    yield f"#   {LAUNCHED[ros].format(node)} params:=/path/of/the/copy.yaml ..."
    if ros == 2:
        yield "/**:"
        yield "  ros__parameters:"
    indent = "    " if ros == 2 else ""
    for name, kind, default, low, high, words in rows:
        span = f" ({low} to {high})" if kind == "float" else ""
        for line in textwrap.wrap(words + span, WIDTH - len(indent) - 2):
            yield f"{indent}# {line}"
        # ROS 2 has no empty list, and a parameter without a value is not set
        comment = "# " if kind == "list" else ""
        yield f"{indent}{comment}{name}: {_value(kind, default)}"


def _value(kind: str, default: str) -> str:
    if kind == "str":
        return json.dumps(default)
    if kind == "float":
        return str(float(default))
    return {"list": "[0.0]"}.get(kind, default)


def main() -> None:
    """Write the files."""
    sys.path.insert(0, str(ROOT / "tests"))
    from cpp_tools import built, run  # noqa: PLC0415

    for path, text in files(run(str(built("parameters")))).items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)


if __name__ == "__main__":
    main()
