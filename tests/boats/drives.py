# SPDX-License-Identifier: MIT
"""Drives to follow: simulated ones with their truth, the real ship's, and models of either."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
from scipy.interpolate import CubicSpline

import seatrial
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import DisturbanceForce
from seatrial.simulation.trials import Trial
from seatrial.util.frames import Array
from tests.boats.plans import planned
from tests.boats.scenes import CORRELATION, TRAINING, driven, pushed

SCENES = {"hard": 0.0, "hard, pushed": 0.04}  # share of full thrust that no model knows of
LASTS = 2.0  # [s]
CORRELATED = {name: f"{name}, correlated" for name in SCENES}  # the same but for the poses' errors
PUSHES = {**SCENES, **{CORRELATED[name]: share for name, share in SCENES.items()}}
SETTLED = 5.0  # [s] from the start, not counted
SHIP = Path(__file__).parents[2] / "data" / "cse1"
RUNS = ("run1", "random_run1", "random_run3")


@dataclass(frozen=True)
class Inputs:
    """What a predictor gets."""

    command_t: Array  # (m,) [s]
    command: Array  # (m, inputs)
    pose_t: Array  # (n,) [s]
    pose: Array  # (n, 3) as the SLAM gives them, with false matches
    scale_t: Array  # (k,) [s]
    scale: Array  # (k, scales)

    def events(self, delay: float = 0.0) -> Iterator[tuple[float, str, float, Array]]:
        """Arrival, kind, stamp, values in the order of arrival; poses arrive `delay` [s] late."""
        kinds = [
            (self.scale_t, self.scale_t, "scale", self.scale),
            (self.command_t, self.command_t, "command", self.command),
            (self.pose_t + delay, self.pose_t, "pose", self.pose),
        ]
        rows = [
            (arrival, order, kind, stamp, row)
            for order, (arrivals, stamps, kind, values) in enumerate(kinds)
            for arrival, stamp, row in zip(arrivals.tolist(), stamps.tolist(), values, strict=True)
        ]
        for arrival, _, kind, stamp, row in sorted(rows, key=lambda r: r[:2]):
            yield arrival, kind, stamp, row


def of_recording(recording: Recording) -> Inputs:
    """A recording's raw signals, without poses that the sensor itself marks as none."""
    good = np.isfinite(recording.raw).all(axis=1)
    for fault in recording.faults:
        if fault.kind is FaultKind.MARKED:
            good &= (recording.t < fault.start) | (recording.t > fault.end)
    scales = recording.scales
    return Inputs(
        recording.seconds(recording.commands.stamps), recording.commands.values,
        recording.t[good], recording.raw[good],
        np.zeros(0) if scales is None else recording.seconds(scales.stamps),
        np.zeros((0, 0)) if scales is None else scales.values,
    )  # fmt: skip


@dataclass(frozen=True)
class Drive:
    """Simulated inputs, and the truth at the stamp of every pose."""

    recording: Recording
    inputs: Inputs
    truth: Array  # (n, 6) x, y, psi, u, v, r


def of_trial(trial: Trial) -> Drive:
    """The truth by the poses' stamps: what they jitter, the boat has moved on."""
    path = CubicSpline(trial.truth_t, trial.truth)
    truth = path(trial.pose_stamps * 1e-9)
    return Drive(trial.recording, of_recording(trial.recording), truth)


@cache
def trials(scene: str, seed: int, names: tuple[str, ...]) -> dict[str, Trial]:
    """Trials by name. The preset's false matches are left out: `matches` has its own."""
    plan = pushed("hard", DisturbanceForce(PUSHES[scene], LASTS) if PUSHES[scene] else None)
    jumps = msgspec.structs.replace(plan.pose.jumps, per_minute=0.0)
    correlation = CORRELATION if scene in CORRELATED.values() else 0.0
    plan = planned(plan, pose={"jumps": jumps, "noise_correlation": correlation})
    return driven(plan, seatrial.load_vehicle("mallard-mp"), seed, names)


@cache
def drive(scene: str, seed: int) -> Drive:
    """S7."""
    return of_trial(trials(scene, seed, ("S7",))["S7"])


@cache
def model(scene: str, seed: int, method: str = "output-error") -> seatrial.Model:
    """Identified from S1 to S3."""
    made = trials(scene, seed, TRAINING)
    recordings = [made[name].recording for name in TRAINING]
    return seatrial.identify(recordings, made["S1"].vehicle, method=method)


@cache
def ship(vehicle: str) -> dict[str, Recording]:
    """The real runs."""
    known = seatrial.load_vehicle(SHIP / f"{vehicle}.yaml")
    return {n: seatrial.read(SHIP / "csv" / f"CSE1_data_{n}.csv", known) for n in RUNS}


@cache
def ship_model(vehicle: str, left_out: str) -> seatrial.Model:
    """Identified from the other two runs."""
    others = [r for name, r in ship(vehicle).items() if name != left_out]
    return seatrial.identify(others, seatrial.load_vehicle(SHIP / f"{vehicle}.yaml"))


@dataclass(frozen=True)
class Track:
    """Estimates at given times."""

    t: Array  # (n,) [s]
    state: Array  # (n, 6) pose and velocity
    covariance: Array  # (n, 6, 6)
    health: Sequence[seatrial.Health]

    def errors(self, truth: Array) -> Array:
        """Estimate less truth (n, 6), the heading's in (-pi, pi]."""
        off = self.state - truth
        off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
        return np.asarray(off)


def give(predictor: seatrial.Predictor, kind: str, stamp: float, values: Array) -> seatrial.Taken:
    """One input."""
    calls = {"pose": predictor.pose, "command": predictor.command, "scale": predictor.scale}
    return calls[kind](stamp, values)


def follow(predictor: seatrial.Predictor, inputs: Inputs, ask: Array, delay: float = 0.0) -> Track:
    """Estimates at rising times (n,) [s], from the inputs that have arrived by then."""
    found = []
    events = inputs.events(delay)
    event = next(events, None)
    for t in ask.tolist():
        while event is not None and event[0] <= t:
            give(predictor, *event[1:])
            event = next(events, None)
        found.append(predictor.at(t))
    return Track(
        ask, np.array([np.concatenate([e.pose, e.velocity]) for e in found]),
        np.array([e.covariance for e in found]), [e.health for e in found],
    )  # fmt: skip
