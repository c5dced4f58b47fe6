# SPDX-License-Identifier: MIT
"""Texts that are no tables: what they are, and what to do with them."""

import re
import shlex
from collections.abc import Sequence
from pathlib import Path

from seatrial.util.errors import RecordingError
from seatrial.util.format import shortened

NMEA = re.compile(r"[$!][A-Z]{2}[A-Z0-9]{3},")
# lines of key=value, between spaces, commas, semicolons or tabs
NAMED_VALUE = r"[A-Za-z_][\w./-]*\s?=\s?[^\s=,;]+"
NAMED_VALUES = re.compile(rf"{NAMED_VALUE}(?:[\s,;]+{NAMED_VALUE})+[\s,;]*")
ONLY_VALUES = r"s/[^ ,;=\t]+ ?= ?//g; s/[ ,;\t]+/,/g"  # of such lines, for sed
OTHER_FILES = ("seatrial:", "# Proposed by", "%YAML")


def refuse_other_text(path: Path, lines: Sequence[str]) -> None:
    """Raises RecordingError where the first lines of a text are those of no table."""
    if not lines:
        return
    if NMEA.match(lines[0]):
        raise RecordingError(
            f"{path}: has NMEA 0183 sentences, not columns; write time, latitude, longitude, heading and "
            "commands as a table (docs/formats.md)"
        )
    if all(NAMED_VALUES.fullmatch(line.strip()) for line in lines[:2]):
        keys = re.findall(r"([\w./-]+)\s?=", lines[0])
        raise RecordingError(
            f"{path}: has lines of key=value ({shortened(keys)}), not columns; write a table, a column a "
            "key: the keys once as header, then rows of values. Where the keys are the same in each line: "
            f"(echo {','.join(keys)}; sed -E '{ONLY_VALUES}' {shlex.quote(str(path))}) > table.csv"
        )
    if lines[0].startswith(OTHER_FILES):
        raise RecordingError(
            f"{path}: is a vehicle or model file, not a recording; give it with --vehicle, or first"
        )
