# SPDX-License-Identifier: MIT
"""Scores of right and wrong models beside their true errors, of simulated drives.

python -m benchmarks.studies.reference              # the table, some minutes
python -m benchmarks.studies.reference --write      # into docs/decisions/0009-smoothed-reference.md
"""

import sys
from dataclasses import replace

import numpy as np

import seatrial
from benchmarks.harness import command
from benchmarks.harness.markdown import table
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import noise_entry
from seatrial.boat.schema import NoiseEntry
from seatrial.evaluation.filtering import recording_noise, run_filter
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.prediction import Lookahead, predict
from seatrial.evaluation.reference import smoothed_motion
from seatrial.simulation.trials import Trial
from seatrial.util.frames import Array
from tests.boats.wrong_models import SENSORS, SURE, driven, variants

SECONDS = 400.0
EVERY = 3  # poses from start to start


def scores() -> str:
    """One second ahead: true error, score and stencil's score, in cm/s and 0.01 rad/s."""
    boat = seatrial.load_vehicle("mallard-af")
    rows = []
    for sensor, (rate, position, heading) in SENSORS.items():
        right, trial = driven(boat, sensor, seconds=SECONDS)
        for name, model in variants(right).items():
            likeliest = noise_entry(recording_noise(model, [trial.recording]))
            stated = {"likeliest": likeliest, "none": NoiseEntry(position, heading, SURE)}
            for noise, entry in stated.items():
                cells = _row(replace(model, noise=entry), trial)
                rows.append([f"{sensor}, {rate:g} Hz", name, noise, *map(_three, cells)])
    head = ["poses", "model", "its process noise", "true error", "score", "standard error of the reference",
            "true error from the stencil", "score by the stencil"]  # fmt: skip
    return table(head, rows)


def _row(model: Model, trial: Trial) -> list[Array]:
    recording = trial.recording
    look = Lookahead(
        model,
        recording,
        filtered=run_filter(model, recording),
        smoothed=smoothed_motion(model, recording),
    )
    new, old = look.predict(1.0, EVERY), predict(model, recording, 1.0, every=EVERY)
    found = [
        _true(new, trial), _rms(new.squares), new.reference_error, _true(old, trial), _rms(old.squares),
    ]  # fmt: skip
    return [one for one in found if one is not None]


def _true(ahead: Prediction, trial: Trial) -> Array:
    return _rms((trial.truth[trial.arrived, 3:][ahead.index] - ahead.nu) ** 2)


def _rms(squares: Array) -> Array:
    return np.asarray(np.sqrt(squares.mean(axis=0)))


def _three(values: Array) -> str:
    return " / ".join(f"{100.0 * value:.2f}" for value in values)


if __name__ == "__main__":
    parser = command.parser("studies.reference", __doc__)
    makers = {"scores": scores}
    command.show(
        command.tables(parser, sys.argv[1:], makers), makers, "decisions/0009-smoothed-reference.md"
    )
