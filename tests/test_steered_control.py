# SPDX-License-Identifier: MIT
"""Control of a boat with one thruster and an angle: allocation by inversion, tuning, courses, station keeping."""

import dataclasses

import numpy as np
import pytest
from cli_tools import done, refused
from conftest import make_model
from steered_boat import BOW_THRUSTER, RUDDER, driven, known, outboard
from tune_tools import in_loop

import seatrial
from seatrial import _core
from seatrial.control import (
    Eight,
    Reference,
    Tracked,
    TrackingController,
    WaitingReference,
    at_speed,
    fitted,
    lawn_mower,
    load_gains,
    rounded_square,
    save_gains,
    tune,
)
from seatrial.control.allocation.steered import steering_of
from seatrial.control.tuning.design import SENSITIVITY_LIMIT
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.util.errors import ControlError
from seatrial.util.files import dump_yaml

RATE = 20.0  # [Hz] of the controller
STILL = np.zeros(3)
PLAIN = OutputErrorSettings(select_stages=False)


@pytest.fixture(scope="module")
def found():
    """The outboard's model, identified from four minutes of noisy poses."""
    open_ = dict.fromkeys(("offset_deg", "rate_deg", "dead_zone", "angle_deg"), "estimate")
    return output_error([driven(known(), 5)], outboard(open_), settings=PLAIN)


@pytest.fixture(scope="module")
def tuning(found):
    return tune(found, 1.5, rate=RATE, draws=20)


@pytest.fixture
def controller(tuning):
    return TrackingController(tuning)


def accelerations(model, nu, values):
    """Surge and yaw (2,) by commands long after them, less those without thrust."""
    trace = _core.ThrustTrace(
        model.vehicle.chain, model.constants, np.zeros(1), values[None, :], np.zeros(1),
        np.ones((1, 0)),
    )  # fmt: skip
    force = np.asarray(trace.forces(np.array([100.0])))
    both = [
        _core.accelerations(model.structure.compiled, model.coefficients, nu[None, :], f)[0]
        for f in (force, np.zeros_like(force))
    ]
    return (both[0] - both[1])[[0, 2]]


@pytest.mark.parametrize("changed", [{}, RUDDER], ids=["outboard", "rudder"])
def test_commands_give_the_accelerations_that_were_asked(changed):
    """By the plant's own chain and equations: trim, dead band, sides, the rudder's speed."""
    model = known({"rate_deg": None}, **changed)
    steering = steering_of(model)
    rng = np.random.default_rng(3)
    given = 0
    for _ in range(300):
        nu = np.array([rng.uniform(0.1, 1.2), rng.normal(0.0, 0.05), rng.normal(0.0, 0.2)])
        wanted = np.array([rng.uniform(-0.3, 0.6), rng.normal(0.0, 0.15)])
        values, enough = steering.command(*wanted, nu, 0.02)
        assert np.abs(values).max() <= 1.0 + 1e-9
        reached = accelerations(model, nu, values)
        if enough:
            np.testing.assert_allclose(reached, wanted, atol=1e-6)
            given += 1
        elif wanted[0] > 0.0 and np.abs(values).max() < 1.0 - 1e-6:
            assert reached[1] == pytest.approx(wanted[1], abs=1e-6)  # yaw first
    assert given > 30


def test_ahead_thrust_rises_to_what_yaw_needs():
    model = known({"rate_deg": None})
    steering = steering_of(model)
    nu = np.array([0.4, 0.0, 0.0])
    for yaw in (-0.2, 0.2):
        values, enough = steering.command(0.02, yaw, nu, 0.02)
        assert not enough
        assert values[1] == pytest.approx(-np.sign(yaw), abs=1e-6)
        surge, turn = accelerations(model, nu, values)
        assert turn == pytest.approx(yaw, abs=1e-6)
        assert surge > 0.02


def test_the_angle_moves_no_faster_than_its_gear():
    model = known()
    steering = steering_of(model)
    nu, helm = np.array([0.5, 0.0, 0.0]), []
    for _ in range(100):
        values, enough = steering.command(0.3, -0.2, nu, 0.02)
        helm.append(values[1])
    angle = -4.0 + 35.0 * (np.array(helm) - 0.08) / 0.92  # [deg], past the dead band
    rates = np.diff(angle[20:]) / 0.02
    assert rates.max() == pytest.approx(40.0, rel=1e-6)
    assert enough
    assert rates[-1] == pytest.approx(0.0, abs=1e-9)


def test_gains_of_an_outboard_bear_their_draws(found, tuning, tmp_path):
    assert tuning.boat.driven == (0, 2)
    assert tuning.worst.stable
    assert (tuning.worst.sensitivity <= SENSITIVITY_LIMIT).all()
    # the helm's lag is the gear's: 35 deg at 40 deg/s, half of it; the motor's its own
    values = found.vehicle.constants
    own = dict(zip(values.names, found.constants, strict=True))
    gear = 0.5 * own["steer_angle.helm"] / own["steer_rate.helm"]
    assert tuning.boat.actuators.lag[1] == pytest.approx(gear)
    assert tuning.boat.actuators.lag[0] == pytest.approx(0.3, abs=0.05)
    save_gains(tuning, tmp_path / "gains.yaml")
    seatrial.save(found, tmp_path / "model.yaml")
    one = TrackingController(tmp_path / "gains.yaml", tmp_path / "model.yaml")
    two = TrackingController(tuning)
    for i in range(20):
        given = [0.02 * i, 0.1, 0.05], [0.5, 0.0, 0.02], along(0.5)(0.02 * i)
        np.testing.assert_allclose(
            one.command(0.02 * i, *given), two.command(0.02 * i, *given), rtol=1e-6
        )
    assert load_gains(tmp_path / "gains.yaml").guidance is not None


def along(speed):
    """A straight path."""
    return lambda t: Reference([speed * t, 0.0, 0.0], [speed, 0.0, 0.0], STILL)


def straight(speed, controller):
    """The same for `follow`."""
    go, lead = along(speed), controller.gains.lead
    return lambda t, _: (go(t), go(t + lead))


def follow(plant, controller, reference, seconds, **scene):
    """States (n, 6) at every call, by the true motion. reference: of time and pose, with its later one."""
    found = in_loop(plant, controller, reference, seconds, rate=RATE, radius=0.0, **scene)
    return np.array([[*eta, *nu] for _, eta, nu, _ in found])


def waiting(course, controller):
    """The course's reference, which waits for the boat."""
    own = WaitingReference(course, controller.gains.guidance.radius)
    lead = controller.gains.lead
    return lambda t, eta: (own.at(t, eta), own.later(lead))


def across(states, course):
    """Distance [m] of each state from the course's nearest point."""
    path = np.array([course.at(t).eta[:2] for t in np.linspace(0.0, course.duration, 4000)])
    return np.array([np.hypot(*(path - s[:2]).T).min() for s in states[:: round(RATE / 4)]])


@pytest.mark.system
@pytest.mark.parametrize(
    ("shape", "current"),
    [(rounded_square(24.0, 6.0), (0.0, 0.0)), (lawn_mower(30.0, 18.0, 3, 5.0), (0.05, 0.08))],
    ids=["square", "lawn-mower"],
)
def test_an_identified_outboard_follows_a_course(found, controller, shape, current):
    """Bends near the tightest that the thrust at 0.6 m/s allows; the current is unknown at first."""
    course = at_speed(shape, 0.6, 6.0)
    states = follow(
        known(), controller, waiting(course, controller), course.duration, current=current,
        start=course.at(0.0).eta,
    )  # fmt: skip
    off = across(states, course)
    assert np.sqrt(np.mean(off**2)) < 0.45
    assert off.max() < 1.0
    assert np.hypot(*(states[-1, :2] - course.at(course.duration).eta[:2])) < 1.0


def test_a_rudder_in_the_flow_keeps_its_gain_over_speed():
    """The same heading loop at 0.5 and 1 m/s, though the rudder has four times the moment."""
    plant = known(**RUDDER)
    model = dataclasses.replace(plant, covariance=np.zeros_like(plant.covariance))
    controller = TrackingController(tune(model, 2.0, rate=RATE))
    for speed in (0.5, 1.0):
        controller.forget()
        states = follow(plant, controller, straight(speed, controller), 60.0, start=[0.0, 0.5, 0.1])
        late = states[len(states) // 2 :]
        assert np.abs(late[:, 1]).max() < 0.12
        assert np.abs(states[:, 1]).max() < 0.9


def test_it_keeps_station_as_far_as_it_can(controller):
    goal = Reference.still(STILL)
    states = follow(
        known(), controller, lambda t, _: (goal, goal), 240.0, current=(0.0, 0.1),
        start=[6.0, 4.0, 1.0],
    )  # fmt: skip
    away = np.hypot(*states[len(states) // 2 :, :2].T)
    assert away.max() < 2.0 * controller.gains.guidance.radius


@pytest.mark.system
def test_a_course_is_fitted_to_what_the_angle_can(found):
    shape = rounded_square(60.0, 14.0)
    quick = fitted(shape, found)
    assert 0.3 < shape.length / quick.duration < 1.2  # [m/s] its top speed is 1.28
    with pytest.raises(ControlError, match="can't follow this course"):
        fitted(Eight(1.0, 0.4), found)  # it stops in a bend, without thrust


def test_the_command_shows_what_thrust_and_angle_can_do(found, tmp_path, capsys):
    path = tmp_path / "model.yaml"
    seatrial.save(found, path)
    text = done(capsys, "allocate", path)
    rows = [
        line.split() for line in text.splitlines() if line.startswith("  ") and line[2].isdigit()
    ]
    assert len(rows) == 3
    # at rest the thrust is none, and so is the yaw; by the forces that the vehicle has: 0.6 f sin(35 - 4 deg)
    right, left = (float(word.strip(",")) for word in rows[0][3:5])
    assert [right, left] == pytest.approx(
        [-1.6 * 0.6 * np.sin(np.radians(31)), 1.6 * 0.6 * np.sin(np.radians(39))], rel=0.03
    )
    assert [abs(float(word.strip(","))) for word in rows[0][5:]] == pytest.approx(
        [0.0, 0.0], abs=1e-9
    )
    own = tmp_path / "vehicle.yaml"
    own.write_text(dump_yaml(found.vehicle.to_mapping()))
    for options in (
        ["--wrench", "0.1", "0", "0"], ["--scheme", "auto", "--priority", "yaw,surge"], ["--margin", "0.1"],
        ["--vehicle", str(own), "--json", str(tmp_path / "x.json")], ["-o", str(tmp_path / "x.html")],
    ):  # fmt: skip
        said = refused(capsys, "allocate", path, *options)
        assert "has a thrust and its angle, which have one allocation" in said
        assert all(option in said for option in options if option.startswith("--"))


def test_what_is_no_single_steered_thruster_is_refused_in_one_line():
    with pytest.raises(ControlError, match="takes one thruster and one angle") as caught:
        tune(known(**BOW_THRUSTER))
    assert "\n" not in str(caught.value)
    astern = known()
    values = {**astern.values, "X_F": -0.6}
    back = make_model(astern.vehicle, {n: values[n] for n in astern.structure.coefficients})
    with pytest.raises(ControlError, match="needs a thrust ahead that gives surge"):
        tune(back)


def test_limits_are_named(controller):
    values = controller.command(0.0, [-5.0, 0.0, 0.6], STILL, along(1.5)(0.0))
    assert controller.outcome is Tracked.LIMITED
    assert np.abs(values).max() <= 1.0
