# SPDX-License-Identifier: MIT
"""Scores of the first screen, as numbers: prediction against the floor, what is known."""

from dataclasses import dataclass

import numpy as np

from seatrial.identification.uncertainty.identifiability import Identifiability
from seatrial.identification.uncertainty.parameter_verdict import ParameterVerdict
from seatrial.report.evidence.runs import Run, judged
from seatrial.report.text.numbers import floors, resolved_ratio, rms_and_ratio
from seatrial.util.frames import Array


@dataclass(frozen=True)
class FloorScore:
    """Share by which predictions exceed the noise floor less than constant velocity does; 1: at the floor."""

    share: Array  # (3,)
    over_floor: Array  # (3,) RMS error over the noise floor; infinite where that is 0
    still_over_floor: Array  # (3,) the same of constant velocity

    @property
    def worst(self) -> int:
        """The axis with the smallest share."""
        return int(np.argmin(self.share))


def floor_score(runs: tuple[Run, ...]) -> FloorScore | None:
    """Of the recordings that judge the model; None where none was predicted."""
    chosen = judged(runs)
    if not chosen:
        return None
    floor, (rms, ratio) = floors(chosen), rms_and_ratio(chosen)
    over = np.divide(rms, floor, out=np.full(3, np.inf), where=floor > 0.0)
    still = np.divide(over, ratio, out=np.full(3, np.inf), where=ratio > 0.0)
    share = np.clip(1.0 - resolved_ratio(chosen), 0.0, 1.0)
    return FloorScore(share, over, still)


@dataclass(frozen=True)
class KnownScore:
    """Parameters that were estimated, by verdict."""

    sharp: int
    usable: int
    estimated: int

    @property
    def share(self) -> float:
        """Those that are sharp or usable."""
        return (self.sharp + self.usable) / self.estimated if self.estimated else 0.0


def known_score(found: Identifiability) -> KnownScore:
    """Counts of the verdicts."""
    verdicts = [f.verdict for f in found.findings if f.verdict.estimated]
    sharp = verdicts.count(ParameterVerdict.SHARP)
    usable = verdicts.count(ParameterVerdict.USABLE)
    return KnownScore(sharp, usable, len(verdicts))
