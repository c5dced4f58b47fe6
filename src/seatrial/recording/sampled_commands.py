# SPDX-License-Identifier: MIT
"""Commands that a logger sampled: a change is at any time between two samples."""

from collections.abc import Sequence
from typing import Literal

from seatrial.recording.recording import Recording
from seatrial.recording.timing import Clock, Stream

COARSE_SAMPLING = 0.05  # [s] between samples of commands: as long as lags of thrusters, or longer
FINE_SAMPLING = 0.01  # [s] a logger with rows closer than this writes every command
Stated = bool | Literal["estimate"] | None  # what the vehicle file has


def sampled_commands(streams: Sequence[Stream], stated: Stated = None) -> Stream | None:
    """The commands that are or may be a logger's samples, as the vehicle file states, or as they seem to be.

    They seem so in an autopilot's log, in a table, or beside the poses, `FINE_SAMPLING` or more apart. A message
    of ROS is the command itself, and its stamp the time of the change.
    """
    places = {stream.source for stream in streams if stream.role == "poses"}
    for stream in streams:
        if stream.role != "commands" or not stream.rate or stream.on_change or stated is False:
            continue
        logged = stream.clock in (Clock.LOG, Clock.COLUMN) or stream.source in places
        if stated or (logged and 1.0 / stream.rate >= FINE_SAMPLING):
            return stream
    return None


def are_samples(stream: Stream, stated: Stated = None) -> bool:
    """Whether commands that may be samples are known to be.

    Those of an autopilot's log are, where they are rarer than its outputs change. Else it is open: rows may be of
    the controller that changed the command, at its row.
    """
    if isinstance(stated, bool):
        return stated
    rare = 1.0 / stream.rate >= COARSE_SAMPLING
    return stated is None and stream.clock is Clock.LOG and rare


def taken_halfway(stream: Stream) -> str:
    """What is done with sampled commands."""
    autopilot = stream.clock is Clock.LOG
    hint = " (ArduPilot: LOG_BITMASK with RCOUT at its fast rate)" if autopilot else ""
    return (
        f"the commands of {stream.source} are samples, {1.0 / stream.rate:.2g} s apart: each change counts as "
        "halfway between two of them, and the intervals include the error of this. For shorter intervals log the "
        f"commands at 50 Hz or more{hint}"
    )


def sampling_unknown(recording: Recording) -> bool:
    """Whether the commands may be samples, and the log does not tell."""
    return recording.command_period > 0.0 and not recording.command_sampled


def sampling_doubt(recording: Recording) -> list[str]:
    """The doubt on commands in the rows of the poses; a table of commands alone usually has every command."""
    places = {stream.source for stream in recording.streams if stream.role == "poses"}
    beside = any(s.role == "commands" and s.source in places for s in recording.streams)
    rare = recording.command_period >= COARSE_SAMPLING
    if not (beside and rare and sampling_unknown(recording)):
        return []
    return [
        f"the rows of the commands are {recording.command_period:.2g} s apart. If a logger sampled them, a change "
        "is up to that much older than its row. Latency, lag and dead zone are then off by more than their "
        "intervals say. Under 'commands:' in the vehicle file state 'sampled: true', or 'sampled: false' if each "
        "row is a new command"
    ]
