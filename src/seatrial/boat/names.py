# SPDX-License-Identifier: MIT
"""The grammar of names in vehicle and model files.

A boat's name is one line of printable text. All other names stand in equations, in keys of files and in other
programs: they are words. Exports spell and escape both once more (`export/spelling.py`).
"""

import re
from collections.abc import Iterable

import msgspec

from seatrial.boat.schema import VehicleFile
from seatrial.util.errors import VehicleError

LONGEST_TITLE = 100  # [characters] of a boat's name
LONGEST_NAME = 64  # [characters] of other names; the longest that ROS, MATLAB and C read are near
SHOWN = 40  # [characters] of a refused name in the message
_WORD = re.compile(r"\w(?:[\w./: -]*\w)?")  # bow-thruster, axes.1, port motor, Backbord_Motor


def check_vehicle_names(file: VehicleFile, source: str) -> None:
    """Raise VehicleError for a name in a vehicle file that is against the grammar."""
    check_title(file.name, source)
    for kind, names in (
        ("input", file.commands.inputs),
        ("scale", file.scales),
        ("thruster", file.thrusters),
        ("force", file.forces),
        ("chain group", [group.name for group in file.chain if group.name]),
    ):
        check_names(kind, names, source)
    for entry in (file.pose, file.commands, file.scales):
        check_files(entry, source)


def check_title(title: str, source: str) -> None:
    """Raise VehicleError where a boat's name is not one line of text."""
    if not title.isprintable() or not title.strip() or len(title) > LONGEST_TITLE:
        raise VehicleError(
            f"{source}: name '{_shown(title)}': a boat's name is one line of 1 to {LONGEST_TITLE} printable "
            "characters"
        )


def check_names(kind: str, names: Iterable[str], source: str) -> None:
    """Raise VehicleError for a name that is no word. `kind`: input, thruster, force, group, scale."""
    for name in names:
        if not _WORD.fullmatch(name) or len(name) > LONGEST_NAME:
            raise VehicleError(
                f"{source}: {kind} '{_shown(name)}': a name has 1 to {LONGEST_NAME} letters, digits, and between "
                "them _ - . / : or spaces"
            )


def check_files(entry: object, source: str) -> None:
    """Raise VehicleError where a `file` somewhere in an entry is not below the recording's folder."""
    if isinstance(entry, dict):
        for value in entry.values():
            check_files(value, source)
    elif isinstance(entry, msgspec.Struct):
        check_files(msgspec.structs.asdict(entry), source)
        name = getattr(entry, "file", None)
        if name is not None:
            check_file(name, source)


def check_file(name: str, source: str) -> None:
    """Raise VehicleError for a path out of a folder, on any system."""
    parts = re.split(r"[/\\]", name)
    if ".." in parts or re.match("[A-Za-z]:", name) or name.startswith(("/", "\\")) or "\0" in name:
        raise VehicleError(
            f"{source}: file '{_shown(name)}' is not in the recording's folder; give a name in it"
        )


def _shown(name: str) -> str:
    return name if len(name) <= SHOWN else f"{name[:SHOWN]}..."
