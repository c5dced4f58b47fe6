# SPDX-License-Identifier: MIT
"""A recorded signal: commands, or what thrust depends on, with stamps of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps, freeze

KEPT_BEFORE = 10.0  # [s] of commands before a cut, for latency and lag
KEPT_AFTER = 1.0  # [s] of commands after it: a late clock looks like a negative latency


@dataclass(frozen=True, eq=False)
class Signal:
    """Rows of values with integer stamps, zero-order hold.

    names: of the columns
    stamps: (n,) [ns], rising
    values: (n, names)
    """

    names: tuple[str, ...]
    stamps: Stamps
    values: Array

    def __post_init__(self) -> None:
        freeze(self, "stamps", dtype=np.int64)
        freeze(self, "values")
        if self.values.shape != (len(self.stamps), len(self.names)):
            raise RecordingError(
                f"signal {', '.join(self.names)}: {len(self.stamps)} stamps but values of shape "
                f"{self.values.shape}"
            )
        if np.any(np.diff(self.stamps) <= 0):
            raise RecordingError(f"signal {', '.join(self.names)}: stamps must rise")

    def cut(self, start: int, end: int) -> Signal:
        """Rows in [start, end) [ns], with `KEPT_BEFORE` and `KEPT_AFTER` around it.

        The row that holds where they begin moves there.
        """
        start -= round(KEPT_BEFORE * 1e9)
        end += round(KEPT_AFTER * 1e9)
        first = int(np.searchsorted(self.stamps, start, side="right")) - 1
        keep = (self.stamps >= start) & (self.stamps < end)
        stamps, values = self.stamps[keep], self.values[keep]
        if first >= 0 and self.stamps[first] < start:
            stamps = np.concatenate([[start], stamps])
            values = np.concatenate([self.values[first : first + 1], values])
        return Signal(self.names, stamps, values)
