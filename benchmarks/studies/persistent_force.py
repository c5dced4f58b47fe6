# SPDX-License-Identifier: MIT
"""Study: how much of what a model of the ship leaves unexplained stays for a second.

    python -m benchmarks.studies.persistent_force [--vehicle data/cse1/pair.yaml]

What the model missed in the half second before a start, times a gain, is added to its prediction one second
ahead. The gain of each axis is by least squares on the runs that identify the model (`structure: auto`). Start and
reference are those of `python -m benchmarks.cse1 --auto`. Errors are over those of a velocity that stays, on the
run left out.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import seatrial
from benchmarks import cse1
from benchmarks.harness import command
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array
from tests.boats.drives import RUNS, SHIP

AHEAD, BEFORE = 1.0, 0.5  # [s]


@dataclass(frozen=True)
class Missed:
    """Velocity changes (n, 3) that a model does not predict."""

    before: Array  # in `BEFORE` up to the start
    ahead: Array  # in `AHEAD` from it
    change: Array  # of the velocity in `AHEAD`

    def ratios(self, gain: Array) -> Array:
        """RMS error (3,) with a gain (3,), over that of a velocity that stays."""
        wrong = self.ahead - gain * self.before
        return np.asarray(np.sqrt(np.mean(wrong**2, axis=0) / np.mean(self.change**2, axis=0)))


def missed(model: seatrial.Model, run: Recording) -> Missed:
    """Along a run, by the reference of the gate."""
    truth = cse1.reference(run)
    far, near = (seatrial.predict(model, run, h, velocities=truth) for h in (AHEAD, BEFORE))
    before = np.full((len(run.t), 3), np.nan)
    before[near.index] = near.errors
    before = before[far.begun]
    known = np.isfinite(before).all(axis=1) & np.isfinite(far.errors).all(axis=1)
    return Missed(before[known], far.errors[known], (far.measured - far.start)[known])


def gains(known: Sequence[Missed]) -> Array:
    """The gain (3,) of each axis, by least squares."""
    before, ahead = (np.concatenate([getattr(m, n) for m in known]) for n in ("before", "ahead"))
    return np.asarray(np.sum(before * ahead, axis=0) / np.sum(before**2, axis=0))


def main(arguments: Sequence[str]) -> None:
    """Print a line for each run left out, and the means."""
    parser = command.parser("persistent_force", __doc__)
    parser.add_argument("--vehicle", type=Path, default=SHIP / "pair.yaml")
    vehicle = seatrial.load_vehicle(parser.parse_args(arguments).vehicle)
    vehicle = vehicle.with_automatic_structure()
    runs = {n: seatrial.read(SHIP / "csv" / f"CSE1_data_{n}.csv", vehicle) for n in RUNS}
    print("u, v, r: the model; with what it missed before, times the gain; gain")
    rows = []
    for left_out in RUNS:
        others = [run for name, run in runs.items() if name != left_out]
        model = seatrial.identify(others, vehicle)
        gain = gains([missed(model, run) for run in others])
        of_run = missed(model, runs[left_out])
        rows.append(np.array([of_run.ratios(np.zeros(3)), of_run.ratios(gain), gain]))
        _show(left_out, rows[-1])
    _show("mean", np.mean(rows, axis=0))


def _show(name: str, rows: Array) -> None:
    print(f"{name:12}", *(" ".join(f"{x:.3f}" for x in row) for row in rows), sep="  ")


if __name__ == "__main__":
    main(sys.argv[1:])
