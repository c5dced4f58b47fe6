# SPDX-License-Identifier: MIT
"""What is driven and recorded: presets, allocations, unmodelled force, faults, noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

import seatrial
from seatrial import _core
from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import (
    DisturbanceForce,
    DropOuts,
    Jumps,
    PlanFile,
    load_plan,
)
from seatrial.simulation.trials import Trial, simulate
from seatrial.util.frames import Array
from tests.boats.plans import planned

PRESETS = ("paper-like", "hard")
ALLOCATIONS = ("MP", "AF")
TRAINING = ("S1", "S2", "S3")  # 3 x 200 s
UNSEEN = "S7"
FORCE = DisturbanceForce(share=0.04, correlation=2.0)
NO_JUMPS, NO_DROP_OUTS = Jumps(per_minute=0.0), DropOuts(per_minute=0.0)
# 18 of a minute's 900 poses are 2 %
JUMPS = Jumps(per_minute=18.0, shortest=0.1, longest=1.0, samples=1)
DROP_OUTS = DropOuts(per_minute=1.0, shortest=3.0, longest=3.0)
SIGMAS = (0.3e-3, 0.6e-3, 1e-3, 2e-3, 4e-3, 8e-3)  # [m], and as many [rad]
CORRELATION = 0.3  # [s]


@dataclass(frozen=True)
class Scene:
    """One way of driving and recording; its plan lacks only the seed."""

    name: str
    group: str  # still, pushed, together, faults, noise
    plan: PlanFile
    allocations: tuple[str, ...]

    def trials(self, seed: int, names: Sequence[str] = TRAINING) -> dict[str, Trial]:
        """Its trials by name, S1-MP and so on."""
        found = (driven(self.plan, vehicle_of(a), seed, names) for a in self.allocations)
        return {trial.name: trial for one in found for trial in one.values()}


def vehicle_of(allocation: str) -> Vehicle:
    """The bundled boat with MP or AF."""
    return seatrial.load_vehicle(f"mallard-{allocation.lower()}")


def driven(
    plan: str | PlanFile, vehicle: Vehicle, seed: int | None = None, names: Sequence[str] = ()
) -> dict[str, Trial]:
    """Trials of a plan by its own names; all where none are named, its own seed where none is given."""
    plan = planned(plan, *names, seed=seed)
    return dict(zip(plan.trials, simulate(plan, vehicle), strict=True))


def pushed(plan: str | PlanFile, force: DisturbanceForce | None = FORCE) -> PlanFile:
    """The plan with an unmodelled force, or without one."""
    return planned(plan, plant={"unmodelled": force})


def scenes() -> dict[str, Scene]:
    """All scenes by name."""
    found = [_preset(p, a, force) for p in PRESETS for a in ALLOCATIONS for force in (False, True)]
    for preset in PRESETS:
        plan = load_plan(preset)
        found.append(Scene(f"{preset} MP+AF", "together", plan, ALLOCATIONS))
        found += [Scene(f"{preset} {a} faults", "faults", _faulty(plan), (a,)) for a in ALLOCATIONS]
    found += [_noisy(sigma, tau) for tau in (0.0, CORRELATION) for sigma in SIGMAS]
    return {scene.name: scene for scene in found}


def _preset(preset: str, allocation: str, force: bool) -> Scene:
    if not force:
        return Scene(f"{preset} {allocation}", "still", load_plan(preset), (allocation,))
    return Scene(f"{preset} {allocation} pushed", "pushed", pushed(preset), (allocation,))


def _faulty(plan: PlanFile) -> PlanFile:
    """Exact stamps: their random numbers come after those of the faults, with and without differ."""
    return planned(plan, pose={"stamp_jitter": 0.0, "jumps": JUMPS, "drop_outs": DROP_OUTS})


def without_faults(scene: Scene) -> Scene:
    """The same scene, and with the same seed the same drive and noise, without any fault."""
    pose = msgspec.structs.replace(scene.plan.pose, jumps=NO_JUMPS, drop_outs=NO_DROP_OUTS)
    return replace(scene, plan=msgspec.structs.replace(scene.plan, pose=pose))


def _noisy(sigma: float, tau: float) -> Scene:
    noise = {"position_noise": sigma, "heading_noise": sigma, "noise_correlation": tau}
    plan, colour = planned("paper-like", pose=noise), "correlated" if tau else "white"
    return Scene(f"{colour} {1e3 * sigma:g} mm", "noise", plan, ("MP",))


def true_parameters(plan: PlanFile, names: Sequence[str]) -> Array:
    """What coefficients and constants by these names should be.

    Without a dead zone in the model a thruster that stays on one side of it has the thrust
    (f - e) / (1 - e): a gain of 1 / (1 - e).
    """
    constants = _chain(plan)
    edge = constants["edge_forward"]
    gain = 1.0 if any(n.startswith("edge") for n in names) else 1.0 / (1.0 - edge)
    out = []
    for name in names:
        if name in plan.plant.coefficients:
            out.append(plan.plant.coefficients[name] * (gain if name.endswith("_F") else 1.0))
        else:
            out.append(constants[name.partition(".")[0]])
    return np.array(out)


def _chain(plan: PlanFile) -> Mapping[str, float]:
    (group,) = plan.plant.chain
    if group.dead_zone is None or group.lag is None:
        raise ValueError(f"plan {plan.name}: expected a dead zone and a lag")
    return {
        "latency": -plan.joypad.clock_offset,  # stamps that are late: acts before them
        "edge_forward": group.dead_zone.forward,
        "edge_reverse": group.dead_zone.reverse,
        "lag": group.lag,
        "reverse_ratio": 1.0,
        "power": 1.0,
    }


def by_thrusters(trials: Sequence[Trial]) -> tuple[Vehicle, list[Recording]]:
    """One vehicle for trials of several allocations: the commands are the thrusters' own."""
    content = trials[0].vehicle.to_mapping()
    names = tuple(content["thrusters"])
    content["commands"] = {**content["commands"], "inputs": {n: n for n in names}}
    content["allocation"] = {"scheme": "direct", "limit": 1.0}
    found = []
    for trial in trials:
        given = trial.recording.commands
        thrust = _core.allocate(trial.vehicle.chain, np.ascontiguousarray(given.values))[0]
        found.append(replace(trial.recording, commands=Signal(names, given.stamps, thrust)))
    return vehicle_from(content, "thrusters"), found
