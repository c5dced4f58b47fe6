# SPDX-License-Identifier: MIT
"""What a guided path holds out to test the model: a recording, or the last part of each."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from seatrial.boat.vehicle import Vehicle
from seatrial.guide.answers import LAST_QUARTER, TEST_QUESTION
from seatrial.guide.steps import Task
from seatrial.identification.guided import check_length
from seatrial.io.reader import recording_names
from seatrial.recording.excitation import find_roles
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError, RecordingError

HELD_OUT_SHARE = 0.25  # of each recording, its last part, where no recording is chosen for the test
HELD_OUT_SUFFIX = "-held-out"  # of the name of such a part


def hold_out(
    here: Task, recordings: Sequence[Recording], vehicle: Vehicle, test: str | Path | None
) -> tuple[list[Recording], list[Recording]]:
    """Recordings that identify, and those that test."""
    chosen = _test_recording(here, recordings, test)
    if chosen is not None:
        return [r for r in recordings if r is not chosen], [chosen]
    ends = [(1.0 - HELD_OUT_SHARE) * r.duration for r in recordings]
    training = [r.cut(None, end) for r, end in zip(recordings, ends, strict=True)]
    try:
        find_roles(vehicle, training)
        check_length(training, vehicle)
    except (RecordingError, IdentificationError) as error:
        find_roles(vehicle, recordings)  # an axis that is never driven is another matter
        here.assumed.append(
            f"nothing is held out, so that the scores are optimistic: without the last quarter {error}"
        )
        return [*recordings], []
    held = [
        replace(r.cut(end), name=f"{r.name}{HELD_OUT_SUFFIX}")
        for r, end in zip(recordings, ends, strict=True)
    ]
    other = (
        "--test LOG for another"
        if len(here.logs) > 1
        else "another drive tests it better: --test LOG2"
    )
    here.assumed.append(f"the model is tested on {LAST_QUARTER} ({other})")
    return training, held


def _test_recording(
    here: Task, recordings: Sequence[Recording], test: str | Path | None
) -> Recording | None:
    """The recording that tests the model: given, or answered, or none."""
    names = recording_names(here.logs)
    if test is None:
        test = _answered_test(here, names)
    return None if test == LAST_QUARTER else recordings[place_of(str(test), here.logs)]


def _answered_test(here: Task, names: Sequence[str]) -> str:
    """The recording that the user chose, now or before; one that is added or gone makes it a new question."""
    before, of = here.steps.answer("test"), ", ".join(names)
    same = here.steps.answer("of") in (None, of)
    if before in (LAST_QUARTER, *names) and (same or here.ask is None):
        return str(before)
    if here.ask is None or len(names) < 2:
        return LAST_QUARTER
    answer = here.ask.choose(TEST_QUESTION, (LAST_QUARTER, *names))
    here.steps.keep_answer("test", answer)
    here.steps.keep_answer("of", of)
    return answer


def with_test(test: str | Path | None, logs: Sequence[Path]) -> tuple[Path, ...]:
    """The logs, and the one that tests the model where it is a further one. Raises RecordingError."""
    further = test is not None and not _places(str(test), logs) and Path(test).exists()
    found = (*logs, Path(str(test))) if further else tuple(logs)
    if test is not None:
        place_of(str(test), found)
    return found


def place_of(test: str, logs: Sequence[Path]) -> int:
    """The place of the log that tests the model, given by path or name. Raises RecordingError."""
    places = _places(test, logs)
    if len(places) == 1 < len(logs):
        return places[0]
    wrong = (
        "it is the only log; give another one"
        if len(logs) == 1
        else "several logs have this name; give its path"
    )
    if not places:
        wrong = f"there is no such log; give one of {', '.join(map(str, logs))} or another one"
    raise RecordingError(f"--test {test}: {wrong}")


def _places(test: str, logs: Sequence[Path]) -> list[int]:
    named = enumerate(zip(logs, recording_names(logs), strict=True))
    return [i for i, (log, name) in named if log.resolve() == Path(test).resolve() or name == test]
