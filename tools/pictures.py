# SPDX-License-Identifier: MIT
"""Run docs/tutorial.md and docs/gallery.md, and make their pictures and that of the live page (with Chromium).

python tools/pictures.py              # after a change of a plot or a page, or of the two documents
"""

import contextlib
import os
import re
import shlex
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from screenshot import screenshot

DOCS = Path(__file__).resolve().parents[1] / "docs"
IMAGES = DOCS / "images"
PLOTS = ("recording", "model", "scores", "odometry")  # written by the tutorial itself
PAGES = {  # pictures of pages
    "tutorial/report": "report.html",
    "gallery/compare": "compare.html",
    "gallery/allocation": "allocation.html",
    "gallery/tune": "tune.html",
}
COLOURS = 255  # of a picture: half the size
WIDTH, HEIGHT = 1200, 800  # [px] of a page
LIVE_HEIGHT, LIVE_SPEED, LIVE_UNTIL = 1250, 2.0, 62.0  # [px], times the pace, [s] of the drive


def steps(page: Path) -> Iterator[tuple[str, str]]:
    """Its blocks of commands and of Python, in order."""
    for found in re.finditer(r"```(sh|python)\n(.*?)```", page.read_text(), re.DOTALL):
        yield found[1], found[2]


def run(page: Path, command: Callable[[list[str]], int], names: dict[str, Any]) -> None:
    """Run a page in this folder: `command` takes the arguments after `seatrial`."""
    for language, text in steps(page):
        if language == "python":
            exec(compile(text, page.name, "exec"), names)
            continue
        for line in text.splitlines():
            program, *arguments = shlex.split(line)
            if program != "seatrial" or command([*arguments, "--quiet"]) != 0:
                raise SystemExit(f"{page.name}: {line}")


def smaller(picture: Path, out: Path) -> None:
    """The same picture in few colours."""
    from PIL import Image  # noqa: PLC0415

    out.parent.mkdir(exist_ok=True)
    with Image.open(picture) as whole:
        whole.convert("RGB").quantize(COLOURS).save(out, optimize=True)


def poolside(folder: Path, command: Callable[[list[str]], int]) -> None:
    """The live page during a simulated drive."""
    import seatrial  # noqa: PLC0415
    from seatrial.poolside.area import rectangle  # noqa: PLC0415
    from seatrial.poolside.session import Wishes, make_session  # noqa: PLC0415
    from seatrial.poolside.sources import open_source  # noqa: PLC0415
    from seatrial.poolside.web.server import PageServer, Place  # noqa: PLC0415

    os.chdir(folder)
    command(["simulate", "-o", "trials", "--quiet"])
    vehicle = seatrial.load_vehicle(folder / "trials" / "vehicle-MP.yaml")
    source = open_source("trials/S4-MP", vehicle, LIVE_SPEED)  # as the page states it
    session = make_session(vehicle, source, folder / "drive", Wishes(rectangle(4.0, 3.0)))
    with PageServer(Place(port=0)) as server:
        server.serve(session)
        session.start()
        while session.state().time < LIVE_UNTIL or not session.state().parameters:
            time.sleep(0.1)
        shot = folder / "poolside.png"
        screenshot(
            server.url, shot, width=WIDTH, height=LIVE_HEIGHT, dark=False, at=None, whole=False
        )
        session.close()
    smaller(shot, IMAGES / "poolside.png")


def main() -> None:
    """All pictures."""
    from seatrial.commands.cli import main as command  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        names: dict[str, Any] = {}
        with contextlib.redirect_stdout(None):
            for page in ("tutorial.md", "gallery.md"):
                run(DOCS / page, command, names)
        for name in PLOTS:
            smaller(Path(f"{name}.png"), IMAGES / "tutorial" / f"{name}.png")
        for name, page in PAGES.items():
            shot = Path(f"{Path(name).name}-page.png")
            screenshot(
                Path(page), shot, width=WIDTH, height=HEIGHT, dark=False, at=None, whole=False
            )
            smaller(shot, IMAGES / f"{name}.png")
        poolside(Path(place), command)
        os.chdir(DOCS)


if __name__ == "__main__":
    main()
