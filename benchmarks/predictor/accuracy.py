# SPDX-License-Identifier: MIT
"""Velocity against truth, beside differentiated poses; pose after poses have stopped."""

import numpy as np

import seatrial
from benchmarks.cse1 import local_polynomial
from seatrial.recording.velocity import Motion, motion
from seatrial.util.frames import Array
from tests.boats.drives import SCENES, SETTLED, Drive, Inputs, drive, follow, model

SEED = 31
WINDOWS = range(3, 32, 2)  # poses of a Savitzky-Golay filter
DEGREES = (1, 2, 3)
HORIZONS = (1.0, 5.0, 10.0, 30.0)  # [s] after the last pose
WARM = 15.0  # [s] of poses before they stop
EVERY = 5.0  # [s] between such stops
STEP = 0.01  # [s] of a boat whose velocity stays constant


def rms(errors: Array) -> Array:
    """Root mean square, column by column."""
    return np.asarray(np.sqrt(np.mean(errors**2, axis=0)))


def best_past(trial: Drive) -> tuple[Motion, str]:
    """The local polynomial through past poses that is nearest to the truth, seen afterwards."""
    tried = []
    for degree in DEGREES:
        for width in (w for w in WINDOWS if w > degree):
            got = local_polynomial(trial.recording, width, degree, width - 1)
            use = got.valid & (trial.recording.t > SETTLED)
            wrong = rms((got.nu - trial.truth[:, 3:])[use])
            share = wrong / rms(trial.truth[use, 3:])
            tried.append((float(np.sum(share**2)), f"{width} poses, degree {degree}", got))
    _, name, got = min(tried, key=lambda x: x[0])
    return got, name


def velocity(scene: str) -> list[tuple[str, Array]]:
    """RMS errors (3,) of u, v [m/s], r [rad/s] on S7, by whose they are; same instants."""
    trial = drive(scene, SEED)
    past, name = best_past(trial)
    stencil = motion(trial.recording)
    track = follow(seatrial.Predictor(model(scene, SEED)), trial.inputs, trial.recording.t)
    use = past.valid & stencil.valid & (trial.recording.t > SETTLED)
    true = trial.truth[use, 3:]
    return [
        ("five-point stencil (two poses of the future)", rms(stencil.nu[use] - true)),
        (f"best Savitzky-Golay of the past ({name})", rms(past.nu[use] - true)),
        ("predictor", rms(track.state[use, 3:] - true)),
    ]


def velocity_table() -> str:
    """Markdown."""
    rows = ["| S7 | velocity by | u, mm/s | v, mm/s | r, mrad/s | stencil over it: u | v | r |",
            "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |"]  # fmt: skip
    for scene in SCENES:
        found = velocity(scene)
        for name, wrong in found:
            mm = " | ".join(f"{1e3 * x:.3g}" for x in wrong)
            ratio = " | ".join(f"{x:.3g}" for x in found[0][1] / wrong)
            rows.append(f"| {scene} | {name} | {mm} | {ratio} |")
    return "\n".join(rows)


def stops(trial: Drive) -> Array:
    """Poses (m,) after which none comes any more."""
    t = trial.recording.t
    begins = np.arange(WARM + SETTLED, t[-1] - HORIZONS[-1] - 1.0, EVERY)
    return np.searchsorted(t, begins)


def until(inputs: Inputs, first: float, last: float, end: float) -> Inputs:
    """Poses of [first, last] [s], commands of [first, end]."""
    own = (inputs.pose_t >= first) & (inputs.pose_t <= last)
    driven = (inputs.command_t >= first) & (inputs.command_t <= end)
    return Inputs(
        inputs.command_t[driven], inputs.command[driven], inputs.pose_t[own], inputs.pose[own],
        inputs.scale_t, inputs.scale,
    )  # fmt: skip


def reckoned(known: seatrial.Model, trial: Drive) -> Array:
    """Position errors (stops, horizons) [m] of the predictor."""
    t, out = trial.recording.t, []
    for k in stops(trial):
        ask = t[k] + np.array(HORIZONS)
        given = until(trial.inputs, t[k] - WARM, t[k], ask[-1])
        track = follow(seatrial.Predictor(known), given, ask)
        out.append(np.hypot(*(track.state[:, :2] - position(trial, ask)).T))
    return np.array(out)


def position(trial: Drive, t: Array) -> Array:
    """True x, y (n, 2) at t; straight lines between poses."""
    return np.column_stack([np.interp(t, trial.recording.t, trial.truth[:, i]) for i in (0, 1)])


def constant(trial: Drive) -> Array:
    """Position errors (stops, horizons) [m] of a velocity that stays as the best past filter has it."""
    past, _ = best_past(trial)
    known = np.flatnonzero(past.valid)
    steps = np.arange(0.0, HORIZONS[-1] + STEP / 2, STEP)
    out = []
    for stop in stops(trial):
        k = known[known <= stop][-1]
        x, y, psi = past.eta[k]
        u, v, r = past.nu[k]
        heading = psi + r * (steps + STEP / 2)
        east = x + np.cumsum(STEP * (u * np.cos(heading) - v * np.sin(heading)))
        north = y + np.cumsum(STEP * (u * np.sin(heading) + v * np.cos(heading)))
        ask = trial.recording.t[k] + np.array(HORIZONS)
        at = np.array([round(h / STEP) - 1 for h in HORIZONS])
        out.append(np.hypot(*(np.column_stack([east, north])[at] - position(trial, ask)).T))
    return np.array(out)


def reckoning_table() -> str:
    """Markdown: medians over the stops."""
    head = " | ".join(f"after {h:g} s" for h in HORIZONS)
    rows = [
        f"| S7 | position error [m], median by | {head} |",
        "| --- | --- " + "| ---: " * len(HORIZONS) + "|",
    ]
    for scene in SCENES:
        trial = drive(scene, SEED)
        found = {
            "predictor": reckoned(model(scene, SEED), trial),
            "predictor with the paper's model (equation-error)": reckoned(
                model(scene, SEED, "equation-error"), trial
            ),
            "constant velocity, from the best past filter": constant(trial),
        }
        for name, errors in found.items():
            shown = " | ".join(f"{x:.2g}" for x in np.median(errors, axis=0))
            rows.append(f"| {scene} ({len(errors)} stops) | {name} | {shown} |")
    return "\n".join(rows)
