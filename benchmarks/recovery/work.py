# SPDX-License-Identifier: MIT
"""The work of one scene and seed: identify, compare with the truth, record it."""

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import seatrial
from benchmarks.harness.store import Record
from benchmarks.recovery import bounds, moved, terms
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import noise_vector
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.prediction import predict
from seatrial.identification.estimator import OutputErrorSettings
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.regression.equation_error import equation_error
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion, motion
from seatrial.simulation.trials import Trial
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array
from tests.boats.scenes import (
    TRAINING,
    UNSEEN,
    Scene,
    by_thrusters,
    scenes,
    true_parameters,
    vehicle_of,
    without_faults,
)

FIRST = 1001  # seed; those of the tests are others
PIECES = (3.0, 20.0)  # [s] of the free segments that the bounds are given for
SETTLING = 2.0  # [s] that the filter has before predictions start from it
HORIZON = 1.0  # [s]


def groups() -> dict[str, list[str]]:
    """Names of scenes by group; those of `OTHERS` begin with their group."""
    found: dict[str, list[str]] = {group: [] for group in KINDS}
    for scene in scenes().values():
        found[scene.group].append(scene.name)
    return found | {g: [f"{g} {name}" for name in of.SCENES] for g, of in OTHERS.items()}


def one(name: str, seed: int) -> Record:
    """The record of a scene by its name, and of a seed."""
    group, _, rest = name.partition(" ")
    if group not in OTHERS:
        return work(scenes()[name], seed)
    record: Record = {"scene": name, "group": group, "seed": seed}
    try:
        return record | OTHERS[group].work(rest, seed)
    except SeatrialError as failure:
        return record | {"failed": str(failure)}


def work(scene: Scene, seed: int) -> Record:
    """All figures of one scene and seed; `failed`: the message where no model was found."""
    record: Record = {"scene": scene.name, "group": scene.group, "seed": seed}
    try:
        return record | KINDS[scene.group](scene, seed)
    except SeatrialError as failure:
        return record | {"failed": str(failure)}


def _fit(scene: Scene, recordings: Sequence[Recording], vehicle: Vehicle) -> tuple[Model, Record]:
    begin = time.perf_counter()
    model = seatrial.identify(list(recordings), vehicle, method="output-error")
    seconds = time.perf_counter() - begin
    names = model.parameters
    process = model.noise.process
    return model, {
        "seconds": round(seconds, 3),
        "names": list(names),
        "truth": true_parameters(scene.plan, names).tolist(),
        "found": np.concatenate([model.coefficients, model.constants]).tolist(),
        "error": [model.standard_errors[n] for n in names],
        "noise": [model.noise.position, model.noise.heading],
        "process": [] if process is None else _noise_of(model)[2:].tolist(),
    }


def _bounded(scene: Scene, model: Model, trials: Sequence[Trial]) -> Record:
    """Variances of the bounds by name."""
    problem = bounds.problem_of(model.vehicle, [t.recording for t in trials])
    theta = true_parameters(scene.plan, model.parameters)
    noise = bounds.true_noise(scene.plan)
    least = bounds.without_process(noise)
    path = bounds.undisturbed(problem, theta, trials)
    found = {"whole": bounds.whole(path, theta, least)}
    if scene.plan.plant.unmodelled is not None:
        found["process"] = bounds.whole(problem, theta, noise)
    found |= {f"{s:g} s": bounds.pieces(problem, theta, noise, trials, s) for s in PIECES}
    return {name: bounds.variances(info).tolist() for name, info in found.items()}


def still(scene: Scene, seed: int) -> Record:
    """Coefficients, bounds and predictions; the paper's method beside it."""
    trials = scene.trials(seed, (*TRAINING, UNSEEN))
    *training, unseen = trials.values()
    vehicle = vehicle_of(scene.allocations[0])
    recordings = [t.recording for t in training]
    model, record = _fit(scene, recordings, vehicle)
    paper = equation_error(recordings, vehicle)
    record["bound"] = _bounded(scene, model, training)
    record["paper"] = paper.coefficients.tolist()
    return record | {"ahead": ahead(model, paper, unseen)}


def together(scene: Scene, seed: int) -> Record:
    """MP and AF in one fit."""
    vehicle, recordings = by_thrusters(list(scene.trials(seed).values()))
    return _fit(scene, recordings, vehicle)[1]


def faults(scene: Scene, seed: int) -> Record:
    """With jumps and drop-outs; without; and with all these poses left out, as if one knew them."""
    vehicle = vehicle_of(scene.allocations[0])
    spoilt, whole = (
        [t.recording for t in each.trials(seed).values()] for each in (scene, without_faults(scene))
    )
    known = [unspoilt(*pair) for pair in zip(spoilt, whole, strict=True)]
    record, without, missing = (_fit(scene, r, vehicle)[1] for r in (spoilt, whole, known))
    return record | {
        "without": without["found"], "error_without": without["error"], "missing": missing["found"]
    }  # fmt: skip


def unspoilt(spoilt: Recording, whole: Recording) -> Recording:
    """Of the whole recording the poses that are in the spoilt one, too, as they were."""
    row = {stamp: i for i, stamp in enumerate(spoilt.stamps.tolist())}
    there = np.array([row.get(stamp, -1) for stamp in whole.stamps.tolist()])
    same = (there >= 0) & (whole.raw == spoilt.raw[there]).all(axis=1)
    return replace(whole, valid=whole.valid & same)


def noise(scene: Scene, seed: int) -> Record:
    """This method and the paper's, coefficients and predictions."""
    record = still(scene, seed)
    del record["bound"]
    return record


def _noise_of(model: Model) -> Array:
    """The filter's noise as the model states it."""
    noise = noise_vector(model.noise)
    if noise is None:
        raise SeatrialError("the model states no process noise")
    return noise


def causal(model: Model, recording: Recording) -> Motion:
    """Poses and velocities of the model's own filter, each from the poses before it."""
    problem = bounds.problem_of(model.vehicle, [recording])
    problem = replace(problem, outlier=OutputErrorSettings().outlier)  # outliers count less here
    theta = np.concatenate([model.coefficients, model.constants])
    state = filter_along(problem, theta, _noise_of(model)).by_recording[0].state
    valid = recording.valid & (recording.t > SETTLING)
    return Motion(recording.t, state[:, :3], state[:, 3:6], valid)


def ahead(model: Model, paper: Model, trial: Trial) -> dict[str, list[float]]:
    """RMS [m/s, m/s, rad/s] of the velocity 1 s ahead against the true one, model x start.

    All from the same instants.
    """
    recording, true = trial.recording, trial.true_motion
    starts = {"true": true, "filter": causal(model, recording), "stencil": motion(recording)}
    common = np.logical_and.reduce([s.valid for s in starts.values()])
    out = {}
    for start, given in starts.items():
        moving = Motion(given.t, given.eta, given.nu, common)
        for name, used in (("ours", model), ("paper", paper)):
            found = predict(used, recording, HORIZON, velocities=moving)
            error = true.nu[found.index] - found.nu
            out[f"{name} {start}"] = np.sqrt(np.mean(error**2, axis=0)).tolist()
    return out


KINDS = {"still": still, "pushed": still, "together": together, "faults": faults, "noise": noise}
OTHERS = {"moved": moved, "terms": terms}
