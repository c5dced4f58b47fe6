# SPDX-License-Identifier: MIT
"""What the timing and the values of signals show: the number, what it means, what to do."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from seatrial.poolside.signal_stream import SIGNALS, WINDOW, SignalStream, StreamTiming
from seatrial.poolside.sources.source import EventKind
from seatrial.poolside.state import Level
from seatrial.recording.faults.pose_faults import GAP_FACTOR
from seatrial.recording.other_clock import FACTOR_SLACK, FACTORS, other_zone
from seatrial.util.frames import NS_PER_S

MISSING = 2.0  # [s] after which a signal that has not arrived is missing
STOPPED = 1.0  # [s] least silence after which a periodic signal has stopped
STOPPED_STEPS = 10.0  # usual steps, the same
OWN_CLOCK = 10.0  # [s] from this machine's clock, above which stamps are of a clock of their own
LATE, AHEAD = 0.5, 0.1  # [s] of stamps behind and ahead of this machine's clock that are reported
APART = 0.5  # [s] between the delays of poses and commands: two clocks
PACE = 1.5  # ratio of stamps to arrivals, or its inverse, above which their unit is wrong
CONSTANT = 10.0  # [s] without any change, of a command
DRIVEN = 60.0  # [s] after which saturation is judged
SATURATED = 0.5  # of all rows at the largest value
RAW = 10.0  # command units: a larger command is a raw number, as PWM
FROZEN = 2.0  # [s] of exactly equal poses under changing commands
PARTS: dict[EventKind, str] = {
    "pose": "poses", "position": "positions", "heading": "headings", "command": "commands", "scale": "scales",
}  # fmt: skip
POSES = "nothing can be estimated; start the tracker, and check its port, topic or columns"
ADVICE: dict[EventKind, str] = {
    "command": "no coefficient can be estimated; drive, and check the columns or topic of the commands",
    "scale": "thrust can't be scaled; check the columns or topic of the scales",
}


@dataclass(frozen=True)
class Found:
    """What was found in a signal."""

    level: Level
    text: str
    line: str = ""  # of the vehicle file, as it should be


def missing(kind: EventKind, waited: float, problem: str = "") -> Found:
    """A signal of which nothing has arrived for `waited` [s]. problem: why, where the source knows."""
    if waited < MISSING:
        return Found("ok", f"waiting for {PARTS[kind]}")
    return Found(
        "error", f"no {PARTS[kind]} for {waited:.0f} s: {problem or ADVICE.get(kind, POSES)}"
    )


def clock_findings(kind: EventKind, timings: Mapping[EventKind, StreamTiming]) -> Iterator[Found]:
    """Units and clocks of the stamps."""
    own = timings[kind]
    if own.pace is not None and not 1.0 / PACE < own.pace < PACE:
        yield Found(
            "error", f"stamps advance {own.pace:.3g} s in one second: {_pace_advice(own.pace)}"
        )
        return
    if own.pace is None:  # all rows at once: their arrival shows nothing
        return
    poses = next((timings[k] for k in ("pose", "position") if k in timings), None)
    apart = own.delay - poses.delay if poses is not None and kind in SIGNALS else 0.0
    if abs(apart) > APART:
        yield Found("error", _apart(apart))
    elif -OWN_CLOCK < own.delay < -AHEAD:
        yield Found(
            "warning",
            f"stamps are {-own.delay:.3g} s ahead of this machine's clock; synchronise the clocks. The estimate "
            "is right while poses and commands have one clock",
        )
    elif LATE < own.delay < OWN_CLOCK:
        yield Found(
            "warning",
            f"{PARTS[kind]} arrive {own.delay:.3g} s after their stamps: what is shown is as late; look for a "
            "slow network, or synchronise the clocks",
        )


def _pace_advice(pace: float) -> str:
    factor = max(pace, 1.0 / max(pace, 1e-12))
    if any(abs(factor / f - 1.0) < FACTOR_SLACK for f in FACTORS):
        return "they are in another unit (ms, us or ns instead of s, or the reverse); correct it"
    return "the clock that stamps them is wrong; stamp by the system's clock"


def _apart(apart: float) -> str:
    """Stamps of commands `apart` [s] behind those of the poses, at equal arrival."""
    zone = other_zone(np.array([0.0, 1.0]), np.array([-apart, 1.0 - apart]))
    side = "behind" if apart > 0 else "ahead of"
    return zone or (
        f"stamps are {abs(apart):.3g} s {side} those of the poses: two clocks; stamp both by one clock, or "
        "synchronise them"
    )


def step_findings(stream: SignalStream, timing: StreamTiming, now: int) -> Iterator[Found]:
    """Silence, order and gaps."""
    parts = PARTS[stream.kind]
    silent = (now - stream.newest[1]) / NS_PER_S
    periodic = stream.kind not in SIGNALS or timing.regular
    if periodic and silent > max(STOPPED, STOPPED_STEPS * timing.usual):
        yield Found(
            "error", f"no {parts} for {silent:.1f} s: they have stopped; check sender and network"
        )
    if timing.backward:
        yield Found(
            "warning",
            f"{timing.backward} stamps of the last {WINDOW:.0f} s are not after the one before: such rows are "
            "left out. Look for two senders, a sender that stamps twice, or a clock that was set back",
        )
    if periodic and timing.usual and timing.longest > max(STOPPED, GAP_FACTOR * timing.usual):
        yield Found(
            "warning",
            f"a gap of {timing.longest:.1f} s in the last {WINDOW:.0f} s: the {parts} are not bridged. Keep the "
            "boat in view, and check the network",
        )


def command_findings(
    name: str, stream: SignalStream, i: int, now: int, mend: str = ""
) -> Iterator[Found]:
    """Raw, constant and saturated values of column `i`. mend: of raw values; default: in the vehicle file."""
    low, high, largest = stream.least[i], stream.most[i], stream.largest[i]
    seconds, share = (now - stream.first) / NS_PER_S, stream.at_largest[i] / stream.rows
    if stream.kind != "command":
        return
    if largest > RAW:
        yield Found(
            "error",
            f"{name} reaches {largest:.4g}: full thrust is 1, so this may be a raw number, as PWM; "
            + (mend or f"give offset and scale at commands: inputs: {name}"),
        )
    if low == high and seconds > CONSTANT:
        yield Found(
            "warning",
            f"{name} has been {low:.4g} for {seconds:.0f} s: its effect can't be estimated; drive with it, or "
            "check its column or field",
        )
    if low < high and share > SATURATED and seconds > DRIVEN:
        yield Found(
            "warning",
            f"{name} is at its largest value, {largest:.4g}, {100 * share:.0f} % of the time: this shows its "
            "effect at one point only; drive with smaller values, too",
        )


def frozen_findings(
    stream: SignalStream, commands: SignalStream | None, now: int
) -> Iterator[Found]:
    """Poses that repeat while the commands change."""
    still = (now - max(stream.changed)) / NS_PER_S
    if commands is None or still < FROZEN or max(commands.changed) < max(stream.changed):
        return
    if now - stream.newest[1] < STOPPED * NS_PER_S:
        yield Found(
            "error",
            f"the same pose for {still:.1f} s while the commands change: the tracker is frozen; start it again",
        )


def degree_findings(stream: SignalStream, line: str) -> Iterator[Found]:
    """A heading that wraps at 360. line: of the vehicle file, as it should be."""
    if stream.turns:
        advice = f"set unit: deg at pose: psi ({line})" if line else "send radians"
        yield Found("error", f"psi steps by 360: it is in degrees, not in radians; {advice}", line)


def jump_findings(jumps: int) -> Iterator[Found]:
    """Jumps so far."""
    if jumps:
        yield Found(
            "warning",
            f"{jumps} jumps: false matches of the tracker, which are left out. If there are many, check markers, "
            "light and reflections",
        )
