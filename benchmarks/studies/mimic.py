# SPDX-License-Identifier: MIT
"""How closely a carrier with slipping wheels follows the boat: the whole of the bundled S7, simulated.

python -m benchmarks.studies.mimic              # the table
python -m benchmarks.studies.mimic --write      # into docs/mimic.md
"""

import sys

import numpy as np

from benchmarks.harness import command
from benchmarks.harness.markdown import table
from seatrial.simulation.mimic import Carrier
from tests.boats.carrier import driven, follow
from tests.boats.mecanum import Ground

LAG = 0.14  # [s] the ground's lag and delay
SEEDS = (1, 2, 3)
NO_LIMIT = 1e3  # [m]
CASES = {
    "the carrier's own localisation, 5 mm and 10 mrad at 20 Hz, 60 ms late": (
        Ground(), Carrier(lag=LAG),
    ),
    "the same, without the lead": (Ground(), Carrier(lag=0.0)),
    "no way back to the pose": (Ground(), Carrier(lag=LAG, gain=0.0, lost=NO_LIMIT)),
    "an odometry that counts the wheels' turns": (
        Ground(sees_slip=False), Carrier(lag=LAG, lost=NO_LIMIT),
    ),
}  # fmt: skip


def following() -> str:
    """Position and heading over the seeds, case by case."""
    model, trial = driven()
    rows = []
    for name, (ground, carrier) in CASES.items():
        runs = [follow(model, trial, ground, carrier, seed) for seed in SEEDS]
        position, heading = np.sqrt(np.mean([np.square(run.off) for run in runs], axis=0))
        most = max(run.distance.max() for run in runs)
        rows.append([name, f"{position * 100:.1f}", f"{most * 100:.1f}", f"{heading * 1000:.0f}"])
    head = ["the carrier's poses", "position RMS, cm", "largest, cm", "heading RMS, mrad"]
    return table(head, rows)


if __name__ == "__main__":
    parser = command.parser("studies.mimic", __doc__)
    makers = {"follow": following}
    command.show(command.tables(parser, sys.argv[1:], makers), makers, "mimic.md")
