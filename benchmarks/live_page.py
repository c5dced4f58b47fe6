# SPDX-License-Identifier: MIT
"""From a pose to the page: latency of a whole session at 50 Hz poses and 100 Hz commands, in Chromium.

python -m benchmarks.live_page              # 60 s; --seconds for longer

A boat is simulated and its lines are sent by UDP at their time. The page notes when it drew which pose. A pose is
on the page when the first frame with it, or with a newer one, is drawn. A second client never reads its messages.
"""

import argparse
import json
import shutil
import socket
import tempfile
import time
from pathlib import Path

import numpy as np

import seatrial
from benchmarks.harness.measure import free_port
from seatrial.commands.cli import main as command
from seatrial.poolside.session import make_session
from seatrial.poolside.sources import open_source
from seatrial.poolside.web.server import PageServer, Place
from seatrial.recording.recording import Recording

POSES, COMMANDS = 50.0, 100.0  # [Hz]
MOST = 0.2  # [s] at the 99th percentile
ARGUMENTS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-background-networking")
NOTE = """() => { window.noted = []; new MutationObserver(() => {
    const shown = document.documentElement.dataset.shown;
    requestAnimationFrame(() => window.noted.push([Number(shown), Date.now() / 1000]));
}).observe(document.documentElement, { attributes: true, attributeFilter: ["data-shown"] }); }"""


def lines(recording: Recording, seconds: float) -> list[tuple[float, str]]:
    """Lines and their times [s], of a recording that is played again and again."""
    found = []
    for i in range(round(POSES * seconds)):
        t = i / POSES
        own = t % recording.duration
        eta = [float(np.interp(own, recording.t, recording.eta[:, k])) for k in range(3)]
        found.append((t, json.dumps({"t": t, "pose": eta})))
    stamps = recording.seconds(recording.commands.stamps)
    for i in range(round(COMMANDS * seconds)):
        t = i / COMMANDS
        row = max(int(np.searchsorted(stamps, t % recording.duration, side="right")) - 1, 0)
        found.append((t, json.dumps({"t": t, "command": recording.commands.values[row].tolist()})))
    return sorted(found)


def send(text: list[tuple[float, str]], port: int) -> float:
    """Send lines at their times; the time [s] of t = 0 by the system's clock."""
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    begin = time.time()
    for t, line in text:
        time.sleep(max(0.0, begin + t - time.time()))
        out.sendto(line.encode(), ("127.0.0.1", port))
    return begin


def delays(noted: list[list[float]], begin: float, seconds: float) -> np.ndarray:
    """Delays (n,) [s] from the sending of every pose to the first frame that has it."""
    shown, at = np.array(noted).T
    sent = np.arange(round(POSES * (seconds - 1.0))) / POSES
    first = np.searchsorted(np.maximum.accumulate(shown), sent - 1e-6)
    return at[np.minimum(first, len(at) - 1)] - (begin + sent)


def measure(seconds: float) -> np.ndarray:
    """Delays of a session of a simulated boat."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415
    from websockets.sync.client import connect  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as place, sync_playwright() as playwright:
        folder, port = Path(place), free_port()
        command(["simulate", "-o", str(folder / "trials"), "--quiet"])
        vehicle = seatrial.load_vehicle(folder / "trials" / "vehicle-MP.yaml")
        text = lines(seatrial.read(folder / "trials" / "S4-MP", vehicle), seconds)
        source = open_source(f"udp:{port}", vehicle)
        session = make_session(vehicle, source, folder / "drive")
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=list(ARGUMENTS)
        )
        with PageServer(Place(port=0)) as server:
            server.serve(session)
            page, still = (
                browser.new_page(),
                connect(f"ws://127.0.0.1:{server.port}/ws", max_queue=1, ping_interval=None),
            )
            page.goto(server.url)
            page.evaluate(NOTE)
            session.start()
            used = time.process_time() - time.thread_time()  # this thread sends
            begin = send(text, port)
            cpu = time.process_time() - time.thread_time() - used
            time.sleep(1.0)
            noted = page.evaluate("() => window.noted")
            state = session.state()
            print(f"poses used {state.poses} of {round(POSES * seconds)}; "
                  f"estimate {'there' if state.parameters else 'not there'}, lag {state.lag:.1f} s")  # fmt: skip
            print(f"CPU of session and server: {cpu / seconds:.0%} of a core")
            print(f"frames of the page: {len(noted) / seconds:.1f} a second")
            session.close()
            still.socket.close()  # without the goodbye that it would have to read
        browser.close()
    return delays(noted, begin, seconds)


def main() -> int:
    """The figures; 1 where the page is late."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    found = measure(parser.parse_args().seconds)
    p50, p99 = np.percentile(found, [50, 99])
    print(
        f"pose to page: median {1e3 * p50:.0f} ms, p99 {1e3 * p99:.0f} ms, largest {1e3 * found.max():.0f} ms"
    )
    return int(p99 > MOST)


if __name__ == "__main__":
    raise SystemExit(main())
