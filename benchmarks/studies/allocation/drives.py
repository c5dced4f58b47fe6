# SPDX-License-Identifier: MIT
"""Schemes along drives: MallARD's simulated S7, and the real model ship's unseen run."""

from dataclasses import replace

import numpy as np

import seatrial
from benchmarks.harness.markdown import table
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.boat.vehicle import Vehicle
from seatrial.control.allocation import AllocationComparison, compare_schemes
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from tests.boats.drives import SHIP
from tests.boats.scenes import driven

ZONE = DeadZone(0.2, 0.3)  # of the Voith-Schneider propellers' pitch, PROVENANCE.md
TRAINED, UNSEEN = ("random_run1", "random_run3"), "run1"


def mallard() -> str:
    """S7 of the preset `paper-like` with its plant's dead zone of 0.08; then with half the stick."""
    plan = load_plan("paper-like")
    vehicle = seatrial.load_vehicle("mallard-mp")
    trial = driven(plan, vehicle, names=["S7"])["S7"]
    drives = [trial.recording, scaled(trial.recording, 0.5)]
    found = compare_schemes(plant_model(plan, vehicle), drives)
    return f"{_able(found)}\n{_driven(found, ['as driven', 'half the stick'])}"


def ship() -> str:
    """C/S Enterprise I: T of coefficients, identified with the propellers' dead zone."""
    vehicle = with_dead_zone(seatrial.load_vehicle(SHIP / "vehicle.yaml"))
    runs = {
        n: seatrial.read(SHIP / "csv" / f"CSE1_data_{n}.csv", vehicle) for n in (*TRAINED, UNSEEN)
    }
    model = seatrial.identify([runs[n] for n in TRAINED], vehicle, method="equation-error")
    found = compare_schemes(model, [runs[UNSEEN]])
    return f"{_able(found)}\n{_driven(found, [UNSEEN])}"


def with_dead_zone(vehicle: Vehicle) -> Vehicle:
    """The ship with its propellers' dead zone stated; the bow thruster has none."""
    propellers = [name for name in vehicle.inputs if name != "bow"]
    zone = ChainGroup(name="pitch", actuators=propellers, dead_zone=ZONE)
    return vehicle.with_chain([*vehicle.file.chain, zone])


def scaled(recording: Recording, share: float) -> Recording:
    """The same drive with other sticks."""
    old = recording.commands
    commands = Signal(old.names, old.stamps, share * old.values)
    return replace(recording, commands=commands)


def _able(found: AllocationComparison) -> str:
    rows = []
    for row in found.rows:
        if row.allocator is None or row.authority is None:
            if not row.drives:
                rows.append([row.name, "not possible", "", ""])
            continue
        ends = ", ".join(f"{-b:.2f} to {a:.2f}" for a, b in np.asarray(row.authority).tolist())
        switching = f"{len(row.allocator.switching)} of {len(row.allocator.thrusters)}"
        rows.append([row.name, ends, f"{row.allocator.idle_power:.3f}", switching])
    head = ["scheme", "most of surge, sway, yaw", "idle power", "through their dead zones"]
    return table(head, rows)


def _driven(found: AllocationComparison, names: list[str]) -> str:
    rows = []
    for place, name in enumerate(names):
        for row in found.rows:
            if row.drives:
                d = row.drives[place]
                rows.append([
                    name, row.name, f"{d.crossing:.1f}", f"{100 * d.error_share:.1f}",
                    f"{100 * d.limited:.1f}", f"{d.power:.2f}",
                ])  # fmt: skip
    head = [
        "drive", "scheme", "crossings a minute", "wrench error, %", "limited, % of the time", "power",
    ]  # fmt: skip
    return table(head, rows, text=2)
