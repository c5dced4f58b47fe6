# SPDX-License-Identifier: MIT
"""Top speed and coasting against closed forms; what a physicist would doubt."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import TABLE_II, make_model

from seatrial.boat.physics import (
    axis_physics,
    implausible_coefficients,
    negative_latencies,
    physics_line,
)
from seatrial.boat.schema import ChainGroup, NoiseEntry, ProcessEntry
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
    from seatrial.boat.vehicle import vehicle_from

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
