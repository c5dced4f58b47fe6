# SPDX-License-Identifier: MIT
"""S7 one second ahead from true starts: what the true parameters score, and an estimator at the bound.

The true model's error is that of the recording: its stamps jitter. An estimate adds
J (estimate - truth) to first order, whose mean square has the bound's covariance in it at least.
"""

from dataclasses import replace

import numpy as np

import seatrial
from benchmarks.harness.markdown import table
from benchmarks.recovery import bounds
from benchmarks.recovery.tables import SYMBOLS, rms
from benchmarks.recovery.work import HORIZON
from seatrial.boat.model import Model
from seatrial.evaluation.prediction import predict
from seatrial.simulation.trials import Trial
from seatrial.util.frames import Array
from tests.boats.scenes import (
    ALLOCATIONS,
    PRESETS,
    TRAINING,
    UNSEEN,
    Scene,
    scenes,
    true_parameters,
    vehicle_of,
)

DRIVES = range(1001, 1201)  # seeds of what the true parameters score: those of the other tables
FITS = range(1001, 1005)  # of the bound, which hardly depends on the seed
STEP = 0.1  # of a standard error, for differences
ROWS = ("true parameters", "error at the bound, alone", "both together: at the bound")


def reachable() -> str:
    """Markdown: RMS [mm/s, mm/s, mrad/s] and MP over AF."""
    rows = []
    for preset in PRESETS:
        mp, af = (levels(f"{preset} {a}") for a in ALLOCATIONS)
        for words, over, under in zip(ROWS, mp, af, strict=True):
            cells = [f"{1e3 * x:.3f}" for x in (*over, *under)]
            rows.append([f"{preset}, {words}", *cells, *(f"{x:.2f}" for x in over / under)])
    head = [f"{a} {s}" for a in ALLOCATIONS for s in SYMBOLS] + [f"MP / AF, {s}" for s in SYMBOLS]
    return table(["mm/s, mrad/s", *head], rows)


def levels(name: str) -> tuple[Array, Array, Array]:
    """RMS (3,) [m/s, m/s, rad/s] in one scene, of ROWS."""
    scene = scenes()[name]
    recordings = [t.recording for t in scene.trials(FITS[0]).values()]
    fitted = seatrial.identify(recordings, vehicle_of(scene.allocations[0]))  # for what is sought
    theta = true_parameters(scene.plan, fitted.parameters)
    unseen = (trial for seed in DRIVES for trial in scene.trials(seed, [UNSEEN]).values())
    true = rms(np.array([rms(_errors(fitted, theta, trial)) for trial in unseen]))
    least = rms(np.array([_at_the_bound(scene, seed, fitted, theta) for seed in FITS]))
    return true, least, np.hypot(true, least)


def _at_the_bound(scene: Scene, seed: int, fitted: Model, theta: Array) -> Array:
    """RMS (3,) of the prediction's error that the bound's covariance makes."""
    *training, unseen = scene.trials(seed, (*TRAINING, UNSEEN)).values()
    problem = bounds.problem_of(fitted.vehicle, [t.recording for t in training])
    path = bounds.undisturbed(problem, theta, training)
    noise = bounds.without_process(bounds.true_noise(scene.plan))
    covariance = bounds.inverse(bounds.whole(path, theta, noise))
    slopes = _slopes(fitted, theta, np.sqrt(np.diag(covariance)), unseen)
    squares = np.einsum("nap,pq,naq->na", slopes, covariance, slopes)
    return np.asarray(np.sqrt(squares.mean(axis=0)))


def _errors(model: Model, theta: Array, trial: Trial) -> Array:
    """True less predicted velocities (n, 3) with these parameters."""
    size = len(model.coefficients)
    moved = replace(model, coefficients=theta[:size], constants=theta[size:])
    true = trial.true_motion
    found = predict(moved, trial.recording, HORIZON, velocities=true)
    return np.asarray(true.nu[found.index] - found.nu)


def _slopes(model: Model, theta: Array, error: Array, trial: Trial) -> Array:
    """Derivatives (n, 3, p) of the velocities ahead with respect to the parameters."""
    columns = []
    for i, sigma in enumerate(error):
        step = np.zeros(len(theta))
        step[i] = STEP * sigma
        apart = _errors(model, theta - step, trial) - _errors(model, theta + step, trial)
        columns.append(apart / (2.0 * STEP * sigma))
    return np.stack(columns, axis=2)
