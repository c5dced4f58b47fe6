# SPDX-License-Identifier: MIT
"""What a model's filter believes of noise, and under which noise its errors are most likely."""

from collections.abc import Sequence

import numpy as np

from seatrial import _core
from seatrial.boat.schema import CorrelatedEntry, NoiseEntry, ProcessEntry
from seatrial.util.frames import Array
from seatrial.util.parallel import spread

# position [m], heading [rad], walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory
# [s]; correlated errors of the poses [m], [rad], their memory [s], how fast they swing [rad/s]
NOISE_START = np.array([2e-3, 4e-3, 2e-3, 1e-2, 3e-2, 5e-2, 2.0, 1e-9, 1e-9, 0.3, 1e-9])
NOISE_LEAST = np.array([1e-6, 1e-6, 1e-9, 1e-9, 1e-9, 1e-9, 0.3, 1e-9, 1e-9, 0.02, 1e-9])
NOISE_FIRST = (1e-5, 1e-5)  # [m], [rad] the least that a search starts from
NOISE_MOST = np.array([1.0, 1.0, 1.0, 5.0, 1.0, 5.0, 30.0, 1.0, 0.25, 1.0, 1e-9])
MORE = 3.0  # times what a search begins with pose noise may come to, where that is larger
LONGEST = 60.0  # [s] memory of errors of the poses where they last for more than a second: GNSS
PERIODS = (0.4, 20.0)  # [s] of errors of the poses that swing: waves
# where what was at its least is tried
RAISED = np.array([0.0, 0.0, 5e-4, 2e-3, 1e-3, 3e-3])
PROCESS, DISTURBANCES, MEMORY = slice(2, 6), [4, 5], 6  # places among the noise
WALKS_AND_DISTURBANCES = ((2, 4), (3, 5))  # of the same motion
COLOUR, COLOUR_MEMORY, COLOUR_TURN = [7, 8], 9, 10
NOISE_STEP = 2.5  # the largest of a logarithm
TURN_STEP = 0.15  # the same of how fast errors swing: a resonance is sharp
FALLING = 0.3  # a step of a logarithm that may be one of an endless way down
CREEPING, LITTLE = 0.01, 100.0  # the same where a step gains less of the cost: slow ways down
CURVATURE = 0.3  # at the least, of a logarithm: what the data do not speak of stays where it is
NOISE_SETTLED = 0.1  # of the cost: other noise that gains less is not worth another step
NOISE_TRIALS = 6
LATE = 10.0  # of the cost: when less is gained, the search is near its end
UNCONNECTED = 0.05  # correlation from pose to pose up to which errors count as white
OUTLIER = 4.0  # [sigma] from which on a pose's error counts linearly
# walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory [s]
PROCESS_START = np.array([5e-3, 2e-2, 3e-3, 1e-2, 2.0])


def noise_vector(entry: NoiseEntry) -> Array | None:
    """Noise (11,) as the core's filter takes it; None where no process noise was estimated."""
    p, c = entry.process, entry.correlated
    if p is None:
        return None
    walks = [p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw]
    colour = NOISE_LEAST[COLOUR[0] :] if c is None else correlated_vector(c)
    found = np.array([entry.position, entry.heading, *walks, p.memory, *colour])
    return np.asarray(np.clip(found, NOISE_LEAST, None))


def earth_fixed(entry: NoiseEntry) -> bool:
    """Whether what pushes the boat comes from one side of the world."""
    return entry.process is not None and entry.process.earth_fixed


def correlated_vector(entry: CorrelatedEntry) -> list[float]:
    """Errors of the poses that are correlated as they stand in the noise."""
    turn = 0.0 if entry.period is None else float(2.0 * np.pi / entry.period)
    return [entry.position, entry.heading, entry.memory, turn]


def swings(noise: Array) -> bool:
    """Whether errors of the poses are believed to swing while they are correlated."""
    return bool(noise[COLOUR_TURN] > _core.NO_TURN)


def noise_entry(noise: Array, *, earth: bool = False) -> NoiseEntry:
    """The filter's noise (11,) as a model file has it; whether the disturbance is earth-fixed."""
    position, heading, *rest = noise.tolist()
    process, colour = rest[:5], rest[5:]
    coloured = max(colour[:2]) > _core.NO_COLOUR
    period = float(2.0 * np.pi / noise[COLOUR_TURN]) if swings(noise) else None
    correlated = CorrelatedEntry(colour[0], colour[1], colour[2], period) if coloured else None
    made = ProcessEntry(process[0], process[1], process[2], process[3], process[4], earth)
    return NoiseEntry(position, heading, made, correlated)


def most_noise(noise: Array) -> Array:
    """The most that noise may come to from here (11,).

    Errors of the poses that last look like motion as long as parameters are far off; so what begins
    with short ones keeps to them. And positions may be metres off, but only where a search begins so.
    """
    most = NOISE_MOST.copy()
    most[0] = most[COLOUR[0]] = max(most[0], MORE * noise[0])
    if noise[COLOUR_MEMORY] > NOISE_MOST[COLOUR_MEMORY] * (1.0 + 1e-9):
        most[COLOUR_MEMORY] = LONGEST
    if swings(noise):
        most[COLOUR_TURN] = 2.0 * np.pi / PERIODS[0]
        most[COLOUR_MEMORY] = LONGEST
    return most


def folded(noise: Array, period: float) -> Array:
    """The noise (11,), errors that are correlated for less than `period` [s] counted as the white ones they are.

    From one pose to the next exp(-period / memory) is left of them.
    """
    if np.exp(-period / noise[COLOUR_MEMORY]) > UNCONNECTED:
        return noise
    out = noise.copy()
    out[:2] = np.hypot(noise[:2], noise[COLOUR])
    out[COLOUR] = NOISE_LEAST[COLOUR]
    out[COLOUR_TURN] = NOISE_LEAST[COLOUR_TURN]
    return out


def fitted_noise(
    passes: Sequence[_core.FilterRun],
    poses: Sequence[_core.Series],
    noise: Array,
    settled: float = NOISE_SETTLED,
) -> tuple[Array, float]:
    """The noise (11,) under which the errors are most likely, the model as it is; -2 log likelihood.

    No constant in the likelihood. A step that gains less than `settled` of it is the last.
    """
    for _ in range(6):
        noise, gain = likelier_noise(passes, poses, noise)
        if gain < settled:
            break
    return noise, repeated_cost(passes, poses, noise, OUTLIER)


def repeated_cost(
    passes: Sequence[_core.FilterRun],
    poses: Sequence[_core.Series],
    noise: Array,
    outlier: float,
) -> float:
    """-2 log likelihood, but for a constant, of passes that are repeated with other noise (11,)."""
    pairs = list(zip(passes, poses, strict=True))
    return sum(spread(lambda pair: _core.repeated(*pair, noise, outlier), pairs))


def likelier_noise(
    passes: Sequence[_core.FilterRun],
    poses: Sequence[_core.Series],
    noise: Array,
    outlier: float = OUTLIER,
    *,
    least: Array = NOISE_LEAST,
    most: Array | None = None,
) -> tuple[Array, float]:
    """Noise (11,) under which the errors are more likely, the model as it is; the fall of the cost.

    One step of Fisher's scoring on the logarithms, over linearised repetitions of the passes. What
    falls is tried at its least, too: there the way down is endless and ever flatter; what is at its
    least is tried higher up again. Not beyond `most` (11,), by default `most_noise`.
    """
    pairs = list(zip(passes, poses, strict=True))
    low, high = np.log(least), np.log(most_noise(noise) if most is None else most)

    def cost(phi: Array) -> float:
        return repeated_cost(passes, poses, np.exp(phi), outlier)

    def likelier(i: int, to: float, phi: Array, here: float) -> tuple[Array, float]:
        trial = phi.copy()
        trial[i] = to
        found = cost(trial)
        return (trial, found) if found < here else (phi, here)

    phi = np.log(np.maximum(noise, least))
    active = phi > low
    active[MEMORY] = active[DISTURBANCES].any()
    active[COLOUR_MEMORY] = active[COLOUR].any()
    active[COLOUR_TURN] = active[COLOUR].any() and swings(noise)
    if active[COLOUR_TURN]:
        low[COLOUR_TURN] = np.log(2.0 * np.pi / PERIODS[1])
    mask = int(np.sum(active.astype(int) << np.arange(len(phi))))
    parts = spread(lambda pair: _core.noise_slopes(*pair, np.exp(phi), outlier, mask), pairs)
    first = here = sum(p[0] for p in parts)
    gradient, information = sum(p[1] for p in parts), sum(p[2] for p in parts)
    reach = np.full(len(phi), NOISE_STEP)
    reach[COLOUR_TURN] = TURN_STEP
    damping = 1e-3
    for _ in range(NOISE_TRIALS):
        matrix = information + np.diag(damping * np.diag(information) + CURVATURE)
        move = np.clip(np.linalg.solve(matrix, gradient), -reach, reach)
        trial = np.clip(phi - move, low, high)
        found = cost(trial)
        if found < here:
            phi, here = trial, found
            break
        damping = max(10.0 * damping, 1e-2)
    for i in range(*PROCESS.indices(len(phi))):
        fell = active[i] and move[i] > (CREEPING if first - here < LITTLE else FALLING)
        raised = not active[i] and first - here < NOISE_SETTLED
        if fell or raised:
            phi, here = likelier(i, low[i] if fell else np.log(RAISED[i]), phi, here)
    explained = (phi[PROCESS] <= low[PROCESS]).all()
    for i in COLOUR:  # as long as parameters are far off, what is correlated looks like motion
        if active[i] and (explained or first - here < LATE):
            phi, here = likelier(i, low[i], phi, here)
    return np.exp(phi), first - here


def loosened(noise: Array, times: float) -> Array:
    """The noise with so many times the process noise of a first one, at least: the model is believed
    for a short while only, and so its errors tell where to go though it is far off."""
    other = noise.copy()
    other[PROCESS] = np.maximum(noise[PROCESS], times * PROCESS_START[:-1])
    other[MEMORY] = PROCESS_START[-1]
    return other
