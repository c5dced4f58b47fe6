# SPDX-License-Identifier: MIT
"""What the clocks of a recording's signals say of each other, in words."""

from collections.abc import Sequence

from seatrial.streams import Clock, Delay, Stream

AHEAD = 0.002  # [s] a stamp this far after its arrival was made by another clock
APART = 0.03  # [s] delays of two signals that differ by more are worth a word
LATE = 0.3  # [s] more than transport
DRIFT = 0.005  # [s]


def clock_verdicts(streams: Sequence[Stream]) -> list[str]:
    """One sentence for each thing that is odd about stamps and clocks."""
    said = [sentence for stream in streams for sentence in _of_one(stream)]
    known = [(s, s.delay) for s in streams if s.delay is not None]
    for i, (first, a) in enumerate(known):
        for second, b in known[i + 1 :]:
            said += _between(first, a, second, b)
    headed = [s for s, delay in known if delay.least > APART]
    for stream in streams:
        if stream.clock in (Clock.ARRIVAL, Clock.ZERO) and headed:
            late = max(s.delay.least for s in headed if s.delay is not None)
            said.append(
                f"{headed[0].source} has stamps of its making, {1e3 * late:.0f} ms before arrival, but "
                f"{stream.source} only times of arrival: the two are off by up to so much"
            )
    return list(dict.fromkeys(said))


def _of_one(stream: Stream) -> list[str]:
    said, delay = [], stream.delay
    if stream.clock is Clock.ZERO:
        said.append(
            f"{stream.source}: header stamps are all 0, so the bag's times of arrival are used; fill in "
            "header.stamp where it is published"
        )
    elif stream.clock is Clock.ARRIVAL:
        said.append(
            f"{stream.source} ({stream.kind}) is stamped by its arrival in the bag: late by the "
            "transport, which the latency takes up"
        )
    if stream.backward:
        said.append(
            f"{stream.source}: {stream.backward} stamps go back in time; was a clock set, or are two "
            "publishers on it?"
        )
    if delay is None:
        return said
    if delay.step:
        said.append(
            f"{stream.source}: its clock jumps by {delay.step:+.3f} s against the recorder's after "
            f"{delay.step_at:.1f} s; cut the recording there (--start, --end)"
        )
    elif delay.least < -AHEAD:
        said.append(
            f"{stream.source}: stamps are up to {-1e3 * delay.least:.0f} ms ahead of the recorder's "
            "clock: it is made on another machine; keep the clocks together (chrony, PTP)"
        )
    elif abs(delay.drift) > DRIFT:
        said.append(
            f"{stream.source}: its clock drifts by {1e3 * delay.drift:+.0f} ms against the recorder's "
            "over the recording; keep the clocks together (chrony, PTP)"
        )
    if delay.least > LATE and not delay.step:
        said.append(
            f"{stream.source}: every message arrives {delay.least:.2f} s or more after its stamp: a slow "
            "source, or a clock that is behind"
        )
    return said


def _between(first: Stream, a: Delay, second: Stream, b: Delay) -> list[str]:
    apart = a.least - b.least
    if abs(apart) < APART or a.step or b.step:
        return []
    late, other = (first, second) if apart > 0 else (second, first)
    return [
        f"stamps of {late.source} are {1e3 * abs(apart):.0f} ms further behind their arrival than those "
        f"of {other.source}: clocks that are apart, or processing; the latency takes it up as long as "
        "it stays the same"
    ]
