# SPDX-License-Identifier: MIT
"""`fleet`: many boats, each by itself on a worker, then all against their kind."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import msgspec

from seatrial.fleet.boat_work import REPORT, RESULT, failed, work_on_boat
from seatrial.fleet.fleet_file import BOATS, Boat, Fleet
from seatrial.fleet.kinds import SIGNIFICANCE, Compared, compare_kind
from seatrial.fleet.page import write_fleet_page
from seatrial.fleet.results import BoatResult, FleetBoat, FleetResult
from seatrial.util.distributions import holm
from seatrial.util.errors import FleetError, SeatrialError
from seatrial.util.files import dump_json, finite_or_none, writable, write_text
from seatrial.util.parallel import Farm, InTurn
from seatrial.util.progress import stage

JSON, PAGE, LOCK = "fleet.json", "fleet.html", ".lock"
REPORT_SHARE = 0.01  # of the time
ELSEWHERE = (
    "its worker wrote the results to its own {out}, which this computer does not see: give a folder with -o that "
    "all computers share"
)


@dataclass(frozen=True)
class FleetRun:
    """What a fleet's run ended with."""

    folder: Path
    result: FleetResult

    @property
    def report(self) -> Path:
        """The page of all boats."""
        return self.folder / PAGE


def fleet(boats: Fleet, folder: str | Path, farm: Farm | None = None) -> FleetRun:
    """All boats of a fleet, their table and their page, in a folder.

    A boat whose files and options are as in an earlier run is not worked on again. What fails for one boat is in
    its row. The result does not depend on `farm`, the workers (default: this process). Raises FileError where the
    folder can't be written, FleetError where another run works on it.
    """
    out = Path(folder).resolve()
    with _alone_in(out):
        with stage("", 1.0 - REPORT_SHARE):
            found = list(_by_boat(boats.boats, out, farm or InTurn()))
        result = _together(boats.name, found, out)
        with stage("report"):
            content = finite_or_none(msgspec.to_builtins(result))
            write_text(out / JSON, dump_json(content))
            write_fleet_page(result, out / PAGE)
    return FleetRun(Path(folder), result)


@contextmanager
def _alone_in(out: Path) -> Iterator[None]:
    """No other run in this folder meanwhile, where the system has locks; a lock ends with its process."""
    try:
        import fcntl  # noqa: PLC0415 not on Windows
    except ImportError:
        yield
        return
    with _opened(out / LOCK) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FleetError(
                f"{out}: another 'seatrial fleet' works on this folder; wait for its end, or give another folder"
            ) from None
        except OSError:  # a file system without locks
            pass
        yield


def _opened(path: Path) -> TextIO:
    """A file to be locked, made where it is missing."""
    with writable(path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("a")


def _by_boat(boats: Sequence[Boat], out: Path, farm: Farm) -> Iterator[BoatResult]:
    """The result of each boat, in the boats' order."""
    found = {place: failed(boat, boat.refused) for place, boat in enumerate(boats) if boat.refused}
    todo = [place for place in range(len(boats)) if place not in found]
    without = len(found)
    ended = farm.outcomes(work_on_boat, out, [boats[place] for place in todo])
    for _ in todo:
        words = f", {without} failed" if without else ""
        with stage(f"boats {len(found)}/{len(boats)}{words}", 1.0 / len(todo)):
            place, outcome = next(ended)
        boat = boats[todo[place]]
        if isinstance(outcome, Exception):
            outcome = failed(boat, _in_words(outcome))
        elif not (out / BOATS / boat.name / RESULT).is_file():
            outcome = failed(boat, ELSEWHERE.format(out=out))
        found[todo[place]] = outcome
        without += outcome.error is not None
    yield from (found[place] for place in range(len(boats)))


def _in_words(error: Exception) -> str:
    """What no boat's file is to blame for: the disk, a worker, or seatrial."""
    if isinstance(error, SeatrialError):
        return str(error)
    if isinstance(error, OSError):
        return str(FleetError(f"{error.filename or 'a file'}: {error.strerror or error}"))
    return str(FleetError(f"seatrial failed: {type(error).__name__}: {error}; please report it"))


def _together(name: str, found: Sequence[BoatResult], out: Path) -> FleetResult:
    """Boats against their kind and against their previous models, with the corrections for many tests."""
    compared: dict[str, Compared] = {}
    for kind in sorted({boat.kind for boat in found}):
        compared[kind] = compare_kind([boat for boat in found if boat.kind == kind])
    changed = _changed(found)
    rows = [
        FleetBoat(
            boat, f"{BOATS}/{boat.name}/{REPORT}" if boat.error is None else None,
            compared[boat.kind].differs.get(boat.name, []),
            compared[boat.kind].not_compared.get(boat.name), boat.name in changed,
        )
        for boat in found
    ]  # fmt: skip
    return FleetResult(
        name, rows, {kind: one.kind for kind, one in compared.items()},
        [boat.name for boat in found if boat.error is not None],
        [row.result.name for row in rows if row.differs],
        [row.result.name for row in rows if row.changed],
        [f"{boat.name}/{r.name}" for boat in found for r in boat.recordings if r.bad],
    )  # fmt: skip


def _changed(found: Sequence[BoatResult]) -> set[str]:
    """Boats that differ from their previous models."""
    tested = [
        (b.name, b.change.p) for b in found if b.change is not None and b.change.p is not None
    ]
    corrected = holm([p for _, p in tested]).tolist()
    return {name for (name, _), p in zip(tested, corrected, strict=True) if p < SIGNIFICANCE}
