# SPDX-License-Identifier: MIT
"""Unequal gains of thrusters of one group, as of a fouled or damaged propeller."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial import _core
from seatrial.boat.actuators import STAGES
from seatrial.boat.allocation import with_shared_forces
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.schema import ChainGroup
from seatrial.boat.static_forces import static_forces, usual_commands
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.likelihood.problem import Prior, Problem
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

# share of the forces beyond what coefficients take up: less is not identifiable
LEAST_FORCE_CHANGE = 1e-3
LARGEST_GROUP_SPREAD = 0.4  # within weak or strong thrusters, over the step between them


@dataclass(frozen=True)
class GainProblem:
    """A problem with a gain for each actuator, of which one in each group is held."""

    problem: Problem
    theta: Array
    places: tuple[int, ...]  # of the free gains
    kinds: tuple[tuple[str, ...], ...]  # actuators that have forces in common
    first: int  # place of the first gain of all

    def in_groups(self, theta: Array) -> bool:
        """Whether two or more thrusters of a group are equally weak, and as many equally strong."""
        at = self.first
        for names in self.kinds:
            own = np.sort(theta[at : at + len(names)])
            at += len(names)
            steps = np.diff(own)
            cut = int(np.argmax(steps)) + 1
            inner = float(np.delete(steps, cut - 1).max(initial=0.0))
            if min(cut, len(own) - cut) < 2 or inner > LARGEST_GROUP_SPREAD * steps[cut - 1]:
                return False
        return True

    def findings(self, theta: Array) -> list[Finding]:
        """The gains by group, over their mean, as the vehicle file takes them."""
        found, at = [], self.first
        for names in self.kinds:
            own = theta[at : at + len(names)]
            gains = np.round(own / own.mean(), 3)
            gains[0] += len(gains) - gains.sum()  # the file's mean must be 1
            weak = "several" if self.in_groups(theta) else "one"
            each = tuple(gains.tolist())
            kind = FindingKind.UNEQUAL_THRUSTER_GAINS
            found.append(finding_of(kind, *names, gains=each, weak=weak))
            at += len(names)
        return found


def with_gains(problem: Problem, theta: Array) -> GainProblem | None:
    """The problem with gains, all 1. One in each group is held: a common factor is in the coefficients.

    None where these commands do not identify the gains, where the file states some, and where the core has no room
    for them.
    """
    vehicle = problem.vehicle
    if np.any(vehicle.constants.index[:, STAGES.index("gain")] >= 0):
        return None
    room = _core.MAX_CONSTANTS - len(vehicle.constants.names)
    likely = [kind for kind in with_shared_forces(vehicle.mix) if len(kind) <= room]
    kinds = [kind for kind in likely if _identifiable(vehicle, kind, problem.recordings)]
    if not kinds or sum(map(len, kinds)) > room:
        return None
    place = problem.n_coefficients + problem.n_constants
    firsts = np.cumsum([0, *map(len, kinds)])
    count = int(firsts[-1])
    places = tuple(place + k for k in range(count) if k not in firsts)
    whole = vehicle
    for i, kind in enumerate(kinds):
        whole = _with_gain_group(whole, f"gains_{i}", kind, np.ones(len(kind)))
    free = [i if i < place else i + count for i in problem.free]
    prior = None if problem.prior is None else _with_free_gains(problem.prior, place, count)
    wider = replace(problem, vehicle=whole, free=(*free, *places), prior=prior)
    named = tuple(tuple(vehicle.actuators[k] for k in kind) for kind in kinds)
    return GainProblem(wider, np.insert(theta, place, np.ones(count)), places, named, place)


def _with_gain_group(vehicle: Vehicle, name: str, kind: Sequence[int], gains: Array) -> Vehicle:
    names = [vehicle.actuators[k] for k in kind]
    given = dict(zip(names, gains.tolist(), strict=True))
    return vehicle.with_chain([*vehicle.file.chain, ChainGroup(name=name, gains=given)])


def _with_free_gains(prior: Prior, place: int, count: int) -> Prior:
    """The prior with `count` parameters more, without information on them."""
    here = [place] * count
    precision = np.insert(np.insert(prior.precision, here, 0.0, axis=0), here, 0.0, axis=1)
    return Prior(np.insert(prior.mean, here, 0.0), precision)


def _identifiable(vehicle: Vehicle, kind: Sequence[int], recordings: Sequence[Recording]) -> bool:
    """Whether unequal gains change the forces in another way than a common factor does."""
    count = len(kind)
    rows = usual_commands([r.commands.values for r in recordings])

    def forces(gains: Array) -> Array:
        return static_forces(_with_gain_group(vehicle, "gains", kind, gains), rows)

    now = forces(np.ones(count))
    power = (now**2).sum(axis=0)
    now, some = now[:, power > 0.0], power[power > 0.0]
    effect = np.zeros((count, now.size))
    for k in range(count):
        gains = np.full(count, 1.0 - 0.1 / (count - 1))  # their mean stays
        gains[k] = 1.1
        change = forces(gains)[:, power > 0.0] - now
        effect[k] = ((change - (change * now).sum(axis=0) / some * now) / np.sqrt(some)).ravel()
    spread = np.linalg.eigvalsh(effect @ effect.T)
    return bool(spread[1] > LEAST_FORCE_CHANGE**2)
