# SPDX-License-Identifier: MIT
"""The nodes with a real ROS 2 (SEATRIAL_ROS2: a folder with env.sh): velocity, time, cost, time to compile."""

import json
import resource
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.measure import spent

ROOT = Path(__file__).parents[2]
SECONDS = 30
# odometry, commands [Hz]; odometry at 0: after every command
CASES = ((0, 100), (100, 20), (100, 100))
AXES = ("surge, mm/s", "sway, mm/s", "yaw, mrad/s")


def _tests() -> tuple[Any, Any, Any]:
    """What the tests run a real ROS 2 with."""
    sys.path.insert(0, str(ROOT / "tests"))
    import ros2_drive  # noqa: PLC0415
    import ros2_tools  # noqa: PLC0415
    import ros_drive  # noqa: PLC0415

    ros2_tools.build(quick=False)
    return ros2_tools, ros2_drive, ros_drive


def velocity() -> str:
    """S7 through the node in real time: RMS errors of its velocity against the truth."""
    tools, played, drive = _tests()
    trial = drive.s7()
    with tempfile.TemporaryDirectory() as name, tools.Ros2(Path(name)) as ros:
        peer = tools.Peer(ros.domain)
        found = played.play(ros, peer, trial, drive.save_model(Path(name)))
    t, _, nu = found.odometry()
    late = (t > drive.SETTLED) & (t < drive.OVER)
    truth = drive.truth_at(trial, t[late])[:, 3:]
    rows = [
        "| velocity | RMS of the truth | RMS error | largest error |",
        "| --- | ---: | ---: | ---: |",
    ]
    for i, words in enumerate(AXES):
        off = nu[late, i] - truth[:, i]
        numbers = (np.sqrt(np.mean(x**2)) for x in (truth[:, i], off))
        cells = [*numbers, np.abs(off).max()]
        rows.append(f"| {words} | {' | '.join(f'{1e3 * x:.2f}' for x in cells)} |")
    return "\n".join(rows)


def cost() -> str:
    """Share of a core, and the time from a command to the odometry that it brings about."""
    tools, _, drive = _tests()
    rows = [
        "| odometry | commands | program | share of a core, % | ms from command: median | 99 % | worst |",
        "| --- | --- | --- | ---: | ---: | ---: | ---: |",
    ]
    with tempfile.TemporaryDirectory() as name, tools.Ros2(Path(name)) as ros:
        model = drive.save_model(Path(name))
        for odometry, commands in CASES:
            rate = "after every command" if odometry == 0 else f"{odometry} Hz"
            for words in ("node", "empty node"):
                if words == "node":
                    node = ros.node("odometry", model=model, rate=odometry)
                else:
                    node = ros.start("peer", "relay", odometry)
                probe = ros.start("peer", "latency", SECONDS, commands)
                time.sleep(3.0)  # [s] for them to meet
                begin, before = time.monotonic(), spent(node.pid)
                assert probe.wait(3.0 * SECONDS) == 0, tools.said(probe)
                share = 100.0 * (spent(node.pid) - before) / (time.monotonic() - begin)
                tools.finish(node)
                times = tools.said(probe).splitlines()[-1].split()[2:]
                cells = [f"{share:.1f}", *(times if odometry == 0 else [""] * 3)]
                rows.append(f"| {rate} | {commands} Hz | {words} | {' | '.join(cells)} |")
    return "\n".join(rows)


def compiling() -> str:
    """CPU time of the compiler for each source of the ROS 2 package, optimised as for release, without a cache."""
    tools, _, _ = _tests()
    build = tools.WORKSPACE / "build" / "seatrial_odometry"
    option = "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"
    done = tools.shell(
        f". install/local_setup.bash; cmake {option} {shlex.quote(str(build))}", tools.WORKSPACE
    )
    assert done.returncode == 0, done.stderr
    rows = ["| source | CPU time, s |", "| --- | ---: |"]
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = [w for w in shlex.split(entry["command"]) if not w.endswith("ccache")]
        source = Path(entry["file"])
        if source.name in ("peer.cpp", "main.cpp"):
            continue
        words[words.index("-o") + 1] = "/dev/null"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(words, cwd=entry["directory"], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = sum(getattr(after, n) - getattr(before, n) for n in ("ru_utime", "ru_stime"))
        kind = source.parts[source.parts.index("ros") :][-3:]
        rows.append(f"| `{'/'.join(kind)}` | {used:.0f} |")
    return "\n".join(rows)
