# SPDX-License-Identifier: MIT
"""The report: one HTML file that needs nothing else, not even a network."""

from collections.abc import Sequence
from pathlib import Path

from seatrial.files import write_text
from seatrial.model import Model
from seatrial.predict import DEFAULT_HORIZON
from seatrial.recording import Recording
from seatrial.report.page import page
from seatrial.report.runs import gather
from seatrial.sanity import sanity

__all__ = ["report", "write_report"]


def report(
    model: Model, recordings: Sequence[Recording], *, horizon: float = DEFAULT_HORIZON
) -> str:
    """The report on a model as HTML text: what it is, and how it predicts `horizon` [s] ahead.

    The same model and recordings give the same text. Raises RecordingError where a recording has no
    stretch as long as the horizon, or where there is no recording; ModelError where the model is
    unstable.
    """
    sanity(model)
    return page(model, gather(model, recordings, horizon), horizon)


def write_report(
    model: Model,
    recordings: Sequence[Recording],
    path: str | Path,
    *,
    horizon: float = DEFAULT_HORIZON,
) -> None:
    """Write `report` to a file, whole or not at all. `horizon` in s."""
    write_text(Path(path), report(model, recordings, horizon=horizon))
