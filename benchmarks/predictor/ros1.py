# SPDX-License-Identifier: MIT
"""The ROS 1 node: its share of a core, and how soon odometry follows a command."""

import os
import signal
import sys
import tempfile
import time
from pathlib import Path

import seatrial

ROOT = Path(__file__).parents[2]
SECONDS = 60
CLOCK_TICKS = os.sysconf("SC_CLK_TCK")  # [1/s]
RATES = (
    0.0,
    100.0,
)  # [Hz] of the odometry; 0: after every command, of which there are 100 a second


def spent(pid: int) -> float:
    """Processor time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / CLOCK_TICKS


def measured(rate: float) -> str:
    """A row: commands at 100 Hz, poses at 15 Hz."""
    sys.path.insert(0, str(ROOT / "tests"))
    from ros1_node_tools import LATENCY, NODE  # noqa: PLC0415
    from ros1_tools import Ros1  # noqa: PLC0415

    from benchmarks.predictor.drives import model  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        seatrial.save(model("hard", 5), folder / "model.yaml")
        with Ros1(folder) as ros:
            node = ros.start(str(NODE), f"_model:={folder / 'model.yaml'}", f"_rate:={rate:g}")
            ros.until(lambda: "/seatrial_odometry" in ros.subscribers("/joy"), "node")
            begin, before = time.monotonic(), spent(node.pid)
            probe = ros.start(str(LATENCY), f"_seconds:={SECONDS}")
            probe.wait(2.0 * SECONDS)
            probe.stdin.close()
            share = (spent(node.pid) - before) / (time.monotonic() - begin)
            ros.finish(node, signal.SIGINT)
        commands, answers, middle, late, worst = probe.said.read_text().split()
    asked = "after every command" if rate == 0.0 else f"{rate:g} Hz"
    timing = f"{middle} | {late} | {worst}" if rate == 0.0 else "| |"
    return f"| {asked} | {commands} | {answers} | {100.0 * share:.1f} | {timing} |"


def cost() -> str:
    """Markdown."""
    sys.path.insert(0, str(ROOT / "tests"))
    from ros1_node_tools import build  # noqa: PLC0415

    build()
    head = (
        "| odometry | commands | messages of it | share of a core, % | ms from command: median | 99 % | "
        "worst |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: |"
    )
    return "\n".join([head, *map(measured, RATES)])
