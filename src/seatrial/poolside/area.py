# SPDX-License-Identifier: MIT
"""The area that a boat may drive in: a pool's walls, in the map frame of the poses."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final, Literal

import numpy as np

from seatrial.boat.schema import Strict
from seatrial.util.errors import FileError
from seatrial.util.files import convert, expect_format, read_yaml
from seatrial.util.frames import Array, Mask, frozen_array

AREA_FORMAT: Final = "area 1"
SIZE = re.compile(r"([0-9.]+) *[xX] *([0-9.]+)")  # length x width [m]
MIDDLE_GRID = 41  # places along each side of the bounding box where the middle is sought


class AreaFile(Strict, frozen=True):
    """`walls.yaml`."""

    seatrial: Literal["area 1"]
    corners: Sequence[tuple[float, float]]  # x, y [m] in order around the area


@dataclass(frozen=True)
class Area:
    """A simple polygon of walls, in either direction of rotation."""

    corners: Array  # (n, 2) [m]

    def __post_init__(self) -> None:
        corners = np.asarray(self.corners, dtype=float)
        if corners.ndim != 2 or corners.shape[1:] != (2,) or len(corners) < 3:
            raise FileError(
                f"walls: expected three corners x, y [m] or more, got {self.corners!r:.80}"
            )
        object.__setattr__(self, "corners", frozen_array(corners))
        if not np.isfinite(corners).all() or self.size == 0.0:
            raise FileError("walls: expected finite corners [m] around an area")

    @cached_property
    def size(self) -> float:
        """Area [m^2] by the shoelace formula."""
        x, y = self.corners.T
        return float(0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    @cached_property
    def middle(self) -> tuple[float, float]:
        """The place [m] that is furthest from the walls, on a grid."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        x, y = np.meshgrid(
            *(np.linspace(a, b, MIDDLE_GRID) for a, b in zip(low, high, strict=True))
        )
        places = np.column_stack([x.ravel(), y.ravel()])
        margins = self.margins(places)
        # of equal places the mean: a long pool has a line of them
        best = places[margins >= margins.max() - 1e-9].mean(axis=0)
        if self.margin(*best.tolist()) < margins.max() - 1e-9:
            best = places[int(np.argmax(margins))]
        return float(best[0]), float(best[1])

    def margin(self, x: float, y: float) -> float:
        """Distance [m] from the walls; negative outside."""
        return float(self.margins(np.array([[x, y]]))[0])

    def margins(self, places: Array) -> Array:
        """Distances (n,) [m] of places (n, 2) from the walls; negative outside."""
        begin, side = self.corners, np.roll(self.corners, -1, axis=0) - self.corners
        off = places[:, None, :] - begin  # (n, walls, 2)
        along = np.sum(off * side, axis=2) / np.maximum(np.sum(side**2, axis=1), 1e-300)
        nearest = off - np.clip(along, 0.0, 1.0)[:, :, None] * side
        distance = np.sqrt(np.sum(nearest**2, axis=2)).min(axis=1)
        return np.asarray(np.where(self._inside(places), distance, -distance))

    def _inside(self, places: Array) -> Mask:
        """By the parity of walls that a ray along x crosses."""
        (x0, y0), (x1, y1) = self.corners.T, np.roll(self.corners, -1, axis=0).T
        x, y = places[:, :1], places[:, 1:2]
        spans = (y0 > y) != (y1 > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossed = spans & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        return np.asarray(crossed.sum(axis=1) % 2 == 1)


def rectangle(length: float, width: float, x: float = 0.0, y: float = 0.0) -> Area:
    """A rectangle around x, y [m], its length along x."""
    half = np.array([length, width]) / 2.0
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return Area(corners * half + np.array([x, y]))


def read_walls(text: str | Path) -> Area:
    """Walls from `--walls`: a size as 3.6x2.4 [m] around the origin, or a file. Raises FileError."""
    size = SIZE.fullmatch(str(text).strip())
    if size is not None:
        return rectangle(_metres(size[1]), _metres(size[2]))
    if not Path(text).is_file():
        raise FileError(
            f"--walls {text}: no such file. Give a size in metres, as 3.6x2.4, or a file with "
            f"seatrial: {AREA_FORMAT} and corners: [[x, y], ...]"
        )
    content = expect_format(read_yaml(Path(text)), AREA_FORMAT, text)
    return Area(np.array(convert(content, AreaFile, text).corners, dtype=float))


def _metres(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise FileError(f"--walls: {text} is not a length in metres") from None
