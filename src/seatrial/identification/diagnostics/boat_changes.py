# SPDX-License-Identifier: MIT
"""Changes of the boat: thrust, drag, mass or the clock offset that differ between recordings, or drift in one.

A battery's voltage falls, weeds gather, water comes in, a payload is added, a clock is set. One model for all
recordings then describes none, and its standard errors do not show it. So factors on an axis' thrust, on its drag,
or on both have score tests at the solution, where each is 1: no further fit is needed. Between recordings each has
a factor of its own. Drift is one slope for all recordings, 0 in the middle of each, so that it is independent of
differences between them.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.finding_texts.spec import QUANTITIES
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.selection.score_information import ScoreInformation, score_information
from seatrial.identification.selection.score_test import (
    ScoreTest,
    score_test,
    score_test_after_step,
)
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import AXES, Array

LARGEST_FACTOR_ERROR = 0.05  # standard error, by the information: above it is not identifiable
LEAST_FACTOR_CHANGE = 0.03  # relative difference: less is not reported
LEAST_CLOCK_OFFSET = 0.04  # [s] between recordings, reported: less hardly biases the latency
DISAGREEMENTS = (FindingKind.HOMOGENEITY, FindingKind.CLOCK_HOMOGENEITY)


@dataclass(frozen=True)
class _Change:
    """A scale factor that differs between recordings, or drifts."""

    axis: int
    quantity: str  # of QUANTITIES
    less: str  # where it is least: a recording, or its beginning or end
    more: str
    ratio: float  # of the least to the largest factor
    test: ScoreTest

    @property
    def manifest(self) -> bool:
        """Whether it is significant, and large enough to be reported."""
        return self.test.reported and self.ratio <= 1.0 - LEAST_FACTOR_CHANGE


# of an axis, a quantity, and the weights (p,) by which a factor on it moves the free parameters
_FactorTest = Callable[[int, str, Array], _Change | None]


def change_findings(at: Point) -> list[Finding]:
    """Significant differences between recordings, and drift, by axis; none where a prior explains them."""
    problem = at.runs.problem
    if problem.prior is not None:
        return []
    known = score_information(problem, at.theta, at.noise)
    return [*_homogeneity(at, known), *_drift(at, known)]


def _homogeneity(at: Point, known: ScoreInformation) -> list[Finding]:
    """Scale factors that differ between recordings, or a delay if that is the likelier cause."""
    if len(at.runs.by_recording) < 2:
        return []
    manifest = _manifest(at, lambda *of: _factor_by_recording(at, known, *of))
    delays, gain = _clock_offset(at, known)
    if gain > sum(change.test.gain for change in manifest):
        return delays
    return [
        finding_of(
            FindingKind.HOMOGENEITY,
            *(AXES[change.axis], change.less, change.more),
            change=1.0 - change.ratio,
            quantity=change.quantity,
            dead_zone=_dead_zone(at, change.quantity),
        )
        for change in manifest
    ]


def _drift(at: Point, known: ScoreInformation) -> list[Finding]:
    """Thrust or drag that fall or rise in the course of a recording, or clocks that drift if that is likelier."""
    recordings = at.runs.problem.recordings
    times = _times(at)
    longest = max(range(len(recordings)), key=lambda i: float(np.ptp(times[known.recording == i])))
    span = float(np.ptp(times[known.recording == longest]))
    if span <= 0.0:
        return []
    manifest = _manifest(at, lambda *of: _slope(known, times / span, *of))
    clocks, gain = _clock_drift(at, known, times, longest)
    if gain > sum(change.test.gain for change in manifest):
        return clocks
    return [
        finding_of(
            FindingKind.PARAMETER_DRIFT,
            *(AXES[change.axis], recordings[longest].name),
            change=1.0 - change.ratio,
            quantity=change.quantity,
            lower=change.less,
            higher=change.more,
            of="one recording" if len(recordings) == 1 else "all recordings",
            dead_zone=_dead_zone(at, change.quantity),
        )
        for change in manifest
    ]


def _manifest(at: Point, tested: _FactorTest) -> list[_Change]:
    """Significant changes by axis, of one quantity: the one with the largest expected fall of -2 log L."""
    by_quantity: dict[str, list[_Change]] = {quantity: [] for quantity in QUANTITIES}
    for axis in range(3):
        for quantity, weights in _scaled_parameters(at, axis):
            found = tested(axis, quantity, weights)
            if found is not None and found.manifest:
                by_quantity[quantity].append(found)
    return max(by_quantity.values(), key=lambda found: sum(change.test.gain for change in found))


def _scaled_parameters(at: Point, axis: int) -> Iterator[tuple[str, Array]]:
    """Each quantity, and the derivative (p,) of the free parameters by a factor on it: their own values."""
    problem = at.runs.problem
    thrust, drag = problem.vehicle.structure.thrust_and_drag(axis)
    free = np.array(problem.free)
    for quantity, names in (("thrust", thrust), ("drag", drag), ("thrust and drag", thrust | drag)):
        own = np.array([problem.names[i] in names for i in free])
        weights = np.where(own, at.theta[free], 0.0)
        if weights.any():
            yield quantity, weights


def _factor_by_recording(
    at: Point, known: ScoreInformation, axis: int, quantity: str, weights: Array
) -> _Change | None:
    """The largest difference of scale factors between recordings; None where fewer than two identify one."""
    found = _by_recording(known, weights)
    if found is None:
        return None
    places, test = found
    factors = np.concatenate([[1.0], 1.0 + test.step])
    low, high = int(np.argmin(factors)), int(np.argmax(factors))
    less, more = (at.runs.problem.recordings[places[i]].name for i in (low, high))
    return _Change(axis, quantity, less, more, float(max(factors[low], 0.0) / factors[high]), test)


def _by_recording(known: ScoreInformation, weights: Array) -> tuple[list[int], ScoreTest] | None:
    """Recordings that identify it, and the score test of each one's own step along `weights` (p,) of the free
    parameters, relative to the first's; None where fewer than two identify it.
    """
    own = known.of_recordings @ weights @ weights
    places = np.flatnonzero(own > LARGEST_FACTOR_ERROR**-2).tolist()
    if len(places) < 2:
        return None
    courses = (known.recording[:, None] == places).astype(float)
    p = len(weights)
    # the first is the reference: a factor of all is in the coefficients
    tested = list(range(p + 1, p + len(places)))
    return places, score_test(known.with_courses(weights, courses), tested, neutral=[p])


def _slope(
    known: ScoreInformation, times: Array, axis: int, quantity: str, weights: Array
) -> _Change | None:
    """The change over the longest recording, by one slope for all; None where it is not identifiable.

    times: (blocks,) from any origin in each recording, in lengths of the longest.
    """
    test = _slope_test(known, times, weights)
    if test is None:
        return None
    change = float(test.step[0])
    less, more = ("beginning", "end") if change > 0.0 else ("end", "beginning")
    half = min(0.5 * abs(change), 1.0)
    return _Change(axis, quantity, less, more, (1.0 - half) / (1.0 + half), test)


def _slope_test(known: ScoreInformation, times: Array, weights: Array) -> ScoreTest | None:
    """The test of one slope along `weights` (p,) of the free parameters; None where it is not identifiable."""
    own = known.shares @ weights @ weights
    course = np.zeros(known.blocks)
    for i in range(len(known.of_recordings)):
        at = known.recording == i
        middle = float(own[at] @ times[at] / own[at].sum()) if own[at].sum() > 0.0 else 0.0
        course[at] = times[at] - middle
    if not own @ course**2 > LARGEST_FACTOR_ERROR**-2:
        return None
    return score_test_after_step(known.with_courses(weights, course[:, None]), len(weights))


def _times(at: Point) -> Array:
    """The middle (blocks,) [s] of the blocks of all recordings."""
    problem = at.runs.problem
    pairs = zip(problem.recordings, problem.blocks, strict=True)
    return np.concatenate([np.bincount(b, r.t) / np.bincount(b) for r, b in pairs])


def _clock_offset(at: Point, known: ScoreInformation) -> tuple[list[Finding], float]:
    """The largest difference of delays from commands to poses, and the expected fall of -2 log L."""
    problem, late = at.runs.problem, _latencies(at)
    found = _by_recording(known, late)
    if found is None or not found[1].reported:
        return [], 0.0
    places, test = found
    delays = np.concatenate([[0.0], test.step])
    # of a long delay the first step is too short
    shifts = [0.0] * len(problem.recordings)
    for place, delay in zip(places, delays.tolist(), strict=True):
        shifts[place] = delay
    with suppress(IdentificationError):  # the boat diverges
        again = _by_recording(_with_later_commands(at, shifts), late)
        if again is not None and again[0] == places:
            delays[1:] += again[1].step
    early, last = int(np.argmin(delays)), int(np.argmax(delays))
    more = float(delays[last] - delays[early])
    if more < LEAST_CLOCK_OFFSET:
        return [], 0.0
    one, other = (problem.recordings[places[i]].name for i in (last, early))
    return [finding_of(FindingKind.CLOCK_HOMOGENEITY, one, other, delay=more)], test.gain


def _clock_drift(
    at: Point, known: ScoreInformation, times: Array, longest: int
) -> tuple[list[Finding], float]:
    """The change of the delay from commands to poses over the longest recording, and the fall of -2 log L.

    times: (blocks,) [s].
    """
    problem, late = at.runs.problem, _latencies(at)
    span = float(np.ptp(times[known.recording == longest]))
    test = _slope_test(known, times / span, late)
    if test is None or not test.reported:
        return [], 0.0
    change = float(test.step[0])
    # of a long delay the first step is too short
    shifts = [change / span * (r.commands.stamps - r.stamps[0]) * 1e-9 for r in problem.recordings]
    with suppress(IdentificationError):  # the boat diverges
        again = _slope_test(_with_later_commands(at, shifts), times / span, late)
        change += 0.0 if again is None else float(again.step[0])
    if abs(change) < LEAST_CLOCK_OFFSET:
        return [], 0.0
    recording = problem.recordings[longest]
    parts = ("beginning", "end") if change > 0.0 else ("end", "beginning")
    finding = finding_of(
        FindingKind.CLOCK_DRIFT, recording.name,
        delay=abs(change), factor=1.0 + change / span, **dict(zip(("earlier", "later"), parts, strict=True)),
    )  # fmt: skip
    return [finding], test.gain


def _latencies(at: Point) -> Array:
    """Weights (p,) of the free parameters that are latencies."""
    problem = at.runs.problem
    late = [problem.names[i].partition(".")[0] == "latency" for i in problem.free]
    return np.array(late, dtype=float)


def _with_later_commands(at: Point, delays: Sequence[float | Array]) -> ScoreInformation:
    """A pass with the commands of each recording later by its delays [s].

    Raises IdentificationError where the boat diverges.
    """
    problem = at.runs.problem
    moved = []
    for recording, delay in zip(problem.recordings, delays, strict=True):
        commands = recording.commands
        stamps = commands.stamps + np.round(np.asarray(delay) * 1e9).astype(np.int64)
        moved.append(replace(recording, commands=replace(commands, stamps=stamps)))
    return score_information(replace(problem, recordings=tuple(moved)), at.theta, at.noise)


def _dead_zone(at: Point, quantity: str) -> str:
    """Whether thrust changes in a model without a dead zone, which could explain it, in a finding's words."""
    lacks = quantity == "thrust" and not _has_dead_zone(at.runs.problem.vehicle)
    return "not modelled" if lacks else "modelled"


def _has_dead_zone(vehicle: Vehicle) -> bool:
    """Whether the thrusters have a dead zone, stated or estimated."""
    kinds = {name.partition(".")[0] for name in vehicle.constants.names}
    tables = any(group.table for group in vehicle.file.chain)
    return tables or bool(kinds & {"edge_forward", "edge_reverse", "pair_dead_zone"})
