# SPDX-License-Identifier: MIT
"""A simulated operator who drives by the API of `seatrial live`: a whole session, in real time.

    python -m benchmarks.live_operator                # two thrusters in wind
    python -m benchmarks.live_operator --water pool   # the paper's boat in its pool

The boat is simulated; its poses and commands go to the session by UDP. The operator reads `GET /api/state` as the
page does, drives its `next` manoeuvre, and presses stop and save when `enough` is set. He turns back before walls.
"""

import argparse
import json
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

import seatrial
from benchmarks.harness.measure import free_port
from benchmarks.studies.poolside.drivers import Guided
from benchmarks.studies.poolside.drives import AT_WALL, WATERS, inside
from benchmarks.studies.poolside.waters import Water
from seatrial.poolside.state import LiveState, ManoeuvreState
from seatrial.util.files import dump_yaml
from seatrial.util.frames import Array

LONGEST = 300.0  # [s] of a drive
ASK = 0.5  # [s] between two looks at `enough`
PATIENCE = 60.0  # [s] of an answer, and of the session's start
WAITING = ManoeuvreState("wait for advice", 1.0, "", 0.0, 0.0)


class Api:
    """The session's API; in place of an `Advisor`."""

    def __init__(self, url: str) -> None:
        self.url = url

    def state(self) -> LiveState:
        """`GET /api/state`."""
        with urllib.request.urlopen(f"{self.url}/api/state", timeout=PATIENCE) as answer:
            return msgspec.json.decode(answer.read(), type=LiveState)

    def advise(self, *_: object, **__: object) -> tuple[ManoeuvreState, ...]:
        """What the page shows as next."""
        found = self.state().next
        return (WAITING if found is None else found,)

    def stop(self) -> dict[str, str]:
        """`POST /api/stop`."""
        kind = {"content-type": "application/json"}
        request = urllib.request.Request(f"{self.url}/api/stop", b"{}", kind)
        with urllib.request.urlopen(request, timeout=10.0 * PATIENCE) as answer:
            found: dict[str, str] = json.load(answer)
        return found

    def wait(self) -> None:
        """Until the session answers. Raises OSError."""
        end = time.monotonic() + PATIENCE
        while True:
            try:
                self.state()
            except OSError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.2)
            else:
                return


class Operator(Guided):
    """Follows the API; what the boat measures is sent as lines."""

    def __init__(self, water: Water, seed: int, api: Api, port: int) -> None:
        super().__init__(water, seed)
        self.advisor: Any = api
        self._out, self._port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), port

    def send(self, t: float, kind: str, values: Array) -> None:
        """A line."""
        line = json.dumps({"t": t, kind: np.asarray(values).tolist()})
        self._out.sendto(line.encode(), ("127.0.0.1", self._port))


def drive(operator: Operator, api: Api) -> tuple[float, float, list[str]]:
    """Drive in real time until it is enough: seconds, share of the time at a wall, manoeuvres."""
    water, begin, asked, at_wall, driven = operator.water, time.time(), 0.0, 0, []
    for tick in range(round(LONGEST / water.tick)):
        t, x = tick * water.tick, water.state
        time.sleep(max(0.0, begin + t - time.time()))
        before = operator.now
        row = operator.look(t, x)
        if operator.now is not None and operator.now is not before:
            driven.append(f"{t:5.1f} s  {operator.now.text}")
        operator.send(begin + t + water.offset, "command", row)
        for stamp, pose in water.step(row):
            operator.send(begin + stamp, "pose", pose)
        at_wall += bool(water.area.margin(*x[:2].tolist()) < water.radius - AT_WALL)
        if t >= asked + ASK:
            asked = t
            if api.state().enough:
                return t, at_wall / (tick + 1), driven
    return float("inf"), at_wall / (tick + 1), driven


def session(water: Water, seed: int) -> None:
    """A whole session of a boat."""
    lines, page = free_port(), free_port(socket.SOCK_STREAM)
    api = Api(f"http://127.0.0.1:{page}")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "vehicle.yaml").write_text(dump_yaml(water.vehicle.to_mapping()))
        x, y = (water.area.corners.max(axis=0)).tolist()
        command = [
            sys.executable, "-m", "seatrial", "live", str(folder / "vehicle.yaml"), f"udp:{lines}",
            "-o", str(folder / "drive"), "--port", str(page), "--no-browser", "--walls", *map(str, (-x, -y, x, y)),
        ]  # fmt: skip
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
            api.wait()
            seconds, at_wall, driven = drive(Operator(water, seed, api, lines), api)
            saved = api.stop()
            code = process.wait(PATIENCE)
        print("\n".join(driven))
        wall = f"{100 * at_wall:.1f} % of the time at a wall"
        print(f"{water.name}: enough after {seconds:.0f} s, {wall}; exit code {code}")
        if "model" in saved:
            held = inside(seatrial.load(saved["model"]), water)
            print(f"saved model: {sum(held)} of {len(held)} 95 % intervals hold the truth")
        else:
            print("no model was saved")


def main(arguments: Sequence[str]) -> None:
    """A session."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--water", choices=list(WATERS), default="twin")
    parser.add_argument("--seed", type=int, default=4001)
    given = parser.parse_args(arguments)
    session(WATERS[given.water](given.seed), given.seed)


if __name__ == "__main__":
    main(sys.argv[1:])
