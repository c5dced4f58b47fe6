# SPDX-License-Identifier: MIT
"""What stands between boat and sensor, or differs between recordings: planted, then found."""

import sys
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import at_length, on_request
from recording_tools import in_vehicle_terms
from survey_boat import TRUTH, blown
from test_model import frd

import seatrial
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.model_file import load, save
from seatrial.boat.noise_parameters import PROCESS, folded, noise_entry
from seatrial.evaluation.comparison.compare import drive_of
from seatrial.identification.console import plus_minus, summary
from seatrial.identification.diagnostics.unmodelled_effects import EFFECTS_FOUND
from seatrial.identification.estimator import OutputErrorSettings, fit, output_error
from seatrial.identification.likelihood.fit_horizon import likelihood_noise
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.solution import with_lever
from seatrial.recording.origin import poses_of_origin
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Axes
from tests.boats.plans import driven_by, planned

LEVER = np.array([0.25, -0.08])  # [m]
FAR = np.array([-8.0, 6.0])  # [m]
CURRENTS = {"S1": (0.03, -0.02), "S2": (-0.01, 0.015), "S3": (0.0, 0.02)}  # [m/s]


@pytest.fixture(scope="module")
def known():
    plan, vehicle = planned("paper-like", *CURRENTS, seed=11), seatrial.load_vehicle("mallard-mp")
    return plan, vehicle, driven_by(plan, vehicle)


def within(found, name, truth, sigmas=4.5):
    """The estimate is within its own standard errors of the truth, and these say something."""
    k = found.names.index(name)
    error = float(np.sqrt(found.covariance[k, k]))
    assert 0.0 < error < 0.01, name
    assert found.theta[found.problem.free[k]] == pytest.approx(truth, abs=sigmas * error), name


@pytest.mark.system
def test_lever_arm_and_currents_are_found_with_the_boat(known):
    plan, vehicle, recordings = known
    moved = []
    for recording in recordings:
        c, s = np.cos(recording.eta[:, 2]), np.sin(recording.eta[:, 2])
        flow = CURRENTS[recording.name[:2]]
        eta = recording.eta.copy()
        eta[:, 0] += c * LEVER[0] - s * LEVER[1] + flow[0] * recording.t
        eta[:, 1] += s * LEVER[0] + c * LEVER[1] + flow[1] * recording.t
        moved.append(replace(recording, eta=eta))
    found = fit(moved, vehicle, settings=OutputErrorSettings(effects=("lever", "current")))
    within(found, "lever_x", LEVER[0])
    within(found, "lever_y", LEVER[1])
    for recording in recordings:
        flow = CURRENTS[recording.name[:2]]
        within(found, f"current_x.{recording.name}", flow[0])
        within(found, f"current_y.{recording.name}", flow[1])
    for name, truth in plan.plant.coefficients.items():
        within(found, name, truth)
    model = found.model()
    np.testing.assert_allclose(model.vehicle.file.pose.lever, LEVER, atol=0.005)
    first = model.recordings[0]
    assert set(first.effects) == set(first.errors) == {"current_x", "current_y"}
    said = summary(model)
    assert "lever arm: standard errors are " in said
    error = found.errors[f"current_x.{first.name}"]
    assert f"current_x {plus_minus(first.effects['current_x'], error)}, current_y" in said
    assert "(z up, as in the model file: y to the left of x" in said
    # what it was identified at is of the origin, through the water
    still = fit(recordings, vehicle).model()
    for symbol, range_ in still.envelope.speeds.items():
        np.testing.assert_allclose(model.envelope.speeds[symbol], range_, atol=0.01)
    # a vehicle file without a lever does not put the measured point at the origin
    assert model.with_vehicle(vehicle).vehicle.same_origin(model.vehicle)
    errors = model.lever_errors
    assert errors == pytest.approx([found.errors["lever_x"], found.errors["lever_y"]], rel=1e-9)
    unsure = [finding_of(FindingKind.LEVER_ARM_ERRORS, ahead=0.01, aside=0.01)]
    unsure = replace(model, estimator=msgspec.structs.replace(model.estimator, findings=unsure))
    assert unsure.same_origin(replace(model, vehicle=with_lever(model.vehicle, 0.02, 0.0)))
    assert not model.same_origin(replace(model, vehicle=with_lever(model.vehicle, 0.02, 0.0)))
    nearly = replace(model, vehicle=with_lever(model.vehicle, 3e-5, 0.0))
    ways = [
        [m.vehicle.lever for m in drive_of(*pair)] for pair in ((model, nearly), (nearly, model))
    ]
    assert ways[0] == ways[1] == [ways[0][0]] * 2
    assert ways[0][0][0] == pytest.approx(model.vehicle.lever[0] + 1.5e-5, abs=1e-7)
    given = replace(nearly, estimator=msgspec.structs.replace(model.estimator, findings=[]))
    assert (
        drive_of(model, given)[0].vehicle.lever == nearly.vehicle.lever
    )  # how well it is known counts
    assert all(m.vehicle.same_origin(model.vehicle) for m in drive_of(model, nearly, vehicle))
    for stated in ((0.1, 0.0), (0.0, 0.0)):  # another sensor
        assert model.with_vehicle(vehicle.with_lever(stated)).vehicle.lever == stated


@pytest.mark.parametrize("axes", [on_request(Axes.FLU), at_length(Axes.FRD)])
def test_a_file_whose_lever_arm_was_corrected_does_not_bring_it_back(known, axes, tmp_path):
    """`validate --vehicle V` with the file that the model was identified with; another sensor's is its own."""
    _, vehicle, recordings = known
    told = (frd(vehicle) if axes is Axes.FRD else vehicle).with_lever((0.15, 0.05))
    read = [poses_of_origin(r.cut(0.0, 100.0), np.array([0.15, 0.05]) - LEVER) for r in recordings]
    model = output_error(read, told, settings=OutputErrorSettings(effects=("lever",)))
    np.testing.assert_allclose(model.vehicle.lever, LEVER, atol=0.005)
    save(model, tmp_path / "model.yaml")
    again = load(tmp_path / "model.yaml")
    assert again.with_vehicle(told).vehicle.lever == again.vehicle.lever
    for other in ((0.0, 0.0), (0.15, -0.05)):
        assert again.with_vehicle(told.with_lever(other)).vehicle.lever == pytest.approx(other)


@pytest.mark.system
def test_short_recordings_in_fast_water_each_find_their_own_current():
    """Every one begins at the velocity over ground, which is not that through the water."""
    plan = planned("hard", "S1", "S2", "S3", "S5", seed=8)
    vehicle, rng = seatrial.load_vehicle("mallard-mp"), np.random.default_rng(8)
    parts, flows = [], {}
    for trial in simulate(plan, vehicle):
        for begin in range(5, 190, 25):
            part = trial.recording.cut(begin, begin + 22.0)
            part = replace(part, name=f"{trial.name}-{begin}")
            flows[part.name] = rng.normal(0.0, 0.4, 2)
            eta = part.eta.copy()
            eta[:, :2] += part.t[:, None] * flows[part.name]
            parts.append(replace(part, eta=eta))
    found = fit(parts, vehicle, settings=OutputErrorSettings(effects=("current",)))
    for name, truth in plan.plant.coefficients.items():
        within(found, name, truth)
    for name, flow in flows.items():
        within(found, f"current_x.{name}", flow[0])
        within(found, f"current_y.{name}", flow[1])


@pytest.mark.system
def test_trim_is_found_in_every_recording(known):
    plan, vehicle, _ = known
    lines = {**vehicle.structure.lines()}
    lines["sway"] = [*lines["sway"], "Y_0"]
    leaning = replace(vehicle, file=msgspec.structs.replace(vehicle.file, structure=lines))
    truth = plant_model(planned(plan, coefficients={"Y_0": 0.01}), leaning)
    trials = simulate(plan, leaning, truth)
    found = fit(
        [t.recording for t in trials], vehicle, settings=OutputErrorSettings(effects=("trim",))
    )
    for trial in trials:
        within(found, f"trim_v.{trial.name}", 0.01)
        within(found, f"trim_u.{trial.name}", 0.0)


def test_a_lever_arm_in_the_file_is_taken_off_when_a_recording_is_read(known):
    _, vehicle, _ = known
    longer = with_lever(vehicle, 0.5, 0.0)
    raw = np.array([[1.0, 2.0, 0.0], [1.0, 2.0, np.pi / 2]])
    got = in_vehicle_terms(raw, longer)
    np.testing.assert_allclose(got[:, :2], [[0.5, 2.0], [1.0, 1.5]], atol=1e-12)


def test_effects_that_there_are_not_are_refused(known):
    _, vehicle, recordings = known
    with pytest.raises(SeatrialError, match="no effect 'waves'"):
        fit(recordings, vehicle, settings=OutputErrorSettings(effects=("waves",)))
    with pytest.raises(SeatrialError, match="effects belong to output-error"):
        seatrial.identify(recordings, vehicle, method="equation-error", effects=("lever",))


@pytest.mark.parametrize(("lever", "side"), [(0.0, 1.0), at_length(0.6, 1.0), (0.6, 2.5)])
def test_wind_is_found_where_the_boat_turns_between_poses(lever, side):
    """Off the centre of mass it turns the boat by its part across, by lever [rad/m]; it moves sway `side` times more.

    Side area over the mass in sway differs from frontal area over that in surge. With one force for both, process
    noise took the rest: errors of drag were 40 times larger, and X_u up to 5 of them off.
    """
    wind = 0.03, 0.05
    vehicle, recording = blown(wind, lever, side)
    found = fit([recording], vehicle, settings=OutputErrorSettings(effects=("wind",)))
    for name, truth in zip(("x", "y"), wind, strict=True):
        within(found, f"wind_{name}.blown", truth)
        within(found, f"wind_turn_{name}.blown", lever * truth)
        within(found, f"wind_side_{name}.blown", (side - 1.0) * truth)
    for name in ("X_u", "X_uu", "Y_v", "X_F"):
        assert found.errors[name] < 0.002, name
        place = found.problem.names.index(name)
        assert found.theta[place] == pytest.approx(
            TRUTH[name], abs=max(5.0 * found.errors[name], 0.003)
        ), name
    assert found.noise[PROCESS].max() < 1e-4 * side  # nothing but the wind pushed it
    # a filter on board does not know the wind: an earth-fixed disturbance of its mean square in the plane
    process = found.model().noise.process
    mean = np.hypot(*wind) / np.sqrt(2.0)
    both = np.sqrt(0.5 * (1.0 + side**2))
    assert process.disturbance_linear == pytest.approx(both * mean, rel=0.02)
    assert process.disturbance_yaw == pytest.approx(lever * mean, rel=0.02, abs=1e-3)
    assert process.walk_linear < 1e-4
    assert process.earth_fixed and process.memory > 25.0
    # the noise that a filter is to believe is that of a filter that knows of the wind
    plain = likelihood_noise(Point(found.theta, found.noise, found.runs), found.noise)
    assert plain[0] == pytest.approx(2e-3, rel=0.1)


def test_errors_that_hang_together_for_less_than_a_pose_are_white():
    noise = np.array([1e-5, 2e-3, 0.0, 0.0, 0.0, 0.0, 1.0, 3e-3, 1e-9, 0.03, 1e-9, 1.0])
    white = folded(noise, 0.2)
    assert white[0] == pytest.approx(np.hypot(1e-5, 3e-3)) and white[1] == pytest.approx(2e-3)
    assert noise_entry(white).correlated is None
    np.testing.assert_array_equal(folded(noise, 0.05), noise)


@pytest.mark.system
def test_a_lever_arms_search_that_begins_far_off_ends_no_elsewhere(known, monkeypatch):
    """The other begins at the solution without one; the likelier is kept."""
    _, vehicle, recordings = known
    moved = [poses_of_origin(recording.cut(0.0, 90.0), -LEVER) for recording in recordings]
    settings = OutputErrorSettings(effects=("lever",))
    usual = fit(moved, vehicle, settings=settings)
    module = sys.modules["seatrial.identification.problem_setup"]
    monkeypatch.setattr(module, "lever_from_poses", lambda *_: FAR)
    found = fit(moved, vehicle, settings=settings)
    for name in usual.names:
        k, free = usual.names.index(name), found.problem.free
        off = found.theta[free[found.names.index(name)]] - usual.theta[usual.problem.free[k]]
        assert abs(off) < 0.3 * np.sqrt(usual.covariance[k, k]), name
    levers = {"lever_x", "lever_y"}
    ended, usually = (
        {f for f in each.findings if set(f.subject) & levers or f.kind in EFFECTS_FOUND}
        for each in (found, usual)
    )
    assert ended == usually
