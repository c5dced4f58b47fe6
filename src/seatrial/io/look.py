# SPDX-License-Identifier: MIT
"""The first look at a recording, before there is a vehicle file: topics, or columns."""

from pathlib import Path
from typing import Any

from seatrial.io.bags.contents import contents, contents_json, contents_text
from seatrial.io.bags.opening import is_bag
from seatrial.io.columns import columns_json, columns_text, look_at_columns


def look(path: Path, *, salvage: bool = False) -> tuple[str, dict[str, Any]]:
    """What is there, in words and for programs. Raises RecordingError, FileError."""
    if is_bag(path):
        found = contents(path, salvage=salvage)
        return contents_text(found), contents_json(found)
    tables = look_at_columns(path)
    return columns_text(tables), columns_json(path, tables)
