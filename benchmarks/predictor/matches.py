# SPDX-License-Identifier: MIT
"""False matches: poses that jump by 0.3 to 2 m, single and five in a row."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

import seatrial
from seatrial.util.frames import Array, Mask
from tests.boats.drives import SCENES, SETTLED, Inputs, drive, give, model

SEED = 31
SHARE = 0.01  # of the poses at which one begins
BURST = 5  # poses
NEAREST, FARTHEST = 0.3, 2.0  # [m]


def spoiled(inputs: Inputs, burst: int, seed: int) -> tuple[Inputs, Mask]:
    """With false matches that begin at SHARE of the poses; which poses they are."""
    rng = np.random.default_rng(seed)
    pose, false = inputs.pose.copy(), np.zeros(len(inputs.pose), dtype=bool)
    first = np.flatnonzero((rng.random(len(pose)) < SHARE) & (inputs.pose_t > SETTLED))
    for k in first[np.diff(first, prepend=-burst) >= burst]:
        size, angle = rng.uniform(NEAREST, FARTHEST), rng.uniform(-np.pi, np.pi)
        jump = np.array([size * np.cos(angle), size * np.sin(angle), rng.uniform(-1.0, 1.0)])
        pose[k : k + burst] += jump
        false[k : k + burst] = True
    return replace(inputs, pose=pose), false


@dataclass(frozen=True)
class Outcome:
    """What the gate made of the poses."""

    false: int
    accepted: int  # of the false ones
    good: int
    rejected: int  # of the good ones
    errors: Array  # (n,) [m] of the corrected position, after every pose


@cache
def outcome(scene: str, burst: int) -> Outcome:
    """Along S7."""
    trial = drive(scene, SEED)
    inputs, false = spoiled(trial.inputs, burst, SEED)
    predictor = seatrial.Predictor(model(scene, SEED))
    used, errors, k = np.zeros(len(false), dtype=bool), np.zeros(len(false)), 0
    for _, kind, stamp, values in inputs.events():
        give(predictor, kind, stamp, values)
        if kind == "pose":
            now = predictor.at(stamp)
            used[k] = now.last_pose == stamp
            errors[k] = np.hypot(*(now.pose[:2] - trial.truth[k, :2]))
            k += 1
    late = inputs.pose_t > SETTLED
    return Outcome(
        int(false.sum()), int(used[false].sum()), int((~false & late).sum()),
        int((~used & ~false & late).sum()), errors[late],
    )  # fmt: skip


def table() -> str:
    """Markdown."""
    rows = ["| S7 | false matches | accepted | good poses | rejected | position error, mm: RMS | largest |",
            "| --- | --- | ---: | ---: | ---: | ---: | ---: |"]  # fmt: skip
    for scene in SCENES:
        for burst in (1, BURST):
            got = outcome(scene, burst)
            kind = "single" if burst == 1 else f"{burst} in a row"
            error = 1e3 * np.sqrt(np.mean(got.errors**2))
            rows.append(
                f"| {scene} | {got.false}, {kind} | {got.accepted} | {got.good} | {got.rejected} | "
                f"{error:.2g} | {1e3 * got.errors.max():.2g} |"
            )
    return "\n".join(rows)
