# SPDX-License-Identifier: MIT
"""`seatrial live`."""

import argparse
import signal
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import add_json, add_salvage, guard, open_page, write_json
from seatrial.identification.methods import EFFECT_KINDS
from seatrial.util.printing import complain, say
from seatrial.workflow.fitness import Use

if TYPE_CHECKING:
    from collections.abc import Callable

    from seatrial.poolside.area import Area
    from seatrial.poolside.session import Session
    from seatrial.poolside.web.server import PageServer

PORT = 8330
POLL = 0.2  # [s]
LAST_LOOK = 1.0  # [s] in which the page gets the last state
CTRL_C = "Ctrl-C: the recording only"
STAYS = "the page is served until it is closed, or Ctrl-C"
NEEDS = "the page needs starlette, uvicorn and websockets: pip install 'seatrial[live]'"


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("boat", metavar="VEHICLE", help="vehicle file, or model of the boat")
    command.add_argument(
        "source", nargs="?", default="-", metavar="SOURCE",
        help="where poses and commands come from: - lines of standard input; udp:PORT; mavlink:udp:PORT or "
        "mavlink:DEVICE; follow:PATH, a table, a folder of tables or a bag that grows; a log or bag, replayed "
        "(default: -)",
    )  # fmt: skip
    command.add_argument(
        "-o", "--out", type=Path, metavar="DIR",
        help="new folder for the recording, the model and the report (default: NAME-DATE-TIME)",
    )  # fmt: skip
    command.add_argument(
        "--walls", nargs=4, type=float, metavar=("X0", "Y0", "X1", "Y1"),
        help="two opposite corners of the pool [m], in the frame of the poses",
    )  # fmt: skip
    command.add_argument(
        "--area", type=Path, metavar="FILE", help="file with the corners of another area"
    )
    command.add_argument(
        "--use", nargs="+", action="extend", default=[], choices=[use.value for use in Use], metavar="USE",
        help="what the model must be good enough for: odometry, control, simulation (default: all)",
    )  # fmt: skip
    command.add_argument(
        "--effect", action="append", default=[], choices=EFFECT_KINDS,
        help="estimate this effect, too, as identify does",
    )  # fmt: skip
    command.add_argument(
        "--mcap", action="store_true", help="save the recording as recording.mcap, too"
    )
    command.add_argument(
        "--speed", type=float, default=1.0, metavar="X",
        help="replay: times the pace of the log; 0: as fast as possible (default: %(default)g)",
    )  # fmt: skip
    _add_page(command)
    add_salvage(command)
    add_json(command)


def _add_page(command: argparse.ArgumentParser) -> None:
    """Those of the page in the browser."""
    command.add_argument(
        "--port", type=int, default=PORT, help="port of the page (default: %(default)s; 0: any)"
    )
    command.add_argument(
        "--address", default="127.0.0.1", metavar="A",
        help="address that the page is served on; another than loopback needs --token (default: %(default)s)",
    )  # fmt: skip
    command.add_argument("--token", metavar="T", help="secret that opens the page")
    command.add_argument("--no-browser", action="store_true", help="do not open the page")


def run(args: argparse.Namespace) -> None:
    """Serve the page until the session is stopped there, or by Ctrl-C."""
    from seatrial.control.allocation import load_boat
    from seatrial.poolside.session import RECORDING, Wishes, make_session
    from seatrial.poolside.sources import open_source

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # keeps the recording, as Ctrl-C
    open_port = _server()
    guard(args.json, "{", args.boat, args.source, args.area)
    boat, vehicle = load_boat(args.boat)
    wishes = Wishes(
        _area(args), tuple(map(Use, args.use)) or tuple(Use), tuple(args.effect), args.mcap
    )
    folder = args.out or Path(f"{vehicle.name.replace(' ', '-')}-{time.strftime('%Y%m%d-%H%M%S')}")
    with (
        open_port(args.address, args.port, args.token) as page,
        open_source(args.source, vehicle, args.speed, salvage=args.salvage) as source,
    ):
        session = make_session(boat, source, folder, wishes)
        try:
            page.serve(session)
            session.start()
            say(f"page      {page.url}")
            say(f"recording {folder / RECORDING}")
            say(f"next: open the page, drive what it shows, press stop and save ({CTRL_C})")
            open_page(args, page.url)
            _wait(session)
        except KeyboardInterrupt:
            session.close()
            complain(f"stopped; the recording is in {folder / RECORDING}")
            raise
        try:
            _saved(args, session, folder)
        finally:
            _leave(page, session)


def _wait(session: "Session") -> None:
    """Until the session is saved."""
    while not session.state().stopped:
        time.sleep(POLL)


def _leave(page: "PageServer", session: "Session") -> None:
    """Serve a little longer: the page learns of the end. A report is served while a browser is connected."""
    with suppress(KeyboardInterrupt):
        time.sleep(LAST_LOOK)
        if "report" in dict(session.state().saved) and page.connected:
            say(STAYS)
            while page.connected:
                time.sleep(POLL)


def _saved(args: argparse.Namespace, session: "Session", folder: Path) -> None:
    from seatrial.commands.shared.results import LiveResult
    from seatrial.util.errors import LiveError

    state = session.state()
    paths = dict(state.saved)
    for what, path in state.saved:
        say(f"{what:9} {path}")
    for one in state.signals:
        mend = f"; change the vehicle file: {one.edit}" if one.edit else ""
        if mend or (one.level == "error" and "model" in paths):
            complain(f"{one.name}: {one.finding}{mend}")
    if state.message and "model" in paths:
        complain(state.message)
    step = _next(args, paths)
    say(step)
    found = LiveResult(
        str(folder), state.time, state.poses, state.enough, paths.get("recording", ""),
        paths.get("model"), paths.get("report"), step,
    )  # fmt: skip
    write_json(args, "live 1", found)
    if "model" not in paths:
        raise LiveError(state.message or "the recording is saved, but there is no model")


def _next(args: argparse.Namespace, paths: dict[str, str]) -> str:
    from seatrial.boat.model_file import load
    from seatrial.boat.vehicle import load_vehicle
    from seatrial.guide.model import effect_options
    from seatrial.workflow.next_step import after_predict, asked_for, command

    recording, vehicle = paths["recording"], Path(paths["recording"]) / "vehicle.yaml"
    if "model" not in paths:
        return f"next: {command('inspect', recording, '--vehicle', vehicle)}"
    path = Path(paths["model"])
    model, automatic = load(path), load_vehicle(vehicle).automatic
    further = path.with_name("model-2.yaml")
    asked = asked_for(
        model, [recording], vehicle, further, effect_options(model), automatic=automatic
    )
    return (asked or after_predict(path)).text


def _area(args: argparse.Namespace) -> "Area | None":
    """The walls. Raises FileError, LiveError."""
    from seatrial.poolside.area import Area, read_walls
    from seatrial.util.errors import LiveError

    if args.walls is not None and args.area is not None:
        raise LiveError("give --walls or --area, not both")
    if args.area is not None:
        return read_walls(args.area)
    if args.walls is None:
        return None
    import numpy as np

    x0, y0, x1, y1 = args.walls
    return Area(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))


def _server() -> "Callable[[str, int, str | None], PageServer]":
    """What opens the port of the page. Raises LiveError where its packages are not installed."""
    from seatrial.util.errors import LiveError

    try:
        from seatrial.poolside.web.server import PageServer, Place
    except ImportError as error:
        raise LiveError(f"{NEEDS} ({error})") from None
    return lambda *place: PageServer(Place(*place))
