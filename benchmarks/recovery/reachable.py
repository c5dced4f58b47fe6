# SPDX-License-Identifier: MIT
"""S7 one second ahead from true starts: what the true parameters score, and any estimator at the bound.

The true model's error is that of the recording: its stamps jitter. An estimate adds
J (estimate - truth) to first order, whose mean square has the bound's covariance in it at least.
"""

from dataclasses import replace

import numpy as np

import seatrial
from benchmarks.recovery import bounds
from benchmarks.recovery.scenes import (
    ALLOCATIONS,
    PRESETS,
    TRAINING,
    UNSEEN,
    scenes,
    true_parameters,
    vehicle_of,
)
from benchmarks.recovery.tables import SYMBOLS, rms, table
from benchmarks.recovery.work import HORIZON
from seatrial.frames import Array
from seatrial.model import Model
from seatrial.predict import predict
from seatrial.simulate import Trial

SEEDS = range(1001, 1005)  # they hardly differ
STEP = 0.1  # of a standard error, for differences
ROWS = ("true parameters", "error at the bound, alone", "both together: the least there is")


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
    true, least = [], []
    fitted: Model | None = None  # says what is sought; its values are replaced by the true ones
    for seed in SEEDS:
        *training, unseen = scene.trials(seed, (*TRAINING, UNSEEN)).values()
        recordings = [t.recording for t in training]
        if fitted is None:
            fitted = seatrial.identify(recordings, vehicle_of(scene.allocations[0]))
        theta = true_parameters(scene.plan, fitted.parameters)
        problem = bounds.problem_of(fitted.vehicle, recordings)
        path = bounds.undisturbed(problem, theta, training)
        noise = bounds.without_process(bounds.true_noise(scene.plan))
        covariance = bounds.inverse(bounds.whole(path, theta, noise))
        slopes = _slopes(fitted, theta, np.sqrt(np.diag(covariance)), unseen)
        least.append(np.sqrt(np.einsum("nap,pq,naq->na", slopes, covariance, slopes).mean(axis=0)))
        true.append(rms(_errors(fitted, theta, unseen)))
    alone = rms(np.array(true)), rms(np.array(least))
    return *alone, np.hypot(*alone)


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
