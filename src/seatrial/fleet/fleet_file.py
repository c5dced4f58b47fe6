# SPDX-License-Identifier: MIT
"""Which boats there are: a folder with one folder a boat, or a file."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from seatrial.boat.schema import Strict
from seatrial.identification.methods import EFFECT_KINDS
from seatrial.io.kinds import TRUTH, recordings_in
from seatrial.io.table import is_table
from seatrial.util.errors import FleetError
from seatrial.util.files import convert, expect_format, read_yaml

FLEET_FORMAT = "fleet 1"
MOST_BOATS, MOST_RECORDINGS = 20_000, 1_000  # of a fleet, of a boat
NAME = re.compile(r"\w[\w. -]{0,63}", re.ASCII)  # of a boat: a folder has it
VEHICLE, PREVIOUS = "vehicle.yaml", "previous.yaml"
BOATS = "boats"  # folder of the results, one folder a boat
BAD_NAME = "the name can't be a folder's: expected 1 to 64 letters, digits, _ - . or spaces; rename the boat"
LONGEST_SHOWN = 60  # [characters] of a name in a message


class Options(Strict, frozen=True):
    """How boats are identified."""

    effects: tuple[str, ...] = ()  # from the beginning; others where the recordings show them
    structure: Literal["auto"] | None = None  # the recordings choose the terms
    salvage: bool = False  # read what is left of damaged bags


class BoatEntry(Strict, frozen=True):
    """One boat of a fleet's file. Paths are relative to the file's folder."""

    recordings: list[str]
    vehicle: str | None = None  # default: the fleet's
    kind: str | None = None  # whose boats are compared; default: the fleet's name
    test: str | None = None  # recording that tests the model; default: the last quarter of each
    previous: str | None = None  # the boat's model of last time
    identify: Options | None = None  # default: the fleet's


class FleetFile(Strict, frozen=True):
    """A fleet's file."""

    seatrial: Literal["fleet 1"]
    boats: dict[str, BoatEntry]
    name: str = "fleet"
    vehicle: str | None = None  # of boats without their own
    identify: Options = Options()


@dataclass(frozen=True)
class Boat:
    """One boat, with absolute paths: workers may be elsewhere."""

    name: str
    kind: str
    vehicle: Path | None
    recordings: tuple[Path, ...]
    test: str | None = None
    previous: Path | None = None
    options: Options = field(default_factory=Options)
    refused: str = ""  # why it can't be worked on; empty: it can


@dataclass(frozen=True)
class Fleet:
    """Boats in the order of their names."""

    name: str
    boats: tuple[Boat, ...]


def load_fleet(path: Path, last_time: Path | None = None) -> Fleet:
    """The boats of a folder or file. Raises FileError, FleetError.

    `last_time`: the results of an earlier run, whose models are the previous ones of boats without their own.
    """
    fleet = _of_folder(path) if path.is_dir() else _of_file(path)
    if not fleet.boats:
        raise FleetError(
            f"{path}: no boats; expected a folder for each boat, with {VEHICLE} and recordings"
        )
    if len(fleet.boats) > MOST_BOATS:
        raise FleetError(f"{path}: {len(fleet.boats)} boats; expected {MOST_BOATS} at most")
    if last_time is not None and not (last_time / BOATS).is_dir():
        raise FleetError(f"{last_time}: no results of a fleet (there is no folder {BOATS} in it)")
    boats = sorted((_with_previous(boat, last_time) for boat in fleet.boats), key=lambda b: b.name)
    return Fleet(fleet.name, tuple(boats))


def _with_previous(boat: Boat, last_time: Path | None) -> Boat:
    """With the model of last time, where the boat has no previous model of its own."""
    if last_time is None or boat.previous is not None or boat.refused:
        return boat
    path = (last_time / BOATS / boat.name / "model.yaml").resolve()
    return replace(boat, previous=path) if path.is_file() else boat


def _of_folder(folder: Path) -> Fleet:
    """A boat for each folder; all are of one kind."""
    root = folder.resolve()
    shared = root / VEHICLE
    boats = [
        _in_folder(one, root, shared if shared.is_file() else None)
        for one in root.iterdir()
        if one.is_dir() and not one.name.startswith(".")
    ]
    return Fleet(root.name, tuple(boats))


def _in_folder(folder: Path, root: Path, shared: Path | None) -> Boat:
    """Vehicle file, recordings and previous model of one folder, none of them outside the fleet's."""
    name, kind = folder.name, root.name
    if not NAME.fullmatch(name):
        return Boat(name, kind, None, (), refused=BAD_NAME)
    own = (
        [folder / VEHICLE] if (folder / VEHICLE).exists() else sorted(folder.glob("vehicle*.yaml"))
    )
    if len(own) > 1:
        return Boat(name, kind, None, (), refused=f"{len(own)} vehicle files; expected {VEHICLE}")
    vehicle = own[0] if own else shared
    recordings = tuple(_recordings(folder))
    previous = folder / PREVIOUS
    found = [*recordings, *own, *([previous] if previous.exists() else [])]
    outside = [one for one in found if not one.resolve().is_relative_to(root)]
    if outside:
        words = f"{outside[0].name} is a link out of the fleet's folder; name it in a fleet's file"
        return Boat(name, kind, None, (), refused=words)
    return Boat(
        name, kind, vehicle, recordings, previous=previous if previous.exists() else None,
        refused=_refused(vehicle, recordings),
    )  # fmt: skip


def _recordings(folder: Path) -> Iterator[Path]:
    """Bags, logs, tables and folders of tables."""
    known = {*recordings_in(folder), *(p for p in folder.iterdir() if p.is_file() and is_table(p))}
    yield from sorted(p for p in known if p.name != TRUTH and not p.name.startswith("."))


def _refused(vehicle: Path | None, recordings: tuple[Path, ...]) -> str:
    if vehicle is None:
        return f"no {VEHICLE}; 'seatrial init' proposes one"
    if not recordings:
        return "no recording"
    if len(recordings) > MOST_RECORDINGS:
        return f"{len(recordings)} recordings; expected {MOST_RECORDINGS} at most"
    return ""


def _of_file(path: Path) -> Fleet:
    content = expect_format(read_yaml(path), FLEET_FORMAT, path)
    fleet = convert(content, FleetFile, path)
    root = path.resolve().parent
    for options in (fleet.identify, *(b.identify for b in fleet.boats.values() if b.identify)):
        for effect in options.effects:
            if effect not in EFFECT_KINDS:
                raise FleetError(
                    f"{path}: effects: '{effect[:LONGEST_SHOWN]}'; expected {', '.join(EFFECT_KINDS)}"
                )
    return Fleet(fleet.name, tuple(_of_entry(n, e, fleet, root) for n, e in fleet.boats.items()))


def _of_entry(name: str, entry: BoatEntry, fleet: FleetFile, root: Path) -> Boat:
    kind = entry.kind or fleet.name
    if not NAME.fullmatch(name):
        return Boat(name, kind, None, (), refused=BAD_NAME)
    given = entry.vehicle or fleet.vehicle
    vehicle = None if given is None else _placed(root, given)
    recordings = tuple(_placed(root, one) for one in entry.recordings)
    return Boat(
        name, kind, vehicle, recordings, entry.test,
        None if entry.previous is None else _placed(root, entry.previous),
        entry.identify or fleet.identify, _refused(vehicle, recordings),
    )  # fmt: skip


def _placed(root: Path, given: str) -> Path:
    """A path as a file has it; a name of the bundled vehicles stays as it is."""
    path = root / given
    return path if path.exists() or "/" in given or "." in given else Path(given)
