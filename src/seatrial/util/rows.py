# SPDX-License-Identifier: MIT
"""Numbers that a caller gives: arguments, commands, poses, covariances."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array


def numbers(
    values: ArrayLike,
    what: str,
    shape: tuple[int, ...],
    error: type[SeatrialError],
    expected: str = "",
) -> Array:
    """Numbers of a shape, NaN allowed. Raises `error`."""
    wanted = expected or f"{shape}"
    try:
        found = np.asarray(values, dtype=float, order="C")
    except (TypeError, ValueError):
        raise error(f"{what} {values!r}; expected {wanted}") from None
    if found.shape != shape:
        raise error(f"{what} of shape {found.shape}; expected {wanted}")
    return found


def row_of(values: ArrayLike, what: str, names: Sequence[str], error: type[SeatrialError]) -> Array:
    """One number (n,) for each of n names, NaN allowed. Raises `error`."""
    return numbers(values, what, (len(names),), error, _for_each(names))


def finite_row(
    values: ArrayLike, what: str, names: Sequence[str], error: type[SeatrialError]
) -> Array:
    """The same, of finite numbers."""
    row = row_of(values, what, names, error)
    if not np.isfinite(row).all():
        raise error(f"{what} {row.tolist()}; expected {_for_each(names)}, all finite")
    return row


def _for_each(names: Sequence[str]) -> str:
    return f"{len(names)} numbers: {', '.join(names) or 'none'}"
