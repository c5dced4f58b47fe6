# SPDX-License-Identifier: MIT
"""A hand or a wall moves the boat in one of three recordings: whether that is seen, and what it does.

    python -m benchmarks.bumps --seeds 10

Of every scene S1 to S3 as they are; with S1 in which the boat is pushed for a fifth of a second at 60 s, twice
as hard as full thrust does, in every axis; and with S2 at whose end it is carried about for 12 s. Each is
identified, and again without what `identify` advises to leave out.
"""

import argparse
import os
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from unittest.mock import patch

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy

import numpy as np

from benchmarks.recovery.scenes import Scene, scenes, true_parameters, vehicle_of
from seatrial.boat.findings import Finding, FindingKind, of_kinds
from seatrial.boat.model import Model
from seatrial.control.tuning.linear import linearise
from seatrial.evaluation.disturbed_intervals import clearest, squared_errors
from seatrial.identification.estimator import fit
from seatrial.recording.recording import Recording, make_recording
from seatrial.simulation import trials
from seatrial.simulation.plan import Unmodelled
from seatrial.simulation.trials import PUSH
from seatrial.util.errors import IdentificationError

SCENES = ("paper-like MP", "hard MP", "hard AF", "hard MP pushed")
FIRST = 5001  # seed
AT, LASTS = 60.0, 0.2  # [s]
BUMP = 2.0  # times full thrust
HELD = 12.0  # [s] at the end


class BumpedPlant(trials.PushedPlant):
    """The plant with a push from outside."""

    def __init__(self, model: Model, force: Unmodelled | None, rng: np.random.Generator) -> None:
        super().__init__(model, force, rng)
        self.push = BUMP * np.asarray(linearise(model).authority)

    def advance_to(self, t: float) -> bool:
        """On to t [s]."""
        for moment in AT + np.arange(0.0, LASTS, PUSH):
            if self.time < moment <= t:
                super().advance_to(moment)
                state = self.state
                state[3:] -= PUSH * self.push
                self.state = state
        return super().advance_to(t) if t > self.time else True


def bumped(scene: Scene, seed: int, name: str) -> Recording:
    """One of the scene's recordings with a bump."""
    with patch.object(trials, "PushedPlant", BumpedPlant):
        (trial,) = scene.trials(seed, [name]).values()
    return trial.recording


def carried(recording: Recording) -> Recording:
    """The boat carried about by hand at the end."""
    eta = recording.raw.copy()
    here = recording.t > recording.duration - HELD
    s = recording.t[here] - recording.t[here][0]
    moved = np.column_stack([1.0 - np.cos(0.5 * s), 0.6 * np.sin(0.7 * s), 1.2 * np.sin(0.4 * s)])
    eta[here] += 0.5 * moved
    return make_recording(recording.name, recording.stamps, eta, recording.commands)


@dataclass(frozen=True)
class Row:
    """What came of one fit."""

    errors: dict[str, float]
    off: np.ndarray  # standard errors
    advice: tuple[tuple[str, float, float], ...]  # name, from, to
    gain: float  # of the clearest stretch


def found(scene: Scene, recordings: Sequence[Recording]) -> Row:
    """Identified; or what was said instead."""
    try:
        solved = fit(recordings, vehicle_of(scene.allocations[0]))
    except IdentificationError as error:
        return Row({}, np.full(1, np.nan), refused(str(error)), np.nan)
    truth = true_parameters(scene.plan, solved.names)
    error = np.array([solved.errors[n] for n in solved.names])
    used = error > 0.0
    off = (solved.theta[list(solved.problem.free)] - truth)[used] / error[used]
    squares = [squared_errors(p) for p in solved.runs.by_recording]
    return Row(solved.errors, off, left_out(solved.findings), clearest(recordings, squares).gain)


def left_out(findings: Sequence[Finding]) -> tuple[tuple[str, float, float], ...]:
    """The disturbed intervals that are to be left out."""
    found = of_kinds(findings, FindingKind.DISTURBED_INTERVAL)
    return tuple((f.part("recording"), f.number("start"), f.number("end")) for f in found)


def refused(message: str) -> tuple[tuple[str, float, float], ...]:
    """The same of a refusal, which has them as options."""
    options = re.findall(r"--without '?(\S+?)'?=([\d.]+)-(\d+(?:\.\d+)?)", message)
    return tuple((name, float(begin), float(end)) for name, begin, end in options)


def main(arguments: Sequence[str]) -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    given = parser.parse_args(arguments)
    known = scenes()
    print(
        f"{'':<22} {'':<9} {'seen':>7}  {'standard errors, times those of':<34} {'largest error':<22}   "
        f"clearest stretch\n{'scene':<22} {'moved by':<9} {'in':>7}  {'nothing: with it':>17} "
        f"{'without it':>16} {'with it':>10} {'without it':>11}   {'gain':>7}"
    )
    for name in given.scenes:
        scene, rows = known[name], []
        for seed in range(FIRST, FIRST + given.seeds):
            rows.append(compared(scene, seed))
            print(f"  {name}, seed {seed}", end="\r", file=sys.stderr)
        print("\n".join(lines(name, rows)))


def compared(scene: Scene, seed: int) -> dict[str, tuple[Row, Row]]:
    """By what moved it: identified with all, and without what is advised."""
    quiet = [t.recording for t in scene.trials(seed).values()]
    pushed = bumped(scene, seed, "S1")
    drives = {
        "nothing": quiet,
        "a bump": [pushed, *quiet[1:]],
        "a hand": [quiet[0], carried(quiet[1]), quiet[2]],
    }
    out = {}
    for kind, recordings in drives.items():
        first = found(scene, recordings)
        left = list(recordings)
        for name, begin, end in first.advice:
            left = [r.without(begin, end) if r.name == name else r for r in left]
        out[kind] = first, found(scene, left) if first.advice else first
    return out


def lines(name: str, rows: Sequence[dict[str, tuple[Row, Row]]]) -> list[str]:
    """The table's lines of a scene."""
    out = []
    for kind in rows[0]:
        seen = sum(bool(row[kind][0].advice) for row in rows)
        ratio = [[_ratio(x, row["nothing"][0]) for x in row[kind]] for row in rows]
        most = [[float(np.abs(x.off).max()) for x in row[kind]] for row in rows]
        (one, other), (off, less) = np.nanmedian(ratio, axis=0), np.nanmax(most, axis=0)
        gains = [row[kind][0].gain for row in rows]
        refused = sum(not row[kind][0].errors for row in rows)
        out.append(
            f"{name:<22} {kind:<9} {seen:>3}/{len(rows):<3}  {one:>17.2f} {other:>16.2f} "
            f"{off:>10.1f} {less:>11.1f}   {np.nanmin(gains):>7.0f} to {np.nanmax(gains):.0f}"
            f"{f', {refused} refused' if refused else ''}"
        )
    return out


def _ratio(row: Row, quiet: Row) -> float:
    """Median ratio of standard errors."""
    both = [n for n in row.errors if quiet.errors.get(n, 0.0) > 0.0 and row.errors[n] > 0.0]
    return float(np.median([row.errors[n] / quiet.errors[n] for n in both])) if both else np.nan


if __name__ == "__main__":
    main(sys.argv[1:])
