# SPDX-License-Identifier: MIT
"""Searches from models that are far off and sure of themselves: where they end.

    python benchmarks/starts.py

Simulated MallARD, trials S1 to S3, 200 s each, thrusters known. The start models are the paper's and 16
that have its coefficients times e^(0.7 z), z normal, one in ten with the wrong sign; without process noise.
"Same": -2 log likelihood within 1 of what is found from the estimator's own start values; "elsewhere" is a
wrong model without a word.
"""

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from estimators import prepare, read

import seatrial
from seatrial.identification.estimator import OutputErrorSettings, fit

PLANS = ("paper-like", "hard")
SPREAD = 0.7  # of the logarithm
REVERSED = 0.1  # share of coefficients
NEAR = 1.0  # of -2 log likelihood


def starts(paper: seatrial.Model, number: int) -> Iterator[seatrial.Model]:
    """The paper's model, and others around it."""
    yield paper
    rng = np.random.default_rng(0)
    for _ in range(number):
        factors = np.exp(rng.normal(0.0, SPREAD, len(paper.coefficients)))
        signs = np.where(rng.random(len(factors)) < REVERSED, -1.0, 1.0)
        yield replace(paper, coefficients=paper.coefficients * factors * signs)


def tried(folder: Path, number: int, *, hold: bool) -> tuple[Counter[str], float]:
    """How often searches ended where, and the seconds of one."""
    vehicle, recordings = read(folder)
    paper = seatrial.load(folder / "start.yaml")
    settings = OutputErrorSettings(hold_noise=hold, select_stages=False)
    own = replace(seatrial.identify(recordings, vehicle, method="weak-form"), noise=paper.noise)
    best = fit(recordings, vehicle, settings=settings, start=own if hold else None).runs.cost
    ends: Counter[str] = Counter()
    begin = time.perf_counter()
    for start in starts(paper, number):
        try:
            cost = fit(recordings, vehicle, settings=settings, start=start).runs.cost
        except seatrial.SeatrialError:
            ends["refused"] += 1
        else:
            ends["same" if cost < best + NEAR else "elsewhere"] += 1
    return ends, (time.perf_counter() - begin) / (number + 1)


def main() -> None:
    """Try, and print."""
    parser = argparse.ArgumentParser(description="Searches from models that are far off")
    parser.add_argument("--starts", type=int, default=16, help="beside the paper's")
    number = parser.parse_args().starts
    print("| plan | noise | same | refused | elsewhere | one takes, s |\n|---|---|---|---|---|---|")
    for plan in PLANS:
        with tempfile.TemporaryDirectory() as name:
            prepare(Path(name), plan)
            for hold in (False, True):
                ends, seconds = tried(Path(name), number, hold=hold)
                found = " | ".join(str(ends[end]) for end in ("same", "refused", "elsewhere"))
                print(f"| {plan} | {'held' if hold else 'free'} | {found} | {seconds:.2f} |")


if __name__ == "__main__":
    main()
