# SPDX-License-Identifier: MIT
"""Functions of rooms above, for the methods of data below: `model.plot()`, `Recording.from_dataframe()`.

Imports go down only (`tests/test_layers.py`). A method that shows or converts its own data calls a function of
a room above by name; the room is loaded at the call.
"""

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for annotations: neither is loaded
    from matplotlib.figure import Figure
    from pandas import DataFrame

__all__ = ["DataFrame", "Figure", "above", "text_by"]


def above(module: str, function: str) -> Any:  # noqa: ANN401
    """A function of `seatrial.MODULE`, loaded now."""
    return getattr(import_module(f"seatrial.{module}"), function)


def text_by(module: str, function: str) -> Callable[[Any], str]:
    """A method whose text is made by a function of `seatrial.MODULE`, loaded at the call."""
    return lambda data: str(above(module, function)(data))
