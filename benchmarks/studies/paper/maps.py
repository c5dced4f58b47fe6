# SPDX-License-Identifier: MIT
"""MP against AF over the dead zone's width, the size of the commands and pose noise."""

from typing import Any

from benchmarks.studies.paper.trials import (
    boat,
    changed,
    identified,
    measured_errors,
    paired,
    rms,
    true_error,
)
from seatrial.simulation.plan import load_plan
from seatrial.util.errors import SeatrialError
from tests.boats.scenes import ALLOCATIONS, UNSEEN, driven

EDGES = (0.0, 0.04, 0.08, 0.12, 0.16)  # share of full command
AMPLITUDES = {"small": (0.1, 0.4), "as in the trials": (0.2, 1.0), "large": (0.6, 1.0)}
NOISES = {"none": (1e-6, 1e-6), "0.7 mm, 3 mrad": (7e-4, 3e-3), "4 mm, 4 mrad": (4e-3, 4e-3)}
METHODS = ("equation-error", "output-error")


def keys(seeds: range) -> list[tuple[Any, ...]]:
    """What is to be run: all of the map for every seed."""
    return [
        (edge, size, noise, a, seed)
        for seed in seeds for noise in NOISES for size in AMPLITUDES for edge in EDGES for a in ALLOCATIONS
    ]  # fmt: skip


def work(edge: float, size: str, noise: str, allocation: str, seed: int) -> dict[str, Any]:
    """Errors of one cell: Table III's pairing, S7 against what is measured and what is true.

    None where a method finds no model, or one that runs away.
    """
    plan = changed(
        load_plan("paper-like"), edge=edge, amplitude=AMPLITUDES[size], noise=NOISES[noise]
    )
    vehicle = boat(allocation, edge)
    trials = driven(plan, vehicle, seed)
    out: dict[str, Any] = {}
    for method in METHODS:
        try:
            model = identified(trials, vehicle, method)
            out[method] = {
                "paired": paired(model, trials),
                "unseen": rms(measured_errors(model, trials[UNSEEN])),
                "true": true_error(model, trials[UNSEEN]),
            }
        except SeatrialError as failure:  # the paper's method may find a boat that runs away
            out[method], out[f"{method} refused"] = None, str(failure)
            continue
        if method == "output-error":
            out["edges"] = [
                float(v)
                for n, v in zip(model.vehicle.constants.names, model.constants, strict=True)
                if n.startswith("edge")
            ]
    return out
