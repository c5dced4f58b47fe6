# SPDX-License-Identifier: MIT
"""The tracking controller and its courses: closed loops in the simulator, geometry by differences."""

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II
from tune_tools import CHAIN, LATENCY, closed_loop, in_loop, mallard

import seatrial
from seatrial.control import (
    Circle,
    Course,
    Eight,
    Reference,
    Square,
    Tracked,
    TrackingController,
    fitted,
    gains_of,
    save_gains,
    tune,
)
from seatrial.control.tuning.linear import steady_motions
from seatrial.util.errors import ControlError

RATE = 50.0  # [Hz]
SMOOTH = [{"latency": CHAIN[0]["latency"], "lag": CHAIN[0]["lag"]}]
SHAPES = [Circle(0.7), Eight(1.1, 0.45), Square(1.2)]


@pytest.fixture(scope="module")
def boat():
    """Without a dead zone."""
    return mallard(chain=SMOOTH, spread=0.0)


@pytest.fixture(scope="module")
def tuning(boat):
    return tune(boat)


def follow(plant, controller, course, *, current=(0.0, 0.0), start=(0.0, 0.0, 0.0), length=None):
    """Errors (n, 3) at every call, and outcomes, by the true motion."""
    lead, seconds = controller.gains.lead, course.duration if length is None else length
    found = in_loop(
        plant, controller, lambda t, _: (course.at(t), course.at(t + lead)), seconds,
        current=current, start=course.at(0.0).eta + np.array(start),
    )  # fmt: skip
    rows = [(eta - course.at(t).eta, controller.outcome) for t, eta, *_ in found]
    off, outcomes = np.array([error for error, _ in rows]), [outcome for _, outcome in rows]
    off[:, 2] = np.angle(np.exp(1j * off[:, 2]))
    return off, outcomes


@pytest.mark.parametrize("shape", SHAPES, ids=["circle", "eight", "square"])
def test_a_course_is_followed(boat, tuning, shape):
    """Feed-forward alone would do: what is left is what thrusters and 50 Hz smear."""
    course = fitted(shape, boat)
    off, outcomes = follow(boat, TrackingController(tuning), course)
    assert np.hypot(*off[:, :2].T).max() < 2.5e-3 and np.abs(off[:, 2]).max() < 0.01
    assert set(outcomes) == {Tracked.FOLLOWING}
    slow, _ = follow(boat, TrackingController(tuning, feed_forward=False), course)
    assert np.hypot(*slow[:, :2].T).max() > 5.0 * np.hypot(*off[:, :2].T).max()


def test_a_small_error_decays_as_the_linear_loop_says(boat, tuning):
    """A state space with the delay by Pade, half a period of the controller added."""
    linalg = pytest.importorskip("scipy.linalg")
    pytest.importorskip("control")
    still = Course(Square(1e-9), 1000.0)
    begin = np.array([0.01, -0.008, 0.05])
    off, _ = follow(boat, TrackingController(tuning), still, start=begin, length=12.0)
    M = closed_loop(
        TABLE_II["AF"], np.zeros(3), tuning.table(), tuning.boat.mix, latency=LATENCY + tuning.hold
    )
    state = np.concatenate([begin, np.zeros(len(M) - 3)])
    step = linalg.expm(M / RATE)
    expected = []
    for _ in range(len(off)):
        expected.append(state[:3])
        state = step @ state
    np.testing.assert_allclose(off / begin, np.array(expected) / begin, atol=0.03)
    assert np.abs(off[-1] / begin).max() < 0.02


def test_the_integral_takes_a_current_out_and_a_pd_does_not(boat):
    still = Course(Square(1e-9), 1000.0)
    left = []
    for action in ("pid", "pd"):
        controller = TrackingController(tune(boat, action=action))
        off, _ = follow(boat, controller, still, current=(0.03, 0.0), length=40.0)
        left.append(off[-1, 0])
    # at rest over ground the water pushes with its drag; P holds against it
    push = 0.20 * 0.03 + 1.74 * 0.03**2
    assert abs(left[0]) < 1e-4
    assert left[1] == pytest.approx(
        push / (tune(boat, action="pd").gains[0].proportional), rel=0.02
    )


def test_a_far_start_is_limited_and_comes_back_without_winding_up(boat, tuning):
    still = Course(Square(1e-9), 1000.0)
    off, outcomes = follow(
        boat, TrackingController(tuning), still, start=(-1.5, 0.5, 1.0), length=60.0
    )
    assert outcomes[0] is Tracked.LIMITED and outcomes[-1] is Tracked.FOLLOWING
    assert np.abs(off[-1]).max() < 2e-3
    assert off[:, 0].max() < 0.3  # beyond the goal


@pytest.mark.parametrize("shape", SHAPES, ids=["circle", "eight", "square"])
def test_a_course_is_smooth_and_its_rates_are_its_slopes(shape):
    course = Course(shape, 40.0)
    h = 1e-4
    for t in np.linspace(0.31, 39.7, 57):
        before, now, after = (course.at(float(x)) for x in (t - h, t, t + h))
        np.testing.assert_allclose(now.rate, (after.eta - before.eta) / (2 * h), atol=2e-5)
        np.testing.assert_allclose(
            now.acceleration, (after.rate - before.rate) / (2 * h), atol=2e-4
        )
    for t in (-1.0, 0.0, 40.0, 50.0):
        assert not course.at(t).rate.any() and not course.at(t).acceleration.any()


@pytest.mark.parametrize("shape", [*SHAPES, Eight(0.4, 0.9, laps=2)])
def test_a_shapes_heading_does_not_jump(shape):
    s = np.linspace(0.0, shape.length, 4001)
    psi, rate = np.array([shape.at(float(x))[:2, 2] for x in s]).T
    assert np.abs(np.diff(psi)).max() <= 1.001 * np.abs(rate).max() * s[1]
    assert psi[-1] - psi[0] == pytest.approx(
        2 * np.pi * shape.laps if isinstance(shape, Circle) else 0.0
    )


@pytest.mark.parametrize("shape", SHAPES, ids=["circle", "eight", "square"])
def test_a_course_ends_where_it_began(shape):
    course = Course(shape, 40.0)
    np.testing.assert_allclose(course.at(40.0).eta[:2], course.at(0.0).eta[:2], atol=1e-9)


def test_along_its_tangent_a_boat_only_goes_forward():
    for shape in (Circle(0.7), Eight(1.1, 0.45)):
        for t in np.linspace(1.0, 39.0, 21):
            nu, _ = Course(shape, 40.0).at(float(t)).body()
            assert nu[0] > 0 and abs(nu[1]) < 1e-12


def test_a_steady_circle_has_the_closed_forms_velocity_and_acceleration():
    now = Course(Circle(0.7), 40.0).at(20.0)
    nu, nu_dot = now.body()
    turn = 2 * np.pi / (40.0 * 0.8)
    assert nu == pytest.approx([0.7 * turn, 0.0, turn])
    assert nu_dot == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert np.hypot(*now.acceleration[:2]) == pytest.approx(0.7 * turn**2)


def test_a_fitted_course_asks_for_its_share_and_no_more(boat):
    """By the commands that the pure feed-forward gives along it, and by speeds."""
    course = fitted(Circle(0.7), boat, 0.5)
    controller = TrackingController(tune(boat, action="pd"))
    most = np.abs(steady_motions(boat)).max(axis=0)
    asked = []
    for t in np.linspace(0.0, course.duration, 400):
        now = course.at(float(t))
        nu, _ = now.body()
        values = controller.command(float(t), now.eta, nu, now)
        asked.append(max(np.abs(values).max(), (np.abs(nu) / most).max()))
    assert max(asked) == pytest.approx(0.5, rel=0.02)


def test_a_course_that_no_boat_could_follow_is_refused(boat):
    with pytest.raises(ControlError, match="can't follow this course even in"):
        fitted(Circle(1e6), boat)
    with pytest.raises(ControlError, match="course of -1 s"):
        Course(Circle(1.0), -1.0)


def test_gains_from_a_file_do_the_same(boat, tuning, tmp_path):
    save_gains(tuning, tmp_path / "gains.yaml")
    seatrial.save(boat, tmp_path / "model.yaml")
    now = Reference([1.0, 0.2, 0.1], [0.1, 0.0, 0.02], [0.01, 0.0, 0.0])
    one, two = (
        TrackingController(tmp_path / "gains.yaml", tmp_path / "model.yaml"),
        TrackingController(tuning),
    )
    for t in (0.0, 0.02, 0.04):
        a, b = (c.command(t, [0.97, 0.2, 0.1], [0.1, 0.01, 0.0], now) for c in (one, two))
        np.testing.assert_allclose(a, b, rtol=1e-8)
    assert one.integral == pytest.approx([0.04 * 0.03, 0.0, 0.0], abs=1e-12)
    one.forget()
    assert not one.integral.any()


def test_gains_of_another_boat_are_refused(boat, tuning):
    other = mallard(chain=SMOOTH, X_F=0.2)
    with pytest.raises(
        ControlError, match=r"the gains are for full commands of 0\.14, .* has 0\.2, .*: tune it"
    ):
        TrackingController(gains_of(tuning), other)
    with pytest.raises(ControlError, match="give the model, too"):
        TrackingController(gains_of(tuning))
    odd = msgspec.structs.replace(gains_of(tuning), inputs=["a", "b", "c"])
    with pytest.raises(ControlError, match="the gains are for the inputs a, b, c"):
        TrackingController(odd, boat)


def test_what_is_no_number_gives_no_command(tuning):
    controller = TrackingController(tuning)
    here = Reference.still(np.array([0.01, 0.0, 0.0]))
    assert not controller.command(0.0, [np.nan, 0, 0], [0, 0, 0], here).any()
    assert controller.outcome is Tracked.NOT_A_NUMBER
    assert controller.command(0.02, [0, 0, 0], [0, 0, 0], here).any()
    assert controller.outcome is Tracked.FOLLOWING
    with pytest.raises(seatrial.SeatrialError, match="eta of shape"):
        controller.command(0.0, [0, 0], [0, 0, 0], here)
