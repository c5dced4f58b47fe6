# SPDX-License-Identifier: MIT
"""`auto`: vehicle file, inspection, model, validation on what was held out, report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from seatrial.boat.model import Model
from seatrial.evaluation.scores import Scores
from seatrial.guide.held_out import hold_out, with_test
from seatrial.guide.model import model_of, whole_command
from seatrial.guide.recordings import as_model_reads, driven_recordings
from seatrial.guide.scores_and_report import report, scores_on
from seatrial.guide.steps import Say, Steps, Task
from seatrial.guide.vehicle_file import vehicle_of
from seatrial.inspection.overview import Inspection, inspect
from seatrial.inspection.proposal.sources import Choices
from seatrial.util.arguments import expect_each
from seatrial.util.blas import one_blas_thread
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.progress import stage
from seatrial.util.questions import Questions
from seatrial.workflow.next_step import NextStep


@dataclass(frozen=True)
class Guide:
    """What a guided path ended with.

    folder: with all results
    model: as identified
    scores: of the recordings that were left out
    assumed: what was not known, in words
    next: what to do next, and why
    inspection: of the recordings
    """

    folder: Path
    model: Model
    scores: Scores
    assumed: tuple[str, ...]
    next: NextStep
    inspection: Inspection

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / "report.html"


@one_blas_thread
def auto(
    logs: Sequence[str | Path],
    folder: str | Path,
    *,
    test: str | Path | None = None,
    choices: Choices | None = None,
    ask: Questions | None = None,
    say: Say = lambda _: None,
    salvage: bool = False,
    effects: Sequence[str] = (),
) -> Guide:
    """From logs to a model that is validated on what was held out, and its report, in one folder.

    `test`: the log that tests the model, of `logs` or a further one; default: the last quarter of each. `ask`: who
    answers what no log can tell; without, it is assumed and stated. `effects`: those to begin with, as of
    `identify`. A path that was stopped goes on where it was, and a vehicle file in the folder is used as it is:
    it has the answers. Raises as `init`, `identify` and `validate`.
    """
    paths, place = _checked(logs, Path(folder), test), Path(folder)
    here = Task(paths, place, ask, say, salvage, Steps(place), tuple(effects))
    # 1. the vehicle file: proposed once, then the user's
    with stage("vehicle file", 0.1):
        vehicle, proposed_now = vehicle_of(here, choices or Choices())
    # 2. the recordings, and consistency of the vehicle file with them
    recordings, inspection = driven_recordings(here, vehicle, proposed_now=proposed_now)
    # 3. the model, from all but what is held out
    training, held_out = hold_out(here, recordings, vehicle, test)
    made_from = here.made_from(recordings, training)
    with stage("identifying", 0.55):
        model = model_of(here, training, held_out, vehicle, made_from)
    whole = whole_command(here, model, held_out)
    # 4. scores on what was held out
    with stage("validating", 0.1):
        tested = as_model_reads(here, model, vehicle, held_out)
        scores = scores_on(here, model, tested or training, made_from)
    # 5. the report on all of it, and what to do next
    with stage("report"):
        seen = as_model_reads(here, model, vehicle, training)
        look = partial(inspect, training, vehicle)
        step = report(
            here, model, [*tested, *seen], training, whole, automatic=vehicle.automatic, look=look
        )
    return Guide(here.folder, model, scores, tuple(here.assumed), step, inspection)


def _checked(logs: Sequence[str | Path], folder: Path, test: str | Path | None) -> tuple[Path, ...]:
    """The logs. Raises RecordingError or FileError where the inputs can't be those of a path."""
    expect_each(logs, (str, Path), "logs")
    paths = tuple(Path(log) for log in logs)
    if not paths:
        raise RecordingError("no log given; pass at least one")
    if folder.is_file():
        raise FileError(f"{folder}: is a file; give a folder to write to")
    return with_test(test, paths)
