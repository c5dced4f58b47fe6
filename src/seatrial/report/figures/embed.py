# SPDX-License-Identifier: MIT
"""Figures as compact JSON that is safe inside a script element.

A numpy array in a figure becomes `{"column": i}`. Column i is stored once however many plots use
it: `[e, d1, d2, ...]`, each d the step from the last number before it in units of 10^e, or null.
"""

import json
from collections.abc import Mapping

import numpy as np

from seatrial.util.frames import Array

COLUMN_DIGITS = 5  # significant digits of a column's largest number
WIDE_SPAN = 100.0  # largest over smallest: above it a column may be on a logarithmic axis
SMALLEST_DIGITS = 4  # significant digits of the smallest number of such a column


def pack(figures: Mapping[str, object]) -> str:
    """Figures by name as JSON: `{"columns": [...], "figures": {...}}`."""
    columns: list[list[int | None]] = []
    known: dict[bytes, int] = {}

    def walk(value: object) -> object:
        if isinstance(value, np.ndarray):
            key = value.tobytes()
            if key not in known:
                known[key] = len(columns)
                columns.append(encode(value))
            return {"column": known[key]}
        if isinstance(value, Mapping):
            return {str(name): walk(part) for name, part in value.items()}
        if isinstance(value, (list, tuple)):
            return [walk(part) for part in value]
        if isinstance(value, float):
            return rounded(value)
        return value

    packed = walk(figures)
    return safe_json({"columns": columns, "figures": packed})


def safe_json(content: object) -> str:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(content, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def rounded(value: float) -> float | None:
    """A number with `COLUMN_DIGITS` significant digits; null where it is none."""
    return float(f"{value:.{COLUMN_DIGITS}g}") if np.isfinite(value) else None


def encode(values: Array) -> list[int | None]:
    """A column as exponent and steps."""
    flat = np.asarray(values, dtype=float).ravel()
    finite = np.isfinite(flat)
    exponent = _exponent(flat[finite])
    whole = np.rint(flat[finite] / 10.0**exponent).astype(np.int64)
    steps = iter(np.diff(whole, prepend=0).tolist())
    return [exponent, *(next(steps) if good else None for good in finite.tolist())]


def _exponent(values: Array) -> int:
    """Power of ten that values are given in."""
    largest = float(np.abs(values).max(initial=0.0))
    if largest == 0.0:
        return 0
    exponent = int(np.floor(np.log10(largest))) - COLUMN_DIGITS + 1
    smallest = float(values.min())
    if largest <= WIDE_SPAN * smallest or smallest <= 0.0:
        return exponent
    return max(
        min(exponent, int(np.floor(np.log10(smallest))) - SMALLEST_DIGITS + 1),
        exponent - COLUMN_DIGITS,
    )


def decode(column: list[int | None]) -> Array:
    """The numbers of a column, NaN where null: as `report.js`."""
    exponent = column[0] or 0
    steps = np.array([0 if d is None else d for d in column[1:]], dtype=np.int64)
    total = np.cumsum(steps)
    found = total / 10.0**-exponent if exponent < 0 else total * 10.0**exponent
    return np.where([d is None for d in column[1:]], np.nan, found)
