# SPDX-License-Identifier: MIT
"""All results that the report shows of one model, computed once."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial.boat.model import Model
from seatrial.evaluation.assessment import Assessment, assess, assess_from
from seatrial.evaluation.scores import Scores
from seatrial.evaluation.validation import scores_of
from seatrial.identification.experiment_design import (
    ManoeuvreGain,
    RecordingInformation,
    ReferencePoint,
    information_by_recording,
    manoeuvre_gains,
    reference_point,
)
from seatrial.identification.uncertainty.identifiability import Identifiability, identifiability
from seatrial.recording.recording import Recording
from seatrial.report.evidence.physics import Physics, physics
from seatrial.report.evidence.runs import Run, gather
from seatrial.util.errors import SeatrialError
from seatrial.util.progress import stage
from seatrial.workflow.fitness import Fitness, fitness


@dataclass(frozen=True)
class Evidence:
    """A model and its recordings."""

    model: Model
    runs: tuple[Run, ...]
    scores: Scores
    known: Identifiability
    physics: Physics
    point: ReferencePoint | None  # where the information is linearised; None: see `no_information`
    by_recording: tuple[RecordingInformation, ...]  # each recording's own estimate
    gains: tuple[ManoeuvreGain, ...]  # expected information of further manoeuvres
    no_information: str  # why there is none; empty: there is

    @cached_property
    def fitness(self) -> tuple[Fitness, ...]:
        """For simulation, control and odometry."""
        return fitness(self.model, self.scores)

    @property
    def horizon(self) -> float:
        """That of the scores [s]."""
        return self.scores.horizon

    @property
    def tested(self) -> list[Run]:
        """Recordings that could be predicted."""
        return [run for run in self.runs if run.tested]


def collect(
    model: Model, recordings: Sequence[Recording], horizon: float, scores: Scores | None = None
) -> Evidence:
    """All of it, with `scores` as `validate` wrote them or computed here; see `gather` for what is raised."""
    with stage("predicting", 0.65):
        found = (
            assess(model, recordings, horizon)
            if scores is None
            else assess_from(model, recordings, scores)
        )
    return evidence_of(model, found, scores or scores_of(model, found, horizon))


def evidence_of(model: Model, found: Sequence[Assessment], scores: Scores) -> Evidence:
    """The same of recordings that are assessed already."""
    runs = gather(model, found)
    with stage("information of recordings", 0.2):
        point, each, gained, reason = _information(model, runs)
    return Evidence(
        model, tuple(runs), scores, identifiability(model), physics(model), point, each, gained, reason,
    )  # fmt: skip


def _information(
    model: Model, runs: Sequence[Run]
) -> tuple[ReferencePoint | None, tuple[RecordingInformation, ...], tuple[ManoeuvreGain, ...], str]:
    """Information of each recording and of further manoeuvres; or why there is none."""
    recordings = [run.recording for run in runs]
    period = float(np.median([r.period for r in recordings]))
    try:
        noise = next((run.noise for run in runs if run.noise is not None), None)
        point = reference_point(model, recordings, noise)
        with stage("", 0.6):
            each = information_by_recording(point, recordings)
        seen = [run.name for run in runs if not run.unseen]
        return point, tuple(each), tuple(manoeuvre_gains(point, period, each, seen)), ""
    except SeatrialError as error:
        return None, (), (), str(error)
