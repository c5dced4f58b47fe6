# SPDX-License-Identifier: MIT
"""Accuracy against minutes driven, size of the pool and rate of the poses."""

from typing import Any

import msgspec

from benchmarks.studies.paper.trials import boat, identified, true_error
from seatrial.util.errors import SeatrialError
from tests.boats.plans import planned
from tests.boats.scenes import TRAINING, UNSEEN, driven

SECONDS = (15.0, 30.0, 60.0, 120.0, 200.0)  # [s] of each of S1, S2, S3
POOLS = {"2.4 x 1.8 m": (2.4, 1.8), "3.6 x 2.4 m": (3.6, 2.4), "6 x 4 m": (6.0, 4.0),
         "15 x 10 m": (15.0, 10.0)}  # fmt: skip
RATES = (3.0, 5.0, 10.0, 15.0, 30.0)  # [Hz]
METHODS = ("equation-error", "output-error")
PLAN, USUAL = "hard", (200.0, "3.6 x 2.4 m", 15.0)


def keys(seeds: range) -> list[tuple[Any, ...]]:
    """What is to be run: one of the three at a time."""
    seconds, pool, rate = USUAL
    cases = [(s, pool, rate) for s in SECONDS]
    cases += [(seconds, p, rate) for p in POOLS if p != pool]
    cases += [(seconds, pool, r) for r in RATES if r != rate]
    return [(*case, seed) for seed in seeds for case in cases]


def work(seconds: float, pool: str, rate: float, seed: int) -> dict[str, Any]:
    """Errors on S7 against the true velocity, by both methods under AF; None where one refuses."""
    length, width = POOLS[pool]
    plan = planned(PLAN, pool={"length": length, "width": width}, pose={"rate": rate})
    trials = planned(plan, *TRAINING, seconds=seconds).trials | {UNSEEN: plan.trials[UNSEEN]}
    plan = msgspec.structs.replace(plan, trials=trials)
    vehicle = boat("AF")
    found = driven(plan, vehicle, seed)
    out: dict[str, Any] = {}
    for method in METHODS:
        try:
            out[method] = true_error(identified(found, vehicle, method), found[UNSEEN])
        except SeatrialError as failure:
            out[method] = None
            out[f"{method} refused"] = str(failure)
    return out
