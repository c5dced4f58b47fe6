# SPDX-License-Identifier: MIT
"""Messages about the clocks of a recording's signals: offsets, drift, steps, missing stamps."""

from collections.abc import Iterator, Sequence

from seatrial.recording.timing import Clock, Delay, Stream, time_text
from seatrial.util.format import times

CLOCK_AHEAD = 0.002  # [s] stamp after arrival, above which the clock is another machine's
DELAYS_APART = 0.03  # [s] difference of two signals' delays that gets a message
SLOW_TRANSPORT = 0.3  # [s] least delay above it: no transport on a local network
LEAST_DRIFT = 0.005  # [s] over the recording that gets a message
REPLAYED_DELAY = 3600.0  # [s] arrival after stamp, above which the log is a replay
REPLAYED_DRIFT = 0.05  # of the recording's length; a larger drift is replay at another speed
SAME_STEP = 0.2  # of a step, difference of two clocks' steps that are one event
DUPLICATED_SHARE = 0.01  # of the stamps, equal to the one before, that gets a message


def clock_verdicts(streams: Sequence[Stream], begin: int | None = None) -> list[str]:
    """One message for each anomaly of stamps and clocks.

    begin [ns]: the recording's zero, for times as --start takes them; else from a stream's start.
    """
    # 1. Each signal by itself, then steps of the clocks, then pairs of signals.
    messages = [sentence for stream in streams for sentence in _of_one(stream)]
    known = [(s, s.delay) for s in streams if s.delay and not _replayed(s, s.delay)]
    messages += _steps(known, begin)
    for i, (first, a) in enumerate(known):
        for second, b in known[i + 1 :]:
            messages += _between(first, a, second, b)
    # 2. Signals without stamps of their own, next to others that arrive late.
    headed = [(s, d.least) for s, d in known if d.least > DELAYS_APART and not d.step]
    for stream in streams:
        if stream.clock in (Clock.ARRIVAL, Clock.ZERO) and headed:
            source, late = max(headed, key=lambda h: h[1])
            messages.append(
                f"{source.source} is stamped {time_text(late)} or more before its arrival, but "
                f"{stream.source} has arrival times only: the two may be offset by that much"
            )
    return list(dict.fromkeys(messages))


def _of_one(stream: Stream) -> list[str]:
    """What one signal's stamps show, and what its delay from stamp to arrival shows."""
    messages = list(_stamp_messages(stream))
    if stream.delay is not None:
        messages += _delay_messages(stream, stream.delay)
    return [f"{stream.source}{message}" for message in messages]


def _stamp_messages(stream: Stream) -> Iterator[str]:
    if stream.clock is Clock.ZERO:
        yield (
            ": header stamps are all 0, so arrival times in the bag are used; set header.stamp in the "
            "publisher"
        )
    elif stream.clock is Clock.ARRIVAL:
        yield (
            f" ({stream.kind}) is stamped by its arrival in the bag: the transport delay acts as a "
            "latency"
        )
    if stream.publishers > 1:
        yield (
            f" has {stream.publishers} publishers: check for two robots, or a node that was restarted"
        )
    if stream.backward:
        yield (
            f": stamps go back in time {times(stream.backward)}: check for a clock that was set, a logger that "
            "was started again (split the log there, to use both parts), or two publishers"
        )
    if stream.duplicated > DUPLICATED_SHARE * stream.count:
        yield (
            f": {stream.duplicated} of {stream.count} stamps equal that of the message before: check "
            "for repeated messages or rounded stamps"
        )


def _delay_messages(stream: Stream, delay: Delay) -> Iterator[str]:
    if _replayed(stream, delay):
        yield (
            ": arrivals do not match its stamps: they are simulated time (use_sim_time), or the log was played "
            "back and recorded again; its own stamps are used"
        )
        return
    if delay.least < -CLOCK_AHEAD and not delay.step:
        yield (
            f": stamps are up to {time_text(-delay.least)} ahead of the recorder's clock, so another "
            "machine makes them. A constant offset acts as a latency; keep it constant (chrony, PTP)"
        )
    if abs(delay.drift) > LEAST_DRIFT:  # a clock that runs fast makes the delay fall
        yield (
            f": its clock {'gains' if delay.drift < 0 else 'loses'} {time_text(abs(delay.drift))} "
            "against the recorder's over the recording; synchronise the clocks (chrony, PTP)"
        )
    if delay.least > SLOW_TRANSPORT and not delay.step:
        yield (
            f": every message arrives {time_text(delay.least)} or more after its stamp: a slow source, "
            "or a clock that is behind"
        )


def _replayed(stream: Stream, delay: Delay) -> bool:
    """Whether arrivals are of a replay: much later, or at another speed."""
    length = max(stream.count / stream.rate if stream.rate else 0.0, 1.0)
    return abs(delay.median) > REPLAYED_DELAY or abs(delay.drift) > REPLAYED_DRIFT * length


def _steps(known: Sequence[tuple[Stream, Delay]], begin: int | None) -> list[str]:
    """Messages about clocks that were set: the delay falls by a step forward."""
    set_ones = [(s, d) for s, d in known if d.step]
    if not set_ones:
        return []
    first = set_ones[0][1].step
    one = all(abs(d.step - first) < SAME_STEP * abs(first) for _, d in set_ones)
    if len(set_ones) == len(known) > 1 and one:
        jump = f"all stamps jump {_jump_text(first)} against the recorder's clock"
        return [f"{jump} {_when(*set_ones[0], begin)}"]
    return [
        f"{s.source}: its clock jumps {_jump_text(d.step)} against the recorder's {_when(s, d, begin)}"
        for s, d in set_ones
    ]


def _jump_text(step: float) -> str:
    return f"{'ahead' if step < 0 else 'back'} by {time_text(abs(step))}"


def _when(stream: Stream, delay: Delay, begin: int | None) -> str:
    if begin is None:
        return f"{delay.step_at:.1f} s after the first message on {stream.source}"
    at = (delay.step_stamp - begin) * 1e-9
    return (
        f"at {at:.1f} s: use the part before (--end {at:.1f}) or the part after (--start {at:.1f})"
    )


def _between(first: Stream, a: Delay, second: Stream, b: Delay) -> list[str]:
    apart = a.least - b.least
    if abs(apart) < DELAYS_APART or a.step or b.step:
        return []
    (early, x), (late, y) = sorted(((first, a), (second, b)), key=lambda p: p[1].least)
    if (x.least < -CLOCK_AHEAD and abs(y.least) < DELAYS_APART) or (
        y.least > SLOW_TRANSPORT and abs(x.least) < DELAYS_APART
    ):
        return []  # a message about one of them exists
    return [
        f"stamps of {late.source} are {time_text(abs(apart))} further behind their arrival than those of "
        f"{early.source}: an offset of the clocks, or processing time; the latency absorbs it while it "
        "is constant"
    ]
