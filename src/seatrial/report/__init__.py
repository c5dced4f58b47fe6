# SPDX-License-Identifier: MIT
"""The report: one HTML file that needs nothing else, not even a network."""

from collections.abc import Sequence
from pathlib import Path

from seatrial.files import write_text
from seatrial.model import Model
from seatrial.predict import DEFAULT_HORIZON
from seatrial.recording import Recording
from seatrial.report.evidence import collect
from seatrial.report.page import page
from seatrial.report.sections import sections

__all__ = ["report", "write_report"]


def report(
    model: Model, recordings: Sequence[Recording], *, horizon: float = DEFAULT_HORIZON
) -> str:
    """The report on a model as HTML text: what it is, and how it predicts `horizon` [s] ahead.

    The same model and recordings give the same text. Raises RecordingError where no recording has a
    stretch as long as the horizon, or where there is no recording. A model that is unstable gets a
    report that says so.
    """
    found = sections(collect(model, recordings, horizon))
    return page(f"{model.name}: seatrial report", found)


def write_report(
    model: Model,
    recordings: Sequence[Recording],
    path: str | Path,
    *,
    horizon: float = DEFAULT_HORIZON,
) -> None:
    """Write `report` to a file, whole or not at all. `horizon` in s."""
    write_text(Path(path), report(model, recordings, horizon=horizon))
