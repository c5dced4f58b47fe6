# SPDX-License-Identifier: MIT
"""What stands between boat and sensor, or differs between recordings: planted, then found."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

import seatrial
from seatrial.errors import SeatrialError
from seatrial.identify.output_error import OutputErrorSettings, fit
from seatrial.identify.solution import with_lever
from seatrial.identify.text import plus_minus, summary
from seatrial.io.poses import in_vehicle_terms
from seatrial.plan import load_plan, with_seed
from seatrial.simulate import plant_model, simulate

LEVER = np.array([0.25, -0.08])  # [m]
CURRENTS = {"S1": (0.03, -0.02), "S2": (-0.01, 0.015), "S3": (0.0, 0.02)}  # [m/s]


@pytest.fixture(scope="module")
def known():
    plan = with_seed(load_plan("paper-like"), 11)
    vehicle = seatrial.load_vehicle("mallard-mp")
    found = [t.recording for t in simulate(plan, vehicle) if t.name[:2] in CURRENTS]
    return plan, vehicle, found


def within(found, name, truth, sigmas=4.5):
    """The estimate is within its own standard errors of the truth, and these say something."""
    k = found.names.index(name)
    error = float(np.sqrt(found.covariance[k, k]))
    assert 0.0 < error < 0.01, name
    assert found.theta[found.problem.free[k]] == pytest.approx(truth, abs=sigmas * error), name


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
    assert "standard errors of the lever arm: " in said
    error = found.errors[f"current_x.{first.name}"]
    assert f"current_x {plus_minus(first.effects['current_x'], error)}, current_y" in said


def test_trim_is_found_in_every_recording(known):
    plan, vehicle, _ = known
    lines = {**vehicle.structure.lines()}
    lines["sway"] = [*lines["sway"], "Y_0"]
    leaning = replace(vehicle, file=msgspec.structs.replace(vehicle.file, structure=lines))
    pushed = {**plan.plant.coefficients, "Y_0": 0.01}
    given = msgspec.structs.replace(plan.plant, coefficients=pushed)
    truth = plant_model(msgspec.structs.replace(plan, plant=given), leaning)
    trials = [t for t in simulate(plan, leaning, truth) if t.name[:2] in CURRENTS]
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
