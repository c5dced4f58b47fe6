# SPDX-License-Identifier: MIT
"""Which signs and which order of a vehicle file's signals explain the gains with the fewest edits."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations, permutations, product

import numpy as np

from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.inspection.consistency.gains import Gains
from seatrial.inspection.consistency.repair import Repair, edits_of
from seatrial.util.frames import Array, Axes, Mask

PRICE = 10.0  # chi-square that an edit must be worth, given many blocks;
FEW = 12.0  # so many blocks above the number of inputs double it
TIE = 0.01  # edits: of explanations alike, y and psi mirrored, else the one that leaves the poses
EXHAUSTIVE = 5  # more inputs than this are searched edit by edit
SHORT, LONG = 0.3, 1.5  # [m] arms of a measured point, of one recording and of several that agree
STEP = 0.02  # [m]
MIRROR = np.diag([1.0, -1.0])
UNLIKE = (
    0.08  # of its thrust by which an actuator may differ from the others: its dead zone, its curve
)


@dataclass(frozen=True)
class Pattern:
    """How the vehicle file says that inputs act on one axis, in forward-left-up axes."""

    weights: Array  # (forces, n) of the forces in the axis' equation, of the file's inputs
    own: Mask  # (forces,) those along the axis, whose gain can't be negative


def patterns(vehicle: Vehicle) -> tuple[Pattern, Pattern, Pattern]:
    """Patterns of surge, sway and yaw."""
    allocated = vehicle.actuators != vehicle.inputs  # then T f = F, and the inputs are F
    names = np.array([[float(i == f) for i in vehicle.inputs] for f in WRENCH])
    mix = (names if allocated else vehicle.mix) * vehicle.input_signs
    found = []
    for axis in range(3):
        rows, own = [], []
        for force, row in zip(vehicle.forces, mix, strict=True):
            terms = [
                t for t in vehicle.structure.terms if t.axis == axis and force.name in t.factors
            ]
            if terms:
                rows.append(np.sign(terms[0].number) * row)
                own.append(force.axis == axis)
        weights = np.array(rows, dtype=float).reshape(-1, len(vehicle.inputs))
        found.append(Pattern(weights, np.array(own, dtype=bool)))
    return found[0], found[1], found[2]


@dataclass(frozen=True)
class Search:
    """Readings of signs and order against gains of the file's inputs."""

    vehicle: Vehicle
    gains: tuple[Gains, Gains, Gains]  # mirrored: with y turned round
    mirrored: bool  # whether the plane of the poses has the wrong hand against psi
    blocks: int

    @cached_property
    def price(self) -> float:
        """Chi-square that an edit must be worth."""
        left = max(1.0, float(self.blocks - len(self.vehicle.inputs)))
        return PRICE * (1.0 + FEW / left)

    @cached_property
    def patterns(self) -> tuple[Pattern, Pattern, Pattern]:
        """What the file says."""
        return patterns(self.vehicle)

    @cached_property
    def as_is(self) -> Repair:
        """No edit."""
        n = len(self.vehicle.inputs)
        return Repair(order=tuple(range(n)), input_signs=(1,) * n)

    def best(self) -> Repair:
        """The repair with the best of chi-square and price of its edits."""
        if self.fits(self.as_is):
            return self.as_is  # nothing can be worth an edit
        if len(self.vehicle.inputs) > EXHAUSTIVE:
            return min((self._climbed(pose) for pose in self._poses()), key=self._score)
        inputs, matrices, edits = _signed_permutations(len(self.vehicle.inputs))
        found = []
        for pose in self._poses():
            cost = self._misfits(pose, matrices) + self.price * (edits + _pose_edits(pose))
            i = int(np.argmin(cost))
            found.append(
                (float(cost[i]), replace(pose, order=inputs[i][0], input_signs=inputs[i][1]))
            )
        return min(found, key=lambda f: f[0])[1]

    def misfit(self, repair: Repair) -> float:
        """Chi-square of the gains against what the repaired file allows."""
        return float(self._misfits(repair, repair.matrix[None])[0])

    def fits(self, repair: Repair) -> bool:
        """Whether the file with its inputs repaired is right, for a measured point that may be off the origin."""
        if self.mirrored:
            return False
        if self.misfit(repair) < self.price:
            return True
        return self.moved(nearest_arm([self], SHORT, repair), repair).misfit(repair) < self.price

    def moved(self, arm: tuple[float, float], repair: Repair | None = None) -> "Search":
        """The same of a point so far behind and to starboard [m] of the measured one, forward-left-up.

        It turns as the file allows: what these inputs do not show may be anything in the gains themselves.
        """
        ahead, left = arm
        surge, sway, yaw = self.gains
        weights = self.patterns[2].weights @ (repair or self.as_is).matrix
        turns = _allowed(yaw, weights) * (-1.0 if self.mirrored else 1.0)
        surge = replace(surge, values=surge.values + left * turns)
        sway = replace(sway, values=sway.values - ahead * turns)
        return replace(self, gains=(surge, sway, yaw))

    def body(self, repair: Repair) -> Array:
        """What the repair of the poses does to [surge, sway, yaw] of the gains: (3, 3)."""
        flip = MIRROR if self.vehicle.axes is Axes.FRD else np.eye(2)
        plane = flip @ repair.plane @ flip @ (MIRROR if self.mirrored else np.eye(2))
        whole = np.zeros((3, 3))
        whole[:2, :2], whole[2, 2] = plane, repair.pose_signs[2]
        return whole

    def worth(self, repair: Repair, changed: Repair) -> float:
        """By how much a change of a repair makes it worse, in prices of an edit."""
        return (self.misfit(changed) - self.misfit(repair)) / self.price

    def alike(self, i: int, j: int) -> bool:
        """Whether the file gives two inputs the same part, so that their order does not matter."""
        return all(np.allclose(p.weights[:, i], p.weights[:, j]) for p in self.patterns)

    def _poses(self) -> Iterator[Repair]:
        """Signs and order of the coordinates that have the right hand."""
        for exchanged, x, y, psi in product((False, True), (1, -1), (1, -1), (1, -1)):
            repair = replace(self.as_is, exchanged=exchanged, pose_signs=(x, y, psi))
            if (np.linalg.det(repair.plane) * psi < 0) == self.mirrored:
                yield repair

    def _misfits(self, pose: Repair, matrices: Array) -> Array:
        """Chi-square (h,) for each matrix (h, n, n) of the inputs."""
        total = np.zeros(len(matrices))
        for pattern, row in zip(self.patterns, self.body(pose), strict=True):
            axis = int(np.argmax(np.abs(row)))
            total += _misfit(self.gains[axis], row[axis], pattern, matrices)
        return total

    def _score(self, repair: Repair) -> float:
        edits = edits_of(repair.order, repair.input_signs) + _pose_edits(repair)
        return self.misfit(repair) + self.price * edits

    def _climbed(self, repair: Repair) -> Repair:
        """The best that can be reached edit by edit."""
        while True:
            step = min(neighbours(repair), key=self._score)
            if self._score(step) >= self._score(repair):
                return repair
            repair = step


def nearest_arm(
    searches: Sequence[Search], most: float, repair: Repair | None = None
) -> tuple[float, float]:
    """Where the measured point is [m], ahead of the origin and to port, if the files are right; `most` away."""
    arms = np.arange(-round(most / STEP), round(most / STEP) + 1) * STEP

    def misfit(arm: tuple[float, float]) -> float:
        return sum(s.moved(arm, repair).misfit(repair or s.as_is) for s in searches)

    ahead = min(arms.tolist(), key=lambda arm: misfit((arm, 0.0)))  # moves sway
    left = min(arms.tolist(), key=lambda arm: misfit((0.0, arm)))  # moves surge
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
    """The repair with input i turned round."""
    signs = list(repair.input_signs)
    signs[i] = -signs[i]
    return replace(repair, input_signs=tuple(signs))


def swapped(repair: Repair, i: int, j: int) -> Repair:
    """The repair with the columns of inputs i and j exchanged."""
    order = list(repair.order)
    order[i], order[j] = order[j], order[i]
    return replace(repair, order=tuple(order))


def _pose_edits(repair: Repair) -> float:
    handed = repair.pose_signs == (1, -1, -1) and not repair.exchanged
    return repair.pose_edits * (1.0 - TIE if handed else 1.0 + TIE)


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


def _loosened(gains: Gains, weights: Array) -> Array:
    """Precisions (h, n, n) of gains, when actuators need not thrust quite as the shares (h, forces, n) say.

    What is left of an axis that others drive is no sign of a mistake. `UNLIKE` is in their errors, of forces as
    large as these gains allow; of a force that was hardly given they allow any size: then the axis tells little.
    """
    precision = gains.precision
    shared = np.count_nonzero(weights, axis=2) > 1  # (h, forces) by several actuators
    if not shared.any():
        return np.broadcast_to(precision, (len(weights), *precision.shape))
    curvature = weights @ precision @ np.swapaxes(weights, 1, 2)
    most = np.linalg.norm(precision, 2) * np.sum(weights**2, axis=(1, 2))
    inverse = np.linalg.inv(curvature + 1e-9 * most[:, None, None] * np.eye(weights.shape[1]))
    found = (inverse @ weights @ (precision @ gains.values)[:, None])[:, :, 0]
    force = np.abs(found) + 2.0 * np.sqrt(np.diagonal(inverse, axis1=1, axis2=2))
    parts = np.where(shared[:, :, None], force[:, :, None] * weights, 0.0)
    unlike = UNLIKE**2 * np.sum(parts**2, axis=1)[:, :, None] * np.eye(weights.shape[2])
    return np.asarray(np.linalg.inv(np.linalg.inv(precision) + unlike))


def _allowed(gains: Gains, weights: Array) -> Array:
    """The gains (n,) nearest to those seen that a pattern's weights (forces, n) allow, of either sign."""
    if not weights.any():
        return gains.values
    pull = weights @ gains.precision
    curvature = pull @ weights.T
    ridge = 1e-9 * float(np.trace(curvature)) * np.eye(len(curvature))
    return np.asarray(np.linalg.solve(curvature + ridge, pull @ gains.values) @ weights)


def _misfit(gains: Gains, sign: float, pattern: Pattern, matrices: Array) -> Array:
    """Chi-square (h,) of an axis' gains, times sign, against its pattern of edited inputs."""
    if len(pattern.own) == 0:
        return np.full(len(matrices), gains.total)
    weights = pattern.weights @ matrices  # (h, forces, n)
    precision = _loosened(gains, weights)
    pull = precision @ gains.values  # (h, n)
    total = pull @ gains.values
    curvature = weights @ precision @ np.swapaxes(weights, 1, 2)
    slope = sign * (weights @ pull[:, :, None])[:, :, 0]
    best = total
    for active in _active_sets(pattern.own):
        matrix = curvature[:, active[:, None], active]
        ridge = 1e-9 * np.trace(matrix, axis1=1, axis2=2) + 1e-300
        matrix = matrix + ridge[:, None, None] * np.eye(len(active))
        gain = np.linalg.solve(matrix, slope[:, active, None])[:, :, 0]
        allowed = np.all((gain >= 0) | ~pattern.own[active], axis=1)
        cost = total - np.sum(gain * slope[:, active], axis=1)
        best = np.where(allowed & (cost < best), cost, best)
    return np.asarray(best)


def _active_sets(own: Mask) -> Iterator[Array]:
    """Forces that act while others are at their bound of no gain: all free ones, any own ones."""
    free, bounded = np.flatnonzero(~own), np.flatnonzero(own)
    for size in range(len(bounded) + 1):
        for chosen in combinations(bounded.tolist(), size):
            active = np.sort(np.concatenate([free, np.array(chosen, dtype=np.int64)]))
            if len(active):
                yield active
