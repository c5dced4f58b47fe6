# SPDX-License-Identifier: MIT
"""A boat without sway thrust: its gains and guidance, in closed loop with the simulator and by state spaces."""

import dataclasses

import msgspec
import numpy as np
import pytest
from cli_tools import done
from conftest import at_length, make_model
from survey_boat import LAG, LATENCY, TRUTH, boat
from tune_tools import in_loop, without_guidance

import seatrial
from seatrial.control import (
    ByLength,
    Course,
    Eight,
    Reference,
    Tracked,
    TrackingController,
    at_speed,
    gains_of,
    lawn_mower,
    load_gains,
    ros_parameters,
    rounded_square,
    save_gains,
    tune,
    tuning_text,
)
from seatrial.control.tuning.design import SENSITIVITY_LIMIT, gains_for
from seatrial.control.tuning.guidance import Guidance, about_path, guidance_for, guided_motions
from seatrial.control.tuning.linear import linearise
from seatrial.control.tuning.loops import Feedback, frequencies, margins
from seatrial.control.tuning.page import tuning_report
from seatrial.util.errors import ControlError

RATE = 50.0  # [Hz]
CHAIN = [{"latency": LATENCY, "lag": LAG}]
STILL = np.zeros(3)


@pytest.fixture(scope="module")
def model():
    """Two thrusters astern; coefficients known to 3 %."""
    found = make_model(boat(CHAIN), TRUTH)
    n = len(found.coefficients)
    covariance = np.zeros((n + len(found.constants),) * 2)
    covariance[:n, :n] = np.diag((0.03 * found.coefficients) ** 2)
    return dataclasses.replace(found, covariance=covariance)


@pytest.fixture(scope="module")
def tuning(model):
    return tune(model, draws=20)


def follow(plant, controller, reference, seconds, **scene):
    """States (n, 6) at every call, by the true motion."""
    lead = controller.gains.lead
    found = in_loop(
        plant, controller, lambda t, _: (reference(t), reference(t + lead)), seconds, **scene, radius=0.0
    )  # fmt: skip
    return np.array([[*eta, *nu] for _, eta, nu, _ in found])


def along_x(speed):
    """A straight path."""
    return lambda t: Reference([speed * t, 0.0, 0.0], [speed, 0.0, 0.0], STILL)


def still(t):
    """A goal at the origin."""
    del t
    return Reference.still(STILL)


def test_speed_and_heading_have_the_gains_of_their_axes_and_sway_has_none(tuning, model):
    three = gains_for(linearise(make_model(boat(CHAIN, bow=True), TRUTH)), 1.0, 0.01, "pid")
    assert tuning.boat.driven == (0, 2)
    # the same rule at the same drag and delay: the surge gains are those of a boat with a bow thruster
    assert dataclasses.astuple(tuning.gains[0]) == pytest.approx(dataclasses.astuple(three[0]))
    assert not tuning.table()[1].any() and not tuning.boat.mix[:, 1].any()
    np.testing.assert_allclose(tuning.boat.mix[:, [0, 2]], [[1, -1], [1, 1]], atol=1e-12)
    np.testing.assert_allclose(tuning.boat.authority, [TRUTH["X_F"], 0.0, TRUTH["N_F"]])


def test_the_look_ahead_time_is_simcs(tuning):
    """Twice the heading loop's time constant and delay, and the lag of the course by the turn's sway."""
    g, yaw = tuning.guidance, tuning.gains[2]
    heading = (yaw.derivative - TRUTH["N_r"]) / yaw.proportional
    lag = TRUTH["Y_ur"] / TRUTH["Y_v"]
    assert g.time == pytest.approx(2.0 * (heading + LAG + LATENCY + 0.01) + lag, rel=1e-4)
    assert g.slowest == pytest.approx(0.1 * g.fastest)
    assert g.radius == pytest.approx(2.0 * g.slowest * g.time)
    top = np.roots([TRUTH["X_uu"], TRUTH["X_u"], TRUTH["X_F"]]).max()
    assert g.fastest == pytest.approx(top, rel=1e-3)


@pytest.mark.parametrize(
    ("knob", "draw"),
    [(0.15, 0), at_length(0.15, 2), at_length(0.3, 1), (1.0, 1), at_length(1.0, 2), (2.0, 0)],
)
def test_poles_on_the_right_are_counted_as_a_state_space_has_them(knob, draw):
    """Without delay and lag: pose, integrals, drift and velocity as states, about every motion."""
    values = {**TRUTH, "Y_ur": (-0.6, -0.9, -0.3)[draw], "Y_v": (-0.4, -0.15, -1.5)[draw]}
    own = make_model(boat(), values)
    straight = linearise(own, guided_motions(own))
    gains = gains_for(straight, knob, 0.0, "pid")
    guidance = guidance_for(straight, 0.0, gains)
    (ahead,) = about_path([straight], guidance)
    tight = linearise(
        own, np.vstack([ahead.speeds, [[0.3, 0.0, 0.8]], [[0.3, 0.0, -0.4 / guidance.time]]])
    )
    # as designed, and with ever too short a look-ahead
    omega = frequencies(knob, 0.01, 3000, guidance.time)
    for share in (1.0, 0.1, 0.02, 0.004):
        short = dataclasses.replace(
            guidance, time=share * guidance.time, radius=share * guidance.radius
        )
        feedback = Feedback(gains, tight.speeds, omega, 0.0, short)
        found = margins(tight, feedback).stable
        expected = [
            closed_poles(A, nu, gains, short).real.max() < 1e-7
            for A, nu in zip(tight.slopes, tight.speeds, strict=True)
        ]
        assert found.tolist() == expected, (share, short)
    assert not all(expected) or knob < 0.2


def closed_poles(A, nu, gains, guidance):
    """Poles but those at which no state answers: nu, x, y, psi, two integrals fixed to the earth, the yaw's."""
    near, drift = guidance.coupling(nu[0], nu[2])
    spin = nu[2] * np.array([[0.0, 1.0], [-1.0, 0.0]])
    M = np.zeros((11, 11))
    M[:3, :3] = A
    M[3, 0], M[3, 4], M[3, 5] = 1.0, nu[2], -nu[1]
    M[4, 1], M[4, 5] = 1.0, nu[0]
    M[5, 2] = 1.0
    M[6:8, 6:8], M[6, 3] = spin, 1.0
    M[8:10, 8:10], M[9, 4] = spin, drift
    heading = np.zeros(11)
    heading[5], heading[4], heading[9] = 1.0, near, float(drift > 0.0)
    M[10] = heading
    surge = np.zeros(11)
    surge[0], surge[3], surge[6] = gains[0].derivative, gains[0].proportional, gains[0].integral
    yaw = gains[2].proportional * heading + gains[2].derivative * heading @ M
    yaw[10] += gains[2].integral
    M[0] -= surge
    M[2] -= yaw
    poles = np.linalg.eigvals(M)
    return poles[np.abs(poles.real) > 1e-7] if np.any(np.abs(poles.real) > 1e-7) else poles


def test_margins_have_a_cross_track_loop_which_bears_them_and_no_more(tuning):
    assert tuning.loops == ("surge", "cross-track", "yaw")
    assert tuning.worst.stable and (tuning.worst.sensitivity <= SENSITIVITY_LIMIT).all()
    assert (tuning.worst.sensitivity >= tuning.nominal.sensitivity).all()
    fast = linearise(tuning.model, tuning.boat.speeds[2:3])
    omega = frequencies(1.0, 0.17, 3000)

    def stays(times):
        # a look-ahead shorter by a factor is a gain higher by it, with the drift's integral scaled alike
        g = tuning.guidance
        own = dataclasses.replace(g, time=g.time / times, radius=g.radius / times)
        scaled = _Scaled(*dataclasses.astuple(own), times)
        feedback = Feedback(tuning.gains, fast.speeds, omega, tuning.hold, scaled)
        return bool(margins(fast, feedback).stable.all())

    own = margins(fast, Feedback(tuning.gains, fast.speeds, omega, tuning.hold, tuning.guidance))
    most = own.gain_up[0, 1]
    assert stays(0.98 * most) and not stays(1.02 * most)


@dataclasses.dataclass(frozen=True)
class _Scaled(Guidance):
    """Guidance of which the drift's gain grows by the same factor as the look-ahead's."""

    times: float = 1.0

    def coupling(self, speed, turn=0.0):
        near, drift = super().coupling(speed, turn)
        return near, drift / self.times


@pytest.mark.parametrize("current", [(0.0, 0.1), (0.05, -0.08), (0.0, 0.0)])
def test_the_cross_track_error_converges_to_zero_in_a_current(model, tuning, current):
    controller = TrackingController(tuning)
    found = follow(model, controller, along_x(0.25), 120.0, current=current, start=[0.0, 1.0, 0.4])
    across = np.abs(found[:, 1])
    assert across[-1] < 3e-3
    # the design's pole pair at -1 / (2 T): from 1 m and a heading of 0.4 rad, into a drift to be learned
    late = np.arange(len(across)) / RATE
    T = tuning.guidance.time
    bound = 2.2 * (1.0 + late / (2.0 * T)) * np.exp(-late / (2.0 * T)) + 3e-3
    assert (across <= bound).all()
    assert controller.drift[1] == pytest.approx(current[1] * 0.25 / (0.25 - current[0]), abs=0.01)
    assert abs(found[-1, 0] - 0.25 * (120.0 - 1.0 / RATE)) < 5e-3
    # the crab angle is the current's: through the water it moves where it points
    water = np.array([0.25 - current[0], -current[1]])
    assert found[-1, 2] == pytest.approx(np.arctan2(water[1], water[0]), abs=0.01)


def test_without_drift_compensation_the_current_leaves_an_offset(model, tuning):
    """Plain line of sight settles where atan(y / Delta) is the crab angle: what the integral is for."""
    controller = TrackingController(tuning)
    found = follow(model, controller, along_x(0.25), 6.0, current=(0.0, 0.1))
    assert found[-1, 1] > 0.1  # still learning


@pytest.mark.system
@pytest.mark.parametrize(
    "shape", [rounded_square(6.0, 1.5), ByLength(Eight(6.0, 2.5)), lawn_mower(8.0, 5.0, 3, 1.2)],
    ids=["square", "eight", "lawn-mower"],
)  # fmt: skip
def test_a_course_is_followed(model, tuning, shape):
    course = at_speed(shape, 0.25, 6.0)
    begin = course.at(0.0).eta
    found = follow(model, TrackingController(tuning), course.at, course.duration, start=begin)
    wanted = np.array([course.at(i / RATE).eta for i in range(len(found))])
    off = found[:, :2] - wanted[:, :2]
    normal = np.column_stack([-np.sin(wanted[:, 2]), np.cos(wanted[:, 2])])
    assert np.abs((off * normal).sum(axis=1)).max() < 0.04
    assert np.hypot(*off.T).max() < 0.08


@pytest.mark.parametrize("current", [(0.0, 0.08), (0.06, 0.0), (0.0, 0.02)])
def test_it_keeps_station_with_the_bow_in_the_current(model, tuning, current):
    controller = TrackingController(tuning)
    found = follow(model, controller, still, 240.0, current=current, start=[3.0, 2.0, 1.0])
    away = np.hypot(*found[:, :2].T)
    assert away[-1] < 0.05
    arrived = np.argmax(away < tuning.guidance.radius)
    assert away[arrived:].max() < 2.0 * tuning.guidance.radius
    into = np.arctan2(-current[1], -current[0])
    assert abs(np.angle(np.exp(1j * (found[-1, 2] - into)))) < 0.1


def test_a_far_goal_is_approached_no_faster_than_the_model_knows(model, tuning):
    found = follow(model, TrackingController(tuning), still, 40.0, start=[-8.0, 0.0, 3.0])
    assert found[:, 3].max() < 1.05 * tuning.guidance.fastest
    assert np.hypot(*found[-1, :2]) < tuning.guidance.radius


def test_yaw_keeps_its_share_at_the_limits(model, tuning):
    """Far behind, and pointing the wrong way: the turn is served first."""
    controller = TrackingController(tuning)
    values = controller.command(0.0, [-5.0, 0.0, 0.6], STILL, along_x(0.5)(0.0))
    assert controller.outcome is Tracked.LIMITED
    assert np.abs(values).max() == pytest.approx(1.0)
    yaw = 0.5 * (values[1] - values[0])
    gains = tuning.table()[2]
    # P of the heading error and D of the wanted turn, as if alone
    assert yaw < -0.3
    assert yaw == pytest.approx(np.clip(-gains[0] * 0.6 + gains[2] * 0.0, -1.0, 1.0), abs=0.02)


def test_a_gains_file_is_read_as_it_was_written(model, tuning, tmp_path):
    save_gains(tuning, tmp_path / "gains.yaml")
    seatrial.save(model, tmp_path / "model.yaml")
    read, own = load_gains(tmp_path / "gains.yaml"), gains_of(tuning)
    assert dataclasses.astuple(tuning.guidance) == pytest.approx(
        msgspec.structs.astuple(read.guidance)
    )
    assert set(read.margins) == {"surge", "cross-track", "yaw"}
    one = TrackingController(tmp_path / "gains.yaml", tmp_path / "model.yaml")
    two = TrackingController(own, model)
    for i in range(20):
        given = [0.025 * i, 0.05, 0.0], [0.25, 0.01, 0.05], along_x(0.25)(0.1 * i)
        np.testing.assert_allclose(
            one.command(0.1 * i, *given), two.command(0.1 * i, *given), rtol=1e-8
        )
    np.testing.assert_allclose(one.drift, two.drift)
    assert one.drift[1] > 0.0
    one.forget()
    assert not one.drift.any()
    assert ros_parameters(tuning)["guidance"] == list(msgspec.structs.astuple(own.guidance))


def test_gains_without_guidance_are_no_gains_of_this_boat(tuning, tmp_path):
    with pytest.raises(ControlError, match="guidance is for a boat without sway thrust"):
        load_gains(without_guidance(tuning, tmp_path / "gains.yaml"))


@pytest.mark.system
def test_text_page_and_command_say_what_the_boat_can_do(model, tuning, tmp_path, capsys):
    text = tuning_text(tuning)
    assert "No sway thrust: follows a path by line of sight with drift compensation" in text
    assert "\n  sway" not in text and "\n  cross-track" in text
    page = tuning_report(tune(model, draws=4))  # a step response each
    assert "cross-track: response over step" in page
    assert "No sway thrust" in page
    seatrial.save(model, tmp_path / "model.yaml")
    out = tmp_path / "gains.yaml"
    shown = done(capsys, "tune", tmp_path / "model.yaml", "-o", out, "--knob", "1.5")
    assert "keeps station within" in shown
    assert load_gains(out).guidance.time > tuning.guidance.time


def test_too_quick_a_knob_is_told_the_smallest(model):
    with pytest.raises(ControlError, match=r"knob 0\.2 s is not robust .* --knob \S+$") as e:
        tune(model, 0.2, draws=5)
    smallest = float(str(e.value).rpartition(" ")[2])
    assert (tune(model, smallest, draws=5).worst.sensitivity <= SENSITIVITY_LIMIT).all()


def test_by_an_allocator_the_dead_zone_is_gone(tmp_path):
    zone = [{**CHAIN[0], "dead_zone": {"forward": 0.1, "reverse": 0.1}}]
    own = make_model(boat(zone), TRUTH)
    own = dataclasses.replace(own, covariance=np.zeros_like(own.covariance))
    tuning = tune(own, allocation="auto")
    save_gains(tuning, tmp_path / "gains.yaml")
    assert load_gains(tmp_path / "gains.yaml").allocation.scheme == "moore-penrose"
    # to and fro along the bow about a goal: PID alone leaves a limit cycle at the dead zone
    swings = [
        np.ptp(follow(own, TrackingController(one), still, 120.0, start=[0.1, 0.0, 0.0])[-2000:, 0])
        for one in (tuning, tune(own))
    ]
    assert swings[0] < 5e-3 < swings[1]


def test_what_is_no_number_gives_no_command(tuning):
    controller = TrackingController(tuning)
    assert not controller.command(0.0, [np.nan, 0, 0], STILL, still(0.0)).any()
    assert controller.outcome is Tracked.NOT_A_NUMBER
    assert not controller.command(0.0, STILL, STILL, still(0.0)).any()
    assert isinstance(Course(rounded_square(4.0, 0.5), 40.0).at(1.0), Reference)
