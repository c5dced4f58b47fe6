# SPDX-License-Identifier: MIT
"""Whether the covariance is right: against the truth in simulation, against poses of the real ship."""

from dataclasses import replace
from typing import Literal

import numpy as np
from scipy.stats import binom, chi2, t

import seatrial
from benchmarks.predictor.accuracy import rms
from benchmarks.predictor.drives import (
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
from seatrial.frames import Array
from seatrial.schema import NoiseEntry

SEEDS = range(41, 65)
FEWER = SEEDS[:8]  # where each takes longer
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


def nees(scene: str, seed: int, frame: Frame = "earth") -> Array:
    """Squares on S7, by a model of that seed's own S1 to S3."""
    return sampled(*followed(scene, seed, model(scene, seed), frame))


def verdict(found: Array) -> str:
    """Cells: samples, mean and coverage, with what a right covariance would give in 95 of 100."""
    n = len(found)
    mean = " to ".join(f"{x:.2f}" for x in chi2.ppf([0.025, 0.975], SIZE * n) / n)
    share = " to ".join(f"{100 * x / n:.1f}" for x in binom.ppf([0.025, 0.975], n, LEVEL))
    inside = 100.0 * np.mean(found < chi2.ppf(LEVEL, SIZE))
    return f"{n} | {found.mean():.2f} | {mean} | {inside:.1f} | {share}"


def by_seeds(found: list[Array]) -> str:
    """95 % interval of the mean by the scatter of the seeds' means: a seed's samples share a model."""
    means = np.array([each.mean() for each in found])
    half = t.ppf(0.975, len(means) - 1) * means.std(ddof=1) / np.sqrt(len(means))
    return f"{means.mean() - half:.2f} to {means.mean() + half:.2f}"


def nees_table() -> str:
    """Markdown: mean and coverage, with what a right covariance would give in 95 of 100 cases."""
    rows = ["| S7 | disturbance | seeds | samples | mean NEES | if right | inside the 95 % region, % | if right | "
            "mean NEES, 95 % by seeds |",
            "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"]  # fmt: skip
    frames: tuple[Frame, ...] = ("earth", "body")
    for scene in SCENES:
        for frame in frames:
            found = [nees(scene, seed, frame) for seed in SEEDS]
            told = f"{verdict(np.concatenate(found))} | {by_seeds(found)}"
            rows.append(f"| {scene} | {frame} | {len(SEEDS)} | {told} |")
    return "\n".join(rows)


def taken_for_white(known: seatrial.Model) -> seatrial.Model:
    """The model with all of its pose noise white, of the same size."""
    noise, hangs = known.noise, known.noise.correlated
    if hangs is None:
        return known
    position = float(np.hypot(noise.position, hangs.position))
    heading = float(np.hypot(noise.heading, hangs.heading))
    return replace(known, noise=NoiseEntry(position, heading, noise.process))


def correlated_table() -> str:
    """Markdown: pose errors that hang together, as states and taken for white ones.

    Where the estimator found none there is nothing to choose: a row of its own.
    """
    rows = ["| S7 | pose errors | seeds | samples | mean NEES | if right | inside the 95 % region, % | "
            "if right | RMS error u, mm/s | v, mm/s | r, mrad/s |",
            "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"]  # fmt: skip
    for scene in CORRELATED.values():
        models = {seed: model(scene, seed) for seed in FEWER}
        found = {s: m for s, m in models.items() if m.noise.correlated is not None}
        ways = {
            "states of the filter": found,
            "taken for white": {s: taken_for_white(m) for s, m in found.items()},
            "not found by the estimator": {s: m for s, m in models.items() if s not in found},
        }
        for way, known in ways.items():
            if not known:
                continue
            followed_all = [followed(scene, seed, m) for seed, m in known.items()]
            squared = np.concatenate([sampled(*one) for one in followed_all])
            moving = np.concatenate([e[track.t > SETTLED, 3:] for track, e in followed_all])
            mm = " | ".join(f"{1e3 * x:.3g}" for x in rms(moving))
            rows.append(f"| {scene} | {way} | {len(known)} | {verdict(squared)} | {mm} |")
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
