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
    return (
        f"the commands of {stream.source} are samples, {1.0 / stream.rate:.2g} s apart: each change counts as "
        "halfway between two of them, and the intervals have the error of that. Commands logged at 50 Hz or more "
        "give better ones (ArduPilot: LOG_BITMASK with RCOUT at its fast rate)"
    )


def sampling_doubt(recording: Recording) -> list[str]:
    """The doubt where it is open whether the commands are samples."""
    if recording.command_period == 0.0 or recording.command_sampled:
        return []
    return [
        f"rows of the commands are {recording.command_period:.2g} s apart: where a logger looked at the commands, "
        "one changed up to that long before its row; then latency, lag and dead zone are off by more than their "
        "intervals say. State in the vehicle file, below commands, 'sampled: true', or 'sampled: false' where "
        "each changed at its row"
    ]
