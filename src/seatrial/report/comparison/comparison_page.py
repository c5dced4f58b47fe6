# SPDX-License-Identifier: MIT
"""Head-to-head comparison of two models as one HTML file."""

from collections.abc import Sequence
from pathlib import Path

from seatrial.boat.model import Model
from seatrial.evaluation.comparison.compare import Comparison
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.recording.recording import Recording
from seatrial.report.comparison import errors, models, prediction
from seatrial.report.comparison.two_models import model_pair
from seatrial.report.figures.png import check
from seatrial.report.papers import write_page
from seatrial.report.sections.base import Section, with_folds

FOLDED = frozenset(("known", "actuators", "recorded", "errors", "physics", "advice", "provenance"))


def write_comparison(
    a: Model,
    b: Model,
    recordings: Sequence[Recording],
    found: Comparison,
    path: str | Path,
    *,
    horizon: float = DEFAULT_HORIZON,
    figures: str | Path | None = None,
    raster: bool = False,
    tables: str | Path | None = None,
) -> None:
    """Write the page on `compare`'s result to a file; `horizon` in s, the rest as in `write_report`."""
    if raster:
        check()
    sections = _sections(a, b, recordings, found, horizon)
    names = [recording.name for recording in recordings]
    write_page(_title(a, b), sections, path, names, figures=figures, raster=raster, tables=tables)


def _sections(
    a: Model, b: Model, recordings: Sequence[Recording], found: Comparison, horizon: float
) -> list[Section]:
    pair = model_pair(a, b, recordings, found, horizon)
    order = (
        models.verdict, models.causes, models.known, models.parameters, models.actuators, prediction.recorded,
        prediction.horizons, prediction.ahead, errors.errors, models.boat, models.advised,
        models.provenance,
    )  # fmt: skip
    sections = [section for one in order if (section := one(pair)) is not None]
    return with_folds(sections, FOLDED)


def _title(a: Model, b: Model) -> str:
    names = a.name if a.name == b.name else f"{a.name} and {b.name}"
    return f"{names}: two models compared by seatrial"
