# SPDX-License-Identifier: MIT
"""Topics or columns of a recording, before there is a vehicle file."""

from pathlib import Path
from typing import Any

import msgspec

from seatrial.io.bags.contents import contents, contents_json, contents_text
from seatrial.io.bags.opening import is_bag, open_bag
from seatrial.io.columns import columns_text, read_tables
from seatrial.io.formats import is_log
from seatrial.io.formats.contents import log_contents


def look(path: Path, *, salvage: bool = False) -> tuple[str, dict[str, Any]]:
    """The contents as text and as JSON. Raises RecordingError, FileError."""
    if is_bag(path):
        with open_bag(path, salvage=salvage) as bag:
            found = contents(bag, path)
        return contents_text(found), contents_json(found)
    if is_log(path):
        return log_contents(path)
    tables = [seen.view for seen in read_tables(path)]
    content = {"path": str(path), "kind": "tables", "tables": msgspec.to_builtins(tables)}
    return columns_text(tables), content
