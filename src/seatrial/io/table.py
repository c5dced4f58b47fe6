# SPDX-License-Identifier: MIT
"""Tables of a recording: which files are tables, and their readers."""

from collections.abc import Collection
from pathlib import Path

from seatrial.io.tables.base import Table
from seatrial.io.tables.capture_table import capture_tables
from seatrial.io.tables.csv_table import CsvTable
from seatrial.io.tables.json_table import JSON, JsonTable
from seatrial.io.tables.mat_table import mat_tables
from seatrial.io.tables.parquet_table import ParquetTable
from seatrial.io.tables.tall_table import spread_out
from seatrial.util.errors import FileError, RecordingError

__all__ = ["CsvTable", "Table", "is_table", "open_tables"]

TABLES = (".csv", ".txt", ".tsv", ".tum", ".parquet", ".mat", ".jsonl", ".ndjson")
ALONE = (".json",)  # no table of a folder, where files of settings have the same name


def is_table(path: Path) -> bool:
    """Whether this is a table by its name, or a folder with one."""
    if path.is_dir():
        return any(file.suffix.lower() in TABLES and file.is_file() for file in path.iterdir())
    return path.suffix.lower() in (*TABLES, *ALONE)


def open_tables(path: Path, only: Collection[str] | None = None) -> dict[str, Table]:
    """Tables of a file by name, or of a folder by the names of its files. Raises RecordingError, FileError.

    A file with several tables in a folder gives `FILE:TABLE`. only: files of the folder to open.
    """
    if not path.is_dir():
        return {table.name: table for table in _open(path)}
    found: dict[str, Table] = {}
    for file in sorted(path.iterdir()):
        if file.suffix.lower() not in TABLES or not (only is None or file.name in only):
            continue
        try:
            tables = _open(file)
        except RecordingError:
            if only is None and file.suffix.lower() == ".txt":  # a note that lies beside the tables
                continue
            raise
        for table in tables:
            found[file.name if len(tables) == 1 else f"{file.name}:{table.name}"] = table
    return found


def _open(path: Path) -> list[Table]:
    """The tables of one file."""
    if not path.exists():
        raise FileError(f"{path}: no such file or folder")
    suffix = path.suffix.lower()
    if suffix == ".parquet":
        return [ParquetTable(path)]
    if suffix == ".mat":
        return mat_tables(path)
    if suffix in JSON:
        return [spread_out(JsonTable(path))]
    table = CsvTable(path)
    return [spread_out(table)] if table.joined is None else capture_tables(table, table.joined)
