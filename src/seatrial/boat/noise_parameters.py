# SPDX-License-Identifier: MIT
"""Noise parameters of the filter: packing, bounds, units, and the model file."""

import numpy as np

from seatrial import _core
from seatrial.boat.schema import CorrelatedEntry, NoiseEntry, ProcessEntry
from seatrial.util.frames import Array, Mask

# white pose noise: position [m], heading [rad]; process noise: random walks of velocity
# [m/s, rad/s per sqrt(s)], Gauss-Markov disturbances [m/s^2, rad/s^2], their memory [s];
# Gauss-Markov pose noise: position [m], heading [rad], memory [s], angular frequency [rad/s];
# process noise of sway over that of surge
NOISE_START = np.array([2e-3, 4e-3, 2e-3, 1e-2, 3e-2, 5e-2, 2.0, 1e-9, 1e-9, 0.3, 1e-9, 1.0])
NOISE_LEAST = np.array([1e-6, 1e-6, 1e-9, 1e-9, 1e-9, 1e-9, 0.3, 1e-9, 1e-9, 0.02, 1e-9, 1.0])
NOISE_FIRST = (1e-5, 1e-5)  # [m], [rad] least start values of a search
# process noise: several times the thrust of a toy boat of 0.5 kg, so that no boat reaches it
NOISE_MOST = np.array([1.0, 1.0, 10.0, 100.0, 20.0, 200.0, 30.0, 1.0, 0.25, 1.0, 1e-9, 8.0])
# times the start value, bound of pose noise where that is above `NOISE_MOST`
POSE_NOISE_GROWTH = 3.0
LONGEST = 60.0  # [s] longest memory of Gauss-Markov pose noise that starts above a second (GNSS)
WAVE_PERIODS = (0.4, 20.0)  # [s] of oscillating pose noise
PROCESS, WALKS, DISTURBANCES, MEMORY = slice(2, 6), [2, 3], [4, 5], 6  # places in the vector
COLOUR, COLOUR_MEMORY, COLOUR_TURN = [7, 8], 9, 10  # Gauss-Markov pose noise
COLOURED = slice(7, 11)  # all of it
SWAY_RATIO, IN_PLANE = 11, [2, 4]  # and the process noise that it is of
AMPLITUDES = (0, 1, 2, 3, 4, 5, 7, 8)  # the others are time constants and a frequency
UNIT_POSES = 10.0  # within so many poses a noise source matters that moves the boat by their errors
WHITE_CORRELATION = 0.05  # from pose to pose, below which correlated noise is white
OUTLIER = 4.0  # [sigma] of an innovation, above which its cost is linear (Huber)
# random walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory [s]
PROCESS_START = np.array([5e-3, 2e-2, 3e-3, 1e-2, 2.0])


def noise_vector(entry: NoiseEntry) -> Array | None:
    """Noise (12,) as the core's filter takes it; None where no process noise was estimated."""
    p, c = entry.process, entry.correlated
    if p is None:
        return None
    walks = [p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw]
    colour = NOISE_LEAST[COLOURED] if c is None else correlated_vector(c)
    ratio = 1.0 if p.earth_fixed else p.sway_ratio
    found = np.array([entry.position, entry.heading, *walks, p.memory, *colour, ratio])
    return np.asarray(np.clip(found, least_noise(), None))


def earth_fixed(entry: NoiseEntry) -> bool:
    """Whether the disturbance of the process noise is earth-fixed."""
    return entry.process is not None and entry.process.earth_fixed


def disturbance_estimated(entry: NoiseEntry) -> bool:
    """Whether the process noise has a Gauss-Markov disturbance."""
    noise = noise_vector(entry)
    return noise is not None and bool((noise[DISTURBANCES] > NOISE_LEAST[DISTURBANCES]).any())


def correlated_vector(entry: CorrelatedEntry) -> list[float]:
    """Gauss-Markov pose noise in the order of the noise vector."""
    turn = 0.0 if entry.period is None else float(2.0 * np.pi / entry.period)
    return [entry.position, entry.heading, entry.memory, turn]


def present(noise: Array) -> Mask:
    """Which noise sources (12,) are there; time constants and the frequency count as present."""
    out = noise > NOISE_LEAST
    out[[MEMORY, COLOUR_MEMORY, COLOUR_TURN, SWAY_RATIO]] = True
    return np.asarray(out)


def oscillates(noise: Array) -> bool:
    """Whether the Gauss-Markov pose noise oscillates."""
    return bool(noise[COLOUR_TURN] > _core.NO_TURN)


def noise_entry(noise: Array, *, earth: bool = False) -> NoiseEntry:
    """The noise vector (12,) as the entry of a model file; earth: the disturbance is earth-fixed."""
    position, heading, *rest = noise.tolist()
    colour = rest[5:9]
    coloured = max(colour[:2]) > _core.NO_COLOUR
    period = float(2.0 * np.pi / noise[COLOUR_TURN]) if oscillates(noise) else None
    correlated = CorrelatedEntry(colour[0], colour[1], colour[2], period) if coloured else None
    ratio = 1.0 if earth else float(noise[SWAY_RATIO])
    walks, forces, memory = rest[:2], rest[2:4], rest[4]
    made = ProcessEntry(walks[0], walks[1], forces[0], forces[1], memory, ratio, earth)
    return NoiseEntry(position, heading, made, correlated)


def least_noise() -> Array:
    """Lower bounds (12,) of a search: those of noise that is as good as none, and of the sway ratio."""
    least = NOISE_LEAST.copy()
    least[SWAY_RATIO] = 1.0 / NOISE_MOST[SWAY_RATIO]
    return least


def is_unequal(noise: Array) -> bool:
    """Whether the process noise has a ratio of sway to surge of its own."""
    return bool(noise[SWAY_RATIO] != NOISE_LEAST[SWAY_RATIO])


def equal_in_plane(noise: Array) -> Array:
    """The noise (12,) with the mean power of surge and sway in both, as an earth-fixed disturbance has it."""
    out = noise.copy()
    out[IN_PLANE] *= np.sqrt(0.5 * (1.0 + noise[SWAY_RATIO] ** 2))
    out[SWAY_RATIO] = NOISE_LEAST[SWAY_RATIO]
    return out


def most_noise(noise: Array) -> Array:
    """Upper bounds (12,) of a search from this noise.

    Far from the optimum, long correlation of pose noise absorbs motion: a search that starts with a short memory
    keeps it short. Metres of position noise are allowed only from such a start.
    """
    most = NOISE_MOST.copy()
    if noise[COLOUR_MEMORY] > NOISE_MOST[COLOUR_MEMORY] * (1.0 + 1e-9) or oscillates(noise):
        most[COLOUR_MEMORY] = LONGEST
    most[0] = most[COLOUR[0]] = max(most[0], POSE_NOISE_GROWTH * noise[0])
    if oscillates(noise):
        most[COLOUR_TURN] = 2.0 * np.pi / WAVE_PERIODS[0]
    return most


def folded(noise: Array, period: float) -> Array:
    """The noise (12,), with Gauss-Markov pose noise of negligible correlation counted as white.

    The correlation from one pose to the next is exp(-period / memory).
    """
    if np.exp(-period / noise[COLOUR_MEMORY]) > WHITE_CORRELATION:
        return noise
    out = noise.copy()
    out[:2] = np.hypot(noise[:2], noise[COLOUR])
    out[COLOUR] = NOISE_LEAST[COLOUR]
    out[COLOUR_TURN] = NOISE_LEAST[COLOUR_TURN]
    return out


def noise_units(noise: Array, period: float) -> Array:
    """The amplitude (12,) from which on each noise source matters, 0 for the others.

    White pose errors are the unit of pose noise. A random walk or a disturbance force matters where it moves the
    boat by as much as these within `UNIT_POSES` poses. period: [s] of the poses.
    """
    out = np.zeros(len(noise))
    errors = np.hypot(noise[:2], noise[COLOUR])
    time = UNIT_POSES * period
    out[:2] = out[COLOUR] = errors
    out[2:4] = np.sqrt(3.0) * errors / time**1.5
    out[DISTURBANCES] = 2.0 * errors / time**2
    return out


def loosened(noise: Array, times: float) -> Array:
    """The noise with at least `times` the start values of the process noise.

    The filter then trusts the model over a short time only, and far from the optimum its innovations
    still show the direction."""
    other = noise.copy()
    other[PROCESS] = np.maximum(noise[PROCESS], times * PROCESS_START[:-1])
    other[MEMORY] = PROCESS_START[-1]
    return other
