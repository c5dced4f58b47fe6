# SPDX-License-Identifier: MIT
"""The tracking controller by the allocator: in the linear range as without, and no dead zone left."""

import msgspec
import numpy as np
import pytest
from conftest import in_coarse_steps
from tune_tools import in_loop

from seatrial import Allocator, Model
from seatrial.boat.model_file import save
from seatrial.boat.vehicle import vehicle_from
from seatrial.commands.cli import main
from seatrial.control import (
    ALLOCATIONS,
    Reference,
    Tracked,
    TrackingController,
    gains_of,
    load_gains,
    ros_parameters,
    save_gains,
    tune,
)
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.errors import ControlError

RATE = 50.0  # [Hz]
SCHEMES = ["moore-penrose", "sign-pattern", "null-space"]
ORIGIN = Reference(np.zeros(3), np.zeros(3), np.zeros(3))


def one_by_one(model: Model) -> Model:
    """The same boat, its four thrusters commanded each by itself on a topic."""
    content = model.vehicle.to_mapping()
    names = list(content["thrusters"])
    content["allocation"] = {"scheme": "direct"}
    content["commands"]["inputs"] = {
        name: {"topic": "/thrusters", "field": f"data[{k}]"} for k, name in enumerate(names)
    }
    return model.with_vehicle(vehicle_from(content, "one-by-one"))


@pytest.fixture(scope="module")
def boat(mp):
    """The paper's, with a dead zone of 0.08 and a lag."""
    return one_by_one(in_coarse_steps(plant_model(load_plan("paper-like"), mp)))


@pytest.fixture(scope="module")
def tunings(boat):
    return {scheme: tune(boat, draws=0, allocation=scheme) for scheme in ALLOCATIONS}


def axis_commands(tuning, errors):
    """Axis commands (n, 3) of a PD at rest for pose errors (n, 3), by the table of gains."""
    return errors * tuning.table()[:, 0]


@pytest.mark.parametrize("scheme", [*SCHEMES, "auto", "always-forward"])
def test_the_push_is_what_the_gains_ask_for(boat, tunings, scheme):
    """Thrust by the chain's own curve, accelerations by the equations; the dead zone is gone."""
    from seatrial import _core
    from seatrial.control.tuning.linear import linearise

    tuning = tunings[scheme]
    errors = np.array(
        [[1e-3, 0, 0], [0, -2e-3, 0], [0, 0, 0.01], [-1e-3, 1e-3, -5e-3], [0.01, 0, 0.02]]
    )
    still = tunings["vehicle"]
    for error in errors:
        controller = TrackingController(tuning, feed_forward=False)
        wanted = Reference(error, np.zeros(3), np.zeros(3))
        command = controller.command(0.0, np.zeros(3), np.zeros(3), wanted)
        assert controller.outcome is Tracked.FOLLOWING
        rows = np.ascontiguousarray(command[None])
        thrust = [_core.curve(boat.vehicle.chain, boat.constants, k, rows)[0] for k in range(4)]
        pushed = linearise(boat).actuators.push @ np.array(thrust)
        asked = axis_commands(still, error) * still.boat.authority
        held = tuning.allocator.hysteresis * np.abs(tuning.allocator.boat.scale).max()
        if scheme in SCHEMES or scheme == "always-forward":
            np.testing.assert_allclose(pushed, asked, atol=1e-12)
        assert np.abs(pushed - asked).max() <= held
    assert not np.allclose(plain_push(boat, still, errors[0]), errors[0, 0])


def plain_push(boat, tuning, error):
    """Thrust along surge without the allocator: none within the dead zone."""
    controller = TrackingController(tuning, feed_forward=False)
    wanted = Reference(error, np.zeros(3), np.zeros(3))
    command = controller.command(0.0, np.zeros(3), np.zeros(3), wanted)
    assert np.abs(command).max() < 0.08
    return Allocator(boat, "moore-penrose").wrench(command)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_keeping_still_ends_where_the_dead_zone_let_it_swing(boat, tunings, scheme):
    """From 2 cm off: the vehicle's own allocation goes to and fro, the allocator comes to rest."""

    def rest(tuning):
        controller, begin = TrackingController(tuning), (0.02, -0.01, 0.05)
        found = list(in_loop(boat, controller, lambda *_: (ORIGIN,), 60.0, start=begin))
        late = np.array([eta[:2] for t, eta, *_ in found if t >= 30.0])
        return np.hypot(*np.ptp(late, axis=0)), np.array([command for *_, command in found])

    swing, _ = rest(tunings["vehicle"])
    still, thrusters = rest(tunings[scheme])
    assert swing > 5e-3  # [m]
    assert still < 1e-4
    if scheme == "null-space":
        assert np.abs(thrusters).min() >= 0.12 - 1e-12


def test_beyond_the_limits_yaw_is_served_first_and_nothing_winds_up(boat, tunings):
    controller = TrackingController(tunings["null-space"], feed_forward=False)
    still = np.zeros(3)
    for i in range(50):
        command = controller.command(
            0.02 * i, still, still, Reference.still(np.array([5.0, 0, 0.02]))
        )
        assert controller.outcome is Tracked.LIMITED
        assert np.abs(command).max() <= 1.0
    asked = axis_commands(tunings["vehicle"], np.array([5.0, 0.0, 0.02]))  # N_ud, too
    given = tunings["null-space"].allocator.wrench(command)
    full = tunings["null-space"].allocator.boat.T @ tunings["null-space"].boat.mix
    assert given[2] == pytest.approx((full @ asked)[2], rel=1e-9)
    assert controller.integral[0] == 0.0


def test_gains_come_back_from_their_file_and_do_the_same(boat, tunings, tmp_path):
    tuning = tunings["null-space"]
    save_gains(tuning, tmp_path / "gains.yaml")
    again = load_gains(tmp_path / "gains.yaml")
    assert_close(again.allocation, gains_of(tuning).allocation)
    assert gains_of(tuning).dead_zone == (0.0, 0.0, 0.0)
    assert gains_of(tunings["vehicle"]).dead_zone[0] == pytest.approx(0.08)
    assert gains_of(tunings["vehicle"]).allocation is None
    wanted = Reference.still(np.array([0.03, 0.01, -0.02]))
    one, two = TrackingController(tuning), TrackingController(again, boat)
    for i in range(3):
        given = [c.command(0.02 * i, np.zeros(3), np.zeros(3), wanted) for c in (one, two)]
        np.testing.assert_allclose(*given, rtol=1e-9)


def assert_close(one, two):
    """Numbers to the file's digits, the rest alike."""
    given = msgspec.to_builtins(one), msgspec.to_builtins(two)
    assert given[0].pop("scheme") == given[1].pop("scheme")
    assert given[0].keys() == given[1].keys()
    for name, values in given[0].items():
        np.testing.assert_allclose(values, given[1][name], rtol=1e-9)


def test_ros_parameters_are_the_files_numbers(tunings):
    given, numbers = ros_parameters(tunings["auto"]), gains_of(tunings["auto"]).allocation
    rows = np.array(given["allocation_thrusters"]).reshape(4, 6)
    np.testing.assert_array_equal(rows[:, :3], numbers.effectiveness)
    np.testing.assert_array_equal(
        rows[:, 3:].T, [numbers.limits, numbers.idle_forward, numbers.idle_reverse]
    )
    assert (given["allocation"], given["allocation_rank"]) == (
        "moore-penrose",
        [1.0, 1.0, 0.0],
    )  # the scheme that auto chose
    assert ros_parameters(tunings["vehicle"])["allocation"] == "vehicle"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"scheme": "best"}, "scheme 'best'; expected one of moore-penrose, "),
        ({"limits": [1.0]}, "limits has 1 rows; expected one for each of the thrusters F_1, F_2"),
        ({"effectiveness": [(0.5, 0.5, 0.5)] * 4}, "is for other thrusters than those of"),
        (
            {"idle_forward": [2.0] * 4},
            "allocation moore-penrose: not possible with the thrusters of mallard; tune it",
        ),
    ],
)
def test_a_damaged_allocation_is_one_line(boat, tunings, changes, words):
    gains = gains_of(tunings["auto"])
    bad = msgspec.structs.replace(gains.allocation, **changes)
    with pytest.raises(ControlError, match=words):
        TrackingController(msgspec.structs.replace(gains, allocation=bad), boat)


def test_a_boat_that_allocates_by_itself_is_refused(mp):
    model = plant_model(load_plan("paper-like"), mp)
    with pytest.raises(
        ControlError, match=r"by itself; expected a vehicle file with an input for each"
    ):
        tune(model, allocation="auto", draws=0)
    with pytest.raises(
        ControlError, match="allocation 'best': expected one of vehicle, moore-penrose"
    ):
        tune(model, allocation="best", draws=0)


def test_the_command_writes_it_and_says_what_it_is(boat, tmp_path, capsys):
    save(boat, tmp_path / "model.yaml")
    out = tmp_path / "gains.yaml"
    assert (
        main(["tune", str(tmp_path / "model.yaml"), "--allocation", "null-space", "-o", str(out)])
        == 0
    )
    said = capsys.readouterr().out
    assert "Allocation null-space: a bias in T's null space keeps them out: F_1 forward" in said
    assert "Dead zone" not in said
    assert load_gains(out).allocation.scheme == "null-space"


def test_a_gains_file_that_says_auto_keeps_its_bias(boat):
    """Before `auto` compared wrench errors, it was what `fewest-crossings` is."""
    gains = gains_of(tune(boat, allocation="fewest-crossings", draws=0))
    old = msgspec.structs.replace(
        gains, allocation=msgspec.structs.replace(gains.allocation, scheme="auto")
    )
    one, two = (TrackingController(g, boat) for g in (gains, old))
    for t in (0.0, 0.02, 0.04):
        given = [0.02, -0.03, 0.1], [0.01, 0.0, 0.0], Reference.still(np.zeros(3))
        values = one.command(t, *given)
        np.testing.assert_array_equal(values, two.command(t, *given))
        assert (np.abs(values) > 0.08).all()  # each thruster idles past its edge
