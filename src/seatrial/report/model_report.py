# SPDX-License-Identifier: MIT
"""The report: one self-contained HTML file, without network access."""

from collections.abc import Sequence
from pathlib import Path

from seatrial.boat.model import Model
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.evaluation.scores import Scores
from seatrial.recording.recording import Recording
from seatrial.report.evidence.model_evidence import Evidence, collect
from seatrial.report.figures.png import check
from seatrial.report.html import page
from seatrial.report.papers import write_page
from seatrial.report.sections import all_sections
from seatrial.util.progress import stage


def report(
    model: Model,
    recordings: Sequence[Recording],
    *,
    horizon: float = DEFAULT_HORIZON,
    scores: Scores | None = None,
) -> str:
    """The report on a model as HTML text: the model, and its predictions over `horizon` [s].

    `scores`: those of `validate`, which are not computed again; their horizon is used.
    The same model and recordings give the same text. Raises RecordingError where no recording has an
    interval as long as the horizon, or where there is no recording. The report of an unstable model
    states so.
    """
    return page(_title(model), all_sections(collect(model, recordings, horizon, scores)))


def write_report(
    model: Model,
    recordings: Sequence[Recording],
    path: str | Path,
    *,
    horizon: float = DEFAULT_HORIZON,
    scores: Scores | None = None,
    figures: str | Path | None = None,
    raster: bool = False,
    tables: str | Path | None = None,
) -> None:
    """Write `report` to a file, atomically. `horizon` in s; `scores` as there.

    `figures`: a folder for every plot as SVG, and with `raster` as PNG, which needs resvg-py;
    `tables`: one for every table as CSV and LaTeX.
    """
    if raster:
        check()
    evidence = collect(model, recordings, horizon, scores)
    write_evidence(evidence, path, figures=figures, raster=raster, tables=tables)


def write_evidence(
    evidence: Evidence,
    path: str | Path,
    *,
    figures: str | Path | None = None,
    raster: bool = False,
    tables: str | Path | None = None,
) -> None:
    """`write_report` of what is computed already."""
    with stage("drawing"):
        write_page(
        _title(evidence.model), all_sections(evidence), path, [run.name for run in evidence.runs],
        figures=figures, raster=raster, tables=tables,
    )  # fmt: skip


def _title(model: Model) -> str:
    return f"{model.name}: seatrial report"
