# SPDX-License-Identifier: MIT
"""What to drive next: the axis that is least known, within the walls."""

from dataclasses import replace

import numpy as np
import pytest
import steered_boat
from conftest import at_length
from live_advice_boat import known_boat

from benchmarks.studies.guidance import boat as twin
from seatrial.boat.static_forces import static_forces
from seatrial.identification.experiment_design.simulated_drive import simulated_drive
from seatrial.poolside.advisor import BOAT_RADIUS, Advisor, _added, position_errors
from seatrial.poolside.area import Area, rectangle
from seatrial.poolside.needs import needs_of
from seatrial.poolside.stick_patterns import first_patterns, stick_patterns
from seatrial.workflow.fitness import Use

POOL = rectangle(3.6, 2.4)
REST = np.zeros(6)


def advice(model, state=REST, area=POOL, **options):
    needs = needs_of(model, tuple(Use))
    return Advisor(model.vehicle, area).advise(model, state, needs, **options)


def effort(one):
    """RMS of each stick."""
    return np.sqrt(np.mean(np.square(one.commands), axis=0))


@pytest.mark.parametrize(("letter", "stick"), [("X", 0), at_length("Y", 1), ("N", 2)])
def test_the_axis_that_is_not_known_is_driven(letter, stick):
    first = advice(known_boat(0.005, **{letter: 0.5}))[0]
    assert effort(first)[stick] > 0.25
    assert first.parameter.startswith(letter)
    assert first.after < 0.5 * first.before


def test_the_best_comes_first_and_is_a_manoeuvre_of_some_seconds():
    found = advice(known_boat(0.2))
    assert len(found) == 3
    for one in found:
        assert 7.0 <= one.seconds <= 30.0
        assert len(one.t) == len(one.path) == len(one.commands)
        assert max(np.abs(one.commands).max(axis=0)) <= 1.0


@pytest.mark.parametrize(
    "place", [at_length((0.0, 0.0, 0.3)), (1.1, 0.5, 0.5), at_length((-1.2, -0.7, -2.0))]
)
def test_it_keeps_clear_of_the_walls(place):
    state = np.array([*place, 0.05, 0.0, 0.1])
    for one in advice(known_boat(0.2), state):
        assert POOL.margins(np.array(one.path)[:, :2]).min() >= 0.3 - 0.02
        assert one.margin <= POOL.margins(np.array(one.path)[:, :2]).min() + 0.03
        assert one.path[0] == pytest.approx(place, abs=1e-3)


def test_a_boat_without_room_drives_to_the_middle_first():
    found = advice(known_boat(0.2), np.array([1.65, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert len(found) == 1
    assert "middle first: 1.6 m astern" in found[0].text.replace("1.7", "1.6")
    assert found[0].path[-1][:2] == pytest.approx((0.0, 0.0))


def test_position_errors_are_those_of_models_drawn_from_the_covariance():
    model, rng = known_boat(0.05), np.random.default_rng(7)
    pattern = next(
        p for p in stick_patterns(model.vehicle) if p.text.startswith("Surge: full stick ahead 3 s")
    )
    times = np.arange(0.0, 12.0, 0.25)
    sticks = pattern.t, pattern.commands
    path = simulated_drive(model, REST, sticks, times).states[:, :2]
    values = np.concatenate([model.coefficients, model.constants])
    n, squares = len(model.coefficients), []
    for drawn in rng.multivariate_normal(values, model.covariance, 300):
        own = replace(model, coefficients=drawn[:n], constants=np.maximum(drawn[n:], 0.0))
        squares.append(
            np.sum((simulated_drive(own, REST, sticks, times).states[:, :2] - path) ** 2, axis=1)
        )
    found = position_errors(model, REST, pattern, times, path)
    assert found[-1] == pytest.approx(np.sqrt(np.mean(squares, axis=0))[-1], rel=0.2)
    assert found[0] == 0.0


def test_it_keeps_clear_of_the_walls_while_the_boat_coasts_after_the_manoeuvre():
    """From 0.5 m/s the sticks are released 0.8 m before the boat stops: the sum of the path is checked."""
    model, patterns = known_boat(0.02), stick_patterns(known_boat().vehicle)
    area = rectangle(4.0, 3.0)
    nearest = []
    for place in ((0.9, 0.4, 0.6), (-0.8, 0.5, 2.0), (0.0, -0.6, -1.0)):
        here = np.array([*place, 0.2, 0.0, 0.1])
        for one in advice(model, here, area):
            pattern = next(p for p in patterns if p.text == one.text)
            t = np.append(pattern.t, pattern.seconds)
            sticks = np.vstack([pattern.commands, np.zeros((1, 3))])
            times = np.arange(0.0, pattern.seconds + 5.0, 0.05)
            margins = area.margins(simulated_drive(model, here, (t, sticks), times).states[:, :2])
            assert one.margin == pytest.approx(margins.min(), abs=0.03)
            assert margins.min() > 0.28
            nearest.append(times[np.argmin(margins)] > pattern.seconds)
    assert any(nearest)  # of some the coasting is what comes nearest


@pytest.mark.system
def test_a_poor_model_keeps_further_off_the_walls():
    area = rectangle(3.6, 2.4)
    near = np.array([0.9, 0.5, 0.6, 0.1, 0.0, 0.0])
    model, patterns = known_boat(0.2), stick_patterns(known_boat().vehicle)
    sharp, poor = advice(known_boat(0.01), near, area), advice(model, near, area)
    assert [one.text for one in sharp] != [one.text for one in poor]
    for one in poor:
        pattern = next(p for p in patterns if p.text == one.text)
        times = np.arange(0.0, pattern.seconds, 0.25)
        path = simulated_drive(model, near, (pattern.t, pattern.commands), times).states[:, :2]
        off = 1.96 * position_errors(model, near, pattern, times, path)
        assert (area.margins(path) - off).min() > 0.29


def test_the_drawn_path_is_what_the_model_does_with_the_sticks():
    model = known_boat(0.2)
    one = advice(model, area=None)[0]
    assert one.margin is None
    held = np.array(one.t), np.array(one.commands)
    states = simulated_drive(model, REST, held, np.array(one.t)).states
    assert np.array(one.path) == pytest.approx(states[:, :3], abs=0.02)


@pytest.mark.system
def test_in_axes_forward_right_down_path_and_sticks_are_mirrored():
    left, right = (known_boat(0.2, axes=f"forward-{side}") for side in ("left-up", "right-down"))
    area = np.array([[-2.0, -0.5], [2.0, -0.5], [2.0, 1.5], [-2.0, 1.5]])
    begin = np.array([0.2, 0.4, 0.3, 0.0, 0.02, 0.0])
    signs = np.array([1.0, -1.0, -1.0])
    one = advice(left, begin, Area(area))[0]
    mirrored = advice(right, begin * np.tile(signs, 2), Area(area * signs[:2]))
    other = next(o for o in mirrored if o.text == one.text)  # of equal ones rounding decides
    assert np.array(other.path) == pytest.approx(np.array(one.path) * signs)
    assert np.array(other.commands) == pytest.approx(np.array(one.commands) * signs)


def test_without_a_model_the_axis_that_was_driven_least_is_next():
    boat = known_boat().vehicle
    driven = np.array([[4.0, 4.0], [0.0, 1.0], [3.0, 3.0]])
    first = Advisor(boat, POOL).advise(None, REST, driven=driven)[0]
    assert first.text.startswith("Sway: half stick to the left")
    assert effort(first)[[0, 2]] == pytest.approx(0.0)
    assert first.path == ()


def test_without_a_model_a_boat_far_from_the_middle_goes_there_first():
    first = Advisor(known_boat().vehicle, POOL).advise(None, [1.2, 0, 0, 0, 0, 0])[0]
    assert first.text.startswith("Drive to the middle first: 1.2 m astern")


def test_information_is_added_to_the_covariance():
    rng = np.random.default_rng(5)
    root, other = rng.normal(size=(2, 5, 5))
    covariance, information = root @ root.T, other @ other.T
    after, smaller = _added(covariance, information)
    expected = np.linalg.inv(np.linalg.inv(covariance) + information)
    assert after == pytest.approx(expected)
    fall = np.linalg.slogdet(covariance)[1] - np.linalg.slogdet(expected)[1]
    assert smaller == pytest.approx(fall)


def test_dense_poses_are_averaged(monkeypatch):
    model = known_boat(0.05)
    needs = needs_of(model, tuple(Use))
    thinned = Advisor(model.vehicle, period=1 / 60).advise(model, REST, needs)[0]
    monkeypatch.setattr("seatrial.poolside.advisor.LEAST_PERIOD", 0.0)
    dense = {o.text: o for o in Advisor(model.vehicle, period=1 / 60).advise(model, REST, needs)}
    assert thinned.text in dense
    assert thinned.after == pytest.approx(dense[thinned.text].after, rel=0.05)


def test_driving_that_is_not_trusted_shortens_nothing():
    one = advice(known_boat(0.2), area=None, trust=1e-9)[0]
    assert one.after == pytest.approx(one.before, rel=1e-3)


def test_a_manoeuvre_that_is_kept_begins_where_the_boat_is_and_is_left_where_it_meets_a_wall():
    """It stays the first at another place; where its path would leave the pool, the best clear one takes its place."""
    model = known_boat()
    needs = needs_of(model, tuple(Use))
    advisor = Advisor(model.vehicle, Area(np.array([[-2, -1.5], [2, -1.5], [2, 1.5], [-2, 1.5]])))
    at_rest = np.zeros(6)
    _, second, *_ = advisor.advise(model, at_rest, needs)
    here = np.array([0.1, 0.1, 0.0, 0.0, 0.0, 0.0])
    (first, *_), (kept, *_) = (
        advisor.advise(model, here, needs, keep=text) for text in ("", second.text)
    )
    assert first.text != second.text
    assert kept.text == second.text
    assert kept.path[0] == pytest.approx((0.1, 0.1, 0.0))
    assert kept.margin >= BOAT_RADIUS
    forth = "Surge: full stick ahead and astern in turn, 1 s each, 10 times"
    nose_to_wall = np.array([1.65, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert advisor.advise(model, at_rest, needs, keep=forth)[0].text == forth
    assert forth not in [one.text for one in advisor.advise(model, nose_to_wall, needs, keep=forth)]


def test_a_quarter_apart_says_both_sides_of_both_sticks():
    """Ahead is a direction: a time is earlier. What the text says is what the sticks do."""
    text = "Surge: half stick astern and ahead in turn, 3 s each; sway: half stick to the left and to the right, 1.5 s earlier"
    (one,) = [p for p in stick_patterns(known_boat().vehicle) if p.text == text]
    np.testing.assert_allclose(one.commands[:, 0], 0.5 * np.array([-1, -1, 1, 1, -1, -1, 1, 1]))
    np.testing.assert_allclose(one.commands[:, 1], 0.5 * np.array([1, -1, -1, 1, 1, -1, -1, 1]))
    np.testing.assert_allclose(one.t, 1.5 * np.arange(8))


def test_an_angle_has_patterns_at_a_held_thrust():
    vehicle = steered_boat.outboard()
    found = stick_patterns(vehicle)
    left = next(
        p for p in found if p.text.startswith("Yaw, motor held at 50 %: full stick turning left")
    )
    assert left.commands[:2] == pytest.approx(np.array([[0.5, -1.0], [0.5, 0.0]]))
    both = next(p for p in found if p.text.startswith("Surge: full stick ahead; yaw"))
    assert both.commands[:, 0] == pytest.approx(1.0) and np.ptp(both.commands[:, 1]) > 1.0
    for pattern in (*found, *first_patterns(vehicle, np.zeros((3, 2)))):
        assert np.abs(static_forces(vehicle, pattern.commands)).max() > 0.1, pattern.text


def test_a_rudder_whose_thrust_across_turns_the_boat_is_driven_by_turns():
    """As `init` proposes a rudder: its thrust to the right turns the boat left, and no axis is driven twice."""
    vehicle = steered_boat.outboard(**steered_boat.ACROSS)
    found = [*stick_patterns(vehicle), *first_patterns(vehicle, np.zeros((3, 2)))]
    assert not any("sway" in pattern.text.lower() for pattern in found)
    left = next(
        p for p in found if p.text.startswith("Yaw, motor held at 50 %: full stick turning left")
    )
    assert left.commands[0] == pytest.approx([0.5, -1.0])
    driven = np.array([[0.0, 0.0], [9.0, 9.0], [0.0, 0.0]])  # of the thrust across
    assert first_patterns(vehicle, driven)[0].text.startswith("Surge")


def test_of_several_angles_the_text_names_the_one_that_is_driven():
    """Both turn the boat: the stick of each is another, and so are the patterns."""
    found = stick_patterns(steered_boat.outboard(**steered_boat.AZIMUTHS))
    texts = [pattern.text for pattern in found if pattern.text != "All sticks as drawn"]
    assert len(set(texts)) == len(texts)
    for name, column, side in (("bow", 1, 1.0), ("stern", 3, -1.0)):
        text = f"Yaw ({name} angle), {name} held at 50 %: full stick turning left 3 s"
        (left,) = (p for p in found if p.text.startswith(text))
        assert left.commands[0, column] == side
        text = (
            f"Surge: full stick ahead; yaw ({name} angle): half stick turning left; both held 10 s"
        )
        (both,) = (p for p in found if p.text == text)
        assert both.commands[0, column] == 0.5 * side and both.commands[0, 4 - column] == 0.0


def test_two_thrusters_have_patterns_of_surge_and_yaw():
    found = stick_patterns(twin.vehicle())
    ahead = next(p for p in found if p.text.startswith("Surge: full stick ahead 3 s"))
    assert ahead.commands[0] == pytest.approx([1.0, 1.0])
    left = next(p for p in found if p.text.startswith("Yaw: full stick turning left 3 s"))
    assert left.commands[0] == pytest.approx([-1.0, 1.0])
    assert not any("Sway" in p.text for p in found)
    assert max(np.abs(p.commands).max() for p in found) <= 1.0
