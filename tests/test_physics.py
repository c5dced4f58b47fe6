# SPDX-License-Identifier: MIT
"""Top speed and coasting against closed forms; what a physicist would doubt."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import TABLE_II, make_model

from seatrial.boat.physics import (
    axis_physics,
    full_forces,
    implausible_coefficients,
    negative_latencies,
    physics_line,
)
from seatrial.boat.schema import ChainGroup, EnvelopeEntry, NoiseEntry, ProcessEntry
from seatrial.boat.vehicle import WRENCH, vehicle_from
from seatrial.evaluation.comparison.boats import axis_meanings
from seatrial.util.errors import ModelError


def top_speed(quadratic: float, linear: float, force: float) -> float:
    """Positive root of quadratic u^2 + linear u + force = 0."""
    return (-linear - np.sqrt(linear**2 - 4 * quadratic * force)) / (2 * quadratic)


def coast(quadratic: float, linear: float, u0: float, share: float) -> float:
    """Distance from u0 to share * u0 under u_dot = linear u + quadratic u |u|: dx = u du / u_dot."""
    a, b = -linear, -quadratic
    return np.log((a + b * u0) / (a + b * share * u0)) / b


@pytest.mark.parametrize("column", ["MP", "AF"])
def test_top_speed_and_coast_are_the_closed_forms(mp, column):
    c = TABLE_II[column]
    surge, sway, yaw = axis_physics(make_model(mp, c, step=1 / 60))
    for found, names in ((surge, "X_uu X_u X_F"), (sway, "Y_vv Y_v Y_F")):
        q, lin, f = (c[n] for n in names.split())
        top = top_speed(q, lin, f)
        assert found.top_speed == pytest.approx(top, rel=1e-6)
        assert found.coast == pytest.approx(coast(q, lin, top, 0.02), rel=2e-3)
        assert found.command == 1.0
    assert yaw.top_speed == pytest.approx(top_speed(c["N_rr"], c["N_r"], c["N_F"]), rel=1e-6)
    assert 0 < surge.rise_time < 5


def test_the_papers_boat_in_words(mp):
    line = physics_line(make_model(mp, TABLE_II["AF"]))
    assert line.startswith(
        "Implied top speed 0.23 m/s in surge, 0.38 m/s in sway, 1.62 rad/s in yaw;"
    )
    assert line.endswith("Compare with your boat.")


def test_a_latency_that_no_simulation_can_have_is_said(mp):
    for latency, said in ((-0.02, 1), (-1e-4, 0), (0.1, 0)):
        model = make_model(mp.with_chain([ChainGroup(latency=latency)]), TABLE_II["AF"])
        assert len(negative_latencies(model)) == said
    told = make_model(mp.with_chain([ChainGroup(latency=-0.02)]), TABLE_II["AF"])
    assert negative_latencies(told)[0].startswith("latency is -0.02 s")


def test_drag_that_drives_the_boat_is_a_doubt(mp):
    (doubt,) = implausible_coefficients(make_model(mp, TABLE_II["AF"] | {"X_u": 0.02}))
    assert doubt.startswith("X_u = 0.02")
    assert "linear surge drag that accelerates the boat" in doubt
    assert implausible_coefficients(make_model(mp, TABLE_II["AF"])) == []


def test_pose_noise_is_not_blamed_where_the_estimator_knows_of_it(mp):
    model = make_model(mp, TABLE_II["AF"] | {"X_u": 0.02})
    (doubt,) = implausible_coefficients(model)
    assert "the bias of a regression on noisy velocities" in doubt
    noise = NoiseEntry(1e-3, 2e-3, ProcessEntry(1e-9, 1e-9, 1e-3, 1e-3, 2.0))
    (doubt,) = implausible_coefficients(replace(model, noise=noise))
    assert "noisy velocities" not in doubt
    assert "drag that grows with speed in another way" in doubt


def test_drag_that_is_positive_within_its_error_is_none(mp):
    model = make_model(mp, TABLE_II["AF"] | {"X_u": 0.02})
    k = model.structure.coefficients.index("X_u")
    for error, said in ((0.015, 0), (0.005, 1)):
        covariance = np.zeros_like(model.covariance)
        covariance[k, k] = error**2
        assert len(implausible_coefficients(replace(model, covariance=covariance))) == said


def test_a_model_that_runs_away_is_refused_with_the_coefficients_at_fault(mp):
    with pytest.raises(ModelError, match=r"surge passes 10 m/s within \d+ s.*X_u = 0\.5, X_uu = 0"):
        axis_physics(make_model(mp, TABLE_II["AF"] | {"X_u": 0.5, "X_uu": 0.0}))


def test_a_boat_whose_accelerations_can_not_be_solved_is_refused(mp):
    content = mp.to_mapping()
    content["structure"] = {
        "surge": ["X_u * u", "X_F * F_u", "X_rd * r_dot"], "sway": ["Y_v * v", "Y_F * F_v"],
        "yaw": ["N_r * r", "N_F * F_r", "N_ud * u_dot"],
    }  # fmt: skip
    vehicle = vehicle_from(content, "singular")
    values = {"X_u": -1, "X_F": 1, "X_rd": 2, "Y_v": -1, "Y_F": 1, "N_r": -1, "N_F": 1, "N_ud": 0.5}
    with pytest.raises(ModelError, match="unstable"):
        axis_physics(make_model(vehicle, values))


def test_a_thrust_gain_that_is_negative_or_not_there_is_a_doubt(mp):
    from dataclasses import replace

    model = make_model(mp, TABLE_II["AF"] | {"Y_F": -0.2})
    (doubt,) = implausible_coefficients(model)
    assert "F_v drives sway backwards. Change the sign" in doubt and "(inputs: F_v: sign)" in doubt
    odd = replace(make_model(mp, TABLE_II["AF"]), covariance=np.eye(11))
    assert [d.split(":")[1].split(". Check")[0] for d in implausible_coefficients(odd)] == [
        " F_u does not significantly drive surge", " F_v does not significantly drive sway",
        " F_r does not significantly drive yaw",
    ]  # fmt: skip


def of_thrusters(mp):
    """The same boat with its four thrusters commanded one by one."""
    content = mp.to_mapping()
    content["allocation"] = {"scheme": "direct"}
    content["commands"] = {"inputs": {name: {"column": name} for name in content["thrusters"]}}
    return vehicle_from(content, "four")


def recorded(model, size):
    return replace(model, envelope=EnvelopeEntry({}, dict.fromkeys(WRENCH, (-size, 0.5 * size))))


def test_full_command_is_what_all_thrusters_together_give(mp):
    assert full_forces(mp) == dict.fromkeys(WRENCH, 1.0)
    assert full_forces(of_thrusters(mp)) == pytest.approx(dict.fromkeys(WRENCH, 2.0))
    c = TABLE_II["MP"]
    model = make_model(of_thrusters(mp), c)
    for seen, command in ((1.99, 1.99), (2.7, 2.0)):  # 2.7: raw commands out of their range
        surge, sway, _ = axis_physics(recorded(model, seen))
        assert (surge.command, surge.full_command) == pytest.approx((command, 2.0))
        top = top_speed(c["X_uu"], c["X_u"], command * c["X_F"])
        assert surge.top_speed == pytest.approx(top, rel=1e-6)
        top = top_speed(c["Y_vv"], c["Y_v"], command * c["Y_F"])
        assert sway.top_speed == pytest.approx(top, rel=1e-6)
    assert axis_physics(model)[0].command == pytest.approx(2.0)  # nothing recorded
    assert axis_physics(recorded(make_model(mp, c), 1.3))[0].command == 1.0  # a stick


def test_a_part_of_full_command_is_said_with_the_top_speed(mp):
    for vehicle, size in ((mp, 0.45), (of_thrusters(mp), 0.9)):
        line = physics_line(recorded(make_model(vehicle, TABLE_II["MP"]), size))
        assert line.count("at 45 % of full command") == 3
    most = recorded(make_model(of_thrusters(mp), TABLE_II["MP"]), 1.6)
    assert "of full command" not in physics_line(most)


def test_two_boats_are_compared_at_the_force_that_both_reach(mp):
    stick, four = (make_model(v, TABLE_II["MP"]) for v in (mp, of_thrusters(mp)))
    for a, b, command in (
        (recorded(four, 1.9), recorded(four, 1.6), 1.6),
        (recorded(stick, 1.1), recorded(four, 1.6), 1.0),
        (four, four, 2.0),
    ):
        rows = axis_meanings(a, b)
        assert [row.command for row in rows] == pytest.approx([command] * 3)
        assert rows[0].top_speed[0] == pytest.approx(rows[0].top_speed[1], rel=1e-6)


@pytest.mark.parametrize("step", [1 / 12, 0.07713871722])
def test_times_and_ways_are_right_between_the_steps(mp, step):
    fast = {**TABLE_II["MP"], "N_F": 3.0, "N_r": -1.0, "N_rr": -1.5}
    coarse, fine = (axis_physics(make_model(mp, fast, step=h)) for h in (step, 1 / 400))
    for one, other in zip(coarse, fine, strict=True):
        assert one.rise_time == pytest.approx(other.rise_time, rel=5e-3)
        assert one.coast == pytest.approx(other.coast, rel=1e-3)
    lag = 1.0 / 0.8  # [s] of linear drag alone, in closed form
    linear = {**TABLE_II["MP"], "X_u": -1 / lag, "X_uu": 0.0, "X_F": 0.4}
    surge = axis_physics(make_model(mp, linear, step=step))[0]
    assert surge.rise_time == pytest.approx(-lag * np.log(1 - 0.632), rel=1e-4)
    assert surge.coast == pytest.approx(0.98 * 0.5 * lag, rel=1e-4)
