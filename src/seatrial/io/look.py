# SPDX-License-Identifier: MIT
"""Topics or columns of a recording, before there is a vehicle file."""

from pathlib import Path
from typing import Any

from seatrial.io.bags.contents import contents, contents_json, contents_text
from seatrial.io.bags.opening import is_bag
from seatrial.io.columns import columns_json, columns_text, look_at_columns
from seatrial.io.formats import is_log
from seatrial.io.formats.contents import log_contents


def look(path: Path, *, salvage: bool = False) -> tuple[str, dict[str, Any]]:
    """The contents as text and as JSON. Raises RecordingError, FileError."""
    if is_bag(path):
        found = contents(path, salvage=salvage)
        return contents_text(found), contents_json(found)
    if is_log(path):
        return log_contents(path)
    tables = look_at_columns(path)
    return columns_text(tables), columns_json(path, tables)
