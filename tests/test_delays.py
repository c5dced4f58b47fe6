# SPDX-License-Identifier: MIT
"""Delays of sensors: positions and headings that are older than their stamps."""

from dataclasses import replace
from functools import partial

import msgspec
import numpy as np
import pytest
from conftest import at_length, make_model, on_request
from survey_boat import TRUTH, as_stated, both
from survey_boat import driven as surveyed

import seatrial
from seatrial.boat.findings import FindingKind, finding_text
from seatrial.boat.model_file import load, save
from seatrial.boat.schema import NoiseEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.console import summary
from seatrial.identification.estimator import OutputErrorSettings, fit, output_error
from seatrial.onboard.predictor import Health, Predictor, Taken
from seatrial.simulation.plan import DisturbanceForce, DropOuts, Jumps, load_plan
from seatrial.simulation.sensors import PoseSettings, Sensors
from seatrial.simulation.trials import DisturbedPlant, simulate
from seatrial.util.errors import IdentificationError, SeatrialError
from tests.boats.hulls import MIDDLE, SMALL, driven

CHAIN = {"latency": 0.1, "lag": 0.2, "dead_zone": {"forward": 0.05, "reverse": 0.05}}
WHITE = 2e-3  # [m], [rad]
QUICK = replace(MIDDLE, thrust=20.0)  # more than 1 m/s
PLAIN = OutputErrorSettings(select_stages=False)
DELAY = OutputErrorSettings(effects=("delay",), select_stages=False)


def with_pose(vehicle, **keys):
    """The vehicle with further entries of its pose."""
    content = vehicle.to_mapping()
    return vehicle_from({**content, "pose": {**content["pose"], **keys}}, "boat")


@pytest.fixture(scope="module")
def older(once):
    """A boat whose positions are 0.2 s older than its headings: vehicle, recordings, the model with delays sought."""
    vehicle, recordings = driven(MIDDLE, CHAIN, seed=1, white=WHITE, late=(0.2, 0.0))
    make = partial(output_error, recordings, vehicle, settings=DELAY)
    return vehicle, recordings, once("delays-sought", lambda _: make())[1]


def standardised(model, truth):
    """Errors of the coefficients in standard errors."""
    return [(model.values[n] - x) / model.standard_errors[n] for n, x in truth.items()]


@pytest.mark.parametrize(
    ("pose", "delays", "estimated"),
    [
        ({}, (0.0, 0.0), (False, False)),
        ({"delay": 0.2}, (0.2, 0.2), (False, False)),
        ({"delay": 0.2, "heading_delay": 0}, (0.2, 0.0), (False, False)),
        ({"heading_delay": 0.1}, (0.0, 0.1), (False, False)),
        ({"delay": "estimate", "heading_delay": 0.1}, (0.1, 0.1), (True, False)),
        ({"delay": 0.3, "heading_delay": "estimate"}, (0.3, 0.3), (False, True)),
        ({"heading_delay": "estimate"}, (0.0, 0.0), (False, True)),
        ({"delay": "estimate"}, (0.0, 0.0), (True, True)),
    ],
)
def test_what_a_vehicle_file_states_of_delays(pose, delays, estimated):
    vehicle = with_pose(MIDDLE.vehicle([]), **pose)
    assert vehicle.delays == delays
    assert vehicle.estimated_delays == estimated
    assert vehicle_from(vehicle.to_mapping(), "again").delays == delays


@pytest.mark.parametrize("value", [5.5, -6, "soon", [0.1]])
def test_a_delay_that_is_none_is_refused(value):
    with pytest.raises(SeatrialError, match="delay"):
        with_pose(MIDDLE.vehicle([]), delay=value)


@pytest.mark.parametrize(
    ("hull", "late"),
    [
        (MIDDLE, (0.2, 0.0)),
        at_length(SMALL, (0.0, 0.2)),
        on_request(MIDDLE, (0.0, 0.2)),
        on_request(SMALL, (0.2, 0.0)),
    ],
)
def test_a_difference_of_delays_is_recovered_within_its_standard_error(hull, late):
    off, coefficients = [], []
    for seed in (2, 3):
        vehicle, recordings = driven(hull, CHAIN, seed=seed, white=WHITE, late=late)
        found = fit(recordings, vehicle, settings=DELAY)
        model = found.model()
        position, heading = model.vehicle.delays
        error = found.errors["delay_position"]
        assert error < 5e-4
        off.append((position - heading - (late[0] - late[1])) / error)
        coefficients += standardised(model, hull.coefficients)
        # a delay of both is in the latency
        assert latency_of(model) == pytest.approx(CHAIN["latency"] + late[1], abs=0.005)
    assert np.abs(off).max() < 3.5
    assert np.sqrt(np.mean(np.square(off))) < 1.8
    assert np.sqrt(np.mean(np.square(coefficients))) < 1.5


def latency_of(model):
    return dict(zip(model.vehicle.constants.names, model.constants, strict=True))["latency"]


@pytest.mark.system
def test_so_it_is_with_poses_of_a_satellite_receiver_and_a_compass():
    off = []
    for seed in range(1, 4):
        vehicle, recording = gnss(seed)
        found = fit(
            [recording], with_pose(vehicle, delay="estimate", heading_delay=0), settings=PLAIN
        )
        model = found.model()
        error = found.errors["delay_position"]
        assert error < 0.006
        off.append((model.vehicle.delays[0] - 0.25) / error)
        assert as_stated(model, TRUTH) == {}
    assert np.abs(off).max() < 3.0


def gnss(seed, late=(0.25, 0.0)):
    """5 Hz positions good to 2 cm, headings to 5 mrad."""
    return surveyed(
        {"dead_zone": {"forward": 0.0, "reverse": 0.0}},
        [both] * 3,
        bow=True,
        seconds=300.0,
        seed=seed,
        stamps=lambda _, seconds: np.arange(0.0, seconds, 0.2),
        noise=np.array([0.02, 0.02, 0.005]),
        late=late,
    )


@pytest.mark.system
def test_so_it_is_where_the_boat_is_pushed():
    push = DisturbanceForce(0.05, 5.0)
    vehicle, recordings = driven(SMALL, CHAIN, seed=1, white=5e-3, late=(0.2, 0.0), push=push)
    found = fit(recordings, vehicle, settings=DELAY)
    assert found.noise[4] > 1e-2  # process noise
    error = found.errors["delay_position"]
    assert error < 0.01
    assert abs(found.model().vehicle.delays[0] - 0.2) < 3.0 * error


@pytest.mark.system
def test_coefficients_that_are_off_without_are_right_with_it():
    vehicle, recordings = driven(SMALL, CHAIN, seed=2, white=WHITE, late=(0.2, 0.0))
    off = {
        effects: np.abs(
            standardised(
                output_error(recordings, vehicle, settings=replace(DELAY, effects=effects)),
                SMALL.coefficients,
            )
        ).max()
        for effects in ((), ("delay",))
    }
    assert off[()] > 4.0
    assert off[("delay",)] < 3.5


def test_a_stated_difference_is_as_good_as_an_estimated_one(older):
    """The recording knows it: nothing is estimated, and nothing is off."""
    vehicle, recordings, sought = older
    stated = [replace(r, position_delay=0.2) for r in recordings]
    model = output_error(stated, with_pose(vehicle, delay=0.2, heading_delay=0.0), settings=PLAIN)
    assert np.abs(standardised(model, MIDDLE.coefficients)).max() < 3.5
    assert model.vehicle.delays == (0.2, 0.0)
    errors = [sought.standard_errors[n] for n in MIDDLE.coefficients]
    change = [model.values[n] - sought.values[n] for n in MIDDLE.coefficients]
    assert np.abs(np.array(change) / errors).max() < 2.0


def test_a_common_delay_is_estimated_only_beside_a_stated_latency():
    vehicle, recordings = driven(SMALL, CHAIN, seed=3, white=WHITE, late=(0.2, 0.1))
    both = with_pose(vehicle, delay="estimate")
    with pytest.raises(IdentificationError, match="indistinguishable from the thrusters' latency"):
        output_error(recordings, both, settings=PLAIN)
    known = vehicle_from({**both.to_mapping(), "chain": [{"latency": 0.1}]}, "boat")
    found = fit(recordings, known, settings=PLAIN)
    model = found.model()
    for name, delay, truth in zip(found.names[-2:], model.vehicle.delays, (0.2, 0.1), strict=True):
        assert abs(delay - truth) < 3.5 * found.errors[name]
        assert found.errors[name] < 2e-3
    assert model.constants[model.vehicle.constants.names.index("latency")] == 0.1
    said = [finding_text(f) for f in model.findings_of(FindingKind.DELAY)]
    assert [text.partition(" is ")[0] for text in said] == [
        "sensor delays: the position",
        "sensor delays: the heading",
    ]


def test_the_model_file_keeps_what_was_found(older, tmp_path):
    vehicle, _, model = older
    save(model, tmp_path / "model.yaml")
    again = load(tmp_path / "model.yaml")
    assert again.vehicle.delays == pytest.approx(model.vehicle.delays)
    (found,) = again.findings_of(FindingKind.DELAY_DIFFERENCE)
    assert found.subject == ("position", "heading")
    assert found.number("delay") == pytest.approx(0.2, abs=2e-3)
    assert "0.200 ±" in finding_text(found)
    assert "latency" in finding_text(found)
    assert "sensor delays" in summary(again)
    # the vehicle file that it was sought from states none: its recordings are read with the model's
    assert again.with_vehicle(vehicle).vehicle.delays == pytest.approx(model.vehicle.delays)
    other = with_pose(vehicle, delay=0.05)
    assert again.with_vehicle(other).vehicle.delays == (0.05, 0.05)


@pytest.mark.system
def test_a_delay_that_nobody_stated_is_reported(older):
    vehicle, recordings, _ = older
    model = output_error(recordings, vehicle)
    (found,) = model.findings_of(FindingKind.UNMODELLED_DELAY)
    assert found.number("size") == pytest.approx(0.2, abs=0.03)
    assert "--effect delay" in finding_text(found)


def test_where_there_is_none_none_is_reported_and_a_sought_one_is_zero():
    vehicle, recordings = driven(MIDDLE, CHAIN, seed=1, white=WHITE)
    assert output_error(recordings, vehicle).findings_of(FindingKind.UNMODELLED_DELAY) == ()
    found = fit(recordings, vehicle, settings=DELAY)
    assert abs(found.model().vehicle.delays[0]) < 3.0 * found.errors["delay_position"]


def sailing(late, *, lever=(0.0, 0.0), noise=0.01, stated=None):
    """A predictor of QUICK at full speed with turns, given its poses late; errors (n, 3) of its answer now."""
    vehicle = with_pose(QUICK.vehicle([CHAIN]), lever=list(lever), **(stated or {}))
    model = replace(make_model(vehicle, QUICK.coefficients), noise=NoiseEntry(noise, noise))
    rng = np.random.default_rng(1)
    boat = make_model(QUICK.vehicle([CHAIN]), QUICK.coefficients)
    plant = DisturbedPlant(boat, None, rng)
    odometer = seatrial.Odometer(model)
    states, errors, past = [], [], 1000
    for i in range(past, past + 1500):  # 30 s at 50 Hz
        plant.advance_to(0.02 * (i - past))
        states.append(plant.state.copy())
        command = np.array([1.0, 0.0, 0.15 * np.sin(0.02 * i)])
        plant.command(0.02 * (i - past), command)
        odometer.command(20_000_000 * i, command)
        if i % 10 == 0:  # 5 Hz
            before = [states[max(0, len(states) - 1 - round(50 * d))] for d in late]
            c, s = np.cos(before[0][2]), np.sin(before[0][2])
            arm = [c * lever[0] - s * lever[1], s * lever[0] + c * lever[1]]
            pose = np.array([*(before[0][:2] + arm), before[1][2]]) + noise * rng.normal(size=3)
            assert odometer.pose(20_000_000 * i, pose) == Taken.USED
        if i > past + 500:
            now = odometer.look(20_000_000 * i)
            errors.append(now.pose - states[-1][:3])
            if stated is not None:
                assert not now.health & (Health.GATE_REJECTING | Health.DEAD_RECKONING)
    errors = np.array(errors)
    errors[:, 2] = (errors[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    return errors, np.hypot(*np.array(states)[500:, 3:5].T).mean()


@pytest.mark.parametrize(
    ("late", "stated"),
    [
        ((0.2, 0.0), {"delay": 0.2, "heading_delay": 0.0}),
        ((0.0, 0.2), {"delay": 0.0, "heading_delay": 0.2}),
        ((0.2, 0.2), {"delay": 0.2}),
        ((0.3, 0.1), {"delay": 0.3, "heading_delay": 0.1}),
    ],
)
@pytest.mark.parametrize("lever", [(0.0, 0.0), (0.4, -0.1)])
def test_the_predictor_answers_with_the_motion_of_now(late, stated, lever):
    errors, speed = sailing(late, lever=lever, stated=stated)
    assert speed > 1.0  # [m/s]
    size = np.sqrt(np.mean(errors**2, axis=0))
    assert size[:2].max() < 0.01  # [m] the noise of one pose
    assert size[2] < 0.015  # [rad] 0.2 s after one


def test_without_it_the_predictor_is_late_by_the_delay():
    errors, speed = sailing((0.2, 0.0))
    assert np.hypot(*errors[:, :2].T).mean() > 0.5 * 0.2 * speed


def test_the_predictor_finds_a_boat_that_was_carried_away():
    """Position and heading are two measurements: both are rejected, then both are followed."""
    vehicle = with_pose(MIDDLE.vehicle([CHAIN]), delay=0.2, heading_delay=0.0)
    model = replace(make_model(vehicle, MIDDLE.coefficients), noise=NoiseEntry(0.01, 0.01))
    predictor = Predictor(model)
    places = [0.0, 0.0, 0.0], [2.0, 1.0, 0.5], [2.0, 1.0, -0.5], [-3.0, 0.0, -0.5]
    for k, away in enumerate(places):
        for t in 5.0 * k + np.arange(0.0, 5.0, 0.1):
            predictor.command(t, [0.0, 0.0, 0.0])
            assert predictor.pose(t, away) == Taken.USED
        now = predictor.at(5.0 * k + 5.0)
        assert np.abs(now.pose - away).max() < 0.02
        assert not now.health & (Health.NO_POSE | Health.GATE_REJECTING)


def test_the_simulators_sensors_are_as_late_as_the_vehicle_file_states():
    vehicle = with_pose(MIDDLE.vehicle([CHAIN]), delay=0.2, heading_delay=0.05, lever=[0.3, 0.1])
    model = make_model(vehicle, MIDDLE.coefficients)
    exact = PoseSettings(10.0, 0.0, 0.0, stamp_jitter=0.0, delay=0.0)
    boat = seatrial.Simulator(model, sensors=Sensors(exact, None, None))
    boat.command([1.0, 0.0, 0.7])
    states, seen = {0: np.concatenate([boat.eta, boat.nu])}, []
    for k in range(1, 1000):
        readings = boat.advance_to(0.005 * k)
        states[k] = boat.eta.copy()
        seen += [(k, r) for r in readings]
    assert len(seen) > 40
    for k, reading in seen[5:]:
        position, heading = states[k - 40], states[k - 10]
        c, s = np.cos(position[2]), np.sin(position[2])
        arm = [0.3 * c - 0.1 * s, 0.3 * s + 0.1 * c]
        assert reading.stamp == pytest.approx(0.005 * k)
        assert reading.eta[:2] == pytest.approx(position[:2] + arm, abs=1e-4)
        assert np.cos(reading.eta[2] - heading[2]) == pytest.approx(1.0, abs=1e-8)


def test_a_plans_poses_are_late_as_it_says():
    plan = load_plan("clean")
    sensor = msgspec.structs.replace(
        plan.pose, position_noise=0.0, heading_noise=0.0, stamp_jitter=0.0,
        drop_outs=DropOuts(0.0), jumps=Jumps(0.0),
    )  # fmt: skip
    late = msgspec.structs.replace(sensor, position_delay=0.2)
    short = {"S1": msgspec.structs.replace(plan.trials["S1"], duration=20.0)}
    vehicle = seatrial.load_vehicle(plan.vehicles[0])
    exact, delayed = (
        next(simulate(msgspec.structs.replace(plan, pose=p, trials=short), vehicle))
        for p in (sensor, late)
    )
    assert np.allclose(exact.truth, delayed.truth, atol=1e-6)
    assert np.allclose(exact.pose[:, 2], delayed.pose[:, 2], atol=1e-6)
    places = np.column_stack(
        [np.interp(exact.truth_t - 0.2, exact.truth_t, x) for x in exact.pose[:, :2].T]
    )
    assert np.abs(delayed.pose[:, :2] - places).max() < 2e-3
    assert np.abs(delayed.pose[:, :2] - exact.pose[:, :2]).max() > 0.02
