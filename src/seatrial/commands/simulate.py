# SPDX-License-Identifier: MIT
"""`seatrial simulate`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import add_json, guard, write_json
from seatrial.io.bags.write import BAG_FORMATS
from seatrial.util.printing import say
from seatrial.util.progress import over

if TYPE_CHECKING:
    from seatrial.boat.model import Model
    from seatrial.boat.vehicle import Vehicle
    from seatrial.simulation.plan import PlanFile


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument(
        "--plan",
        help="plan file, or paper-like, hard, clean, lake (default: paper-like, or lake without sway thrust)",
    )
    command.add_argument("--vehicle", help="vehicle file instead of the plan's, or the model's")
    command.add_argument("--model", type=Path, help="model file instead of the plan's plant")
    command.add_argument("--seed", type=int, help="seed (default: the plan's)")
    command.add_argument(
        "--seeds", type=int, metavar="N",
        help="N times, from --seed on, each in a folder of its own: a fleet for 'seatrial fleet DIR'",
    )  # fmt: skip
    command.add_argument(
        "--format", choices=("csv", *BAG_FORMATS), default="csv",
        help="csv: a folder of tables for each trial; else a bag for each (default: csv)",
    )  # fmt: skip
    command.add_argument("-o", "--out", type=Path, required=True, metavar="DIR")
    add_json(command)


def _setting(args: argparse.Namespace) -> tuple[PlanFile, list[Vehicle], Model | None]:
    """The plan, the vehicles that read its trials, and the model that is the truth; None: the plan's plant."""
    from seatrial.boat.model_file import load
    from seatrial.boat.vehicle import WRENCH, load_vehicle
    from seatrial.io.trial_files import of_trials
    from seatrial.simulation.joypad import default_plan
    from seatrial.simulation.plan import load_plan, with_seed

    given = None if args.model is None else load(args.model)
    plan = load_plan(args.plan or default_plan(given))
    if args.seed is not None:
        plan = with_seed(plan, args.seed)
    if args.vehicle is not None:
        vehicles = [load_vehicle(args.vehicle)]
    elif given is not None and set(given.vehicle.inputs) != set(WRENCH):
        vehicles = [given.unidentified]  # to be identified again
    else:
        vehicles = [load_vehicle(name) for name in plan.vehicles]
    return plan, [of_trials(vehicle) for vehicle in vehicles], given


def run(args: argparse.Namespace) -> None:
    """Trials of a plan, written vehicle by vehicle."""
    from seatrial.boat.physics import negative_latencies
    from seatrial.commands.shared.results import SimulatedVehicle, SimulateResult
    from seatrial.io.trial_files import guard_trials, write_setting, write_trial
    from seatrial.simulation.plan import seeded
    from seatrial.simulation.trials import plant_model, simulate
    from seatrial.workflow.next_step import after_simulate, fleet_of

    guard(args.json, "{", args.plan, args.vehicle, args.model)
    plan, vehicles, given = _setting(args)
    jobs = [(plan, vehicle, args.out) for vehicle in vehicles]
    if args.seeds is not None:
        jobs = list(seeded(plan, vehicles, args.seeds, args.out))
    for one, vehicle, out in jobs:
        guard_trials(one, vehicle, out)
    done: list[SimulatedVehicle] = []
    for one, vehicle, out in over(jobs, "vehicle" if len(jobs) > 1 else ""):
        truth = plant_model(one, vehicle) if given is None else given.with_vehicle(vehicle)
        for words in negative_latencies(truth):
            say(f"seatrial: {truth.name}: {words}", file=sys.stderr)
        trials = simulate(one, vehicle, given)  # refused before anything is written
        done.append(SimulatedVehicle(str(write_setting(one, vehicle, truth, out)), []))
        say(f"vehicle {done[-1].vehicle}")
        for trial in over(trials, "simulating trial", len(one.trials)):
            done[-1].trials.append(str(write_trial(trial, out, args.format)))
            say(f"  {done[-1].trials[-1]}")
    write_json(args, "simulate 1", SimulateResult(plan.name, str(args.out), done))
    first = done[0]
    following = (
        after_simulate(first.trials, first.vehicle) if args.seeds is None else fleet_of(args.out)
    )
    say(following.text)
