# SPDX-License-Identifier: MIT
"""A rudder, outboard or azimuth angle as actuator: in the vehicle file, identified, simulated, refused."""

import numpy as np
import pytest
import yaml
from conftest import ROOT
from steered_boat import COEFFICIENTS, TRUTH, driven, known, outboard, rudder

import seatrial
from seatrial import _core
from seatrial.boat.model_file import load, save
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.inspection.consistency.check import check_consistency
from seatrial.util.errors import AllocationError, SeatrialError

OPEN = {
    "offset_deg": "estimate", "rate_deg": "estimate", "dead_zone": "estimate", "angle_deg": "estimate",
}  # fmt: skip
PLAIN = OutputErrorSettings(select_stages=False)


def forces(vehicle: seatrial.Vehicle, motor: float, helm: float) -> np.ndarray:
    """Long after one command."""
    rows = np.array([[motor, helm]])
    trace = _core.ThrustTrace(
        vehicle.chain, vehicle.constants.values, np.zeros(1), rows, np.zeros(1), np.ones((1, 0))
    )
    return np.asarray(trace.forces(np.array([100.0])))[0]


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
def test_the_thrust_acts_along_its_angle_in_the_axes_of_the_file(axes):
    boat = outboard({"angle_deg": 30, "offset_deg": -5, "dead_zone": 0.2}, axes=axes)
    side = 1.0 if axes == "forward-left-up" else -1.0  # forces are forward-left-up
    for helm, angle in ((0.0, -5.0), (0.15, -5.0), (1.0, 25.0), (-0.6, -20.0)):
        along, across = 0.8 * np.cos(np.radians(angle)), 0.8 * np.sin(np.radians(angle))
        wanted = [along, side * across, -0.6 * side * across]
        np.testing.assert_allclose(forces(boat, 0.8, helm), wanted, atol=1e-12)


def test_a_deflection_is_the_sine_of_the_angle_without_thrust():
    """The rudder in the flow: a term |u| u F_d."""
    boat = outboard(
        {"angle_deg": 30},
        forces={
            "F_u": {"axis": "surge", "of": {"motor": 1}},
            "F_d": {"axis": "yaw", "deflection": {"helm": -0.6}},
        },
        structure={
            "surge": ["X_u * u", "X_F * F_u"],
            "sway": ["Y_v * v"],
            "yaw": ["N_r * r", "N_ud * |u| * u * F_d"],
        },
    )
    np.testing.assert_allclose(forces(boat, 0.0, 1.0), [0.0, -0.3], atol=1e-12)
    np.testing.assert_allclose(forces(boat, 1.0, 1.0), [np.cos(np.pi / 6), -0.3], atol=1e-12)


def test_all_constants_of_a_helm_are_recovered_within_their_intervals():
    """Outboard with trim, backlash-like dead band and a slow steering gear; 4 min of poses."""
    model = output_error([driven(known(), 5)], outboard(OPEN), settings=PLAIN)
    found = dict(zip(model.vehicle.constants.names, model.constants, strict=True))
    errors = model.standard_errors
    for name, value in TRUTH.items():
        assert abs(found[f"{name}.helm"] - value) < 2.6 * errors[f"{name}.helm"], name
        assert errors[f"{name}.helm"] < 0.01 * max(abs(value), 1.0)
    for name, value in model.values.items():
        if name in COEFFICIENTS:
            assert abs(value - COEFFICIENTS[name]) < 2.6 * errors[name], name


@pytest.mark.system
def test_intervals_of_a_helm_hold_their_share_of_truths():
    """95 % intervals over 12 recordings of 13 parameters."""
    within = []
    for seed in range(12):
        model = output_error([driven(known(), 100 + seed)], outboard(OPEN), settings=PLAIN)
        found = dict(zip(model.vehicle.constants.names, model.constants, strict=True))
        truths = {f"{n}.helm": v for n, v in TRUTH.items()} | {
            n: v for n, v in COEFFICIENTS.items() if n in model.values
        }
        values = {**model.values, **found}
        within += [abs(values[n] - v) < 1.96 * model.standard_errors[n] for n, v in truths.items()]
    assert np.mean(within) > 0.88


def test_a_rudder_in_the_flow_is_told_from_one_in_the_race():
    """Yaw moment of thrust times sine, and of u |u| times sine, with their own coefficients."""
    changed = rudder(-0.6)
    truth = known(**changed)
    model = output_error(
        [driven(truth, 6)],
        outboard({"rate_deg": "estimate", "offset_deg": -4.0, "dead_zone": 0.08}, **changed),
        settings=PLAIN,
    )
    for name in ("N_F", "N_ud"):
        assert abs(model.values[name] - COEFFICIENTS[name]) < 3 * model.standard_errors[name]
        assert model.standard_errors[name] < 0.05 * abs(COEFFICIENTS[name])


def simulated(model, command, t):
    """States (n, 6) at t [s] from rest, under a command from 0 s on."""
    rows, since = np.array([[0.0, 0.0], command]), np.array([-1.0, 0.0])
    chain, constants = model.vehicle.chain, model.constants
    trace = _core.ThrustTrace(chain, constants, since, rows, np.zeros(1), np.ones((1, 0)))
    return _core.simulate(model.boat, trace, np.zeros(6), t, False)[0]


def test_a_model_keeps_its_angle_and_predicts_on_board_what_it_simulates(tmp_path):
    truth = known()
    save(truth, tmp_path / "model.yaml")
    back = load(tmp_path / "model.yaml")
    assert back.vehicle.file == truth.vehicle.file
    entry = (tmp_path / "model.yaml").read_text()
    assert "unit: deg/s" in entry
    predictor = seatrial.Predictor(back)
    predictor.pose(0.0, [0.0, 0.0, 0.0])
    predictor.command(0.0, [0.8, 0.7])
    t = np.arange(0.0, 2.0, 0.1)
    path = simulated(back, [0.8, 0.7], t)
    np.testing.assert_allclose(predictor.at(t[-1]).pose, path[-1, :3], atol=1e-4)


def test_the_live_simulator_turns_the_boat_as_the_model_does():
    """Port rudder, by trim and rate limit: the track of `simulate`, to the left."""
    model = known()
    simulator = seatrial.Simulator(model)
    simulator.command([0.8, 0.9])
    simulator.advance(3.0)
    path = simulated(model, [0.8, 0.9], np.linspace(0.0, 3.0, 31))
    np.testing.assert_allclose(simulator.eta, path[-1, :3], atol=1e-4)
    assert path[-1, 2] < -0.3  # thrust to port at the stern: the bow goes to starboard


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"of": []}, "no actuator named"),
        ({"of": [["motor", "helm"], ["helm", "motor"]]}, "named twice; one angle turns one thrust"),
        ({"of": [["motor", "rudder"]]}, "names 'rudder'; the actuators are motor, helm"),
        ({"angle_deg": 0}, "angle_deg"),
        ({"angle_deg": "sought"}, "got 'sought'; expected a number, or estimate"),
        ({"rate_deg": -3}, "rate_deg"),
        ({"dead_zone": 1.0}, "dead_zone"),
        ({"rate": 3}, "rate"),
    ],
)
def test_a_steered_entry_that_is_none_is_one_clear_line(entry, words):
    with pytest.raises(SeatrialError, match=words) as caught:
        outboard(entry)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_swapped_pair_is_named_with_its_edit(swapped):
    """By the surge gains of the recording: a thrust ahead has one, the cosine of an angle has none."""
    pair = ["helm", "motor"] if swapped else ["motor", "helm"]
    found = check_consistency([driven(known(), 5)], outboard({"of": [pair]})).findings
    assert len(found) == swapped
    if swapped:
        assert "motor, the angle, moves surge forward" in found[0].text
        assert found[0].text.endswith("; set of: [[motor, helm]]")


def test_a_deflection_of_what_is_no_angle_is_one_clear_line():
    with pytest.raises(SeatrialError, match="deflection names 'motor'; angles of the chain"):
        outboard(forces={"F_r": {"axis": "yaw", "deflection": {"motor": 1.0}}}, structure="auto")


def test_schemes_for_fixed_thrusters_refuse_an_angle_in_one_line():
    with pytest.raises(
        AllocationError, match=r"helm is an angle .*takes thrusters in fixed directions"
    ) as refused:
        seatrial.Allocator(known())
    assert "`seatrial allocate`, `tune` (without --allocation) and MPC of the model" in str(
        refused.value
    )


def test_the_example_of_the_documentation_is_a_vehicle():
    text = (ROOT / "docs" / "vehicle.md").read_text()
    (block,) = [part for part in text.split("```yaml\n")[1:] if "steered:" in part.split("```")[0]]
    content = yaml.safe_load(block.split("```")[0])
    head = {"seatrial": "vehicle 1", "name": "outboard", "axes": "forward-left-up", "pose": {}}
    boat = vehicle_from({**head, **content}, "docs")
    assert boat.estimated == ("steer_offset.helm", "steer_rate.helm")
    np.testing.assert_allclose(forces(boat, 1.0, 1.0)[1], np.sin(np.radians(35)))
