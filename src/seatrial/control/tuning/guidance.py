# SPDX-License-Identifier: MIT
"""Line-of-sight guidance of a boat without sway thrust: its constants, by the same rule as the gains.

About a straight path at speed U the cross-track error y obeys y_dot = U sin(course error): an integrator
behind the heading loop. SIMC for e^(-theta s) / s with the closed-loop time constant tau_c is a
proportional gain of 1/T and an integral time of 4 T, T = tau_c + theta (Skogestad 2003, table 1). The
gain is the look-ahead distance U T of line-of-sight guidance (Fossen 2021, chapter 12), the integral
time its drift compensation. Derived in docs/tune.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.model import Model
from seatrial.control.tuning.linear import LinearBoat, slopes_at, steady_motions
from seatrial.control.tuning.rules import Gains
from seatrial.util.frames import Array

SLOWEST_SHARE = 0.1  # of the fastest speed: a slower reference rests, station keeping begins
RADIUS_SHARE = 2.0  # of the look-ahead distance at the slowest speed
STRAIGHT = 0.5  # [rad] of turn in the time T: the drift is learned up to it
TURN_SHARE = 0.7  # of the fastest speed and yaw rate, in a bend
AXES_GUIDED = ("surge", "cross-track", "yaw")  # loops of a boat without sway thrust


@dataclass(frozen=True)
class Guidance:
    """Constants of `core/include/seatrial/control/guidance.hpp`.

    time: [s] T: look-ahead distance over speed
    radius: [m] least look-ahead distance, and the circle of station keeping
    slowest: [m/s] a reference below it rests
    fastest: [m/s] of approach
    approach: [s] position error over the speed that the surge gains make of it
    """

    time: float
    radius: float
    slowest: float
    fastest: float
    approach: float

    def coupling(self, speed: float, turn: float = 0.0) -> tuple[float, float]:
        """Heading per cross-track error [rad/m] and per its integral [rad/(m s)].

        speed [m/s]; turn [rad/s] of the path: no drift is learned in a bend.
        """
        if speed < self.slowest:
            return 0.0, 0.0
        ahead = max(self.radius, speed * self.time)
        bend = abs(turn) * self.time > STRAIGHT
        return 1.0 / ahead, 0.0 if bend else speed / (4.0 * ahead**2)


def guided_motions(model: Model) -> Array:
    """Rest, the slowest and the fastest motion ahead (m, 3)."""
    most = np.abs(steady_motions(model)).max(axis=0)
    found = np.zeros((3, 3))
    found[1, 0], found[2, 0] = SLOWEST_SHARE * most[0], most[0]
    return found


def about_path(boats: Sequence[LinearBoat], guidance: Guidance | None) -> list[LinearBoat]:
    """The boats about a bend, too: its radius is the look-ahead distance, at most at the first one's turning rate.

    Without guidance the boats themselves.
    """
    if guidance is None:
        return list(boats)
    most = boats[0].fastest
    turn = min(TURN_SHARE * most[2], 1.0 / guidance.time)
    bend = np.array([[TURN_SHARE * most[0], 0.0, turn]])
    return [
        replace(
            boat,
            speeds=np.vstack([boat.speeds, bend]),
            slopes=np.concatenate([boat.slopes, slopes_at(boat.model, bend)]),
        )
        for boat in boats
    ]


def guidance_for(
    boat: LinearBoat, hold: float, gains: tuple[Gains, Gains, Gains]
) -> Guidance | None:
    """Of a boat without sway thrust; None: it has some. `boat` is about `guided_motions`.

    tau_c is that of the heading loop: its delay, and its slow time constant (D + d) / P at the largest yaw drag,
    which is the knob where the drag is the least one that the gains are for. theta is as much, and the lag of
    the course behind the heading: in a turn v = -(A_vr / A_vv) r, so that the course lags by
    tau_v = A_vr / (A_vv u) at speed u. An angle pushes the stern aside, too: its lever over u is a lag more,
    which the radius has at low speed.
    """
    if len(boat.driven) == 3:
        return None
    surge, _, yaw = gains
    heading = (yaw.derivative + float(boat.drag[:, 2].max())) / yaw.proportional
    fastest = float(boat.speeds[:, 0].max())
    slowest, lever = SLOWEST_SHARE * fastest, stern_lever(boat)
    time = 2.0 * (heading + float(boat.actuators.delay[2]) + hold) + course_lag(boat)
    time += lever / fastest
    approach = (surge.derivative + float(boat.drag[:, 0].min())) / surge.proportional
    radius = RADIUS_SHARE * (slowest * time + lever)
    return Guidance(time, radius, slowest, fastest, approach)


def course_lag(boat: LinearBoat) -> float:
    """tau_v [s]: of the course behind the heading, the largest of the straight motions ahead."""
    straight = (boat.speeds[:, 0] > 0.0) & (boat.speeds[:, 2] == 0.0)
    A, u = boat.slopes[straight], boat.speeds[straight, 0]
    return float(np.maximum(A[:, 1, 2] / (np.minimum(A[:, 1, 1], -1e-9) * u), 0.0).max())


def stern_lever(boat: LinearBoat) -> float:
    """Sway over yaw rate [m] that a yaw command itself brings, to the outside of the turn, at rest.

    With b = push of the yaw command, v / r = (A_vr b_r - A_rr b_v) / (A_rv b_v - A_vv b_r), less the turn's own.
    """
    _, b_v, b_r = boat.actuators.push @ boat.actuators.share[:, 2]
    A = boat.slopes[0]
    beside = A[2, 1] * b_v - min(A[1, 1], -1e-9) * b_r
    return max(0.0, float(A[2, 2] * b_v / beside)) if beside else 0.0
