# SPDX-License-Identifier: MIT
"""Hypotheses of signs and order: the fewest edits of the vehicle file that explain the gains.

`HypothesisSearch.best` minimises chi-square of the gains plus `EDIT_PENALTY` for each edit.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import combinations, permutations, product

import numpy as np

from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.inspection.consistency.gains import Gains
from seatrial.inspection.consistency.repair import Repair, edits_of
from seatrial.util.frames import Array, Axes, Mask

EDIT_PENALTY = 10.0  # least fall of chi-square for an edit, with many blocks (p about 0.002)
SPARE_BLOCKS = 12.0  # blocks beyond the number of inputs at which the penalty doubles
# edits; breaks ties: y and psi negated together first, then fewer pose edits
POSE_PAIR_PREFERENCE = 0.01
MOST_INPUTS_EXHAUSTIVE = 5  # up to 5! 2^5 = 3840 signed permutations; beyond it a stepwise search
LEVER_ALLOWED = 1.5  # [m] longest lever arm that recordings may imply, beside what the file states
LEVER_STEP = 0.02  # [m] grid of lever arms
PLANES = (  # exchanged, signs of x and y, quarter turns of psi: the eight ways to lay a plane
    (False, 1, 1, 0), (False, 1, 1, 1), (False, 1, 1, 2), (False, 1, 1, 3),
    (False, 1, -1, 0), (False, -1, 1, 0), (True, 1, 1, 0), (True, 1, 1, 2),
)  # fmt: skip
MIRROR = np.diag([1.0, -1.0])
THRUSTER_SPREAD = 0.08  # share of the thrust by which actuators may differ: dead zones, curves
RIDGE = 1e-9  # of the trace: keeps inputs without effect from making the equations singular


@dataclass(frozen=True)
class Pattern:
    """The actuation of one axis by the vehicle file, in forward-left-up axes."""

    weights: Array  # (forces, n) of the file's inputs in the forces of the axis' equation
    own: Mask  # (forces,) those along the axis, whose gain is positive


def _patterns(vehicle: Vehicle) -> tuple[Pattern, Pattern, Pattern]:
    """Patterns of surge, sway and yaw."""
    allocated = vehicle.actuators != vehicle.inputs  # then T f = F, and the inputs are F
    names = np.array([[float(i == f) for i in vehicle.inputs] for f in WRENCH])
    mix = (names if allocated else vehicle.mix) * vehicle.input_signs
    found = []
    for axis in range(3):
        rows, own = [], []
        for force, row in zip(vehicle.forces, mix, strict=True):
            own_axis = (t for t in vehicle.structure.terms if t.axis == axis)
            terms = [t for t in own_axis if force.name in t.factors]
            if terms:
                rows.append(np.sign(terms[0].number) * row)
                own.append(force.axis == axis)
        weights = np.array(rows, dtype=float).reshape(-1, len(vehicle.inputs))
        found.append(Pattern(weights, np.array(own, dtype=bool)))
    return found[0], found[1], found[2]


@dataclass(frozen=True)
class HypothesisSearch:
    """Hypotheses of signs and order, scored by the estimated gains of the file's inputs."""

    vehicle: Vehicle
    # mirrored: with y turned round; each of h hypotheses or of one
    gains: tuple[Gains, Gains, Gains]
    mirrored: bool  # whether the plane of the poses is mirrored with respect to psi
    blocks: int
    _known: dict[Repair, float] = field(default_factory=dict, init=False, compare=False, repr=False)

    @cached_property
    def edit_penalty(self) -> float:
        """Least fall of chi-square for an edit."""
        left = max(1.0, float(self.blocks - len(self.vehicle.inputs)))
        return EDIT_PENALTY * (1.0 + SPARE_BLOCKS / left)

    @cached_property
    def patterns(self) -> tuple[Pattern, Pattern, Pattern]:
        """Actuation of the three axes by the file."""
        return _patterns(self.vehicle)

    @cached_property
    def no_edit(self) -> Repair:
        """No edit."""
        n = len(self.vehicle.inputs)
        return Repair(order=tuple(range(n)), input_signs=(1,) * n)

    def best(self) -> Repair:
        """The repair that minimises chi-square plus the penalty of its edits."""
        # No edit, where the file as it is fits: no edit can improve it by its penalty.
        if self.fits(self.no_edit):
            return self.no_edit
        # Many inputs: one edit at a time, from every reading of the poses.
        if len(self.vehicle.inputs) > MOST_INPUTS_EXHAUSTIVE:
            return min((self._stepwise(pose) for pose in self._pose_readings()), key=self._score)
        # Few inputs: every order and sign of the inputs, under every reading of the poses.
        inputs, matrices, edits = _signed_permutations(len(self.vehicle.inputs))
        found = []
        for pose in self._pose_readings():
            cost = self._misfits(pose, matrices) + self.edit_penalty * (edits + _pose_edits(pose))
            i = int(np.argmin(cost))
            order, signs = inputs[i]
            found.append((float(cost[i]), replace(pose, order=order, input_signs=signs)))
        return min(found, key=lambda f: f[0])[1]

    def misfit(self, repair: Repair) -> float:
        """Chi-square of the gains against what the repaired file allows."""
        if repair not in self._known:  # searches compare with the same one again and again
            self._known[repair] = float(self.misfits(repair)[0])
        return self._known[repair]

    def misfits(self, repair: Repair) -> Array:
        """The same (h,) for the gains of each hypothesis."""
        return self._misfits(repair, repair.matrix[None])

    def fits(self, repair: Repair) -> bool:
        """Whether the repaired file explains the gains, with a lever arm up to `LEVER_ALLOWED`."""
        if self.mirrored:
            return False
        if self.misfit(repair) < self.edit_penalty:
            return True
        ahead, left = nearest_lever([self], LEVER_ALLOWED, repair)
        return self.at_point(ahead, left, repair).misfit(repair) < self.edit_penalty

    def at_point(
        self, ahead: float | Array, left: float | Array, repair: Repair | None = None
    ) -> "HypothesisSearch":
        """The gains of the point that lies so far [m] back from the measured one; of h points, their gains.

        Yaw gains are projected on what the file allows: unexcited inputs have arbitrary gains.
        """
        surge, sway, yaw = self.gains
        weights = self.patterns[2].weights @ (repair or self.no_edit).matrix
        turns = _projected(yaw, weights) * (-1.0 if self.mirrored else 1.0)
        surge = replace(surge, values=surge.values + np.multiply.outer(left, turns))
        sway = replace(sway, values=sway.values - np.multiply.outer(ahead, turns))
        return replace(self, gains=(surge, sway, yaw))

    def gain_rotation(self, repair: Repair) -> Array:
        """Matrix (3, 3) by which the pose edits act on [surge, sway, yaw] of the gains."""
        flip = MIRROR if self.vehicle.axes is Axes.FRD else np.eye(2)
        plane = flip @ repair.plane @ flip @ (MIRROR if self.mirrored else np.eye(2))
        whole = np.zeros((3, 3))
        whole[:2, :2], whole[2, 2] = plane, repair.pose_signs[2]
        return whole

    def relative_misfit(self, repair: Repair, changed: Repair) -> float:
        """Rise of chi-square from a repair to a changed one, in units of the edit penalty."""
        return (self.misfit(changed) - self.misfit(repair)) / self.edit_penalty

    def interchangeable(self, i: int, j: int) -> bool:
        """Whether two inputs have equal weights in every axis, so that their order has no effect."""
        return all(np.allclose(p.weights[:, i], p.weights[:, j]) for p in self.patterns)

    def _pose_readings(self) -> Iterator[Repair]:
        """Signs, order and zero of the coordinates that agree with the handedness found."""
        for (exchanged, x, y, turn), psi in product(PLANES, (1, -1)):
            repair = replace(self.no_edit, exchanged=exchanged, pose_signs=(x, y, psi), turn=turn)
            if (np.linalg.det(repair.plane) * psi < 0) == self.mirrored:
                yield repair

    def _misfits(self, pose: Repair, matrices: Array) -> Array:
        """Chi-square (h,) for each matrix (h, n, n) of the inputs, or for each of the gains."""
        total = np.zeros(1)
        for pattern, row in zip(self.patterns, self.gain_rotation(pose), strict=True):
            axis = int(np.argmax(np.abs(row)))
            total = total + _misfit(self.gains[axis], row[axis], pattern, matrices)
        return total

    def _score(self, repair: Repair) -> float:
        edits = edits_of(repair.order, repair.input_signs) + _pose_edits(repair)
        return self.misfit(repair) + self.edit_penalty * edits

    def _stepwise(self, repair: Repair) -> Repair:
        """Greedy search, one edit at a time."""
        while True:
            step = min(neighbours(repair), key=self._score)
            if self._score(step) >= self._score(repair):
                return repair
            repair = step


def nearest_lever(
    searches: Sequence[HypothesisSearch], most: float, repair: Repair | None = None
) -> tuple[float, float]:
    """Lever arm [m] (ahead, left) of the measured point that fits best, each within `most`."""
    steps = round(most / LEVER_STEP)
    levers = np.arange(-steps, steps + 1, dtype=np.float64) * LEVER_STEP

    def best(points: Sequence[HypothesisSearch]) -> float:
        misfits = sum(p.misfits(repair or p.no_edit) for p in points)
        return float(levers[np.argmin(misfits)])

    ahead = best([s.at_point(levers, 0.0, repair) for s in searches])  # acts on sway
    left = best([s.at_point(0.0, levers, repair) for s in searches])  # acts on surge
    return ahead, left


def neighbours(repair: Repair) -> Iterator[Repair]:
    """Repairs of the inputs one edit away, or an exchange with negations."""
    n = len(repair.order)
    for i in range(n):
        yield negated(repair, i)
    for i, j in combinations(range(n), 2):
        swap = swapped(repair, i, j)
        yield from (swap, negated(swap, i), negated(swap, j), negated(negated(swap, i), j))


def negated(repair: Repair, i: int) -> Repair:
    """The repair with input i negated."""
    signs = list(repair.input_signs)
    signs[i] = -signs[i]
    return replace(repair, input_signs=tuple(signs))


def swapped(repair: Repair, i: int, j: int) -> Repair:
    """The repair with the columns of inputs i and j exchanged."""
    order = list(repair.order)
    order[i], order[j] = order[j], order[i]
    return replace(repair, order=tuple(order))


def _pose_edits(repair: Repair) -> float:
    handed = repair.pose_signs == (1, -1, -1) and not (repair.exchanged or repair.turn)
    return repair.pose_edits * (1.0 + (-1.0 if handed else 1.0) * POSE_PAIR_PREFERENCE)


@lru_cache(maxsize=4)
def _signed_permutations(
    n: int,
) -> tuple[list[tuple[tuple[int, ...], tuple[int, ...]]], Array, Array]:
    """All orders and signs of n inputs, their matrices (h, n, n) and numbers of edits (h,)."""
    found = list(product(permutations(range(n)), product((1, -1), repeat=n)))
    matrices = np.zeros((len(found), n, n))
    for matrix, (order, signs) in zip(matrices, found, strict=True):
        matrix[np.arange(n), order] = signs
    return found, matrices, np.array([float(edits_of(o, s)) for o, s in found])


def _with_thruster_spread(gains: Gains, weights: Array) -> Array:
    """Precisions (h, n, n) of the gains for weights (h, forces, n), with `THRUSTER_SPREAD` in the covariance.

    Actuators that share a force differ in dead zone and curve; what remains of an axis that others
    drive is no inconsistency. The spread scales with the largest force that the gains allow; a force
    that was hardly excited allows any size, and then the axis has little weight.
    """
    precision = gains.precision
    shared = np.count_nonzero(weights, axis=2) > 1  # (h, forces): driven by several actuators
    if not shared.any():
        return precision
    curvature = weights @ precision @ np.swapaxes(weights, 1, 2)
    most = np.linalg.norm(precision, 2, axis=(-2, -1)) * np.sum(weights**2, axis=(1, 2))
    inverse = np.linalg.inv(curvature + RIDGE * most[:, None, None] * np.eye(weights.shape[1]))
    found = (inverse @ weights @ (precision @ gains.values[..., None]))[:, :, 0]
    force = np.abs(found) + 2.0 * np.sqrt(np.diagonal(inverse, axis1=1, axis2=2))
    parts = np.where(shared[:, :, None], force[:, :, None] * weights, 0.0)
    unlike = THRUSTER_SPREAD**2 * np.sum(parts**2, axis=1)[:, :, None] * np.eye(weights.shape[2])
    return np.asarray(np.linalg.inv(np.linalg.inv(precision) + unlike))


def _projected(gains: Gains, weights: Array) -> Array:
    """Gains (n,) projected on the span of a pattern's weights (forces, n), of either sign."""
    if not weights.any():
        return gains.values
    pull = weights @ gains.precision
    curvature = pull @ weights.T
    ridge = RIDGE * float(np.trace(curvature)) * np.eye(len(curvature))
    return np.asarray(np.linalg.solve(curvature + ridge, pull @ gains.values) @ weights)


def _misfit(gains: Gains, sign: float, pattern: Pattern, matrices: Array) -> Array:
    """Chi-square (h,) of an axis' gains, times sign, given the pattern of the edited input matrices (h, n, n).

    Gains and matrices: one of the two may be of a single hypothesis.

    Non-negative least squares by enumeration: each set of active forces is solved, the admissible
    solution with the least cost counts.
    """
    if len(pattern.own) == 0:
        return np.atleast_1d(gains.total)
    weights = pattern.weights @ matrices  # (h, forces, n)
    precision = _with_thruster_spread(gains, weights)
    pull = precision @ gains.values[..., None]  # (h, n, 1)
    total = np.sum(pull[..., 0] * gains.values, axis=-1)
    curvature = weights @ precision @ np.swapaxes(weights, 1, 2)
    slope = sign * (weights @ pull)[:, :, 0]
    best = total
    for active in _active_sets(pattern.own):
        matrix = curvature[:, active[:, None], active]
        ridge = RIDGE * np.trace(matrix, axis1=1, axis2=2) + 1e-300
        matrix = matrix + ridge[:, None, None] * np.eye(len(active))
        gain = np.linalg.solve(matrix, slope[:, active, None])[:, :, 0]
        allowed = np.all((gain >= 0) | ~pattern.own[active], axis=1)
        cost = total - np.sum(gain * slope[:, active], axis=1)
        best = np.where(allowed & (cost < best), cost, best)
    return np.asarray(best)


def _active_sets(own: Mask) -> Iterator[Array]:
    """Active sets: every free force, and any subset of those with non-negative gain."""
    free, bounded = np.flatnonzero(~own), np.flatnonzero(own)
    for size in range(len(bounded) + 1):
        for chosen in combinations(bounded.tolist(), size):
            active = np.sort(np.concatenate([free, np.array(chosen, dtype=np.int64)]))
            if len(active):
                yield active
