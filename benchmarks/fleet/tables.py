# SPDX-License-Identifier: MIT
"""The findings of one boat, and the sums of all."""

from collections.abc import Sequence

import numpy as np

from benchmarks.fleet.work import Row
from seatrial.util.statistics import NORMAL_95

FAR = 4.0  # standard errors: worth a line


def line(row: Row) -> str:
    """Findings of one boat; empty where there are none."""
    far = {n: round(z, 1) for n, z in row.off.items() if abs(z) > FAR}
    parts = [f"refused: {row.refused}"] if row.refused else []
    parts += [f"{n} off by {z} standard errors" for n, z in far.items()]
    parts += [f"{n} not freed" for n in row.missed] if far else []
    parts += [f"{n} freed, is 1" for n in row.spurious]
    return "; ".join([*parts, *row.notes])


def sums(rows: Sequence[Row]) -> str:
    """Of all boats."""
    z = np.array([z for row in rows for z in row.off.values()])
    inside = 100.0 * np.mean(np.abs(z) < NORMAL_95)
    return "\n".join(
        [
            f"boats {len(rows)}, refused {sum(bool(r.refused) for r in rows)}, "
            f"with a remark {sum(bool(r.notes) for r in rows)}",
            f"estimates {len(z)}: {inside:.1f} % of 95 % intervals hold the truth; RMS error "
            f"{np.sqrt(np.mean(z**2)):.2f} standard errors, largest {np.abs(z).max():.1f}",
            f"stages of the curve that a boat has and that were not freed {sum(len(r.missed) for r in rows)}, "
            f"freed though it has none {sum(len(r.spurious) for r in rows)}",
        ]
    )
