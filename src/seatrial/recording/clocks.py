# SPDX-License-Identifier: MIT
"""What the clocks of a recording's signals say of each other, in words."""

from collections.abc import Sequence

from seatrial.recording.timing import Clock, Delay, Stream, time_text

AHEAD = 0.002  # [s] a stamp this far after its arrival was made by another clock
APART = 0.03  # [s] delays of two signals that differ by more are worth a word
LATE = 0.3  # [s] more than transport
DRIFT = 0.005  # [s]
ANOTHER_DAY = 3600.0  # [s] no transport takes so long
ANOTHER_SPEED = 0.05  # of the recording's length that a clock would have to drift
ALIKE = 0.2  # steps of two clocks that differ by less than this share are one
TWICE = 0.01  # share of stamps


def clock_verdicts(streams: Sequence[Stream], begin: int | None = None) -> list[str]:
    """One sentence for each thing that is odd about stamps and clocks.

    begin [ns]: the recording's zero, for times as --start takes them; else from a stream's start.
    """
    said = [sentence for stream in streams for sentence in _of_one(stream)]
    known = [(s, s.delay) for s in streams if s.delay and not _replayed(s, s.delay)]
    said += _steps(known, begin)
    for i, (first, a) in enumerate(known):
        for second, b in known[i + 1 :]:
            said += _between(first, a, second, b)
    headed = [(s, d.least) for s, d in known if d.least > APART and not d.step]
    for stream in streams:
        if stream.clock in (Clock.ARRIVAL, Clock.ZERO) and headed:
            source, late = max(headed, key=lambda h: h[1])
            said.append(
                f"{source.source} is stamped {time_text(late)} before its arrival or more, but of "
                f"{stream.source} only the arrival is known: the two may be off by so much"
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
            "transport, which acts like a latency"
        )
    if stream.publishers > 1:
        said.append(
            f"{stream.source} has {stream.publishers} publishers: two robots, or a node that was "
            "started again?"
        )
    if stream.backward:
        said.append(
            f"{stream.source}: stamps go back in time {_times(stream.backward)}: was a clock set, or "
            "are two publishers on it?"
        )
    if stream.duplicated > TWICE * stream.count:
        said.append(
            f"{stream.source}: {stream.duplicated} of {stream.count} stamps are those of the message "
            "before: is it sent twice, or is its stamp rounded?"
        )
    if delay is None:
        return said
    if _replayed(stream, delay):
        said.append(
            f"{stream.source}: arrivals have nothing to do with its stamps: it was played back and "
            "recorded again; its own stamps count"
        )
        return said
    if delay.least < -AHEAD and not delay.step:
        said.append(
            f"{stream.source}: stamps are up to {time_text(-delay.least)} ahead of the recorder's clock: it "
            "is made on another machine. As long as it stays so it acts like a latency; chrony or PTP keep it"
        )
    if abs(delay.drift) > DRIFT:  # a clock that runs fast makes the delay fall
        said.append(
            f"{stream.source}: its clock {'gains' if delay.drift < 0 else 'loses'} "
            f"{time_text(abs(delay.drift))} against the recorder's over the recording; keep the clocks "
            "together (chrony, PTP)"
        )
    if delay.least > LATE and not delay.step:
        said.append(
            f"{stream.source}: every message arrives {time_text(delay.least)} or more after its stamp: a "
            "slow source, or a clock that is behind"
        )
    return said


def _replayed(stream: Stream, delay: Delay) -> bool:
    """Whether arrivals are of another day, or at another speed."""
    length = stream.count / stream.rate if stream.rate else 0.0
    return abs(delay.median) > ANOTHER_DAY or abs(delay.drift) > ANOTHER_SPEED * max(length, 1.0)


def _steps(known: Sequence[tuple[Stream, Delay]], begin: int | None) -> list[str]:
    """A clock that is set forward makes the delay fall by as much."""
    set_ones = [(s, d) for s, d in known if d.step]
    if not set_ones:
        return []
    first = set_ones[0][1].step
    one = all(abs(d.step - first) < ALIKE * abs(first) for _, d in set_ones)
    if len(set_ones) == len(known) > 1 and one:
        said = f"all stamps jump {_way(first)} against the recorder's clock"
        return [f"{said} {_when(*set_ones[0], begin)}"]
    return [
        f"{s.source}: its clock jumps {_way(d.step)} against the recorder's {_when(s, d, begin)}"
        for s, d in set_ones
    ]


def _way(step: float) -> str:
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
    if abs(apart) < APART or a.step or b.step:
        return []
    (early, x), (late, y) = sorted(((first, a), (second, b)), key=lambda p: p[1].least)
    if (x.least < -AHEAD and abs(y.least) < APART) or (y.least > LATE and abs(x.least) < APART):
        return []  # that one of them is off was said
    return [
        f"stamps of {late.source} are {time_text(abs(apart))} further behind their arrival than those of "
        f"{early.source}: clocks that are apart, or processing; the latency takes it up as long as "
        "it stays the same"
    ]


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
