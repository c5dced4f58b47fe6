# SPDX-License-Identifier: MIT
"""Thrust that a motor controller ramps: a stage of the chain, found by the likelihood."""

import numpy as np
import pytest
from conftest import at_length
from steered_boat import outboard
from test_mpc_path import straight

import seatrial
from seatrial import _core
from seatrial.boat.findings import FindingKind, finding_text
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.control.mpc import Nmpc
from seatrial.control.mpc.problem import MOTION_SIZE, PATH_GRID
from seatrial.control.mpc.step import Layout
from seatrial.identification.first_search import first_maximum
from seatrial.identification.selection.actuator_selection import select_stages, with_slew_rate
from seatrial.identification.solution import OutputErrorSettings
from seatrial.recording.recording import Recording
from seatrial.simulation.trials import DisturbedPlant
from seatrial.util.errors import SeatrialError
from tests.boats.hulls import TICK
from tests.boats.motions import given_model, recorded, ticked
from tests.boats.vehicles import TWO_ASTERN, by_columns

TRUTH = {
    "X_u": -0.25, "X_uu": -0.35, "X_F": 0.9, "Y_v": -0.8, "Y_vv": -0.9, "N_r": -0.7, "N_rr": -0.6, "N_F": 2.4,
}  # fmt: skip
STRUCTURE = {
    "surge": ["v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
    "sway": ["-0.8 * u * r", "Y_v * v", "Y_vv * |v| * v"],
    "yaw": ["N_r * r", "N_rr * |r| * r", "N_F * F_r"],
}


def twin(*chain: dict[str, object]) -> Vehicle:
    return by_columns("twin", ("left", "right"), STRUCTURE, forces=TWO_ASTERN, chain=list(chain))


def boat_of(vehicle: Vehicle) -> Model:
    return given_model(vehicle, TRUTH)


def driven(*chain: dict[str, object], seed: int = 1, seconds: float = 240.0) -> Recording:
    """A drive by pulses of both thrusters, seen 5 times a second with noise of 1 cm and 5 mrad."""
    vehicle, rng = twin(*chain), np.random.default_rng(seed)
    boat = boat_of(vehicle)
    command, begin = np.zeros((round(seconds / TICK), 2)), 0
    while begin < len(command):
        end = begin + round(rng.uniform(1.0, 4.0) / TICK)
        command[begin:end] = np.round(rng.uniform(-1.0, 1.0, 2), 2) * (rng.random() > 0.15)
        begin = end
    states = ticked(DisturbedPlant(boat, None, rng), command, TICK)
    seen = np.arange(5, len(command), round(0.2 / TICK))
    eta = states[seen, :3] + rng.normal(size=(len(seen), 3)) * [0.01, 0.01, 0.005]
    ticks = TICK * np.arange(len(command))
    return recorded("run", vehicle, (ticks[seen], eta), (ticks, command))


def forces(vehicle: Vehicle, commands: list[list[float]], t: list[float]) -> np.ndarray:
    """Commands at 0 s, after rest."""
    at = np.array([-1.0, 0.0])
    rows = np.array([[0.0] * len(commands[0]), *commands])
    trace = _core.ThrustTrace(
        vehicle.chain, vehicle.constants.values, at, rows, at[:1], np.ones((1, 0))
    )
    return np.asarray(trace.forces(np.array(t)))


def test_thrust_is_a_ramp_to_each_command():
    found = forces(twin({"slew_rate": 0.8}), [[1.0, 1.0]], [0.0, 0.5, 1.0, 1.25, 3.0])
    np.testing.assert_allclose(found[:, 0], [0.0, 0.4, 0.8, 1.0, 1.0], atol=1e-12)
    found = forces(twin({"slew_rate": 0.8}), [[-0.6, 0.2]], [0.25, 0.5, 1.0])
    np.testing.assert_allclose(found[:, 1], [0.2, 0.3, 0.4], atol=1e-12)


def test_with_a_lag_the_ramp_ends_in_its_exponential():
    """Fossen, section 9: f' = clip((f* - f) / lag, ± rate)."""
    found = forces(twin({"slew_rate": 2.0, "lag": 0.2}), [[1.0, 1.0]], [0.2, 0.3, 0.5])
    np.testing.assert_allclose(found[:, 0], [0.4, 0.6, 1.0 - 0.4 * np.exp(-1.0)], atol=1e-12)


def test_an_angle_has_its_rate_in_degrees_beside_it():
    chain = [
        {"slew_rate": 0.5},
        {"steered": {"of": [["motor", "helm"]], "angle_deg": 30, "rate_deg": 60}},
    ]
    boat = vehicle_from({**outboard({"angle_deg": 30}).to_mapping(), "chain": chain}, "outboard")
    along, across = forces(boat, [[1.0, 1.0]], [0.25])[0, :2]
    np.testing.assert_allclose(
        [along, across], 0.125 * np.array([np.cos(np.pi / 12), np.sin(np.pi / 12)])
    )


@pytest.mark.parametrize("rate", [0.5, at_length(1.0), 2.5])
def test_identify_finds_it_where_no_file_states_it(rate):
    """0.5 of full thrust a second and more; the mean delay of its ramps looks like a lag of 0.1 to 1 s."""
    recording = driven({"latency": 0.1, "slew_rate": rate})
    model = seatrial.identify([recording], twin())
    (found,) = model.findings_of(FindingKind.SLEW_RATE_SELECTED)
    assert found.number("rate") == pytest.approx(rate, rel=0.05)
    assert found.number("gain") > 300.0
    assert f"thrust changes by {rate:.2g} of full thrust a second at most" in finding_text(found)
    true = TRUTH | {"slew_rate": rate, "latency": 0.1}
    off = {n: (model.parameter_values[n] - true[n]) / model.standard_errors[n] for n in true}
    assert max(map(abs, off.values())) < 3.5, off


def test_a_lag_is_none_and_process_noise_alone_is_none():
    plain = OutputErrorSettings()
    for recording, vehicle in (
        (driven({"latency": 0.1, "lag": 0.3}), twin()),
        # the boat has a drag that the model lacks
        (driven({"latency": 0.1, "lag": 0.3}), twin().with_terms([t for t in twin().structure.terms if str(t.coefficient) != "X_uu"])),
    ):  # fmt: skip
        at = first_maximum([recording], vehicle)
        assert with_slew_rate(at, vehicle, plain) is None
        assert not [
            f
            for f in select_stages(at, vehicle, plain, 0.0)[1]
            if f.kind is FindingKind.SLEW_RATE_SELECTED
        ]


def test_a_stated_rate_is_kept_and_an_open_one_is_estimated():
    recording = driven({"latency": 0.1, "slew_rate": 1.0})
    stated = seatrial.identify([recording], twin({"slew_rate": 1.0}))
    assert not stated.findings_of(FindingKind.SLEW_RATE_SELECTED)
    assert stated.standard_errors["slew_rate"] == 0.0
    sought = seatrial.identify([recording], twin({"slew_rate": "estimate"}))
    error = sought.standard_errors["slew_rate"]
    assert sought.parameter_values["slew_rate"] == pytest.approx(1.0, abs=3.5 * error)
    assert sought.units["slew_rate"] == "1/s"
    assert 0.0 < error < 0.01


@pytest.mark.parametrize("wrong", [0, -1.0])
def test_a_rate_is_above_zero(wrong):
    with pytest.raises(SeatrialError, match=r"slew_rate: expected a number > 0"):
        twin({"slew_rate": wrong})


def test_no_plan_of_mpc_is_quicker():
    """Full ahead is wanted at once; the slew rate is what holds it."""
    controller = Nmpc(boat_of(twin({"slew_rate": 0.8, "latency": 0.1})))
    controller.command(0.0, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], straight(PATH_GRID.times, speed=1.0))
    layout = Layout(2, PATH_GRID.stages)
    plan = controller._plan
    levels = [plan[k * layout.block + MOTION_SIZE :][:2] for k in range(PATH_GRID.stages)]
    moved = np.array([plan[layout.thrust(k)] for k in range(PATH_GRID.stages)]) - levels
    assert np.abs(moved).max() == pytest.approx(0.8 * PATH_GRID.length, rel=1e-2)
