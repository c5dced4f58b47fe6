# SPDX-License-Identifier: MIT
"""What the thrusters' dead zone alone does to MP and AF: the ratio of their 1-s errors.

No pose noise, dead zone 0.08, the paper's method. The paper, with noise: 1.28, 1.59, 1.43; an
independent simulator without noise: 1.38, 1.61, 1.53. Usage: python examples/dead_zone.py [SEEDS]
"""

import sys

import msgspec
import numpy as np

import seatrial
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import simulate

TRAINING = ("S1", "S2", "S3")
PAIRING = (("S4", "u"), ("S5", "v"), ("S6", "r"))  # Table III
ALLOCATIONS = ("mallard-mp", "mallard-af")


def errors(name: str, seed: int) -> list[float]:
    """RMS of the 1-s errors by Table III's pairing [m/s, m/s, rad/s]."""
    vehicle = seatrial.load_vehicle(name)
    clean = load_plan("clean")
    driven = {s: clean.trials[s] for s in (*TRAINING, *(s for s, _ in PAIRING))}
    plan = msgspec.structs.replace(clean, seed=seed, trials=driven)
    trials = {t.name.split("-")[0]: t.recording for t in simulate(plan, vehicle)}
    model = seatrial.identify([trials[s] for s in TRAINING], vehicle, method="equation-error")
    rows = seatrial.validate(model, [trials[s] for s, _ in PAIRING], reference="stencil").recordings
    return [row.scores[symbol].rms for row, (_, symbol) in zip(rows, PAIRING, strict=True)]


def main(seeds: int) -> None:
    """Print errors and ratios, seed by seed and on average."""
    print("1 s ahead      MP: S4 u   S5 v   S6 r   AF: S4 u   S5 v   S6 r   MP/AF:  u     v     r")
    ratios = []
    for seed in range(seeds):
        mp, af = (np.array(errors(name, seed)) for name in ALLOCATIONS)
        ratios.append(mp / af)
        cells = [f"{100 * e[0]:6.3f} {100 * e[1]:6.3f} {e[2]:6.4f}" for e in (mp, af)]
        shown = "  ".join(f"{r:4.2f}" for r in ratios[-1])
        print(f"  seed {seed:<3} cm/s, rad/s {cells[0]}      {cells[1]}      {shown}")
    mean, spread = np.mean(ratios, axis=0), np.std(ratios, axis=0)
    print(
        "mean MP/AF: " + ", ".join(f"{m:.2f} ± {s:.2f}" for m, s in zip(mean, spread, strict=True))
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 4)
