# SPDX-License-Identifier: MIT
"""One piece of the study's work: what a worker process is sent."""

from typing import Any

from benchmarks.paper import coupling, maps, minutes, open_points, tables

FINDINGS = {
    "tables": tables, "coupling": coupling, "open": open_points, "minutes": minutes, "maps": maps,
}  # fmt: skip


def one(name: str, key: tuple[Any, ...]) -> dict[str, Any]:
    """The record of a finding at a key."""
    return {"finding": name, "key": list(key), "found": FINDINGS[name].work(*key)}
