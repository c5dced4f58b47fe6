# SPDX-License-Identifier: MIT
"""What each input moves, in words; of inputs that an allocation drives together, what its forces move."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.hypotheses import HypothesisSearch
from seatrial.inspection.consistency.repair import Repair
from seatrial.recording.recording import Recording
from seatrial.util.format import joined
from seatrial.util.frames import AXES, Array

CLEAR_T = 5.0  # least t of an effect that is stated with its direction
# of the largest singular value; below, a combination of inputs is unexcited
LEAST_COMBINATION = 0.01
UNCLEAR = "moves no axis clearly"
DIRECTIONS = (  # of a positive and of a negative gain, by axis
    ("forward", "backward"), ("to the left", "to the right"), ("to the left", "to the right"),
)  # fmt: skip


def effects_of(
    vehicle: Vehicle, search: HypothesisSearch, repair: Repair, recordings: Sequence[Recording]
) -> tuple[dict[str, str], list[str]]:
    """By input its main effect where clear ("moves surge forward (t 35)"), poses corrected; lines of text."""
    names = vehicle.inputs
    values = np.concatenate([r.commands.values for r in recordings])
    spread = values.std(axis=0)
    driven = [name for name, size in zip(names, spread, strict=True) if size > 0.0]
    count = combinations(values[:, spread > 0.0] / spread[spread > 0.0])
    if 0 < count < len(driven):  # the gain of each alone is what the others leave to it
        which = f"{joined(driven)} are driven in {count} combinations"
        together = f"{which}, which do not show what each alone moves"
        return {}, [together, *_forces(vehicle, search, repair)]
    t = _gains_t(search, repair)
    largest = np.abs(t).max(axis=0)
    effects = {n: _effect(t[:, i]) for i, n in enumerate(names) if largest[i] >= CLEAR_T}
    said = [
        f"{n} {effects[n]}" if n in effects else f"{n} {UNCLEAR} (t {largest[i]:.0f})"
        for i, n in enumerate(names)
    ]
    return effects, said


def surge_t(vehicle: Vehicle, search: HypothesisSearch, repair: Repair) -> dict[str, float]:
    """t of the surge gain by input."""
    return dict(zip(vehicle.inputs, _gains_t(search, repair)[0].tolist(), strict=True))


def combinations(values: Array) -> int:
    """Number of independent combinations of the inputs (n, inputs) that are excited."""
    if not values.shape[1]:
        return 0
    size = np.linalg.svd(values - values.mean(axis=0), compute_uv=False)
    return int((size > LEAST_COMBINATION * size[0]).sum()) if size[0] > 0 else 0


def _gains_t(search: HypothesisSearch, repair: Repair) -> Array:
    """t (3, inputs) of the gains, poses corrected."""
    return np.asarray(search.gain_rotation(repair) @ np.array([g.t for g in search.gains]))


def _effect(t: Array) -> str:
    """The axis that moves most, and where to. t (3,)."""
    axis = int(np.argmax(np.abs(t)))
    direction = DIRECTIONS[axis][0 if t[axis] > 0 else 1]
    return f"moves {AXES[axis]} {direction} (t {abs(t[axis]):.0f})"


def _forces(vehicle: Vehicle, search: HypothesisSearch, repair: Repair) -> list[str]:
    """The effect of each force that the file makes of the inputs, where it is clear.

    Their errors include that of the structure, so t is bounded.
    """
    if vehicle.actuators != vehicle.inputs:  # the inputs are the forces
        return []
    share = np.linalg.pinv(vehicle.mix * vehicle.input_signs)  # (n, forces) inputs of each at 1
    t = []
    for gain in search.gains:
        error = np.sqrt(np.einsum("if,ij,jf->f", share, np.linalg.pinv(gain.precision), share))
        t.append(gain.values @ share / error)
    turned = search.gain_rotation(repair) @ np.array(t)
    return [
        f"{force.name} of these {_effect(turned[:, k])}"
        for k, force in enumerate(vehicle.forces)
        if np.abs(turned[:, k]).max() >= CLEAR_T
    ]
