# SPDX-License-Identifier: MIT
"""Whether the covariance is right: against the truth in simulation, against poses of the real ship."""

from dataclasses import replace
from typing import Literal

import msgspec
import numpy as np
from scipy.stats import binom, chi2, t

import seatrial
from benchmarks.predictor.accuracy import rms
from seatrial.boat.schema import NoiseEntry
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95
from tests.boats.drives import (
    CORRELATED,
    RUNS,
    SCENES,
    SETTLED,
    Track,
    drive,
    follow,
    model,
    of_recording,
    ship,
    ship_model,
)

SEEDS = range(41, 65)
FEWER = SEEDS[:8]  # where each takes longer
APART = 5.0  # [s] between samples, which are then nearly independent
SIZE = 6  # pose and velocity
LEVEL = 0.95
AHEAD = 1.0  # [s]
Frame = Literal["earth", "body"]


def squares(errors: Array, covariance: Array) -> Array:
    """e' P^-1 e (n,)."""
    return np.asarray(
        np.einsum("ni,ni->n", errors, np.linalg.solve(covariance, errors[..., None])[..., 0])
    )


def followed(
    scene: str, seed: int, known: seatrial.Model, frame: Frame = "earth"
) -> tuple[Track, Array]:
    """S7 at every pose, and its errors (n, 6)."""
    trial = drive(scene, seed)
    predictor = seatrial.Predictor(known, disturbance=frame)
    track = follow(predictor, trial.inputs, trial.recording.t)
    return track, track.errors(trial.truth)


def sampled(track: Track, errors: Array) -> Array:
    """Squares, one every APART."""
    chosen = np.searchsorted(track.t, np.arange(SETTLED, track.t[-1], APART))
    return squares(errors[chosen], track.covariance[chosen])


def nees(scene: str, seed: int, frame: Frame = "earth", *, noise: bool = False) -> Array:
    """Squares on S7, by a model of that seed's own S1 to S3; `noise`: its parameter errors as process noise."""
    known = model(scene, seed)
    return sampled(
        *followed(scene, seed, with_mismatch(known, explained=False) if noise else known, frame)
    )


def with_mismatch(known: seatrial.Model, *, explained: bool) -> seatrial.Model:
    """The model with its parameter errors as Schmidt–Kalman states (explained), or as process noise."""
    settings = {**known.estimator.settings, "belief": 0.0 if explained else 1.0}
    return replace(known, estimator=msgspec.structs.replace(known.estimator, settings=settings))


def verdict(found: list[Array]) -> str:
    """Cells: mean and coverage, each with its 95 % interval by the scatter of the seeds.

    And with what a right covariance would give in 95 of 100 cases, were all samples independent. Those
    of a seed share one model, and all of its errors.
    """
    every = np.concatenate(found)
    n = len(every)
    inside = [100.0 * (each < chi2.ppf(LEVEL, SIZE)) for each in found]
    alone = [
        chi2.ppf([0.025, 0.975], SIZE * n) / n,
        100.0 / n * binom.ppf([0.025, 0.975], n, LEVEL),
    ]
    cells = []
    for values, (low, high), digits in zip((found, inside), alone, (2, 1), strict=True):
        means = np.array([each.mean() for each in values])
        half = t.ppf(0.975, len(means) - 1) * means.std(ddof=1) / np.sqrt(len(means))
        cells += [
            f"{np.concatenate(values).mean():.{digits}f}",
            f"{means.mean() - half:.{digits}f} to {means.mean() + half:.{digits}f}",
            f"{low:.{digits}f} to {high:.{digits}f}",
        ]
    return " | ".join([str(len(found)), str(n), *cells])


VERDICT = ("seeds | samples | mean NEES | 95 % by seeds | consistent, independent samples | "
           "inside the 95 % region, % | 95 % by seeds | consistent, independent samples")  # fmt: skip
RULE = " | ".join(["---:"] * len(VERDICT.split("|")))


def nees_table() -> str:
    """Markdown: mean and coverage."""
    rows = [f"| S7 | disturbance | {VERDICT} |", f"| --- | --- | {RULE} |"]
    ways: dict[str, tuple[Frame, bool]] = {
        "earth": ("earth", False),
        "body": ("body", False),
        "earth, parameter errors as noise": ("earth", True),
    }
    for scene in SCENES:
        for way, (frame, noise) in ways.items():
            found = [nees(scene, seed, frame, noise=noise) for seed in SEEDS]
            rows.append(f"| {scene} | {way} | {verdict(found)} |")
    return "\n".join(rows)


def as_white(known: seatrial.Model) -> seatrial.Model:
    """The model with all of its pose noise white, of the same size."""
    noise, coloured = known.noise, known.noise.correlated
    if coloured is None:
        return known
    position = float(np.hypot(noise.position, coloured.position))
    heading = float(np.hypot(noise.heading, coloured.heading))
    return replace(known, noise=NoiseEntry(position, heading, noise.process))


def correlated_table() -> str:
    """Markdown: correlated pose errors, as states and assumed white.

    Where the estimator found none there is nothing to choose: a row of its own.
    """
    rows = [f"| S7 | pose errors | {VERDICT} | RMS error u, mm/s | v, mm/s | r, mrad/s |",
            f"| --- | --- | {RULE} | ---: | ---: | ---: |"]  # fmt: skip
    for scene in CORRELATED.values():
        models = {seed: model(scene, seed) for seed in FEWER}
        found = {s: m for s, m in models.items() if m.noise.correlated is not None}
        ways = {
            "filter states": found,
            "assumed white": {s: as_white(m) for s, m in found.items()},
            "not found by the estimator": {s: m for s, m in models.items() if s not in found},
        }
        for way, known in ways.items():
            if not known:
                continue
            followed_all = [followed(scene, seed, m) for seed, m in known.items()]
            squared = [sampled(*one) for one in followed_all]
            moving = np.concatenate([e[track.t > SETTLED, 3:] for track, e in followed_all])
            mm = " | ".join(f"{1e3 * x:.3g}" for x in rms(moving))
            rows.append(f"| {scene} | {way} | {verdict(squared)} | {mm} |")
    return "\n".join(rows)


def ahead(run: Recording, known: seatrial.Model) -> tuple[Array, Array]:
    """Errors (n, 3) of the pose AHEAD of the last pose used, and covariances (n, 3, 3), on a real run.

    Commands go on, poses are that late. With the pose noise, as it is a pose that it is held against.
    """
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
    runs, models = ship(vehicle), {name: ship_model(vehicle, name) for name in RUNS}
    found = {name: ahead(runs[name], models[name]) for name in RUNS}
    considered = {n: ahead(runs[n], with_mismatch(m, explained=True)) for n, m in models.items()}
    ways = {"all": found, "all, Schmidt–Kalman parameters": considered}
    pooled = {
        way: tuple(np.concatenate(parts) for parts in zip(*each.values(), strict=True))
        for way, each in ways.items()
    }
    for name, (off, spread) in {**found, **pooled}.items():
        sigma = np.sqrt(np.einsum("nii->ni", spread))
        wrong = " | ".join(f"{1e3 * x:.3g}" for x in np.median(np.abs(off), axis=0))
        inside = np.mean(np.abs(off) < NORMAL_95 * sigma, axis=0)
        together = np.mean(squares(off, spread) < chi2.ppf(LEVEL, 3))
        shown = " | ".join(f"{100 * x:.1f}" for x in (*inside, together))
        rows.append(f"| {name} | {len(off)} | {wrong} | {shown} |")
    return "\n".join(rows)
