# SPDX-License-Identifier: MIT
"""One boat of a fleet: identified, validated on what was held out, compared with its previous model.

A worker does it, and writes the boat's folder. The result is the last file: a folder that has it is done.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from platform import node

import msgspec

from seatrial.boat.finding_kinds import ASK_FOR_ACTION
from seatrial.boat.findings import finding_text, most_important, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.model_file import load
from seatrial.boat.vehicle import load_vehicle
from seatrial.evaluation.comparison.compare import compare
from seatrial.evaluation.comparison.console import changes_text
from seatrial.evaluation.scores import Scores
from seatrial.fleet.fleet_file import BOATS, Boat
from seatrial.fleet.results import BoatResult, Change, Estimate, FleetRecording
from seatrial.guide import Guide, auto
from seatrial.guide.steps import digest_of, work_digest
from seatrial.inspection.advice import USABLE_POSES
from seatrial.inspection.overview import GOOD
from seatrial.io import read
from seatrial.io.reader import recording_name, recording_names
from seatrial.util.errors import FileError, RecordingError, SeatrialError, VehicleError
from seatrial.util.files import (
    convert,
    dump_json,
    dump_yaml,
    finite_or_none,
    read_json,
    sha256,
    write_text,
)
from seatrial.util.frames import SYMBOLS

RESULT, REPORT, VEHICLE, MODEL = "boat.json", "report.html", "vehicle.yaml", "model.yaml"
WRITTEN = (RESULT, REPORT, MODEL, "scores.json", "inspect.txt", "steps.json")
MOST_FINDINGS = 5  # on one model
NOT_SEEN = "{path}: no such file or folder on {on}; workers read files where this path leads to on their computer"

Unread = Mapping[Path, str]  # recordings that can't be read, with the reason


def work_on_boat(out: Path, boat: Boat) -> BoatResult:
    """The result of one boat, from its folder below `out` where that is of the same files and options.

    A mistake in the boat's files is in the result. Raises OSError where the disk fails.
    """
    folder = out / BOATS / boat.name
    made_from = _digest(boat)
    known = _known(folder / RESULT)
    if known is not None and known.made_from == made_from:
        return known
    _clear(folder)
    try:
        result = _identified(boat, folder, made_from)
    except SeatrialError as error:
        (folder / REPORT).unlink(missing_ok=True)
        result = failed(boat, str(error), made_from)
    write_text(folder / RESULT, dump_json(finite_or_none(msgspec.to_builtins(result))))
    return result


def failed(boat: Boat, error: str, made_from: str = "") -> BoatResult:
    """A boat without a model."""
    return BoatResult(boat.name, boat.kind, made_from, error, [], "", {}, {}, [], None)


def _digest(boat: Boat) -> str:
    """Of the boat's files and options, and of the program."""
    files = [(recording_name(path), _digest_of_files(path)) for path in boat.recordings]
    given = [
        None if path is None or not path.exists() else sha256(path)
        for path in (boat.vehicle, boat.previous)
    ]
    options = msgspec.to_builtins(boat.options)
    return work_digest(boat.name, boat.kind, str(boat.vehicle), given, files, boat.test, options)


def _digest_of_files(path: Path) -> object:
    """Of a file, or of all in a folder; None: there is none."""
    if path.is_dir():
        inside = sorted(p for p in path.rglob("*") if p.is_file())
        return [(p.relative_to(path).as_posix(), sha256(p)) for p in inside]
    return sha256(path) if path.is_file() else None


def _known(path: Path) -> BoatResult | None:
    """The result of an earlier run; None where there is none that can be used."""
    with suppress(FileError):
        return convert(read_json(path), BoatResult, path)
    return None


def _clear(folder: Path) -> None:
    """Remove what was made from other files or options, or is not whole: a model's file has fewer digits."""
    for name in WRITTEN:
        (folder / name).unlink(missing_ok=True)


def _identified(boat: Boat, folder: Path, made_from: str) -> BoatResult:
    if boat.vehicle is None:
        raise VehicleError(f"{boat.name}: no vehicle file")
    for path in (boat.vehicle, boat.previous):
        if path is not None and path.is_absolute() and not path.exists():
            raise FileError(NOT_SEEN.format(path=path, on=node()))
    vehicle = load_vehicle(boat.vehicle)
    if boat.options.structure == "auto":
        vehicle = vehicle.with_automatic_structure()
    previous = None if boat.previous is None else load(boat.previous)
    text = dump_yaml(vehicle.to_mapping() | {"name": boat.name})
    write_text(folder / VEHICLE, text)
    found, unread = _guided(boat, folder)
    model = found.model
    change = None if previous is None else _change(str(boat.previous), previous, model)
    asking = most_important(of_kinds(model.estimator.findings, *ASK_FOR_ACTION))
    return BoatResult(
        boat.name, boat.kind, made_from, None, _recordings(boat, found, unread), _structure(model),
        _parameters(model), _ratios(found.scores), [finding_text(f) for f in asking[:MOST_FINDINGS]],
        change,
    )  # fmt: skip


def _guided(boat: Boat, folder: Path) -> tuple[Guide, Unread]:
    """From all recordings; where that fails, from those that can be read."""

    def from_these(paths: Sequence[Path]) -> Guide:
        options = boat.options
        return auto(paths, folder, test=boat.test, salvage=options.salvage, effects=options.effects)

    try:
        return from_these(boat.recordings), {}
    except (RecordingError, FileError, OSError) as error:
        unread = _unread(boat, folder / VEHICLE)
        good = [path for path in boat.recordings if path not in unread]
        if not unread or isinstance(error, OSError):
            raise
        if not good:
            raise RecordingError(next(iter(unread.values()))) from None
    return from_these(good), unread


def _unread(boat: Boat, vehicle_file: Path) -> Unread:
    vehicle, found = load_vehicle(vehicle_file), {}
    for path in boat.recordings:
        try:
            read(path, vehicle, salvage=boat.options.salvage)
        except SeatrialError as error:
            found[path] = str(error) if path.exists() else NOT_SEEN.format(path=path, on=node())
    return found


def _recordings(boat: Boat, found: Guide, unread: Unread) -> list[FleetRecording]:
    """Which recordings are bad, and why."""
    views = {view.name: view for view in found.inspection.recordings}
    findings = of_kinds(found.model.estimator.findings, *ASK_FOR_ACTION)
    rows = []
    # as they were called when they were read together
    good = [path for path in boat.recordings if path not in unread]
    names = dict(zip(good, recording_names(good), strict=True))
    for path in boat.recordings:
        if path in unread:
            rows.append(FleetRecording(recording_name(path), unread[path], bad=True, remarks=[]))
            continue
        name = names[path]
        named = [finding_text(f) for f in most_important(findings) if name in f.subject]
        remarks = [*named, *(words for words in views[name].verdicts if words != GOOD)]
        bad = bool(named) or views[name].usable < USABLE_POSES
        rows.append(FleetRecording(name, None, bad=bad, remarks=remarks))
    return rows


def _structure(model: Model) -> str:
    """Digest of what parameters mean: terms, allocation, stages of the actuators."""
    terms = [(t.axis, t.text()) for t in model.structure.terms]
    vehicle = model.vehicle
    return digest_of(terms, vehicle.scheme.value, vehicle.actuators, vehicle.constants.names)[:16]


def _parameters(model: Model) -> dict[str, Estimate]:
    units, errors = model.units, model.standard_errors
    return {
        name: Estimate(value, errors[name], units[name])
        for name, value in model.parameter_values.items()
        if errors[name] > 0.0
    }


def _ratios(scores: Scores) -> dict[str, float | None]:
    """RMS error over that of constant velocity at the chosen horizon, all judging recordings together."""
    rows = [row for row in scores.pooled if row.horizon == scores.horizon]
    rows = [row for row in rows if row.start == "filter"] or rows
    return {symbol: rows[0].scores[symbol].ratio if rows else None for symbol in SYMBOLS}


def _change(path: str, previous: Model, model: Model) -> Change:
    """The previous model against the present one."""
    try:
        found = compare(previous, model, labels=("last time", "now"))
    except SeatrialError as error:
        return Change(path, None, [], str(error))
    p = [pair.p for pair in found.pairs if pair.p is not None]
    return Change(path, min(p, default=None), [*changes_text(found)], None)
