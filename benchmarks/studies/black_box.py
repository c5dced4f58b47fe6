# SPDX-License-Identifier: MIT
"""Study: what a black box makes of the model ship: the run left out, one second ahead, by a ridge regression.

    python -m benchmarks.studies.black_box

It predicts what the velocities gain from those at the start, their products, and the commands from some time
before the start to the end. As in `python -m benchmarks.cse1 --auto`, errors are over those of a velocity that
stays. It is an oracle for what these recordings tell, no bound: it has no dynamics and hundreds of coefficients.
"""

import sys
from collections.abc import Sequence

import numpy as np

import seatrial
from benchmarks import cse1
from benchmarks.harness import command
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.util.frames import Array, Stamps
from tests.boats.drives import RUNS, SHIP

AHEAD = 20  # poses in a second
EVERY = 2  # poses from one command among the features to the next
MEMORIES = (0.3, 0.6, 1.0)  # [s] of commands before the start
PROPELLERS = slice(4)  # their commands: port and starboard, along and across
SPEED, SPEED_POWER = 0.4, 2  # thrust is that at this speed, and grows with a power of it
PENALTIES = np.logspace(0.0, 5.0, 8)


def held(signal: Signal, stamps: Stamps) -> Array:
    """The signal's values at stamps, zero-order hold."""
    last = np.searchsorted(signal.stamps, stamps, side="right") - 1
    return np.asarray(signal.values[np.maximum(last, 0)])


def features(run: Recording, memory: float) -> tuple[Array, Array]:
    """Features (n, f) of the starts, and what the velocities gain in a second (n, 3)."""
    truth = cse1.reference(run)
    start = np.flatnonzero(truth.valid[:-AHEAD] & truth.valid[AHEAD:])
    commands = held(run.commands, run.stamps)
    assert run.scales is not None
    commands[:, PROPELLERS] *= (held(run.scales, run.stamps) / SPEED) ** SPEED_POWER
    u, v, r = nu = truth.nu[start].T
    parts = [*nu, *(abs(nu) * nu), u * v, u * r, v * r, abs(u) * v, abs(u) * r, r * r]
    offsets = range(-round(memory * AHEAD), AHEAD + 1, EVERY)
    rows = [commands[np.clip(start + k, 0, len(commands) - 1)] for k in offsets]
    return np.column_stack([*parts, *rows]), truth.nu[start + AHEAD] - truth.nu[start]


def ridge(x: Array, y: Array) -> tuple[Array, float]:
    """Coefficients of standardised features and the mean, the penalty by generalised cross-validation.

    Golub, Heath, Wahba, Technometrics 21, 215, 1979.
    """
    mean = float(y.mean())
    left, sizes, right = np.linalg.svd(x, full_matrices=False)
    along = left.T @ (y - mean)
    best, chosen = np.inf, np.zeros(x.shape[1])
    for penalty in PENALTIES:
        kept = sizes**2 / (sizes**2 + penalty)
        misfit = np.sum((y - mean) ** 2) - np.sum((2.0 * kept - kept**2) * along**2)
        score = misfit / (len(y) - kept.sum()) ** 2
        if score < best:
            best, chosen = score, right.T @ (kept * along / sizes)
    return chosen, mean


def ratios(runs: dict[str, Recording], left_out: str, memory: float) -> Array:
    """Error over that of a velocity that stays as it is (3,), on the run left out."""
    known = [features(run, memory) for name, run in runs.items() if name != left_out]
    x, y = (np.concatenate(part) for part in zip(*known, strict=True))
    centre, size = x.mean(axis=0), x.std(axis=0)
    new, gained = features(runs[left_out], memory)
    found = []
    for axis in range(3):
        weights, mean = ridge((x - centre) / size, y[:, axis])
        wrong = gained[:, axis] - mean - (new - centre) / size @ weights
        found.append(np.sqrt(np.mean(wrong**2) / np.mean(gained[:, axis] ** 2)))
    return np.array(found)


def main(arguments: Sequence[str]) -> None:
    """Print a line for each memory of commands."""
    command.parser("black_box", __doc__).parse_args(arguments)
    vehicle = seatrial.load_vehicle(SHIP / "vehicle.yaml")
    runs = {n: seatrial.read(SHIP / "csv" / f"CSE1_data_{n}.csv", vehicle) for n in RUNS}
    print("commands of the last    u     v     r   mean; of", ", ".join(runs))
    for memory in MEMORIES:
        each = np.array([ratios(runs, name, memory) for name in runs])
        shown = "; ".join(" ".join(f"{x:.2f}" for x in row) for row in each)
        print(
            f"{memory:10.1f} s          {'  '.join(f'{x:.3f}' for x in each.mean(axis=0))};  {shown}"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
