# SPDX-License-Identifier: MIT
"""Topics or columns of a recording, before there is a vehicle file."""

from pathlib import Path
from typing import Any

from seatrial.io.bags.contents import contents, contents_json, contents_text
from seatrial.io.bags.opening import is_bag
from seatrial.io.columns import columns_json, columns_text, look_at_columns


def look(path: Path, *, salvage: bool = False) -> tuple[str, dict[str, Any]]:
    """The contents as text and as JSON. Raises RecordingError, FileError."""
    if is_bag(path):
        found = contents(path, salvage=salvage)
        return contents_text(found), contents_json(found)
    tables = look_at_columns(path)
    return columns_text(tables), columns_json(path, tables)
