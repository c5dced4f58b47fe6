# SPDX-License-Identifier: MIT
"""Which of two models predicts recordings better, and whether the difference is significant."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.comparison.significance import SameBoatErrors, sensitivity_forms
from seatrial.evaluation.filtering import filter_noise, run_filter
from seatrial.evaluation.prediction import predict
from seatrial.evaluation.scoring import seen
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion, motion
from seatrial.util.block_bootstrap import block_draws, block_length, block_sums
from seatrial.util.distributions import holm, normal_two_sided
from seatrial.util.errors import ModelError, SeatrialError
from seatrial.util.frames import SYMBOLS, Array, Axes
from seatrial.util.progress import over

START_SETTLING = 2.0  # [s] of the filters before the first prediction
FALSE_VERDICT = 0.05  # probability of a false verdict
ZERO_VELOCITY = 1e-12  # [m/s], [rad/s] below it two predictions are equal
# of the whole sample's, least standard deviation of a bootstrap sample
LEAST_BOOTSTRAP_DEVIATION = 1e-3


class AxisDifference(msgspec.Struct, frozen=True):
    """One velocity: both models' RMS errors in m/s or rad/s, from the same starts."""

    a: float
    b: float
    difference: float  # a - b: above 0 where B is better
    interval: tuple[float, float] | None  # 95 %; None: too few blocks of time
    p: float | None  # of the hypothesis that both are equally good
    same_boat: float | None = None  # of the hypothesis of two estimates of one unchanged boat

    @property
    def better(self) -> str | None:
        """The significantly better model."""
        if self.interval is None or self.interval[0] <= 0.0 <= self.interval[1]:
            return None
        return "B" if self.difference > 0 else "A"


class PredictionRow(msgspec.Struct, frozen=True):
    """Predictions of one recording, or of all together, at one horizon.

    recording: its name; "all" for all together
    horizon: [s]
    predictions: how many
    starts: "filter": the mean of both models' filters; "stencil": measured
    axes: by u, v, r
    block: [s] of a block of the bootstrap
    seen_a: whether A was identified from it
    seen_b: whether B was
    """

    recording: str
    horizon: float
    predictions: int
    starts: str
    axes: dict[str, AxisDifference]
    block: float
    seen_a: bool = False
    seen_b: bool = False


@dataclass(frozen=True)
class _Errors:
    """Squared errors of both models at the same instants."""

    a: Array  # (m, 3)
    b: Array  # (m, 3)
    index: NDArray[np.int64]  # (m,) poses
    period: float  # [s]
    steps: int
    forms: tuple[Array, Array]  # (3, p, p) of each, for `SameBoatErrors`

    @property
    def block(self) -> float:
        """Length [s] of a block: longer than the horizon and than errors stay correlated."""
        scale = np.sqrt(np.maximum([self.a.mean(axis=0), self.b.mean(axis=0)], ZERO_VELOCITY**2))
        moved = self.a / scale[0] - self.b / scale[1]  # whose mean is the difference of RMS
        moved = moved[:, np.ptp(moved, axis=0) > 0]
        return block_length(moved, self.index, self.steps) * self.period if moved.size else 1.0


def predict_both(
    a: Model,
    b: Model,
    recordings: Sequence[Recording],
    horizons: Sequence[float],
    same_boat: SameBoatErrors,
) -> list[PredictionRow]:
    """RMS errors of both models, by recording and of all together, at each horizon [s].

    `same_boat`: parameter errors of two estimates of one boat. Raises ModelError where a model can't
    be used, RecordingError where a recording is too short.
    """
    # 1. Shared starts, so that both predict the same instants.
    kind, starts = shared_starts(a, b, recordings)
    found = []
    for horizon in over(horizons, "horizon"):
        # 2. Squared errors of both; their difference by recording.
        pairs = list(zip(recordings, starts, strict=True))
        every = [_errors(a, b, r, s, horizon) for r, s in over(pairs)]
        for recording, errors in zip(recordings, every, strict=True):
            axes = _differences([errors], errors.block, same_boat)
            found.append(
                PredictionRow(
                    recording.name, horizon, len(errors.index), kind, axes, errors.block,
                    seen(a, recording), seen(b, recording),
                )
            )  # fmt: skip
        # 3. All recordings together.
        if len(recordings) > 1:
            block = max(e.block for e in every)
            count = sum(len(e.index) for e in every)
            axes = _differences(every, block, same_boat)
            found.append(
                PredictionRow(
                    "all", horizon, count, kind, axes, block,
                    any(seen(a, r) for r in recordings), any(seen(b, r) for r in recordings),
                )
            )  # fmt: skip
    return found


def verdict(found: Sequence[PredictionRow]) -> dict[str, str | None]:
    """The better model by u, v, r, with Holm's correction over the axes; None: not significant.

    `found`: the rows of one horizon; the last (all recordings together) counts.
    """
    last = found[-1].axes
    p = _corrected({s: last[s].p for s in SYMBOLS})
    return {s: last[s].better if p.get(s, 1.0) < FALSE_VERDICT else None for s in SYMBOLS}


def beyond_same_boat(last: Mapping[str, AxisDifference]) -> set[str]:
    """Those of u, v, r with a difference too large for two estimates of one boat (Holm's correction)."""
    return {
        s
        for s, p in _corrected({s: one.same_boat for s, one in last.items()}).items()
        if p < FALSE_VERDICT
    }


def _corrected(chances: Mapping[str, float | None]) -> dict[str, float]:
    known = {s: p for s, p in chances.items() if p is not None}
    return dict(zip(known, holm(list(known.values())), strict=True))


def with_signals(model: Model, vehicle: Vehicle) -> Model:
    """The model with the signals and the allocation of the recordings, about its own origin."""
    model.check_sides(vehicle)
    flip = vehicle.axes is Axes.FRD
    structure = model.structure.flipped() if flip else model.structure
    file = msgspec.structs.replace(
        vehicle.file, structure=structure.lines(), chain=model.vehicle.file.chain
    )
    return replace(model, vehicle=model.about_origin(Vehicle(file, vehicle.source)))


def with_common_lever(a: Model, b: Model) -> tuple[Model, Model]:
    """Both with the weighted mean of their lever arms (inverse variances): symmetric in a and b."""
    levers = np.array([a.vehicle.lever, b.vehicle.lever])
    if (levers[0] == levers[1]).all():
        return a, b
    variances = np.square([a.lever_errors, b.lever_errors])
    whole = variances.sum(axis=0)
    share = np.divide(variances[1], whole, out=np.full(2, 0.5), where=whole > 0)
    ahead, left = (share * levers[0] + (1.0 - share) * levers[1]).tolist()
    one, other = (replace(m, vehicle=m.vehicle.with_lever((ahead, left))) for m in (a, b))
    return one, other


def same_drive(a: Vehicle, b: Vehicle) -> bool:
    """Whether both read and allocate recordings alike, apart from the lever arm."""
    names = "axes", "pose", "commands", "scales", "thrusters", "forces", "allocation"
    own, other = (vehicle.with_lever(a.lever) for vehicle in (a, b))
    return all(getattr(own.file, n) == getattr(other.file, n) for n in names)


def shared_starts(a: Model, b: Model, recordings: Sequence[Recording]) -> tuple[str, list[Motion]]:
    """Start velocities: the mean of both models' filters, which favours neither.

    Stencil velocities where a filter fails: their noise hides small differences.
    """
    try:
        noises = [filter_noise(model, recordings) for model in (a, b)]
        both = [
            [run_filter(m, r, n).motion for m, n in zip((a, b), noises, strict=True)]
            for r in recordings
        ]
    except SeatrialError:
        return "stencil", [motion(r) for r in recordings]
    return "filter", [_mean(*pair) for pair in both]


def _mean(first: Motion, second: Motion) -> Motion:
    valid = first.valid & second.valid & (first.t > START_SETTLING)
    deviation = None
    if first.deviation is not None and second.deviation is not None:
        deviation = 0.5 * (first.deviation + second.deviation)
    return Motion(
        first.t, 0.5 * (first.eta + second.eta), 0.5 * (first.nu + second.nu), valid, deviation
    )


def _errors(a: Model, b: Model, recording: Recording, starts: Motion, horizon: float) -> _Errors:
    found = []
    for label, model in (("A", a), ("B", b)):
        try:
            found.append(predict(model, recording, horizon, starts=starts))
        except ModelError as error:
            raise ModelError(f"{label}: {error}") from None
    index, steps = found[0].index, found[0].steps
    moved = [sensitivity_forms(model, recording, starts, found[0].begun, index) for model in (a, b)]
    squares = [one.errors**2 for one in found]
    return _Errors(squares[0], squares[1], index, recording.period, steps, (moved[0], moved[1]))


def _differences(
    every: Sequence[_Errors], block: float, same_boat: SameBoatErrors
) -> dict[str, AxisDifference]:
    """Differences by u, v, r, over blocks of time of all recordings."""
    parts, numbers, passed = [], [], 0
    for errors in every:
        parts.append(np.column_stack([errors.a, errors.b, np.ones(len(errors.a))]))
        own = ((errors.index - errors.index[0]) * errors.period / block).astype(np.int64)
        numbers.append(own + passed)
        passed += int(own[-1]) + 1
    values = np.concatenate(parts)
    blocks = block_sums(values, np.concatenate(numbers), 1)
    mean = values.mean(axis=0)
    shares = np.array([len(e.a) for e in every]) / len(values)
    moved = [np.tensordot(shares, [e.forms[i] for e in every], 1) for i in (0, 1)]
    out = {}
    for axis, symbol in enumerate(SYMBOLS):
        rms = np.sqrt(mean[[axis, 3 + axis]])
        apart = float(rms[0] - rms[1])
        interval, p, same = None, None, None
        if blocks is not None:
            interval, p, spread = rms_difference(*blocks[:, [axis, 3 + axis, 6]].T)
            by, variance = same_boat.difference((moved[0][axis], moved[1][axis]))
            both = max(float(rms.sum()), 1e-12)  # a^2 - b^2 = (a - b) (a + b); 0: both are exact
            same = _two_sided(apart - by / both, float(np.hypot(spread, np.sqrt(variance) / both)))
        out[symbol] = AxisDifference(float(rms[0]), float(rms[1]), apart, interval, p, same)
    return out


def _two_sided(apart: float, spread: float) -> float:
    """Two-sided p of a normal deviate."""
    if spread > ZERO_VELOCITY:
        return normal_two_sided(apart / spread)
    return float(abs(apart) <= ZERO_VELOCITY)


def rms_difference(
    first: Array, second: Array, count: Array
) -> tuple[tuple[float, float], float, float]:
    """95 % interval of the difference of two RMS, p of there being none, and its standard deviation.

    `first`, `second` (b,): sums of squared errors of the same samples, block by block, `count` (b,)
    samples each. Studentised bootstrap over blocks (Davison, Hinkley, section 5.2): the errors of
    the two models are correlated, so their difference is more certain than each of them.
    """
    drawn = block_draws(len(count))
    whole, spread = _difference(np.ones((1, len(count))), first, second, count)
    if spread[0] <= ZERO_VELOCITY:
        return (float(whole[0]), float(whole[0])), float(abs(whole[0]) <= ZERO_VELOCITY), 0.0
    found, deviation = _difference(drawn, first, second, count)
    student = (found - whole) / np.maximum(deviation, LEAST_BOOTSTRAP_DEVIATION * spread)
    high, low = np.quantile(student, [0.025, 0.975])
    at = whole[0] / spread[0]
    beyond = 2 * min(int(np.sum(student >= at)), int(np.sum(student <= at)))  # as of the interval
    interval = (float(whole[0] - low * spread[0]), float(whole[0] - high * spread[0]))
    return interval, min(1.0, (1 + beyond) / (1 + len(student))), float(spread[0])


def _difference(drawn: Array, first: Array, second: Array, count: Array) -> tuple[Array, Array]:
    """Difference (R,) of both RMS and its standard deviation (R,), from the blocks drawn (R, b)."""
    size = drawn @ count
    rms = [np.sqrt(np.maximum(drawn @ sums / size, ZERO_VELOCITY**2)) for sums in (first, second)]
    slopes = [0.5 / r for r in rms]
    centre = 0.5 * (rms[0] - rms[1])
    # sum over blocks of (slope_a a - slope_b b - centre n)^2, multiplied out
    parts, weights = (first, second, count), (slopes[0], -slopes[1], -centre)
    variance = np.zeros(len(drawn))
    for x, wx in zip(parts, weights, strict=True):
        for y, wy in zip(parts, weights, strict=True):
            variance += wx * wy * (drawn @ (x * y))
    return rms[0] - rms[1], np.sqrt(np.maximum(variance, 0.0)) / size
