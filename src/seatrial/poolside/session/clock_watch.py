# SPDX-License-Identifier: MIT
"""A clock that is set back while the boat drives: its stamps overlap those of before."""

from dataclasses import dataclass

from seatrial.poolside.drive_log import LONGEST_STEP
from seatrial.poolside.live_estimator import HOLD
from seatrial.util.frames import NS_PER_S

STEP = round(LONGEST_STEP * NS_PER_S)  # [ns]


@dataclass
class _Run:
    """Stamps [ns] of rows that follow each other."""

    begin: int
    end: int


@dataclass(frozen=True)
class SetBack:
    """A clock that was set back."""

    seconds: float
    overlap: tuple[int, int] | None  # [ns] stamps of two times, which can't be told apart

    @property
    def text(self) -> str:
        """For the user."""
        what = f"the clock of the stamps was set back by {self.seconds:.3g} s"
        if self.overlap is None:
            return f"{what}: a saved recording leaves out the shorter part; if that is long, begin a new session"
        return f"{what}: the poses of {(self.overlap[1] - self.overlap[0]) / NS_PER_S:.3g} s are left out"


class ClockWatch:
    """Of one signal. A single wrong stamp, a late row and a pause set no clock back."""

    def __init__(self) -> None:
        self._now: _Run | None = None
        self._before: list[_Run] = []
        self._odd: int | None = None  # the last stamp, where it does not follow the run

    def use(self, stamp: int) -> SetBack | None:
        """A row's stamp [ns]."""
        now = self._now
        if now is None:
            self._now = _Run(stamp, stamp)
            return None
        if _follows(now.end, stamp):
            now.end, self._odd = max(now.end, stamp), None
            return self._reached(now)
        if self._odd is None or not _follows(self._odd, stamp):
            self._odd = stamp
            return None
        self._now, self._odd = _Run(self._odd, stamp), None
        self._before.append(now)
        back = (now.end - self._now.begin) / NS_PER_S
        return self._reached(self._now) or (SetBack(back, None) if back > 0.0 else None)

    def _reached(self, now: _Run) -> SetBack | None:
        """A run of before that overlaps; each once."""
        for one in self._before:
            if now.begin <= one.end and one.begin <= now.end:
                self._before.remove(one)
                seconds = (one.end - now.begin) / NS_PER_S
                return SetBack(seconds, (max(now.begin, one.begin), one.end))
        return None


class Clocks:
    """Of all signals."""

    def __init__(self) -> None:
        self._watches: dict[str, ClockWatch] = {}

    def use(self, kind: str, stamp: int) -> SetBack | None:
        """A row's kind and stamp [ns]."""
        return self._watches.setdefault(kind, ClockWatch()).use(stamp)


def _follows(end: int, stamp: int) -> bool:
    """Whether a row continues a run: it may be a little late, or come after a short pause."""
    return -HOLD <= stamp - end <= STEP
