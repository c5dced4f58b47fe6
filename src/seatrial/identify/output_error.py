# SPDX-License-Identifier: MIT
"""Prediction-error estimation of boat and thrusters together, on the raw poses.

An extended Kalman filter, driven by the model, predicts every pose from those before it; what is
maximised is the likelihood of its errors, over coefficients, constants of the actuator chain, and
the noise of poses and process alike (Ljung, System Identification, 2nd ed., section 7.4). Without
process noise this is the simulation error of whole recordings, with much of it every pose is a new
start: the data say how long the model is to be believed. Pose noise is modelled, so that it does
not bias the coefficients as it does the paper's.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from seatrial import _core
from seatrial.causal import noise_vector
from seatrial.errors import IdentificationError
from seatrial.frames import Array, Axes, Mask
from seatrial.identify.belief import believed, least_noise, plain_noise, worth
from seatrial.identify.problem import EFFECTS, KINDS, LEVER, Passes, Prior, Problem
from seatrial.identify.provenance import envelope, recording_entry
from seatrial.identify.score_test import ScoreTest, block_scores, score_test
from seatrial.identify.search import Point, search
from seatrial.identify.stages import extras, staged, with_free_stages
from seatrial.identify.start import start_values
from seatrial.model import Model
from seatrial.noise import pose_noise
from seatrial.recording import Recording
from seatrial.schema import EstimatorEntry, Integration, NoiseEntry, ProcessEntry, RecordingEntry
from seatrial.vehicle import Vehicle
from seatrial.velocity import motion

METHOD = "output-error"
# walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory [s]
PROCESS_START = (5e-3, 2e-2, 3e-3, 1e-2, 2.0)
SHRINKAGE = 4.0  # blocks a parameter at which half of the scatter is believed
LONGEST = 0.3  # step times rate of the boat's quickest motion
SHORTEST_STEP = 1 / 480  # [s]
MANY, HOPELESS = 0.03, 0.3  # shares of poses beyond the outlier's limit: said, refused
MOST_EXTRAS = 3
WORTH = 20.0  # fall of -2 log likelihood from which on a further stage is worth having
NOISE_START = np.array([2e-3, 4e-3, *PROCESS_START])  # with pose noise in [m] and [rad]


__all__ = ["METHOD", "Fit", "OutputErrorSettings", "fit", "output_error", "with_free_stages"]


@dataclass(frozen=True)
class OutputErrorSettings:
    """Choices of the estimator."""

    outlier: float = 4.0  # [sigma] from which on a pose's error counts linearly
    block: float = 10.0  # [s] over which scores may hang together, for the standard errors
    step: float = 1 / 12  # [s] longest of the integration; less where the boat is fast
    effects: tuple[str, ...] = ()  # of lever, current, trim and wind, those that are sought
    hold_noise: bool = False  # the noise stays that of the start model
    extras: bool = (
        True  # further stages of the chain are tried, and freed where the data ask for it
    )


@dataclass(frozen=True)
class Fit:
    """A solution with all that it came from."""

    problem: Problem
    theta: Array  # all parameters, in the problem's order
    noise: Array  # (7,) position, heading, walks, disturbances, memory
    passes: Passes
    covariance: Array  # (p, p) of the free parameters
    settings: OutputErrorSettings
    notes: tuple[str, ...]  # what was not sought, and why
    share: float = 0.0  # how closely the model was believed, see belief.py
    plain: Array | None = None  # (7,) the noise when it was believed as the likelihood has it

    @property
    def names(self) -> tuple[str, ...]:
        """Of the free parameters."""
        return tuple(self.problem.names[i] for i in self.problem.free)

    def model(self) -> Model:
        """The model, with the covariance of coefficients and constants."""
        problem, theta, n = self.problem, self.theta, self.problem.size
        size = n + problem.constants
        own = [k for k, i in enumerate(problem.free) if i < size]
        at = [problem.free[k] for k in own]
        covariance = np.zeros((size, size))
        covariance[np.ix_(at, at)] = self.covariance[np.ix_(own, own)]
        settings: dict[str, str | float | int | bool | None] = {
            "outlier": self.settings.outlier, "block": self.settings.block, "belief": self.share,
            "effects": ", ".join(self.settings.effects),
        }  # fmt: skip
        noise = self.noise
        if self.share and self.plain is not None:
            noise = plain_noise(Point(theta, noise, self.passes), self.plain)
        position, heading, *process = noise.tolist()
        recordings = problem.recordings
        constants = theta[n:size]
        lever = theta[problem.effects(0)[: len(LEVER)]]
        return Model(
            with_lever(problem.vehicle, *lever.tolist()), theta[:n], covariance, constants,
            Integration("runge-kutta", problem.step),
            NoiseEntry(position, heading, ProcessEntry(*process)),
            envelope(problem.vehicle, constants, recordings, [motion(r) for r in recordings]),
            tuple(self._entry(i) for i in range(len(recordings))),
            EstimatorEntry(METHOD, settings, notes=list(self.notes)),
        )  # fmt: skip

    def _entry(self, recording: int) -> RecordingEntry:
        """A recording with the effects on it that were sought."""
        own = recording_entry(self.problem.recordings[recording])
        places = self.problem.effects(recording)[len(LEVER) :].tolist()
        sought = {
            name: float(self.theta[i])
            for name, i in zip(EFFECTS, places, strict=True)
            if i in self.problem.free
        }
        entry: RecordingEntry = msgspec.structs.replace(own, effects=sought)
        return entry


def with_lever(vehicle: Vehicle, ahead: float, left: float) -> Vehicle:
    """The vehicle with its lever arm longer by what was found, forward-left-up [m]."""
    if ahead == left == 0.0:
        return vehicle
    pose = vehicle.file.pose
    second = -left if vehicle.axes is Axes.FRD else left
    lever = (pose.lever[0] + ahead, pose.lever[1] + second)
    changed = msgspec.structs.replace(pose, lever=lever)
    return replace(vehicle, file=msgspec.structs.replace(vehicle.file, pose=changed))


def output_error(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    settings: OutputErrorSettings | None = None,
    start: Model | None = None,
    prior: Model | None = None,
) -> Model:
    """Coefficients and the constants of the chain that the vehicle file does not state.

    Latency and lag are found, and the dead zone where thrusters are driven to both sides. `start`:
    a model to start from; `prior`: a model whose estimates count as far as its covariance says.
    Raises IdentificationError where the search does not get anywhere.
    """
    return fit(recordings, vehicle, settings=settings, start=start, prior=prior).model()


def fit(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    settings: OutputErrorSettings | None = None,
    start: Model | None = None,
    prior: Model | None = None,
) -> Fit:
    """`output_error` with all that the estimates came from."""
    chosen = settings or OutputErrorSettings()
    for kind in chosen.effects:
        if kind not in KINDS:
            raise IdentificationError(f"no effect '{kind}'; there are {', '.join(KINDS)}")
    whole, notes = _whole(vehicle, recordings, start)
    problem = _with_prior(_problem(whole, vehicle, recordings, chosen), prior)
    theta, noise = _first(problem, recordings, start)
    problem = replace(problem, step=_step(problem, theta))
    at = search(problem, theta, noise, hold=chosen.hold_noise)
    likely, at, share = believed(at, hold=chosen.hold_noise)
    if chosen.extras and start is None:
        at, found = _freed(at, vehicle, chosen, share)
        notes += found
    notes += [*_rejected(at), *worth(at)]
    problem = at.passes.problem
    for i, held in zip(problem.free, at_bounds(at), strict=True):
        if held:
            notes.append(f"{problem.names[i]}: {at.theta[i]:g} is the bound of its range")
    if share:
        notes.append(
            f"the structure is not quite right: it is believed to {100 * share:.0f} % of the way gone "
            "in a second, which predicts one second ahead better than the likelihood's choice"
        )
    covariance = sandwich(at, chosen.block)
    return Fit(
        at.passes.problem,
        at.theta,
        at.noise,
        at.passes,
        covariance,
        chosen,
        tuple(notes),
        share,
        likely.noise,
    )


def _rejected(at: Point) -> list[str]:
    """How many poses count less, being far off; refused where they are so many as to mean nothing."""
    weights = np.concatenate([np.asarray(p.weight) for p in at.passes.each])
    used = weights > 0.0
    share = float(np.mean(weights[used] < 1.0))
    if share > HOPELESS:
        raise IdentificationError(
            f"{100 * share:.0f} % of the poses are rejected as outliers: no model of this structure "
            "goes with them; look at the recordings with inspect, and at the vehicle file's signs"
        )
    if share > MANY:
        return [f"{100 * share:.1f} % of the poses are outliers to the model and count less"]
    return []


def _step(problem: Problem, theta: Array) -> float:
    """As long as asked for, but short beside the boat's quickest motion at the speeds that occur."""
    vehicle, n = problem.vehicle, problem.size
    nu = np.concatenate([m.nu[m.valid] for m in map(motion, problem.recordings)])
    fast = np.percentile(np.abs(nu), 99, axis=0)
    corners = fast * np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
    small = 1e-4 * np.eye(3)
    still = np.zeros((len(corners), len(vehicle.forces)))

    def rate(at: Array) -> Array:
        return _core.accelerations(
            vehicle.structure.compiled, np.ascontiguousarray(theta[:n]), at, still
        )

    slopes = np.stack([(rate(corners + d) - rate(corners - d)) / 2e-4 for d in small], axis=2)
    quickest = float(np.abs(np.linalg.eigvals(slopes)).max())
    return float(min(problem.step, max(LONGEST / max(quickest, 1e-9), SHORTEST_STEP)))


def _freed(
    at: Point, vehicle: Vehicle, settings: OutputErrorSettings, share: float
) -> tuple[Point, list[str]]:
    """The solution with those further stages of the chain that the data ask for; said in words."""
    notes: list[str] = []
    for _ in range(MOST_EXTRAS):
        problem = at.passes.problem
        found = []
        for extra in extras(vehicle, problem.vehicle, problem.recordings):
            wider = _problem(extra.vehicle, vehicle, problem.recordings, settings)
            theta = _moved(at, wider, extra.origin)
            test = _tested(problem, wider, theta, at.noise, settings.block)
            if test.manifest and test.gain > WORTH:
                found.append((test.gain, extra.words, wider, theta))
        if not found:
            break
        _, words, wider, theta = max(found, key=lambda f: f[0])
        least = least_noise(wider, share)
        at = search(wider, theta, at.noise, hold=settings.hold_noise, least=least)
        notes.append(f"{words}: sought, as the data ask for it")
    return at, notes


def _tested(
    problem: Problem, wider: Problem, theta: Array, noise: Array, block: float
) -> ScoreTest:
    """Whether what a wider problem has more deserves it."""
    names = [wider.names[i] for i in wider.free]
    new = [k for k, name in enumerate(names) if name not in problem.names]
    split = [k for k in new if "." in names[k]]
    return score_test(
        wider.passes(theta, noise), [k for k in new if k not in split[:1]], block, split
    )


def _moved(at: Point, wider: Problem, origin: Mapping[str, str]) -> Array:
    """The parameters of a wider problem where they are those of the solution."""
    old = dict(zip(at.passes.problem.names, at.theta.tolist(), strict=True))
    neutral = dict(zip(wider.vehicle.constants.names, wider.vehicle.constants.values, strict=True))
    values = [
        old.get(name, old.get(origin.get(name, ""), neutral.get(name, 0.0))) for name in wider.names
    ]
    return np.array(values)


def _whole(
    vehicle: Vehicle, recordings: Sequence[Recording], start: Model | None
) -> tuple[Vehicle, list[str]]:
    """The vehicle with all stages that are sought: the start model's own, where it has some."""
    if start is not None and start.estimator.method == METHOD:
        known = set(vehicle.constants.names)
        if known <= set(start.vehicle.constants.names):
            return vehicle.with_chain(start.vehicle.file.chain), list(start.estimator.notes)
    return staged(vehicle, recordings)


def _problem(
    whole: Vehicle,
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    settings: OutputErrorSettings,
) -> Problem:
    """Free are the coefficients, the constants that the file does not state, chosen effects."""
    known = set(vehicle.constants.names) - set(whole.estimated)
    problem = Problem(whole, tuple(recordings), (), settings.step, settings.outlier)
    n, m = problem.size, problem.constants
    free = [*range(n), *(n + i for i, c in enumerate(whole.constants.names) if c not in known)]
    for i, name in enumerate(problem.names[n + m :], n + m):
        free += [i] if name.partition("_")[0] in settings.effects else []
    return Problem(whole, tuple(recordings), tuple(free), settings.step, settings.outlier)


def _with_prior(problem: Problem, prior: Model | None) -> Problem:
    """The problem with what a model says of parameters of the same name."""
    if prior is None:
        return problem
    names = dict(zip(prior.parameters, range(len(prior.parameters)), strict=True))
    errors = np.sqrt(np.diag(prior.covariance))
    shared = [
        (i, names[problem.names[i]])
        for i in problem.free
        if problem.names[i] in names and errors[names[problem.names[i]]] > 0
    ]
    if not shared:
        raise IdentificationError(
            "the prior model shares no estimated parameter with this vehicle's structure"
        )
    mine, theirs = [i for i, _ in shared], [j for _, j in shared]
    at = np.zeros(len(problem.names))
    at[mine] = np.concatenate([prior.coefficients, prior.constants])[theirs]
    precision = np.zeros((len(at), len(at)))
    precision[np.ix_(mine, mine)] = np.linalg.pinv(
        prior.covariance[np.ix_(theirs, theirs)], hermitian=True
    )
    return Problem(
        problem.vehicle, problem.recordings, problem.free, problem.step, problem.outlier,
        Prior(at, precision),
    )  # fmt: skip


def _first(
    problem: Problem, recordings: Sequence[Recording], start: Model | None
) -> tuple[Array, Array]:
    """Where the search starts: parameters and noise."""
    n, m = problem.size, problem.constants
    theta = np.zeros(len(problem.names))
    given: dict[str, float] = {}
    if start is not None:
        values = np.concatenate([start.coefficients, start.constants]).tolist()
        given = dict(zip(start.parameters, values, strict=True))
    missing = [name for name in problem.names[:n] if name not in given]
    if start is None or len(missing) == n:
        sought = [i - n for i in problem.free if n <= i < n + m]
        theta[:n], theta[n : n + m] = start_values(recordings, problem.vehicle, sought)
    else:
        theta[n : n + m] = problem.vehicle.constants.values
    for i, name in enumerate(problem.names[: n + m]):
        theta[i] = given.get(name, theta[i])
    noise = None if start is None else noise_vector(start.noise)
    if noise is not None:
        return theta, noise
    own = [pose_noise(r) for r in recordings]
    position, heading = (
        float(np.median([getattr(o, k) for o in own])) for k in ("position", "heading")
    )
    return theta, np.array([max(position, 1e-5), max(heading, 1e-5), *PROCESS_START])


def sandwich(at: Point, block: float) -> Array:
    """Of the information and the scatter of scores over blocks, since errors may hang together.

    The scatter of few blocks is uncertain itself. It is drawn towards what the information says of
    it, times a factor for all of it, which the blocks do know: the fewer blocks a parameter, the
    more so (Ledoit and Wolf, J. Multivariate Analysis 88, 2004, for the idea).
    """
    problem = at.passes.problem
    prior, free = problem.prior, list(problem.free)
    inside = ~at_bounds(at)
    scores = block_scores(at.passes, block)[:, inside]
    information = at.passes.information[np.ix_(inside, inside)]
    blocks, p = scores.shape
    if prior is None and blocks < 2 * p:
        raise IdentificationError(
            f"{blocks} blocks of {block:g} s for {p} parameters; record longer"
        )
    known = np.zeros((p, p)) if prior is None else prior.precision[np.ix_(free, free)][
        np.ix_(inside, inside)
    ]  # fmt: skip
    inverse = _inverse(information)
    scores = scores - scores.mean(axis=0)
    scatter = scores.T @ scores * blocks / max(blocks - p / 2, blocks / 4)  # some was fitted away
    factor = float(np.trace(inverse @ scatter)) / p
    share = blocks / (blocks + SHRINKAGE * p)
    drawn = share * scatter + (1.0 - share) * factor * (information - known)
    out = np.zeros((len(free), len(free)))
    out[np.ix_(inside, inside)] = inverse @ (drawn + known) @ inverse
    return out


def at_bounds(at: Point) -> Mask:
    """Which free parameters ended at a bound: the data say no more of them."""
    problem = at.passes.problem
    low, high = problem.bounds
    theta = at.theta[list(problem.free)]
    return np.asarray((theta <= low) | (theta >= high))


def _inverse(information: Array) -> Array:
    """Of what is not informed of at all the variance is large, not 0."""
    scale = 1.0 / np.sqrt(np.diag(information) + 1e-12)
    correlation = information * np.outer(scale, scale) + 1e-9 * np.eye(len(scale))
    return np.asarray(np.linalg.inv(correlation) * np.outer(scale, scale))
