# SPDX-License-Identifier: MIT
"""The ROS 1 node: its share of a core, and how soon odometry follows a command.

Beside it an empty node with the same topics, for what ROS itself costs on this machine.
"""

import signal
import sys
import tempfile
import time
from pathlib import Path

import seatrial
from benchmarks.harness.measure import spent

ROOT = Path(__file__).parents[2]
SECONDS = 30
CASES = (  # odometry, commands [Hz]; odometry at 0: after every command
    (0.0, 100.0),
    (100.0, 20.0),
    (100.0, 100.0),
)


def measured(program: Path, model: Path, odometry: float, commands: float) -> list[str]:
    """Share of a core [%], and median, 99 % and worst [ms] from command to odometry. Poses at 15 Hz."""
    sys.path.insert(0, str(ROOT / "tests"))
    from ros1_node_tools import LATENCY  # noqa: PLC0415
    from ros1_tools import Ros1  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as name, Ros1(Path(name)) as ros:
        node = ros.start(str(program), f"_model:={model}", f"_rate:={odometry:g}")
        ros.until(lambda: "/seatrial_odometry" in ros.subscribers("/joy"), "node")
        begin, before = time.monotonic(), spent(node.pid)
        probe = ros.start(str(LATENCY), f"_seconds:={SECONDS}", f"_commands:={commands:g}")
        probe.wait(2.0 * SECONDS)
        probe.stdin.close()
        share = 100.0 * (spent(node.pid) - before) / (time.monotonic() - begin)
        ros.finish(node, signal.SIGINT)
        times = probe.said.read_text().split()[2:]
    return [f"{share:.1f}", *(times if odometry == 0.0 else [""] * 3)]


def cost() -> str:
    """Markdown."""
    sys.path.insert(0, str(ROOT / "tests"))
    from ros1_node_tools import NODE, RELAY, build  # noqa: PLC0415

    from tests.boats.drives import model  # noqa: PLC0415

    build(quick=False)
    rows = [
        "| odometry | commands | program | share of a core, % | ms from command: median | 99 % | worst |",
        "| --- | --- | --- | ---: | ---: | ---: | ---: |",
    ]
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "model.yaml"
        seatrial.save(model("hard", 5), path)
        for odometry, commands in CASES:
            rate = "after every command" if odometry == 0.0 else f"{odometry:g} Hz"
            for words, program in (("node", NODE), ("empty node", RELAY)):
                cells = measured(program, path, odometry, commands)
                rows.append(f"| {rate} | {commands:g} Hz | {words} | {' | '.join(cells)} |")
    return "\n".join(rows)
