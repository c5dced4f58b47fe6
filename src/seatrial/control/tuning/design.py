# SPDX-License-Identifier: MIT
"""Gains by internal model control, with margins about steady motions and over the covariance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.steering import angle_names
from seatrial.control.allocation import Allocator
from seatrial.control.tracking.thrusters import VEHICLE, allocator_for
from seatrial.control.tuning.guidance import (
    AXES_GUIDED,
    Guidance,
    about_path,
    guidance_for,
    guided_motions,
)
from seatrial.control.tuning.linear import LinearBoat, linearise
from seatrial.control.tuning.loops import Feedback, Margins, frequencies, margins
from seatrial.control.tuning.robustness import MARGIN_DRAWS, MARGIN_SEED, draws_of, worst_of
from seatrial.control.tuning.rules import NO_GAINS, Gains, pd_gains, pid_gains
from seatrial.util.above import text_by
from seatrial.util.arguments import expect
from seatrial.util.blas import one_blas_thread
from seatrial.util.errors import ControlError
from seatrial.util.frames import AXES, SYMBOLS, Array
from seatrial.util.progress import stage

Action = Literal["pid", "pd"]
Request = tuple[float, float, Action, float]  # knob, hold, action, strength
KNOB = 1.0  # [s]
CONTROLLER_RATE = 50.0  # [Hz] of the controller
# largest |S|: 29 degrees of phase and a factor of 2 in gain remain (Skogestad 2003)
SENSITIVITY_LIMIT = 2.0
LARGEST_KNOB = 100.0  # [s] a larger one is refused
NEXT_DIGIT = 1.001  # factor that, rounded up, gives the next number of two digits
LEAST_KNOB_SHARE = 0.5  # of the largest delay: the search of the smallest knob begins there
# draws that a knob adds to the search of the smallest; the result is checked with all draws
WORST_DRAWS = 8


@dataclass(frozen=True, eq=False)
class Tuning:
    """Gains for one model, and their stability margins.

    model: of the boat
    boat: the model, linearised at its motions
    action: pid or pd
    knob: [s] closed-loop time constant
    rate: [Hz] of the controller
    extra: [s] delay in addition to the thrusters' and the controller's own
    gains: in accelerations
    nominal: (3,) of the model, the worst of its motions
    worst: (3,) of all draws, with the steepest slope of the thrusters' curve
    draws: 0: the model states no covariance
    seed: of the draws
    allocator: None: the boat's own allocation
    guidance: of a boat without sway thrust
    """

    model: Model
    boat: LinearBoat
    action: Action
    knob: float
    rate: float
    extra: float
    gains: tuple[Gains, Gains, Gains]
    nominal: Margins
    worst: Margins
    draws: int
    seed: int
    allocator: Allocator | None = None
    guidance: Guidance | None = None

    def __repr__(self) -> str:
        return f"<Tuning of {self.model.name}: {self.action}, knob {self.knob:g} s>"

    __str__ = text_by("control.tuning.console", "tuning_text")

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the three loops that the margins are of."""
        return AXES if self.guidance is None else AXES_GUIDED

    @property
    def curves(self) -> str:
        """What the worst margins take for the curves of the actuators."""
        steered = angle_names(self.model.vehicle.file.chain)
        return "inverse of thrust and angle" if steered else "steepest slope of the thrusters"

    @property
    def slowest(self) -> float:
        """Time constant [s] of the slowest loop: the knob, or the guidance's."""
        return self.knob if self.guidance is None else max(self.knob, self.guidance.time)

    @property
    def hold(self) -> float:
        """Delay [s] of the controller: half its period, and the extra delay."""
        return 0.5 / self.rate + self.extra

    @property
    def delay(self) -> Array:
        """Delay (3,) [s] of each loop, lag included."""
        return np.asarray(self.boat.actuators.delay + self.hold)

    def table(self) -> Array:
        """Gains (3 axes, P I D) in command units of each axis per m, m s, m/s (rad in yaw)."""
        rows = [(g.proportional, g.integral, g.derivative) for g in self.gains]
        return np.asarray(np.array(rows) * self.boat.per_authority[:, None])


@one_blas_thread
def tune(
    model: Model,
    knob: float = KNOB,
    *,
    action: Action = "pid",
    rate: float = CONTROLLER_RATE,
    extra: float = 0.0,
    draws: int = MARGIN_DRAWS,
    seed: int = MARGIN_SEED,
    allocation: str = VEHICLE,
) -> Tuning:
    """Gains for tracking with the closed-loop time constant `knob` [s].

    A boat without sway thrust gets a speed and a heading controller, and line-of-sight guidance.

    rate [Hz]: of the controller. extra [s]: delay beyond the model's, as of a network.
    allocation: "vehicle", or a scheme of `seatrial.Allocator` for a boat whose inputs are its thrusters;
    margins are those without it, at the steepest slope of the thrusters' curve.

    Raises ControlError where surge or yaw has no thrust, drag has the wrong sign, or the delay does not
    permit the knob; the message states the smallest that it permits. AllocationError as the Allocator.
    """
    # The request and the thrusters
    expect(model, Model, "model")
    _check_request(knob, rate, extra, action, draws)
    allocator = allocator_for(model, allocation)
    # Linear plant about rest and the fastest steady motions
    boat = _plant(model)
    # Gains of each axis by internal model control, from its delay and its least drag
    hold = 0.5 / rate + extra
    gains = gains_for(boat, knob, hold, action)
    guidance = guidance_for(boat, hold, gains)
    # Worst margins over draws of the covariance, at the steepest slope of the thrusters' curve
    straight = draws_of(boat, model, draws, seed)
    boats = about_path(straight, guidance)
    request = knob, hold, action, boat.steepest
    with stage("margins of draws", 0.9):
        spread = worst_of(boats, gains, knob, hold, boat.steepest, guidance=guidance)
    if not permitted(spread):
        raise ControlError(_refusal(model, straight, spread, request))
    boat = boats[0]
    nominal = _nominal(boat, gains, guidance, knob, hold)
    return Tuning(
        model, boat, action, knob, rate, extra, gains, nominal, spread.worst(), len(boats) - 1, seed,
        allocator, guidance,
    )  # fmt: skip


def _plant(model: Model) -> LinearBoat:
    """The linear plant about rest and the fastest steady motions; of a boat without sway thrust, guided ones."""
    boat = linearise(model)
    if len(boat.driven) < 3:
        boat = linearise(model, guided_motions(model))
    _check_drag(model, boat)
    return boat


def _nominal(
    boat: LinearBoat,
    gains: tuple[Gains, Gains, Gains],
    guidance: Guidance | None,
    knob: float,
    hold: float,
) -> Margins:
    """Worst margins of the nominal model over the speeds."""
    slow = 0.0 if guidance is None else guidance.time
    omega = frequencies(knob, float(boat.actuators.delay.max()) + hold, slow=slow)
    return margins(boat, Feedback(gains, boat.speeds, omega, hold, guidance)).worst()


def gains_for(
    boat: LinearBoat, knob: float, hold: float, action: Action
) -> tuple[Gains, Gains, Gains]:
    """Gains of the three axes, each by its delay and its least drag; none where there is no thrust."""
    rule = pid_gains if action == "pid" else pd_gains
    delay, drag = boat.actuators.delay + hold, np.maximum(boat.loop_drag.min(axis=0), 0.0)
    surge, sway, yaw = (
        rule(knob, float(delay[i]), float(drag[i])) if i in boat.driven else NO_GAINS
        for i in range(3)
    )
    return surge, sway, yaw


def permitted(found: Margins) -> bool:
    """Whether every draw is stable, with its sensitivity below `SENSITIVITY_LIMIT`."""
    return bool(found.stable.all() and (found.sensitivity <= SENSITIVITY_LIMIT).all())


def _check_request(knob: float, rate: float, extra: float, action: Action, draws: int) -> None:
    if not 0.0 < knob <= LARGEST_KNOB:
        raise ControlError(
            f"knob {knob:g} s: expected a time constant above 0 s, up to {LARGEST_KNOB:g} s"
        )
    if not 0.1 <= rate <= 1e4:
        raise ControlError(f"rate {rate:g} Hz: expected 0.1 to 10000 Hz")
    if not 0.0 <= extra <= LARGEST_KNOB:
        raise ControlError(f"delay {extra:g} s: expected 0 to {LARGEST_KNOB:g} s")
    if action not in get_args(Action):
        raise ControlError(f"action {action!r}: expected one of {', '.join(get_args(Action))}")
    if draws < 0:
        raise ControlError(f"draws {draws}: expected 0 or more")


def _check_drag(model: Model, boat: LinearBoat) -> None:
    for axis, name in enumerate(AXES):
        worst = int(np.argmin(boat.drag[:, axis]))
        if boat.drag[worst, axis] >= 0.0:
            continue
        motion = boat.speeds[worst]
        where = ", ".join(f"{s} {x:.2g}" for s, x in zip(SYMBOLS, motion, strict=True) if x)
        raise ControlError(
            f"{model.name}: unstable in {name}: its drag at {where or 'rest'} is "
            f"{boat.drag[worst, axis]:.3g} 1/s, expected 0 or more; identify it again with more driving in "
            f"{name} there, or remove the drag term that is not significant"
        )


def _refusal(model: Model, boats: list[LinearBoat], found: Margins, request: Request) -> str:
    knob, hold, action, _ = request
    smallest = smallest_knob(boats, found, request)
    delay = boats[0].actuators.delay + hold
    axis = int(np.argmax(found.sensitivity[..., list(boats[0].driven)].max(axis=0)))
    axis = boats[0].driven[axis]
    why = f"with a delay of {delay[axis]:.3g} s in {AXES[axis]} and the model's standard errors"
    alone = _unstable_alone(boats[0])
    if smallest is None:
        advice = f"{alone}; fit a skeg" if alone else "identify it with more driving"
        if alone and action == "pid":
            advice += ", or try --action pd"
        return f"{model.name}: no knob up to {LARGEST_KNOB:g} s is robust {why}; {advice}"
    return (
        f"knob {knob:g} s is not robust {why} (sensitivity "
        f"{found.sensitivity.max():.3g}, at most {SENSITIVITY_LIMIT:g}); the smallest robust one: "
        f"--knob {smallest:g}{f'. Larger ones may fail: {alone}' if alone else ''}"
    )


def _unstable_alone(boat: LinearBoat) -> str:
    """At which motion the boat turns away without a controller, as hulls without a skeg do; empty: at none."""
    growth = np.linalg.eigvals(boat.slopes).real.max(axis=1)
    worst = int(np.argmax(growth))
    if growth[worst] <= 0.0:
        return ""
    return (
        f"without control the boat is unstable at {boat.speeds[worst, 0]:.2g} m/s ahead, "
        f"where a turn doubles within {np.log(2.0) / growth[worst]:.2g} s"
    )


def smallest_knob(boats: list[LinearBoat], found: Margins, request: Request) -> float | None:
    """The smallest knob [s], of two digits, that is robust over all draws; None: there is none.

    Also below that of the request: a knob may be too large, too. found: margins of the request.
    """
    wanted, hold, action, strength = request

    def about(knob: float, among: list[LinearBoat]) -> Margins:
        gains = gains_for(boats[0], knob, hold, action)
        guidance = guidance_for(boats[0], hold, gains)
        among = about_path(among, guidance)  # the bend is that of the knob's look-ahead
        return worst_of(among, gains, knob, hold, strength, guidance=guidance)

    def worst(of: Margins) -> set[int]:
        largest = np.where(of.stable, of.sensitivity.max(axis=1), np.inf)
        return set(np.argsort(-largest)[:WORST_DRAWS].tolist())

    witnesses = {0} | worst(found)  # draws that are tried before all of them
    first = min(wanted, LEAST_KNOB_SHARE * float(boats[0].actuators.delay.max() + hold))
    for knob in knobs_from(first):
        if not permitted(about(knob, [boats[i] for i in sorted(witnesses)])):
            continue
        every = about(knob, boats)
        if permitted(every):
            return knob
        witnesses |= worst(every)
    return None


def knobs_from(first: float) -> Iterator[float]:
    """All knobs [s] of two digits, from the first up to the largest."""
    knob = rounded_up(first)
    while knob <= LARGEST_KNOB:
        yield knob
        knob = rounded_up(NEXT_DIGIT * knob)


def rounded_up(value: float) -> float:
    """To two digits."""
    step = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(f"{np.ceil(value / step - 1e-9) * step:.2g}")
