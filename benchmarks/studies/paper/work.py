# SPDX-License-Identifier: MIT
"""One job of the study."""

from typing import Any

from benchmarks.studies.paper import coupling, maps, minutes, open_points, payload, tables
from seatrial.util.errors import SeatrialError

FINDINGS = {
    "tables": tables, "coupling": coupling, "open": open_points, "minutes": minutes, "maps": maps,
    "payload": payload,
}  # fmt: skip


def one(name: str, *key: Any) -> dict[str, Any]:  # noqa: ANN401
    """The record of a finding at a key: what was found, or why nothing was."""
    record: dict[str, Any] = {"finding": name, "key": list(key)}
    try:
        record["found"] = FINDINGS[name].work(*key)
    except SeatrialError as failure:
        record["failed"] = str(failure)
    return record
