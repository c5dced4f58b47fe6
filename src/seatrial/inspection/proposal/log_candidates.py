# SPDX-License-Identifier: MIT
"""Signals of an autopilot's log that are known by their messages, and their values."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.io.formats.known import HEADINGS, POSITIONS, VOLTAGES, YAW_RATES, Known
from seatrial.io.log import Log, LogSamples, LogTopic, Wanted

LEAST_POSITIONS = 20  # different ones, of a topic that is a position
LEAST_HEADINGS = 20
BEST_FIX = 6.0  # RTK with whole cycles, in the numbers of MAVLink


@dataclass(frozen=True)
class Candidate:
    """A known signal in a topic of the log, and its values."""

    known: Known
    topic: LogTopic
    samples: LogSamples

    @property
    def rate(self) -> float:
        """[Hz] on average."""
        t = self.samples.stamps
        span = (int(t.max()) - int(t.min())) * 1e-9 if len(t) else 0.0
        return len(t) / span if span > 0 else 0.0

    @property
    def different(self) -> int:
        """Number of different values, 0 and none left out."""
        values = self.samples.values[:, : len(self.known.fields)]
        known = np.isfinite(values).all(axis=1) & (values != 0.0).any(axis=1)
        return len(np.unique(values[known], axis=0)) if known.any() else 0

    @property
    def fix(self) -> float:
        """The usual kind of fix of a receiver, `BEST_FIX` at most; 0 where the log does not state it."""
        stated = self.samples.values[:, len(self.known.fields) :]
        return min(float(np.median(stated)), BEST_FIX) if stated.size else 0.0

    @property
    def shown(self) -> str:
        """Topic and fields."""
        return f"{self.topic.name} {', '.join(self.known.fields)}"

    @property
    def why(self) -> str:
        """What it is."""
        return f"{self.known.what}, {self.rate:.3g} Hz"


class Found:
    """Known signals of the log, in each topic that has them, read in one pass."""

    def __init__(self, log: Log) -> None:
        self.log = log
        several = (*POSITIONS, *HEADINGS, *YAW_RATES, *VOLTAGES)
        candidates = [(known, topic) for known in several for topic in known.topics(log)]
        samples = log.read([Wanted(t.name, known.fields_in(t)) for known, t in candidates])
        self.all = [Candidate(k, t, s) for (k, t), s in zip(candidates, samples, strict=True)]

    def of(self, known: Sequence[Known], least: int) -> list[Candidate]:
        """Candidates of one kind of signal that have enough different values, in the order of `known`."""
        mine = [c for k in known for c in self.all if c.known is k]
        return [c for c in mine if c.different >= least]

    def counted(self, known: Sequence[Known]) -> str:
        """How many different values the topics of one kind of signal have; empty: there are no such topics."""
        mine = [c for k in known for c in self.all if c.known is k]
        return ", ".join(
            f"{c.topic.name} has {c.different} in {len(c.samples.stamps)} messages" for c in mine
        )
