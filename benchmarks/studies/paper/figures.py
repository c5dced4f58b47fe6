# SPDX-License-Identifier: MIT
"""The paper's Figs. 4 to 7 for simulated trials: both methods on the same boat and seed."""

from pathlib import Path

import numpy as np

from benchmarks.harness import pictures
from benchmarks.studies.paper.maps import METHODS
from benchmarks.studies.paper.trials import FIRST, HORIZON, Trials, boat, identified
from seatrial.boat.model import Model
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.prediction import predict
from seatrial.report.figures.base import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    RED,
    Figure,
    figure,
    level,
    line,
)
from seatrial.util.frames import SPEED_UNITS, SYMBOLS, Array
from seatrial.util.statistics import autocorrelation, white_band
from tests.boats.scenes import ALLOCATIONS, UNSEEN, driven

PLAN = "paper-like"
SAMPLE = (150.0, 190.0)  # [s] that are drawn
FIG_4 = ("S5", 1, "F_v")
SWAY = 1
LAGS = 60
GAP = 0.3  # [s] that no line is drawn across
BINS = 61
NAMES = {"equation-error": "the paper's method", "output-error": "output-error"}
COLOURS = {"equation-error": ORANGE, "output-error": BLUE}
Models = dict[str, dict[str, Model]]


def write(folder: Path) -> None:
    """Draw the four into a folder."""
    trials = {a: driven(PLAN, boat(a), FIRST) for a in ALLOCATIONS}
    models = {a: {m: identified(trials[a], boat(a), m) for m in METHODS} for a in ALLOCATIONS}
    ahead = {
        a: {m: predict(models[a][m], trials[a][UNSEEN].recording, HORIZON) for m in METHODS}
        for a in ALLOCATIONS
    }
    sheets = {
        "fig-4": _fourth(trials["MP"], models["MP"]),
        "fig-5": _combined(ahead["MP"]),
        "fig-6": _combined(ahead["AF"]),
        "fig-7": [[_correlated(ahead[a], a) for a in ALLOCATIONS]],
    }
    for name, plots in sheets.items():
        pictures.write(folder / f"{name}.svg", plots)


def _fourth(trials: Trials, models: dict[str, Model]) -> list[list[Figure]]:
    """Measured and predicted sway, and the command."""
    name, axis, command = FIG_4
    record = trials[name].recording
    ahead = {m: predict(models[m], record, HORIZON) for m in METHODS}
    given = record.commands
    t = (given.stamps - record.stamps[0]).astype(float) * 1e-9
    drawn = (t >= SAMPLE[0]) & (t <= SAMPLE[1])
    stick = line(command, t[drawn], given.values[drawn, given.names.index(command)], GREEN)
    return [[_velocity(ahead, axis)], [figure([stick], "time [s]", f"{command} [command units]")]]


def _combined(ahead: dict[str, Prediction]) -> list[list[Figure]]:
    """Three velocities, and the histograms of their errors beside them."""
    return [[_velocity(ahead, axis), _histogram(ahead, axis)] for axis in range(len(SYMBOLS))]


def _velocity(ahead: dict[str, Prediction], axis: int) -> Figure:
    first = ahead[METHODS[0]]
    traces = [_sample(first, "measured", first.measured[:, axis], BLACK, 0.8)]
    traces += [
        _sample(found, f"{NAMES[m]}, 1 s ahead", found.nu[:, axis], COLOURS[m], 1.5)
        for m, found in ahead.items()
    ]
    return figure(traces, "time [s]", f"{SYMBOLS[axis]} [{SPEED_UNITS[axis]}]")


def _sample(found: Prediction, name: str, values: Array, colour: str, width: float) -> Figure:
    drawn = (found.t >= SAMPLE[0]) & (found.t <= SAMPLE[1])
    t, y = found.t[drawn], values[drawn]
    gaps = np.flatnonzero(np.diff(t) > GAP) + 1
    return line(name, np.insert(t, gaps, np.nan), np.insert(y, gaps, np.nan), colour, width=width)


def _histogram(ahead: dict[str, Prediction], axis: int) -> Figure:
    """Shares of the errors, and beside their names the root mean squares."""
    most = max(float(np.abs(found.errors[:, axis]).max()) for found in ahead.values())
    edges = np.linspace(-most, most, BINS)
    middle = 0.5 * (edges[1:] + edges[:-1])
    traces = []
    for method, found in ahead.items():
        errors = found.errors[:, axis]
        share = 100.0 * np.histogram(errors, edges)[0] / len(errors)
        rms = f"RMS {np.sqrt(np.mean(errors**2)):.2g} {SPEED_UNITS[axis]}"
        traces.append(line(f"{NAMES[method]}: {rms}", middle, share, COLOURS[method]))
    unit = SPEED_UNITS[axis]
    return figure(traces, f"{SYMBOLS[axis]} measured - predicted [{unit}]", "share [%]")


def _correlated(ahead: dict[str, Prediction], allocation: str) -> Figure:
    """Of the errors in sway, with the band of white ones."""
    traces = []
    for method, found in ahead.items():
        rho = autocorrelation(found.errors, found.index, LAGS)[:, SWAY]
        traces.append(
            line(f"{NAMES[method]}, {allocation}", np.arange(LAGS + 1.0), rho, COLOURS[method])
        )
    band = white_band(len(ahead[METHODS[0]].errors))
    return figure(
        traces, "lag [poses]", "autocorrelation of the errors in v",
        shapes=[level(band, RED), level(-band, RED)],
    )  # fmt: skip
