# SPDX-License-Identifier: MIT
"""Noise parameters of the filter: packing, bounds, model file, and maximum likelihood by Fisher scoring."""

from collections.abc import Sequence

import numpy as np

from seatrial import _core
from seatrial.boat.schema import CorrelatedEntry, NoiseEntry, ProcessEntry
from seatrial.util.frames import Array
from seatrial.util.parallel import spread

# white pose noise: position [m], heading [rad]; process noise: random walks of velocity
# [m/s, rad/s per sqrt(s)], Gauss-Markov disturbances [m/s^2, rad/s^2], their memory [s];
# Gauss-Markov pose noise: position [m], heading [rad], memory [s], angular frequency [rad/s]
NOISE_START = np.array([2e-3, 4e-3, 2e-3, 1e-2, 3e-2, 5e-2, 2.0, 1e-9, 1e-9, 0.3, 1e-9])
NOISE_LEAST = np.array([1e-6, 1e-6, 1e-9, 1e-9, 1e-9, 1e-9, 0.3, 1e-9, 1e-9, 0.02, 1e-9])
NOISE_FIRST = (1e-5, 1e-5)  # [m], [rad] least start values of a search
NOISE_MOST = np.array([1.0, 1.0, 1.0, 5.0, 1.0, 5.0, 30.0, 1.0, 0.25, 1.0, 1e-9])
POSE_NOISE_GROWTH = (
    3.0  # times the start value, bound of pose noise where that is above `NOISE_MOST`
)
LONGEST = 60.0  # [s] longest memory of Gauss-Markov pose noise that starts above a second (GNSS)
WAVE_PERIODS = (0.4, 20.0)  # [s] of oscillating pose noise
# start values for noise that is at its lower bound
RAISED = np.array([0.0, 0.0, 5e-4, 2e-3, 1e-3, 3e-3])
PROCESS, DISTURBANCES, MEMORY = slice(2, 6), [4, 5], 6  # places in the vector
WALKS_AND_DISTURBANCES = ((2, 4), (3, 5))  # of surge and sway, of yaw
COLOUR, COLOUR_MEMORY, COLOUR_TURN = [7, 8], 9, 10  # Gauss-Markov pose noise
NOISE_STEP = 2.5  # largest step of a logarithm
TURN_STEP = 0.15  # the same of the angular frequency: a resonance is narrow
FALLING_STEP = 0.3  # of a logarithm; after a larger fall the lower bound is tried
SLOW_FALL, SLOW_GAIN = 0.01, 100.0  # the same step, where the whole step gains less of the cost
LEAST_CURVATURE = 0.3  # of a logarithm: keeps noise without information in place
NOISE_SETTLED = 0.1  # of the cost; a smaller gain ends the search
NOISE_TRIALS = 6  # damped steps until one gains
NOISE_SCORING_STEPS = 6  # scoring steps of `fitted_noise`
DAMPING, MORE_DAMPING, REJECTED_DAMPING = (
    1e-3,
    10.0,
    1e-2,
)  # first; factor and least after a rejected step
NEARLY_SETTLED = 10.0  # of the cost; below it correlated noise may be dropped
WHITE_CORRELATION = 0.05  # from pose to pose, below which correlated noise is white
OUTLIER = 4.0  # [sigma] of an innovation, above which its cost is linear (Huber)
# random walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory [s]
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
    """Whether the disturbance of the process noise is earth-fixed."""
    return entry.process is not None and entry.process.earth_fixed


def correlated_vector(entry: CorrelatedEntry) -> list[float]:
    """Gauss-Markov pose noise in the order of the noise vector."""
    turn = 0.0 if entry.period is None else float(2.0 * np.pi / entry.period)
    return [entry.position, entry.heading, entry.memory, turn]


def oscillates(noise: Array) -> bool:
    """Whether the Gauss-Markov pose noise oscillates."""
    return bool(noise[COLOUR_TURN] > _core.NO_TURN)


def noise_entry(noise: Array, *, earth: bool = False) -> NoiseEntry:
    """The noise vector (11,) as the entry of a model file; earth: the disturbance is earth-fixed."""
    position, heading, *rest = noise.tolist()
    process, colour = rest[:5], rest[5:]
    coloured = max(colour[:2]) > _core.NO_COLOUR
    period = float(2.0 * np.pi / noise[COLOUR_TURN]) if oscillates(noise) else None
    correlated = CorrelatedEntry(colour[0], colour[1], colour[2], period) if coloured else None
    made = ProcessEntry(process[0], process[1], process[2], process[3], process[4], earth)
    return NoiseEntry(position, heading, made, correlated)


def most_noise(noise: Array) -> Array:
    """Upper bounds (11,) of a search from this noise.

    Far from the optimum, long correlation of pose noise absorbs motion: a search that starts with a
    short memory keeps it short. Metres of position noise are allowed only from such a start.
    """
    most = NOISE_MOST.copy()
    most[0] = most[COLOUR[0]] = max(most[0], POSE_NOISE_GROWTH * noise[0])
    if noise[COLOUR_MEMORY] > NOISE_MOST[COLOUR_MEMORY] * (1.0 + 1e-9):
        most[COLOUR_MEMORY] = LONGEST
    if oscillates(noise):
        most[COLOUR_TURN] = 2.0 * np.pi / WAVE_PERIODS[0]
        most[COLOUR_MEMORY] = LONGEST
    return most


def folded(noise: Array, period: float) -> Array:
    """The noise (11,), with Gauss-Markov pose noise of negligible correlation counted as white.

    The correlation from one pose to the next is exp(-period / memory).
    """
    if np.exp(-period / noise[COLOUR_MEMORY]) > WHITE_CORRELATION:
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
    """Maximum-likelihood noise (11,) for a fixed model, and -2 log likelihood without its constant.

    A step that gains less than `settled` is the last.
    """
    for _ in range(NOISE_SCORING_STEPS):
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
    """-2 log likelihood, without its constant, of linearised passes with other noise (11,)."""
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
    """One step of Fisher scoring on the logarithms of the noise (11,), and the fall of the cost.

    On linearised passes, the model fixed. Noise that falls is also tried at its lower bound, where
    the cost approaches its limit ever more slowly; noise at its bound is tried above it again. Upper
    bounds: `most` (11,), by default `most_noise`.
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

    # 1. Free logarithms: a memory counts only with its amplitudes.
    phi = np.log(np.maximum(noise, least))
    active = phi > low
    active[MEMORY] = active[DISTURBANCES].any()
    active[COLOUR_MEMORY] = active[COLOUR].any()
    active[COLOUR_TURN] = active[COLOUR].any() and oscillates(noise)
    if active[COLOUR_TURN]:
        low[COLOUR_TURN] = np.log(2.0 * np.pi / WAVE_PERIODS[1])
    # 2. Gradient and Fisher information of the linearised passes.
    mask = int(np.sum(active.astype(int) << np.arange(len(phi))))
    parts = spread(lambda pair: _core.noise_slopes(*pair, np.exp(phi), outlier, mask), pairs)
    first = here = sum(p[0] for p in parts)
    gradient, information = sum(p[1] for p in parts), sum(p[2] for p in parts)
    reach = np.full(len(phi), NOISE_STEP)
    reach[COLOUR_TURN] = TURN_STEP
    # 3. A damped step (Levenberg-Marquardt).
    damping = DAMPING
    for _ in range(NOISE_TRIALS):
        matrix = information + np.diag(damping * np.diag(information) + LEAST_CURVATURE)
        move = np.clip(np.linalg.solve(matrix, gradient), -reach, reach)
        trial = np.clip(phi - move, low, high)
        found = cost(trial)
        if found < here:
            phi, here = trial, found
            break
        damping = max(MORE_DAMPING * damping, REJECTED_DAMPING)
    # 4. Process noise: falling to its bound, or up from it.
    for i in range(*PROCESS.indices(len(phi))):
        fell = active[i] and move[i] > (SLOW_FALL if first - here < SLOW_GAIN else FALLING_STEP)
        raised = not active[i] and first - here < NOISE_SETTLED
        if fell or raised:
            phi, here = likelier(i, low[i] if fell else np.log(RAISED[i]), phi, here)
    explained = (phi[PROCESS] <= low[PROCESS]).all()
    # 5. Gauss-Markov pose noise to its bound, once the parameters are near: before, it absorbs motion.
    for i in COLOUR:
        if active[i] and (explained or first - here < NEARLY_SETTLED):
            phi, here = likelier(i, low[i], phi, here)
    return np.exp(phi), first - here


def loosened(noise: Array, times: float) -> Array:
    """The noise with at least `times` the start values of the process noise.

    The filter then trusts the model over a short time only, and far from the optimum its innovations
    still show the direction."""
    other = noise.copy()
    other[PROCESS] = np.maximum(noise[PROCESS], times * PROCESS_START[:-1])
    other[MEMORY] = PROCESS_START[-1]
    return other
