# SPDX-License-Identifier: MIT
"""What columns a table has: the first look, before there is a vehicle file."""

from pathlib import Path

import numpy as np

from seatrial.errors import FileError
from seatrial.frames import Array
from seatrial.io.table import Table

EPOCHS = ((1e17, "ns", 1e9), (1e14, "us", 1e6), (1e11, "ms", 1e3), (0.0, "s", 1.0))


def columns_text(path: Path) -> str:
    """Name and range of every numeric column of a table, or of the tables in a folder."""
    tables = sorted(path.glob("*.csv")) if path.is_dir() else [path]
    if not tables:
        raise FileError(f"{path}: no .csv file in this folder")
    return "\n".join(_table_text(Table(table)) for table in tables)


def _table_text(table: Table) -> str:
    values = table.columns(table.names)
    width = max(len(name) for name in table.names)
    lines = [f"{table.path}: {len(values)} rows"]
    for name, column in zip(table.names, values.T, strict=True):
        lines.append(f"  {name:<{width}}  {_column_text(column)}")
    return "\n".join([*lines, "  => name them in a vehicle file, and pass it with --vehicle"])


def _column_text(column: Array) -> str:
    given = column[np.isfinite(column)]
    if len(given) == 0:
        return "no numbers"
    text = f"{given.min():.6g} to {given.max():.6g}"
    missing = len(column) - len(given)
    text += f", {missing} empty" if missing else ""
    steps = np.diff(given)
    if len(steps) > 2 and np.all(steps >= 0) and np.median(steps) > 0:
        unit, scale = next((u, s) for least, u, s in EPOCHS if given.max() >= least)
        text += f"; rises all the way: stamps in {unit}? {scale / float(np.median(steps)):.4g} Hz"
    elif len(np.unique(given)) == 1:
        text += "; never changes"
    return text
