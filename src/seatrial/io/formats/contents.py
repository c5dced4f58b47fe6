# SPDX-License-Identifier: MIT
"""The contents of an autopilot's log by topic, before there is a vehicle file."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from seatrial.io.formats import open_log
from seatrial.io.formats.known import role
from seatrial.io.log import Log, Wanted
from seatrial.recording.timing import STREAM_HEAD, Stream, describe, stream_cells
from seatrial.util.errors import printable
from seatrial.util.format import table
from seatrial.util.progress import stage

OPENED = 0.4  # of the time
MOST_FIELDS = 8  # of a topic, listed


def log_contents(path: Path) -> tuple[str, dict[str, Any]]:
    """The topics as text and as JSON. Raises RecordingError, FileError."""
    with stage("", OPENED):
        log = open_log(path)
    streams, length = _streams(log)
    return _text(log, streams, length), {
        "path": str(path),
        "kind": log.kind,
        "length": length,
        "topics": [
            {
                **msgspec.to_builtins(s),
                "role": s.role or None,
                "fields": list(log.topics[s.source].fields),
                "units": dict(log.topics[s.source].units),
            }
            for s in streams
        ],
        "parameters": dict(log.parameters),
        "remarks": list(log.remarks),
    }


def _streams(log: Log) -> tuple[list[Stream], float]:
    """Streams of all topics, and the log's length [s]."""
    topics = list(log.topics.values())
    samples = log.read([Wanted(t.name, ()) for t in topics])
    pairs = zip(topics, (s.stamps for s in samples), strict=True)
    streams = [describe(role(t), t.name, t.type, clock=log.clock, stamps=s) for t, s in pairs]
    stamps = np.concatenate([s.stamps for s in samples])
    return streams, 1e-9 * int(np.ptp(stamps)) if len(stamps) else 0.0


def _text(log: Log, streams: list[Stream], length: float) -> str:
    parameters = f", {len(log.parameters)} parameters" if log.parameters else ""
    lines = [f"{log.path}: {log.kind}, {length:.1f} s, {len(streams)} topics{parameters}"]
    rows = []
    for s in streams:
        fields = log.topics[s.source].fields
        more = f", ... ({len(fields)})" if len(fields) > MOST_FIELDS else ""
        cells = (s.source, *stream_cells(s), s.role, ", ".join(fields[:MOST_FIELDS]) + more)
        rows.append([printable(cell, keep="") for cell in cells])
    lines.append(table(("topic", *STREAM_HEAD, "could be", "fields"), rows, text=(0, 4, 5)))
    lines += [f"  => {remark}" for remark in log.remarks]
    roles = ", ".join(s.role for s in streams)
    for wanted in ("position", "heading", "commands"):
        if wanted not in roles:
            lines.append(
                f"  => no topic holds a {wanted.removesuffix('s')} that is known by its name"
            )
    return printable("\n".join(lines))
