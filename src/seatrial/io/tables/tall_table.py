# SPDX-License-Identifier: MIT
"""A table whose rows are of several signals, as a column tells, with a column for each signal."""

from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from seatrial.io.tables.base import Table, unique_names
from seatrial.io.tables.stamps import from_date_times
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

# last part of the dotted name of the column that says what a row is of, without underscores around it
KEYS = (
    "id", "field", "name", "topic", "path", "type", "signal", "channel", "thruster", "motor", "actuator",
    "variable", "parameter",
)  # fmt: skip
MOST_KEYS = 64  # signals of a table: more are a counter
LEAST_ROWS = 10  # of each signal
GAP = 3.0  # usual steps of a signal, above which it has a gap
MOST_GAPS = 0.2  # of its time: a state that comes and goes has more, and is no signal's name


class TallTable(Table):
    """Rows with one stamp are one row; a cell without a value is NaN."""

    def __init__(self, rows: Table, stamp: str, key: str, keys: Sequence[str]) -> None:
        super().__init__(rows.path, rows.name)
        own = _of_rows(rows, key)
        cells = rows.cells(stamp)
        _, first, at = np.unique(_clock(rows, cells), return_index=True, return_inverse=True)
        stamps = [cells[i] for i in first.tolist()] if isinstance(cells, list) else cells[first]
        columns, names = [], []
        values = _varying(rows, (stamp, key), own)
        filled = {n: [k for k in keys if np.isfinite(c[own == k]).any()] for n, c in values.items()}
        shared = [k for of in filled.values() if len(of) > 1 for k in of]
        for name, column in values.items():
            for one in filled[name]:
                mine = own == one
                spread = np.full(len(first), np.nan)
                spread[at[mine]] = column[mine]
                columns.append(spread)
                plain = shared.count(one) == 1 and not one.isdecimal()
                both = one if plain else f"{name} {one}"
                names.append(name if len(filled[name]) == 1 else both)
        self.names = unique_names([stamp, *names])[0]
        self._columns = dict(zip(self.names, [stamps, *columns], strict=True))
        shown = ", ".join(keys[:4])
        text = f"its rows are of several signals, by '{key}': {shown}; each is a column"
        self.remarks = [*rows.remarks, text]

    def _texts(self, name: str) -> list[str] | None:
        column = self._columns[name]
        return column if isinstance(column, list) else None

    def _numbers(self, name: str) -> Array:
        return np.asarray(self._columns[name])


def spread_out(table: Table) -> Table:
    """The table with a column for each signal, where its rows are of several; else as it is."""
    parts = {name: name.rpartition(".")[2].strip().strip("_").lower() for name in table.names}
    named = [name for name, part in parts.items() if part in KEYS]
    for key in named:
        with suppress(RecordingError):
            own = _of_rows(table, key)
            keys, counts = np.unique(own, return_counts=True)
            if not 2 <= len(keys) <= MOST_KEYS or counts.min() < LEAST_ROWS or "" in keys:
                continue
            stamp = next((n for n in table.names if n != key and _is_clock(table, n, own)), None)
            if stamp is not None and _varying(table, (stamp, key), own):
                return TallTable(table, stamp, key, [str(k) for k in keys])
    return table


def _of_rows(table: Table, key: str) -> NDArray[np.str_]:
    """What each row is of."""
    texts = table.texts(key)
    if texts is None:
        values, at = np.unique(table.columns([key])[:, 0], return_inverse=True)
        return np.array([f"{value:.15g}" for value in values])[at]
    return np.array([text.strip() for text in texts])


def _is_clock(table: Table, name: str, own: NDArray[np.str_]) -> bool:
    """Whether a column has the times of every signal."""
    try:
        clock = _clock(table, table.cells(name))
    except RecordingError:
        return False
    if not np.isfinite(clock).all():
        return False
    ends = clock.min(), clock.max()
    return all(_steady(clock[own == key], *ends) for key in np.unique(own))


def _clock(table: Table, cells: Array | list[str]) -> Array | Stamps:
    """Cells (n,) as times, in any unit. Raises RecordingError."""
    return from_date_times(cells, "", table.place) if isinstance(cells, list) else cells


def _steady(clock: Array | Stamps, begin: float, end: float) -> bool:
    """Whether a signal's times rise from begin to end, hardly with a gap."""
    steps = np.diff(clock)
    usual = float(np.median(steps))
    if usual <= 0.0 or np.any(steps < 0):
        return False
    whole = np.array([clock[0] - begin, *steps, end - clock[-1]], dtype=float)
    return float(whole[whole > GAP * usual].sum()) < MOST_GAPS * float(end - begin)


def _varying(table: Table, others: Sequence[str], own: NDArray[np.str_]) -> dict[str, Array]:
    """Columns of numbers that change in the rows of a signal."""
    found = {}
    for name, column in zip(table.names, table.numbers().T, strict=True):
        parts = [column[own == key] for key in np.unique(own)]
        parts = [part[np.isfinite(part)] for part in parts]
        if name not in others and any(len(part) and np.ptp(part) > 0 for part in parts):
            found[name] = column
    return found
