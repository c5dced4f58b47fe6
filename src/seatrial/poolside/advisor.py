# SPDX-License-Identifier: MIT
"""What to drive next: the manoeuvre that shortens the widest needed intervals most, within the walls.

Every stick pattern of a small library is simulated with the current model from the boat's state. Those that keep
clear of the walls add their expected Fisher information to that of the drive so far.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import NOISE_LEAST, noise_vector
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.experiment_design.information import ReferencePoint
from seatrial.identification.experiment_design.manoeuvres import SIDE_WORDS
from seatrial.identification.experiment_design.simulated_drive import (
    SimulatedDrive,
    simulated_drive,
)
from seatrial.poolside.area import Area
from seatrial.poolside.needs import Need
from seatrial.poolside.state import ManoeuvreState
from seatrial.poolside.stick_patterns import StickPattern, first_patterns, stick_patterns
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95, root_of

BOAT_RADIUS = 0.3  # [m] where none is given
PATH_PERIOD = 0.25  # [s] of a manoeuvre's drawn path
RETURN_SPEED = 0.1  # [m/s] back to the middle
MOST_ADVICE = 3  # manoeuvres
MOST_CHECKED = 12  # of the best manoeuvres, whose margins to the walls allow for the model's errors
LEAST_PERIOD = 1 / 15  # [s] of simulated poses
CHECK_PERIOD = 0.25  # [s] of that check
NEGLIGIBLE = 1e-3  # eigenvalue of the correlations, below which a direction moves nothing


@dataclass(frozen=True)
class Candidate:
    """A stick pattern, simulated."""

    pattern: StickPattern
    drive: SimulatedDrive
    margin: float | None  # [m] from the walls


class Advisor:
    """What to drive next, for a vehicle within walls.

    area: walls, in the vehicle file's axes; None: open water. period: [s] of the poses. radius: [m] of the boat.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        area: Area | None = None,
        *,
        period: float = 1 / 15,
        radius: float = BOAT_RADIUS,
    ) -> None:
        self.vehicle, self.period, self.radius = vehicle, period, radius
        self._signs = vehicle.axes.signs
        self._walls = None if area is None else Area(area.corners * self._signs[:2])

    def advise(
        self,
        model: Model | None,
        state: Sequence[float] | Array,
        needs: Sequence[Need] = (),
        *,
        driven: Array | None = None,
        trust: float = 1.0,
        keep: str = "",
    ) -> tuple[ManoeuvreState, ...]:
        """Manoeuvres from here, the best first; before there is a model, each axis in turn.

        state: (6,) x, y [m], psi [rad], u, v [m/s], r [rad/s], in the vehicle file's axes. needs: of `needs_of`.
        driven: seconds (3, 2) that `Coverage` counts. trust: information that driving turns out to have, over what
        the model's noise promises. keep: text of a manoeuvre that stays the first while it is clear of the walls.
        """
        here = np.asarray(state, dtype=float) * np.tile(self._signs, 2)
        found: list[ManoeuvreState] = []
        if model is not None and (np.diag(model.covariance) > 0.0).any():
            thinned = self.period / self._step
            ranked = _ranked(model, self._candidates(model, here), needs, trust, thinned)
            ranked.sort(key=lambda one: one[0].pattern.text != keep)
            found = list(islice(self._clear(model, here, ranked), MOST_ADVICE))
        if not found and self._walls is not None and _off_middle(self._walls, here):
            found = [_to_middle(self._walls, here)]
        if not found:
            seconds = np.zeros((3, 2)) if driven is None else driven
            found = [_without_model(one) for one in first_patterns(self.vehicle, seconds)]
        return tuple(_in_file_axes(one, self.vehicle, self._signs) for one in found[:MOST_ADVICE])

    @property
    def _step(self) -> float:
        """Period [s] of simulated poses: denser ones are averaged, which their white errors allow."""
        return max(self.period, LEAST_PERIOD)

    def _candidates(self, model: Model, here: Array) -> list[Candidate]:
        """The patterns that keep within the walls, simulated from here (6,)."""
        found = []
        for pattern in stick_patterns(self.vehicle, model):
            times = np.arange(0.0, pattern.seconds, self._step)
            commands = pattern.t, pattern.commands
            try:
                drive = simulated_drive(model, here, commands, times)
                margin = self._margin(model, here, pattern, drive)
            except ModelError:
                continue
            if margin is not None and margin < self.radius:
                continue
            found.append(Candidate(pattern, drive, margin))
        return found

    def _margin(
        self, model: Model, here: Array, pattern: StickPattern, drive: SimulatedDrive
    ) -> float | None:
        """Least distance [m] from the walls on the way and while the boat coasts after it. Raises ModelError."""
        if self._walls is None:
            return None
        margin = float(self._walls.margins(drive.states[:, :2]).min())
        if margin < self.radius:
            return margin
        whole = pattern.and_coasting
        times = np.arange(0.0, whole.seconds, CHECK_PERIOD)
        after = simulated_drive(model, here, (whole.t, whole.commands), times).states
        return min(margin, float(self._walls.margins(after[:, :2]).min()))

    def _clear(
        self, model: Model, here: Array, ranked: Sequence[tuple[Candidate, Array]]
    ) -> Iterator[ManoeuvreState]:
        """Those that also keep within the walls where the parameters are off by their 95 % intervals.

        ranked: candidates with the covariance after each; the best `MOST_CHECKED` are looked at.
        """
        if self._walls is None:
            yield from (_state(model, *each) for each in ranked)
            return
        for one, after in ranked[:MOST_CHECKED]:
            every = max(1, round(CHECK_PERIOD / self._step))
            path, times = one.drive.states[::every, :2], one.drive.recording.t[::every]
            off = NORMAL_95 * position_errors(model, here, one.pattern, times, path)
            if (self._walls.margins(path) - off).min() >= self.radius:
                yield _state(model, one, after)


def position_errors(
    model: Model, here: Array, pattern: StickPattern, times: Array, path: Array
) -> Array:
    """Standard errors (n,) [m] of the positions (n, 2) at times (n,) [s], by the parameters' covariance.

    Linearised by a simulation from here (6,) along each principal direction, a standard error long. Infinite
    where the model diverges.
    """
    values = np.concatenate([model.coefficients, model.constants])
    squares = np.zeros(len(times))
    for direction in _directions(model.covariance):
        coefficients, constants = np.split(values + direction, [len(model.coefficients)])
        constants = np.maximum(constants, np.minimum(model.constants, 0.0))  # a lag ends at 0
        moved = replace(model, coefficients=coefficients, constants=constants)
        try:
            drive = simulated_drive(moved, here, (pattern.t, pattern.commands), times)
        except ModelError:
            return np.full(len(times), np.inf)
        squares += np.sum((drive.states[:, :2] - path) ** 2, axis=1)
    return np.sqrt(squares)


def _directions(covariance: Array) -> Array:
    """Rows (k, p) whose squares add up to a covariance (p, p); those that are as good as 0 are left out."""
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.where(size > 0.0, size, 1.0)
    spectrum, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = spectrum > NEGLIGIBLE
    return np.asarray((scale[:, None] * vectors[:, kept] * np.sqrt(spectrum[kept])).T)


def _ranked(
    model: Model,
    candidates: Sequence[Candidate],
    needs: Sequence[Need],
    trust: float,
    thinned: float,
) -> list[tuple[Candidate, Array]]:
    """The candidates, and the covariance after each, by what they gain a second.

    In the widest needs; of equal ones in the log-determinant. thinned: share of the poses that is simulated, each
    the mean of those it stands for.
    """
    if not candidates:
        return []
    point = _point(model, thinned)
    free = np.ix_(*2 * [[model.parameters.index(name) for name in point.names]])
    drives = [one.drive for one in candidates]
    runs = point.run_filter([d.recording for d in drives], [d.states[0, 3:] for d in drives])
    before = _excess(model.covariance, needs)
    scored = []
    for i, one in enumerate(candidates):
        if not runs.by_recording[i].good:
            continue
        after = np.zeros_like(model.covariance)
        information = trust * runs.information_of(i)
        after[free], smaller = _added(model.covariance[free], information)
        gain = before - _excess(after, needs)
        scored.append((gain / one.pattern.seconds, smaller / one.pattern.seconds, i, after))
    scored.sort(key=lambda row: (-row[0], -row[1]))
    return [(candidates[i], after) for _, _, i, after in scored]


def _excess(covariance: Array, needs: Sequence[Need]) -> float:
    """Sum of the logarithms of widths over allowed ones, of the needs that are not met."""
    ratios = np.array([need.ratio(covariance) for need in needs if need.allowed > 0.0])
    return float(np.log(np.maximum(ratios, 1.0)).sum())


def _point(model: Model, thinned: float) -> ReferencePoint:
    """The model's estimated parameters and noise; without process noise, that of its poses alone."""
    values = np.concatenate([model.coefficients, model.constants])
    estimated = np.flatnonzero(np.diag(model.covariance) > 0.0)
    noise = noise_vector(model.noise)
    if noise is None:
        noise = NOISE_LEAST.copy()
        noise[:2] = np.maximum(noise[:2], [model.noise.position, model.noise.heading])
    noise[:2] *= np.sqrt(thinned)
    return ReferencePoint(
        model, tuple(model.parameters[i] for i in estimated), values[estimated], noise
    )


def _added(covariance: Array, information: Array) -> tuple[Array, float]:
    """The covariance (p, p) after more information (p, p), and the fall of its log-determinant.

    In units of the standard errors.
    """
    size = np.sqrt(np.diag(covariance))
    scale = np.outer(size, size)
    root = root_of(covariance / scale)
    inner = np.eye(len(size)) + root.T @ (information * scale) @ root
    after = root @ np.linalg.solve(inner, root.T) * scale
    return np.asarray(after), float(np.linalg.slogdet(inner)[1])


def _state(model: Model, one: Candidate, after: Array) -> ManoeuvreState:
    """With the parameter whose interval it shortens most, by a covariance (p, p) after it."""
    before = np.sqrt(np.maximum(np.diag(model.covariance), 0.0))
    left = np.sqrt(np.maximum(np.diag(after), 0.0))
    best = int(np.argmin(np.where(before > 0.0, left / np.where(before > 0.0, before, 1.0), 1.0)))
    pattern, t = one.pattern, one.drive.recording.t
    times = np.unique(np.concatenate([np.arange(0.0, pattern.seconds, PATH_PERIOD), pattern.t]))
    times = times[times <= t[-1]]
    path = np.column_stack([np.interp(times, t, one.drive.states[:, k]) for k in range(3)])
    held = np.searchsorted(pattern.t, times, side="right") - 1
    return ManoeuvreState(
        pattern.text, pattern.seconds, model.parameters[best],
        NORMAL_95 * float(before[best]), NORMAL_95 * float(left[best]),
        tuple(times.round(3).tolist()),
        tuple((x, y, psi) for x, y, psi in path.round(4).tolist()), _rows(pattern.commands[held]),
        one.margin,
    )  # fmt: skip


def _rows(values: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in (values.round(4) + 0.0).tolist())


def _off_middle(walls: Area, here: Array) -> bool:
    """Whether the boat is further from the middle than half the middle's distance from the walls."""
    off = float(np.hypot(*(np.array(walls.middle) - here[:2])))
    return off > 0.5 * walls.margin(*walls.middle)


def _to_middle(walls: Area, here: Array) -> ManoeuvreState:
    """A straight path to the middle, from here (6,)."""
    x, y = walls.middle
    off = np.array([[x - here[0], y - here[1], 0.0]])
    ahead, left, _ = _core.rotate(np.ascontiguousarray(here[2:3]), off, True)[0].tolist()
    seconds = float(np.hypot(ahead, left)) / RETURN_SPEED
    text = (
        f"Drive to the middle first: {abs(ahead):.1f} m {SIDE_WORDS[0][ahead < 0]}, "
        f"{abs(left):.1f} m {SIDE_WORDS[1][left < 0]}"
    )
    psi = float(here[2])
    path = ((float(here[0]), float(here[1]), psi), (x, y, psi))
    margin = float(walls.margins(np.array([here[:2], [x, y]])).min())
    return ManoeuvreState(text, seconds, "", 0.0, 0.0, (0.0, seconds), path, margin=margin)


def _without_model(pattern: StickPattern) -> ManoeuvreState:
    """Sticks only: no path is known."""
    t, commands = tuple(pattern.t.tolist()), _rows(pattern.commands)
    return ManoeuvreState(pattern.text, pattern.seconds, "", 0.0, 0.0, t, commands=commands)


def _in_file_axes(one: ManoeuvreState, vehicle: Vehicle, signs: Array) -> ManoeuvreState:
    path = np.array(one.path, dtype=float).reshape(-1, 3) * signs + 0.0
    commands = np.array(one.commands, dtype=float).reshape(-1, len(vehicle.inputs))
    return msgspec.structs.replace(
        one, path=tuple((x, y, psi) for x, y, psi in path.tolist()),
        commands=_rows(commands * vehicle.input_signs),
    )  # fmt: skip
