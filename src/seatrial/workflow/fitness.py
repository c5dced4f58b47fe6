# SPDX-License-Identifier: MIT
"""What a model is fit for: simulation, control, odometry; by stated criteria, as values."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from seatrial.boat.findings import FindingKind
from seatrial.boat.model import Model
from seatrial.boat.physics import AxisPhysics, axis_physics, backward_thrust
from seatrial.boat.structure import Term
from seatrial.evaluation.scores import AxisScore, PooledScore, Scores, Start
from seatrial.util.errors import ModelError
from seatrial.util.frames import AXES, SYMBOLS, Array
from seatrial.util.statistics import NORMAL_95

# Simulation: error growth. 1 - ratio is Ljung's fit index with constant velocity as the mean.
SIMULATED_WELL = 0.5  # [-] excess over constant velocity's at the longest horizon: a fit of 50 %
SIMULATED_SO_SO = 0.8  # [-] a fit of 20 %: it hardly follows its commands
# Control: a gain margin of 6 dB, the usual least one, is a factor of 2.
# [-] 95 % half-width of gain or damping over its value: 2 dB, a third of the margin
GAIN_KNOWN = 0.25
GAIN_SO_SO = 0.5  # [-] the whole margin of 6 dB
# A loop as fast as the boat turns its phase by delay / rise time [rad] at crossover; 45 deg are usual.
# [-] 95 % half-width of latency and lag over the fastest rise time: 6 deg of phase
DELAY_KNOWN = 0.1
DELAY_SO_SO = 0.3  # [-] 17 deg, a third of the phase margin
# Odometry: RMS error over the expected one, the square root of a mean NEES per degree of freedom.
CONSISTENT = 1.25  # [-] the stated 95 % interval then holds 88 % of the errors
CONSISTENT_SO_SO = 2.0  # [-] it holds 67 %
# [-] excess over constant velocity's, below which the model adds information
BETTER_THAN_NONE = 0.8
NO_BETTER = 1.0  # [-] a filter without the model does as well
ODOMETRY_HORIZON = 1.0  # [s] between corrections by a slow sensor


class Use(Enum):
    """What a model is used for."""

    SIMULATION = "simulation"
    CONTROL = "control"
    ODOMETRY = "odometry"


class Level(Enum):
    """How fit a model is for a use, the worst last."""

    FIT = "fit"
    LIMITED = "limited"
    NOT_FIT = "not fit"


class Criterion(Enum):
    """What decided, with its sentence."""

    CONTRADICTED = "the recordings that it was identified from contradict the vehicle file"
    UNSTABLE = "the model is unstable within its envelope"
    NOT_PREDICTED = "no recording could be predicted"
    SEEN = "tested only on recordings that it was identified from"
    GROWTH = (
        "{subject}: error grows to {value} of constant velocity's {horizon:g} s ahead "
        "(fit: up to {limit})"
    )
    GAIN = "{subject} is known to ± {percent} (95 %; fit: up to {most})"
    NO_GAIN = "{subject} has no standard error"
    DELAY = "latency and lag are known to ± {percent} of the rise time (95 %; fit: up to {most})"
    NO_DELAY = "the model has no latency and no lag"
    BACKWARD = "{subject} is negative: signs, thruster angles or axes are wrong"
    NO_INPUT = "no command drives any axis"
    BASELINE = "{subject}: error {horizon:g} s ahead is {value} of constant velocity's (fit: up to {limit})"
    CONSISTENCY = (
        "{subject}: errors {horizon:g} s ahead are {value} times those that the model states "
        "(fit: up to {limit})"
    )
    NO_EXPECTED = "the model has no process noise, so its filter states no error"


AT_FLOOR = (
    "{subject}: the error {horizon:g} s ahead is pose noise alone; a perfect model has the same"
)

MORE_DRIVING = "identify from more driving in {subject}, at the speeds of use"
NEXT_DRIVE = "drive what the report's next drive says, which narrows it"
# what lifts a level that is not `FIT`
ACTIONS = {
    Criterion.CONTRADICTED: "correct the vehicle file, which inspect checks, then identify again",
    Criterion.UNSTABLE: "check the vehicle file's signs with inspect, then identify again",
    Criterion.NOT_PREDICTED: "give a recording whose poses and commands have no gaps for a minute",
    Criterion.SEEN: "validate on a recording that it has not seen",
    Criterion.GROWTH: MORE_DRIVING,
    Criterion.GAIN: NEXT_DRIVE,
    Criterion.NO_GAIN: "identify it, rather than state it",
    Criterion.DELAY: NEXT_DRIVE,
    Criterion.NO_DELAY: "identify with the default method, output-error, which finds latency and lag",
    Criterion.BACKWARD: "correct the vehicle file: inspect checks its signs, angles and axes",
    Criterion.NO_INPUT: "give thrusters and commands in the vehicle file",
    Criterion.BASELINE: MORE_DRIVING,
    Criterion.CONSISTENCY: "identify also from recordings like this one, so that the process noise covers such "
    "errors, or multiply the covariance that the filter states by {squared}",
    Criterion.NO_EXPECTED: "identify with the default method, output-error, which estimates it",
}


@dataclass(frozen=True)
class Reason:
    """The criterion that decided: its number beside the limit of `FIT`."""

    criterion: Criterion
    subject: str = ""  # an axis, or a quantity of one
    value: float = float("nan")
    limit: float = float("nan")
    horizon: float = float("nan")  # [s]

    def text(self) -> str:
        """As a clause."""
        floor = self.value == 0.0 and self.criterion in (Criterion.GROWTH, Criterion.BASELINE)
        return (AT_FLOOR if floor else self.criterion.value).format(
            subject=self.subject, horizon=self.horizon,
            value=_shown(self.value, 2), limit=f"{self.limit:g}",
            percent=f"{_shown(100.0 * self.value, 0)} %", most=f"{100.0 * self.limit:.0f} %",
        )  # fmt: skip

    def action(self) -> str:
        """What lifts the level, as a clause."""
        return ACTIONS[self.criterion].format(
            subject=self.subject, squared=_shown(self.value**2, 1)
        )


def _shown(value: float, digits: int) -> str:
    """With so many digits behind the point, or two significant ones where that is more: only 0 is shown as 0."""
    return (
        f"{value:.{digits}f}" if value >= 10.0 ** (1 - digits) or value == 0.0 else f"{value:.2g}"
    )


@dataclass(frozen=True)
class Fitness:
    """How fit a model is for one use, and why."""

    use: Use
    level: Level
    reason: Reason

    @property
    def action(self) -> str:
        """What would make it fit, as a clause; empty where it is."""
        return "" if self.level is Level.FIT else self.reason.action()


@dataclass(frozen=True)
class Quantity:
    """What a controller needs to know: a weighted sum of parameters, its 95 % half-width in parts of a size."""

    criterion: Criterion
    subject: str
    weights: Array  # (p,) of the model's parameters
    size: float  # the sum's own value, or the rise time [s]
    limits: tuple[float, float]  # of the relative half-width: of fit, of limited

    def relative(self, covariance: Array) -> float:
        """95 % half-width over `size`, by a covariance (p, p)."""
        error = float(np.sqrt(max(float(self.weights @ covariance @ self.weights), 0.0)))
        if error == 0.0:
            return 0.0
        return NORMAL_95 * error / self.size if self.size > 0.0 else float("inf")


Graded = tuple[Level, Reason]


def fitness(model: Model, scores: Scores) -> tuple[Fitness, ...]:
    """For every use the worst criterion, from the model and its scores of `validate`."""
    if model.findings_of(FindingKind.CONTRADICTED):
        reason = Reason(Criterion.CONTRADICTED)
        return tuple(Fitness(use, Level.NOT_FIT, reason) for use in Use)
    try:
        driven = axis_physics(model)
    except ModelError:
        driven = None
    kinds = (
        (Use.SIMULATION, _simulation(driven, scores)),
        (Use.CONTROL, _control(model, driven)),
        (Use.ODOMETRY, _odometry(scores)),
    )
    return tuple(_worst(use, list(found)) for use, found in kinds)


def resolved_excess(score: AxisScore) -> float:
    """Excess over the noise floor, over that of constant velocity; 0 at the floor."""
    if score.at_floor:
        return 0.0
    still = float(np.sqrt(max(score.stays_constant**2 - score.floor**2, 0.0)))
    return score.excess / still if still > 0.0 else float("inf")


def _worst(use: Use, found: Sequence[Graded]) -> Fitness:
    """The worst level; of equal ones the reason that is furthest beyond its limit."""

    def order(one: Graded) -> tuple[int, float]:
        level, reason = one
        beyond = reason.value / reason.limit if reason.limit == reason.limit else np.inf
        return list(Level).index(level), float(beyond)

    level, reason = max(found, key=order)
    return Fitness(use, level, reason)


def _grade(
    criterion: Criterion,
    subject: str,
    value: float,
    limits: tuple[float, float],
    horizon: float = float("nan"),
) -> Graded:
    return level_of(value, *limits), Reason(criterion, subject, value, limits[0], horizon)


def level_of(value: float, fit: float, limited: float) -> Level:
    """The level of a value that is fit up to one limit, and limited up to another."""
    return Level.FIT if value <= fit else Level.LIMITED if value <= limited else Level.NOT_FIT


def _simulation(driven: Sequence[AxisPhysics] | None, scores: Scores) -> Iterator[Graded]:
    """`driven`: None of an unstable model."""
    if driven is None:
        yield Level.NOT_FIT, Reason(Criterion.UNSTABLE)
    rows = _rows(scores, "filter", "stencil")
    if not rows:
        yield Level.NOT_FIT, Reason(Criterion.NOT_PREDICTED)
        return
    yield from _seen(scores)
    last = max(rows, key=lambda row: row.horizon)
    limits = SIMULATED_WELL, SIMULATED_SO_SO
    for axis, symbol in zip(AXES, SYMBOLS, strict=True):
        value = resolved_excess(last.scores[symbol])
        yield _grade(Criterion.GROWTH, axis, value, limits, last.horizon)


def _odometry(scores: Scores) -> Iterator[Graded]:
    rows = _rows(scores, "odometry", "filter", "stencil")
    if not rows:
        yield Level.NOT_FIT, Reason(Criterion.NOT_PREDICTED)
        return
    yield from _seen(scores)
    row = min(rows, key=lambda row: abs(row.horizon - ODOMETRY_HORIZON))
    for axis, symbol in zip(AXES, SYMBOLS, strict=True):
        score, ahead = row.scores[symbol], row.horizon
        limits = BETTER_THAN_NONE, NO_BETTER
        yield _grade(Criterion.BASELINE, axis, resolved_excess(score), limits, ahead)
        if score.expected_rms is None:
            yield Level.LIMITED, Reason(Criterion.NO_EXPECTED)
            continue
        expected = score.resolved(score.expected_rms)
        ratio = score.rms / expected if expected > 0.0 else float("inf")
        # an error that may be the expected one, by its interval, does not contradict the filter
        limits = CONSISTENT, float("inf") if score.as_expected else CONSISTENT_SO_SO
        yield _grade(Criterion.CONSISTENCY, axis, ratio, limits, ahead)


def _rows(scores: Scores, *starts: Start) -> list[PooledScore]:
    """The pooled scores from the first of these starts that there are scores of."""
    every = ([row for row in scores.pooled if row.start == start] for start in starts)
    return next((rows for rows in every if rows), [])


def _seen(scores: Scores) -> Iterator[Graded]:
    if all(one.seen for one in scores.recordings):
        yield Level.LIMITED, Reason(Criterion.SEEN)


def _control(model: Model, driven: Sequence[AxisPhysics] | None) -> Iterator[Graded]:
    """`driven`: None of an unstable model."""
    if driven is None:
        yield Level.NOT_FIT, Reason(Criterion.UNSTABLE)
        return
    if not driven:
        yield Level.NOT_FIT, Reason(Criterion.NO_INPUT)
        return
    for name in backward_thrust(model):
        yield Level.NOT_FIT, Reason(Criterion.BACKWARD, name)
    for one in control_quantities(model, driven):
        relative = one.relative(model.covariance)
        if relative == 0.0 and one.criterion is Criterion.GAIN:
            yield Level.LIMITED, Reason(Criterion.NO_GAIN, one.subject)
        else:
            yield _grade(one.criterion, one.subject, relative, one.limits)
    if not _delay_names(model):
        yield Level.LIMITED, Reason(Criterion.NO_DELAY)


def control_quantities(model: Model, driven: Sequence[AxisPhysics]) -> Iterator[Quantity]:
    """Gains and damping of the driven axes, at the envelope's speeds; then latency with lag of each group."""
    for one in driven:
        for what, weights in _gains_and_damping(model, one.axis):
            weight = np.array([weights.get(name, 0.0) for name in model.parameters])
            values = np.array([model.values.get(name, 0.0) for name in model.parameters])
            yield Quantity(
                Criterion.GAIN, f"{AXES[one.axis]} {what}", weight, abs(float(weight @ values)),
                (GAIN_KNOWN, GAIN_SO_SO),
            )  # fmt: skip
    rise = min((one.rise_time for one in driven), default=0.0)
    groups: dict[str, list[str]] = {}
    for name in _delay_names(model):
        groups.setdefault(name.partition(".")[2], []).append(name)
    for own in groups.values():
        weight = np.array([float(name in own) for name in model.parameters])
        yield Quantity(Criterion.DELAY, "", weight, rise, (DELAY_KNOWN, DELAY_SO_SO))


def _gains_and_damping(model: Model, axis: int) -> Iterator[tuple[str, dict[str, float]]]:
    """Weights of each gain along the axis, and of its damping at the envelope's speed."""
    forces = {force.name for force in model.structure.forces if force.axis == axis}
    for term in _terms(model, axis):
        if len(term.factors) == 1 and term.factors[0] in forces:
            yield "gain", {str(term.coefficient): 1.0}
    symbol = SYMBOLS[axis]
    speed = max(map(abs, model.envelope.speeds.get(symbol, (1.0, 1.0))))
    damping: dict[str, float] = {}
    for term in _terms(model, axis):
        if term.factors and {f.strip("|") for f in term.factors} == {symbol}:
            size = term.number * speed ** len(term.factors)
            damping[str(term.coefficient)] = damping.get(str(term.coefficient), 0.0) + size
    if damping:
        yield "damping", damping


def _terms(model: Model, axis: int) -> list[Term]:
    own = [t for t in model.structure.terms if t.axis == axis and t.coefficient]
    return [t for t in own if t.acceleration is None]


def _delay_names(model: Model) -> list[str]:
    names = model.vehicle.constants.names
    return [name for name in names if name.partition(".")[0] in ("latency", "lag")]
