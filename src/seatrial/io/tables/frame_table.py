# SPDX-License-Identifier: MIT
"""A DataFrame of pandas as a table."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from seatrial.io.tables.base import NO_ROWS, Table, first_line, unique_names
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

if TYPE_CHECKING:
    from pandas import DataFrame, Series

UNNAMED_INDEX = "index"


class FrameTable(Table):
    """Columns of a DataFrame. Its index is a column, too, where it has a name or holds times."""

    in_file = False

    def __init__(self, frame: "DataFrame", name: str) -> None:
        import pandas as pd

        super().__init__(Path(name), name)
        if not isinstance(frame, pd.DataFrame):
            raise RecordingError(f"{name}: expected a DataFrame, got {type(frame).__name__}")
        for where, index in (("columns", frame.columns), ("rows", frame.index)):
            if isinstance(index, pd.MultiIndex):
                raise RecordingError(
                    f"{name}: the index of the {where} has {index.nlevels} levels, expected one; flatten it"
                )
        if not len(frame):
            raise RecordingError(f"{name}: has columns {NO_ROWS}")
        own = frame.index
        timed = isinstance(own, (pd.DatetimeIndex, pd.TimedeltaIndex, pd.PeriodIndex))
        columns = [frame.iloc[:, i] for i in range(frame.shape[1])]
        found = [str(column) for column in frame.columns]
        if own.name is not None or timed:
            columns.append(own.to_series())
            found.append(UNNAMED_INDEX if own.name is None else str(own.name))
        self.names, self.remarks = unique_names(found)
        self._columns: dict[str, Series] = dict(zip(self.names, columns, strict=True))

    def _texts(self, name: str) -> list[str] | None:
        """Python's objects, too."""
        import pandas as pd

        column = self._columns[name]
        kind = pd.api.types
        if kind.is_numeric_dtype(column.dtype) or self._timed(column):
            return None
        return [
            "" if empty else str(cell) for cell, empty in zip(column, column.isna(), strict=True)
        ]

    def typed_stamps(self, name: str) -> Stamps | None:
        """A column (n,) of times [ns], `EMPTY_STAMP` in empty cells; None of another type.

        With a time zone they are in UTC; without one they count as UTC.
        """
        import pandas as pd

        self.find(name)
        column = self._columns[name]
        if not self._timed(column):
            return None
        if isinstance(column.dtype, pd.PeriodDtype):
            column = column.dt.to_timestamp()
        try:
            if column.dtype.kind == "M" and column.dt.tz is not None:
                column = column.dt.tz_convert(None)
            cells = column.to_numpy()
            given = cells.astype("timedelta64[ns]" if cells.dtype.kind == "m" else "datetime64[ns]")
            exact = given.astype(cells.dtype) == cells
        except (OverflowError, ValueError) as error:
            raise RecordingError(
                f"{self.path}: column '{name}' has a time that is out of range ({first_line(error)})"
            ) from None
        lost = ~exact & ~np.asarray(column.isna())
        if lost.any():
            row = int(np.flatnonzero(lost)[0])
            raise RecordingError(f"{self.place(row)}: column '{name}' has a time out of range")
        return np.asarray(np.where(column.isna(), self.EMPTY_STAMP, given.astype(np.int64)))

    @staticmethod
    def _timed(column: "Series") -> bool:
        import pandas as pd

        return isinstance(column.dtype, pd.PeriodDtype) or column.dtype.kind in "mM"

    def _numbers(self, name: str) -> Array:
        column = self._columns[name]
        if column.dtype.kind == "c":
            raise RecordingError(
                f"{self.path}: column '{name}' has complex numbers, expected real ones"
            )
        return np.asarray(column.to_numpy(dtype=float, na_value=np.nan))


def pandas_for(what: str) -> Any:  # noqa: ANN401
    """The library. Raises RecordingError where it is not installed."""
    try:
        import pandas as pd
    except ImportError:
        raise RecordingError(
            f"{what}: data frames need pandas: pip install 'seatrial[pandas]'"
        ) from None
    return pd
