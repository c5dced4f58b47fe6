# SPDX-License-Identifier: MIT
"""Whether the covariance is right: against the truth in simulation, against poses of the real ship."""

from typing import Literal

import numpy as np
from scipy.stats import binom, chi2

import seatrial
from benchmarks.predictor.drives import (
    RUNS,
    SCENES,
    SETTLED,
    drive,
    follow,
    model,
    of_recording,
    ship,
    ship_model,
)
from seatrial.frames import Array

SEEDS = range(41, 49)
APART = 5.0  # [s] between samples, which are then nearly independent
SIZE = 6  # pose and velocity
LEVEL = 0.95
AHEAD = 1.0  # [s]
SIGMAS = 1.96  # of one number's 95 % interval
Frame = Literal["earth", "body"]


def squares(errors: Array, covariance: Array) -> Array:
    """e' P^-1 e (n,)."""
    return np.asarray(
        np.einsum("ni,ni->n", errors, np.linalg.solve(covariance, errors[..., None])[..., 0])
    )


def nees(scene: str, seed: int, frame: Frame = "earth") -> Array:
    """Squares on S7, one every APART, by a model of that seed's own S1 to S3."""
    trial = drive(scene, seed)
    predictor = seatrial.Predictor(model(scene, seed), disturbance=frame)
    ask = trial.recording.t
    track = follow(predictor, trial.inputs, ask)
    chosen = np.searchsorted(ask, np.arange(SETTLED, ask[-1], APART))
    return squares(track.errors(trial.truth)[chosen], track.covariance[chosen])


def nees_table() -> str:
    """Markdown: mean and coverage, with what a right covariance would give in 95 of 100 cases."""
    rows = ["| S7 | disturbance | seeds | samples | mean NEES | if right | inside the 95 % region, % | if right |",
            "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |"]  # fmt: skip
    frames: tuple[Frame, ...] = ("earth", "body")
    for scene in SCENES:
        for frame in frames:
            found = np.concatenate([nees(scene, seed, frame) for seed in SEEDS])
            n = len(found)
            mean = " to ".join(f"{x:.2f}" for x in chi2.ppf([0.025, 0.975], SIZE * n) / n)
            share = " to ".join(f"{100 * x / n:.1f}" for x in binom.ppf([0.025, 0.975], n, LEVEL))
            inside = 100.0 * np.mean(found < chi2.ppf(LEVEL, SIZE))
            rows.append(
                f"| {scene} | {frame} | {len(SEEDS)} | {n} | {found.mean():.2f} | {mean} | "
                f"{inside:.1f} | {share} |"
            )
    return "\n".join(rows)


def ahead(vehicle: str, name: str) -> tuple[Array, Array]:
    """Errors (n, 3) of the pose AHEAD of the last pose used, and covariances (n, 3, 3), on a real run.

    Commands go on, poses are that late. With the pose noise, as it is a pose that it is held against.
    """
    run, known = ship(vehicle)[name], ship_model(vehicle, name)
    predictor = seatrial.Predictor(known, window=AHEAD + 0.1)
    ask = run.t[run.valid]
    track = follow(predictor, of_recording(run), ask, delay=AHEAD)
    use = ask > SETTLED + AHEAD
    off = track.state[:, :3] - run.eta[run.valid]
    off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    noise = np.diag([known.noise.position, known.noise.position, known.noise.heading]) ** 2
    return off[use], track.covariance[use, :3, :3] + noise


def ship_table(vehicle: str = "pair") -> str:
    """Markdown: coverage of the real ship's pose one second ahead, model of the other two runs."""
    rows = ["| left out | poses | median error x, mm | y | psi, mrad | within 95 %: x | y | psi | all |",
            "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"]  # fmt: skip
    found = {name: ahead(vehicle, name) for name in RUNS}
    both = [np.concatenate(parts) for parts in zip(*found.values(), strict=True)]
    for name, (off, spread) in {**found, "all": (both[0], both[1])}.items():
        sigma = np.sqrt(np.einsum("nii->ni", spread))
        wrong = " | ".join(f"{1e3 * x:.3g}" for x in np.median(np.abs(off), axis=0))
        inside = np.mean(np.abs(off) < SIGMAS * sigma, axis=0)
        together = np.mean(squares(off, spread) < chi2.ppf(LEVEL, 3))
        shown = " | ".join(f"{100 * x:.1f}" for x in (*inside, together))
        rows.append(f"| {name} | {len(off)} | {wrong} | {shown} |")
    return "\n".join(rows)
