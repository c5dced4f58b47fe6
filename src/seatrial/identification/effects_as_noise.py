# SPDX-License-Identifier: MIT
"""Effects of the recordings as process noise: a filter on board does not know them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.noise_parameters import DISTURBANCES, MEMORY, NOISE_MOST, equal_in_plane
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.velocity import Motion
from seatrial.util.frames import Array

LONGEST = float(NOISE_MOST[MEMORY])  # [s] memory of what does not change
LAG_STEP = 0.1  # [s] of the autocorrelation; the shortest memory of a search is 0.3 s


@dataclass(frozen=True)
class Force:
    """Mean squares of a force as a filter that does not know of it sees it.

    linear: of an axis [(m/s^2)^2]; yaw [(rad/s^2)^2]; memory [s]; earth: it keeps its direction over ground
    """

    linear: float = 0.0
    yaw: float = 0.0
    memory: float = LONGEST
    earth: bool = False


def with_effects_as_noise(
    noise: Array,
    effects: Sequence[Mapping[str, float]],
    moving: Sequence[Motion],
    vehicle: Vehicle,
    coefficients: Array,
) -> tuple[Array, bool | None]:
    """The noise (12,) with the mean square of all recordings' effects as a disturbance force.

    effects: of each recording, by name, in SI; moving: its velocity through the water. The estimator knows them; a
    filter on board estimates them as its disturbance. Also whether the disturbance is then earth-fixed; None: as
    before. Variances add, and so do variances over memories: by these the force changes within a short time. The
    memory is one for all axes: where an axis changes quicker, its variance is larger in place of it.
    """
    if not any(effects):
        return noise, None
    parts = [
        part
        for own, path in zip(effects, moving, strict=True)
        for part in (*_steady(own), *_of_current(own, path, vehicle, coefficients))
    ]
    n, noise = len(effects), equal_in_plane(noise)
    linear, yaw = (noise[DISTURBANCES] ** 2).tolist()
    found = [Force(linear, yaw, float(noise[MEMORY]))]
    found += [Force(p.linear / n, p.yaw / n, p.memory) for p in parts]
    squares = np.array([(p.linear, p.yaw) for p in found])
    changes = squares / np.array([[p.memory] for p in found])  # [1/s], within a short time
    out = noise.copy()
    out[MEMORY] = squares.sum() / changes.sum()
    out[DISTURBANCES] = np.sqrt(np.maximum(squares.sum(axis=0), changes.sum(axis=0) * out[MEMORY]))
    earth = sum(p.linear for p in parts if p.earth) / n
    return out, True if earth > 0.5 * float(squares[:, 0].sum()) else None


def _steady(own: Mapping[str, float]) -> tuple[Force, Force]:
    """Wind and trim: forces that do not change, in earth and in body axes."""
    wind, side = (
        np.array([own.get(f"{part}_{a}", 0.0) for a in "xy"]) for part in ("wind", "wind_side")
    )
    turning = np.hypot(own.get("wind_turn_x", 0.0), own.get("wind_turn_y", 0.0))
    trim = np.hypot(own.get("trim_u", 0.0), own.get("trim_v", 0.0))
    return (
        Force(
            0.25 * float(wind @ wind + (wind + side) @ (wind + side)),
            0.5 * float(turning) ** 2,
            earth=True,
        ),
        Force(0.5 * float(trim) ** 2, own.get("trim_r", 0.0) ** 2),
    )


def _of_current(
    own: Mapping[str, float], path: Motion, vehicle: Vehicle, coefficients: Array
) -> tuple[Force, ...]:
    """A current: the acceleration by which a model that takes motion over ground for motion through water errs.

    At speed it is many times the drag of a boat at rest: by quadratic drag, and in yaw by u v (Munk moment).
    """
    current = own.get("current_x", 0.0), own.get("current_y", 0.0)
    if not any(current):
        return ()
    psi, nu = path.eta[path.valid, 2], path.nu[path.valid]
    water = _core.rotate(psi, np.tile([*current, 0.0], (len(psi), 1)), to_body=True)
    if not len(psi):  # no velocity is known: at rest over ground, any heading
        psi = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
        water = _core.rotate(psi, np.tile([*current, 0.0], (len(psi), 1)), to_body=True)
        nu = -water
    still = np.zeros((len(psi), len(vehicle.forces)))
    through, over = (
        _core.accelerations(
            vehicle.structure.compiled, coefficients, np.ascontiguousarray(v), still
        )
        for v in (nu, nu + water)
    )
    missed = through - over
    # the current turns in body axes
    missed[:, :2] += nu[:, 2:] * water[:, 1::-1] * [1.0, -1.0]
    mean = np.mean(missed**2, axis=0)
    step = float(np.median(np.diff(path.t))) if len(path.t) > 1 else LONGEST
    turned = _core.rotate(psi, missed, to_body=False)
    body, earth = _memory(missed[:, :2], step), _memory(turned[:, :2], step)
    return (
        Force(0.5 * float(mean[:2].sum()), 0.0, max(body, earth), earth >= body),
        Force(0.0, float(mean[2]), _memory(missed[:, 2:], step)),
    )


def _memory(force: Array, step: float) -> float:
    """The lag [s] at which the autocorrelation falls below 1 / e. force: (n, axes), every `step` [s]."""
    whole = float(np.mean(force**2)) / np.e
    every = max(1, round(LAG_STEP / step))
    for lag in range(every, min(len(force), round(LONGEST / step)), every):
        if float(np.mean(force[:-lag] * force[lag:])) < whole:
            return lag * step
    return LONGEST
