# SPDX-License-Identifier: MIT
"""Commands that a logger sampled: a change is at any time between two samples."""

from collections.abc import Sequence

from seatrial.recording.recording import Recording
from seatrial.recording.timing import Clock, Stream

COARSE_SAMPLING = 0.05  # [s] between samples of commands: as long as lags of thrusters, or longer


def sampled_commands(streams: Sequence[Stream], stated: bool | None = None) -> Stream | None:
    """The commands that are a logger's samples, as the vehicle file states, or as they seem to be.

    They seem so, `COARSE_SAMPLING` or more apart, in an autopilot's log, or as a column beside the poses. A
    message of ROS is the command itself, and its stamp the time of the change.
    """
    places = {stream.source for stream in streams if stream.role == "poses"}
    for stream in streams:
        if stream.role != "commands" or not stream.rate or stream.on_change or stated is False:
            continue
        logged = stream.clock is Clock.LOG or stream.source in places
        if stated or (logged and 1.0 / stream.rate >= COARSE_SAMPLING):
            return stream
    return None


def taken_halfway(stream: Stream) -> str:
    """What is done with sampled commands."""
    autopilot = stream.clock is Clock.LOG
    hint = " (ArduPilot: LOG_BITMASK with RCOUT at its fast rate)" if autopilot else ""
    return (
        f"the commands of {stream.source} are samples, {1.0 / stream.rate:.2g} s apart: each change counts as "
        "halfway between two of them, and the intervals include the error of this. For shorter intervals log the "
        f"commands at 50 Hz or more{hint}"
    )


def sampling_doubt(recording: Recording) -> list[str]:
    """The doubt where it is open whether the commands are samples."""
    if recording.command_period == 0.0 or recording.command_sampled:
        return []
    return [
        f"the rows of the commands are {recording.command_period:.2g} s apart. If a logger sampled them, a change "
        "is up to that much older than its row. Latency, lag and dead zone are then off by more than their "
        "intervals say. Under 'commands:' in the vehicle file state 'sampled: true', or 'sampled: false' if each "
        "row is a new command"
    ]
