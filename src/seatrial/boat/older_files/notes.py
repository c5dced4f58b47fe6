# SPDX-License-Identifier: MIT
"""Sentences of older files as findings: `notes:` of "model 2" and of "scores 3". Used to read those only.

A sentence that none of the known ones is stays text. One sentence may hold several findings.
"""

import re
from collections.abc import Iterable

import msgspec

from seatrial.boat.findings import Finding, FindingKind
from seatrial.boat.older_files.wordings import WORDINGS
from seatrial.util.errors import FileError

LONGEST_NOTE = 3000  # [characters] of a sentence that is looked at: a file may hold anything
MOST_NOTES = 200  # of a file that are looked at


def findings_of(notes: Iterable[str]) -> list[Finding]:
    """The findings that sentences stand for, in their order."""
    return [
        finding
        for i, note in enumerate(notes)
        for finding in (_of_note(note) if i < MOST_NOTES else [_other(note)])
        if note
    ]


def with_findings(entry: object, place: str) -> object:
    """A mapping of an older file with `findings` in place of its `notes`. Raises FileError."""
    if not isinstance(entry, dict):
        return entry
    if "findings" in entry:
        raise FileError(f"{place}: unknown key 'findings' in a file of this version")
    notes = entry.get("notes", [])
    if not isinstance(notes, list) or not all(isinstance(note, str) for note in notes):
        raise FileError(f"{place}: notes: expected a list of texts")
    rest = {key: value for key, value in entry.items() if key != "notes"}
    return {**rest, "findings": msgspec.to_builtins(findings_of(notes))}


def _other(note: str) -> Finding:
    return Finding(FindingKind.OTHER, values={"text": note[:LONGEST_NOTE]})


def _of_note(note: str) -> list[Finding]:
    """Of one sentence; its text as it is where it is none of the known ones, or holds what can't be."""
    for pattern, read in WORDINGS if len(note) <= LONGEST_NOTE else ():
        found = re.fullmatch(pattern, note, re.DOTALL)
        if found is not None:
            try:
                return read(found)
            except (ValueError, OverflowError):
                break
    return [_other(note)]
