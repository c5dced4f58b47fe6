# SPDX-License-Identifier: MIT
"""Frozen data: a base that is copied and pickled by its fields alone, and what is computed once of each."""

from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

Data = TypeVar("Data")
Found = TypeVar("Found")


class ByFields:
    """Base of dataclasses that keep values of the core, which have no pickle: these are computed again."""

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        values = (getattr(self, field.name) for field in fields(self))  # type: ignore[arg-type]
        return type(self), tuple(values)


def once(function: Callable[[Data], Found]) -> Callable[[Data], Found]:
    """Keeps what a function finds in frozen data, which are compared by identity, as long as the data live."""
    known: WeakKeyDictionary[Data, Found] = WeakKeyDictionary()

    @wraps(function)
    def found(data: Data) -> Found:
        if data not in known:
            known[data] = function(data)
        return known[data]

    return found
