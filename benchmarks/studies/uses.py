# SPDX-License-Identifier: MIT
"""Pictures of docs/uses.md: wrenches by scheme of allocation, a tuned loop, a carrier and its boat, a scan.

python -m benchmarks.studies.uses
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import seatrial
from benchmarks.harness import command
from benchmarks.harness.pictures import dots, path_of, plan, rectangle, ring, write
from benchmarks.studies.mimic import CASES
from benchmarks.studies.tracking.scenes import identified
from seatrial.control import tune
from seatrial.control.allocation import compare_schemes
from seatrial.control.allocation.page.draw import slices
from seatrial.control.tuning.page.draw import sensitivity, step
from seatrial.control.tuning.responses import responses
from seatrial.report.figures.base import BLACK, BLUE, RED, SKY, Figure, figure, line
from seatrial.simulation import Simulator
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from tests.boats.carrier import driven, follow

SHOWN = 60.0  # [s] of the carrier's path
SCENE = """\
seatrial: scene 1
name: pool
pool: {length: 12, width: 5}
boxes: [{x: 2.4, y: 0.8, length: 0.5, width: 0.4, turn_deg: 20}]
posts: [{x: 0, y: -1.2, radius: 0.15}]
boats: [{start: [-3, 0.3, 0.4]}]
"""


def allocation() -> list[list[Figure]]:
    """Attainable wrenches of the paper's boat with its dead zone."""
    found = compare_schemes(
        plant_model(load_plan("paper-like"), seatrial.load_vehicle("mallard-af"))
    )
    return [[slices(found, 0, 1), slices(found, 0, 2)]]


def tuning() -> list[list[Figure]]:
    """Step and sensitivity in surge, of the identified model."""
    found = tune(identified("AF", "paper-like"))
    curves = responses(found)
    return [[step(curves.step, 0, found.knob), sensitivity(curves.sensitivity, 0)]]


def mimic() -> list[list[Figure]]:
    """Paths of boat and carrier, and the distance between them."""
    model, trial = driven(SHOWN)
    ground, carrier = next(iter(CASES.values()))
    run = follow(model, trial, ground, carrier)
    t = np.linspace(0.0, SHOWN, len(run.distance))
    paths = [path_of("boat", run.boat, SKY), path_of("carrier", run.carrier, BLUE)]
    distance = line("distance", t, 100.0 * run.distance, BLUE)
    return [[plan(paths), figure([distance], "time [s]", "distance [cm]")]]


def simulator() -> list[list[Figure]]:
    """A pool and one scan of it, from where the boat is."""
    model = plant_model(load_plan("paper-like"), seatrial.load_vehicle("mallard-mp"))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "pool.yaml"
        path.write_text(SCENE)
        boat = Simulator(model, scene=path, seed=1)
    boat.advance(0.5)
    scan = boat.scan()
    assert scan is not None
    angle = boat.eta[2] + scan.angles
    points = boat.eta[:2] + scan.ranges[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return [[plan([
        path_of("pool", rectangle(12.0, 5.0), BLACK, width=1.0),
        path_of("boat", ring(boat.eta[:2], 0.3), BLUE),
        dots("scan", points, RED, length=0.05),
    ])]]  # fmt: skip


PICTURES = {"allocate": allocation, "tune": tuning, "mimic": mimic, "sim": simulator}


def main() -> None:
    """All of them."""
    command.parser("studies.uses", __doc__).parse_args()
    for name, make in PICTURES.items():
        write(command.DOCS / "images" / f"{name}.svg", make())
        print(f"wrote {name}.svg")


if __name__ == "__main__":
    main()
