# SPDX-License-Identifier: MIT
"""Pictures of docs/uses.md: what each scheme of allocation gives, a tuned loop, a carrier and its boat, a scan.

python -m benchmarks.uses
"""

import os
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy

import numpy as np

import seatrial
from benchmarks.mimic import CASES, driven, follow
from benchmarks.paper.figures import sheet
from benchmarks.tracking.scenes import identified
from seatrial.allocate import compare_schemes
from seatrial.control import tune
from seatrial.control.responses import responses
from seatrial.frames import Array
from seatrial.plan import load_plan
from seatrial.report.draw.base import BLACK, BLUE, RED, SKY, Figure, figure, line
from seatrial.report.schemes.draw import slices
from seatrial.report.tuning.draw import sensitivity, step
from seatrial.sim import Simulator
from seatrial.simulate import plant_model

IMAGES = Path(__file__).parents[1] / "docs" / "images"
SHOWN = 60.0  # [s] of the carrier's way
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
    """Way of boat and carrier, and the distance between them."""
    model, trial = driven(SHOWN)
    ground, carrier = next(iter(CASES.values()))
    run = follow(model, trial, ground, carrier)
    t = np.linspace(0.0, SHOWN, len(run.distance))
    ways = [_way("boat", run.boat, SKY), _way("carrier", run.carrier, BLUE)]
    plan = figure(
        ways, "x [m]", "y [m]", showlegend=True, yaxis={"scaleanchor": "x", "scaleratio": 1}
    )
    return [
        [
            plan,
            figure([line("distance", t, 100.0 * run.distance, BLUE)], "time [s]", "distance [cm]"),
        ]
    ]


def simulator(folder: Path) -> list[list[Figure]]:
    """A pool and one scan of it, from where the boat is."""
    path = folder / "pool.yaml"
    path.write_text(SCENE)
    model = plant_model(load_plan("paper-like"), seatrial.load_vehicle("mallard-mp"))
    boat = Simulator(model, scene=path, seed=1)
    boat.advance(0.5)
    scan = boat.scan()
    assert scan is not None
    angle = boat.eta[2] + scan.angles
    points = boat.eta[:2] + scan.ranges[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    dots = line("scan", *_dashes(points).T, RED, width=3.0)
    place = line("boat", *_ring(boat.eta[:2], 0.3).T, BLUE)
    walls = 0.5 * np.array([12, 5]) * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    pool = line("pool", *walls.T, BLACK, width=1.0)
    return [[figure([pool, place, dots], "x [m]", "y [m]", showlegend=True,
                    yaxis={"scaleanchor": "x", "scaleratio": 1})]]  # fmt: skip


def _dashes(points: Array) -> Array:
    """Points (n, 2) as short strokes (3 n, 2)."""
    gap = np.full_like(points, np.nan)
    return np.stack([points, points + np.array([0.05, 0.0]), gap], axis=1).reshape(-1, 2)


def _ring(centre: Array, radius: float) -> Array:
    angle = np.linspace(0.0, 2.0 * np.pi, 40)
    return np.asarray(centre + radius * np.column_stack([np.cos(angle), np.sin(angle)]))


def _way(name: str, poses: Array, colour: str) -> Figure:
    return line(name, poses[:, 0], poses[:, 1], colour)


def main() -> None:
    """All of them."""
    import tempfile  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        made = {"allocate": allocation(), "tune": tuning(), "mimic": mimic(),
                "sim": simulator(Path(folder))}  # fmt: skip
    for name, plots in made.items():
        (IMAGES / f"{name}.svg").write_text(sheet(plots))
        print(f"wrote {name}.svg")


if __name__ == "__main__":
    main()
