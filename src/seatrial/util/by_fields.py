# SPDX-License-Identifier: MIT
"""Frozen data that is copied and pickled by its fields alone: what it has computed is computed again."""

from dataclasses import fields
from typing import Any


class ByFields:
    """Base of dataclasses that keep values of the core, which have no pickle."""

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        values = (getattr(self, field.name) for field in fields(self))  # type: ignore[arg-type]
        return type(self), tuple(values)
