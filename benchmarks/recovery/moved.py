# SPDX-License-Identifier: MIT
"""External disturbances in one of three recordings: whether they are found, and what they cost.

Of every scene S1 to S3 as they are; with S1 in which the boat is pushed for a fifth of a second at 60 s, twice
as hard as full thrust does, in every axis; and with S2 at whose end it is carried about for 12 s. Each is
identified, and again without what `identify` advises to leave out.
"""

import re
from collections.abc import Sequence
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.harness import markdown
from seatrial.boat.findings import Finding, FindingKind, of_kinds
from seatrial.boat.model import Model
from seatrial.control.tuning.linear import linearise
from seatrial.evaluation.disturbed_intervals import (
    clearest_interval,
    error_cells,
    most_disturbed,
    squared_innovations,
)
from seatrial.identification.estimator import fit
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.simulation import trials
from seatrial.simulation.plan import DisturbanceForce
from seatrial.simulation.trials import DISTURBANCE_STEP
from seatrial.util.errors import IdentificationError
from tests.boats.scenes import Scene, scenes, true_parameters, vehicle_of

SCENES = ("paper-like MP", "hard MP", "hard AF", "hard MP pushed")
MORE = 4000  # than the benchmark's seed
AT, LASTS = 60.0, 0.2  # [s]
BUMP = 2.0  # times full thrust
HELD = 12.0  # [s] at the end
Row = dict[str, Any]  # of one fit: standard errors, largest error in these, advice, gain


class BumpedPlant(trials.DisturbedPlant):
    """The plant with a push from outside."""

    def __init__(
        self, model: Model, force: DisturbanceForce | None, rng: np.random.Generator
    ) -> None:
        super().__init__(model, force, rng)
        self.push = BUMP * np.asarray(linearise(model).authority)

    def advance_to(self, t: float) -> bool:
        """On to t [s]."""
        for moment in AT + np.arange(0.0, LASTS, DISTURBANCE_STEP):
            if self.time < moment <= t:
                super().advance_to(moment)
                state = self.state
                state[3:] -= DISTURBANCE_STEP * self.push
                self.state = state
        return super().advance_to(t) if t > self.time else True


def bumped(scene: Scene, seed: int, name: str) -> Recording:
    """One of the scene's recordings with a bump."""
    with patch.object(trials, "DisturbedPlant", BumpedPlant):
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


def work(name: str, seed: int) -> Row:
    """By what moved the boat: identified with all, and without what is advised to leave out."""
    scene, seed = scenes()[name], seed + MORE
    quiet = [t.recording for t in scene.trials(seed).values()]
    drives = {
        "nothing": quiet,
        "a bump": [bumped(scene, seed, "S1"), *quiet[1:]],
        "a hand": [quiet[0], carried(quiet[1]), quiet[2]],
    }
    out = {}
    for kind, recordings in drives.items():
        first = found(scene, recordings)
        left = list(recordings)
        for place, begin, end in first["advice"]:
            left = [r.without(begin, end) if r.name == place else r for r in left]
        out[kind] = first, found(scene, left) if first["advice"] else first
    return {"moved": out}


def found(scene: Scene, recordings: Sequence[Recording]) -> Row:
    """Identified; or the advice of a refusal."""
    try:
        solved = fit(recordings, vehicle_of(scene.allocations[0]))
    except IdentificationError as error:
        return {"errors": {}, "off": np.nan, "advice": refused(str(error)), "gain": np.nan}
    truth = true_parameters(scene.plan, solved.names)
    error = np.array([solved.errors[n] for n in solved.names])
    used = error > 0.0
    off = (solved.theta[list(solved.problem.free)] - truth)[used] / error[used]
    squares = [squared_innovations(p) for p in solved.runs.by_recording]
    cells = [error_cells(r, s) for r, s in zip(recordings, squares, strict=True)]
    gain = clearest_interval(cells, most_disturbed(cells)).gain
    return {
        "errors": solved.errors, "off": float(np.abs(off).max()), "gain": float(gain),
        "advice": left_out(solved.findings),
    }  # fmt: skip


def left_out(findings: Sequence[Finding]) -> list[tuple[str, float, float]]:
    """The disturbed intervals that are to be left out."""
    found = of_kinds(findings, FindingKind.DISTURBED_INTERVAL)
    return [(f.part("recording"), f.number("start"), f.number("end")) for f in found]


def refused(message: str) -> list[tuple[str, float, float]]:
    """The same of a refusal, which has them as options."""
    options = re.findall(r"--without '?(\S+?)'?=([\d.]+)-(\d+(?:\.\d+)?)", message)
    return [(name, float(begin), float(end)) for name, begin, end in options]


def table(records: Sequence[Row]) -> str:
    """How often the disturbance is found, and standard errors with it and without it."""
    rows = []
    for name in SCENES:
        mine = [r["moved"] for r in records if r["scene"] == f"moved {name}" and "moved" in r]
        for kind in mine[0] if mine else ():
            each = [r[kind] for r in mine]
            ratio = [
                [_ratio(x, r["nothing"][0]) for x in both]
                for r, both in zip(mine, each, strict=True)
            ]
            one, other = np.nanmedian(ratio, axis=0)
            off, less = np.nanmax([[x["off"] for x in both] for both in each], axis=0)
            gains = [first["gain"] for first, _ in each]
            rows.append([
                name, kind, f"{sum(bool(first['advice']) for first, _ in each)}/{len(each)}",
                f"{one:.3g}, {other:.2f}", f"{off:.1f}, {less:.1f}",
                f"{np.nanmin(gains):.0f} to {np.nanmax(gains):.0f}",
                f"{sum(not first['errors'] for first, _ in each)}",
            ])  # fmt: skip
    head = [
        "scene", "moved by", "named in",
        "standard errors, times those of nothing: with it, without it",
        "largest error in standard errors: with it, without it",
        "twice the log likelihood gained", "refused",
    ]  # fmt: skip
    return markdown.table(head, rows, text=2) if rows else ""


def _ratio(row: Row, quiet: Row) -> float:
    """Median ratio of standard errors."""
    errors, calm = row["errors"], quiet["errors"]
    both = [n for n in errors if calm.get(n, 0.0) > 0.0 and errors[n] > 0.0]
    return float(np.median([errors[n] / calm[n] for n in both])) if both else np.nan
