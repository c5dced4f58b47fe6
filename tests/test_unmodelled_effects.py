# SPDX-License-Identifier: MIT
"""Effects that nobody asked for: named where they act, and only there."""

import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import at_length, on_request
from survey_boat import TRUTH, both, driven

import seatrial
from seatrial.boat.findings import FindingKind, finding_text
from seatrial.identification.diagnostics.unmodelled_effects import EFFECTS_FOUND
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.identification.regression.start_values import lever_from_poses
from seatrial.identification.selection.terms import select, selection_text
from seatrial.recording.from_poses import make_recording
from seatrial.recording.origin import poses_of_origin
from seatrial.simulation.plan import DisturbanceForce
from seatrial.util.errors import IdentificationError
from tests.boats import hulls
from tests.boats.plans import driven_by, planned


def drives(change=None, seeds=(1, 2), **keys):
    """The vehicle, and recordings of 100 s each; change: (recording, eta) -> eta."""
    found = []
    for seed in seeds:
        vehicle, drive = driven(
            {"dead_zone": {"forward": 0.0, "reverse": 0.0}},
            [both, both, both],
            bow=True,
            seconds=100.0,
            seed=seed,
            **keys,
        )
        eta = drive.raw if change is None else change(drive, drive.raw.copy())
        found.append(make_recording(f"drive {seed}", drive.stamps, eta, drive.commands))
    return vehicle, found


def off_by(lever):
    """Poses of a point off the origin."""

    def change(drive, eta):
        c, s = np.cos(eta[:, 2]), np.sin(eta[:, 2])
        eta[:, 0] += c * lever[0] - s * lever[1]
        eta[:, 1] += s * lever[0] + c * lever[1]
        return eta

    return change


def carried(velocity):
    """Poses in water that moves."""

    def change(drive, eta):
        eta[:, :2] += drive.t[:, None] * velocity
        return eta

    return change


def sheared(rate):
    """Poses in water that flows along x, by `rate` [1/s] faster with y, not on average; 15 s are lost."""

    def change(drive, eta):
        aside = eta[:, 1] - eta[:, 1].mean()
        eta[:, 0] += np.cumsum(rate * aside * np.diff(drive.t, prepend=0.0))
        eta[(drive.t > 40.0) & (drive.t < 55.0)] = np.nan
        return eta

    return change


def turning(speed, period):
    """Poses in water whose flow turns with the time."""

    def change(drive, eta):
        phase = 2.0 * np.pi * drive.t / period
        flow = speed * np.column_stack([np.sin(phase), np.cos(phase)])
        eta[:, :2] += np.cumsum(flow * np.diff(drive.t, prepend=0.0)[:, None], axis=0)
        return eta

    return change


def pushed(sd, memory):
    """Poses pushed about by velocities that come and go."""

    def change(drive, eta):
        rng = np.random.default_rng(7)
        keep = np.exp(-np.diff(drive.t) / memory)
        off = np.zeros((len(drive.t), 2))
        for i, k in enumerate(keep):
            off[i + 1] = k * off[i] + np.sqrt(1 - k * k) * sd * rng.normal(size=2)
        eta[:, :2] += np.cumsum(off * np.diff(drive.t, prepend=0.0)[:, None], axis=0)
        return eta

    return change


def told(recordings, vehicle):
    """What is said of effects, be it in a refusal."""
    try:
        return " ".join(map(finding_text, asked(output_error(recordings, vehicle))))
    except IdentificationError as error:
        return str(error)


def asked(model):
    return model.findings_of(*EFFECTS_FOUND)


@pytest.mark.parametrize("lever", [(-0.05, 0.1), on_request((0.3, 0.0)), at_length((0.5, 0.2))])
def test_a_lever_arm_is_named_with_its_length(lever):
    vehicle, recordings = drives(off_by(lever))
    note = told(recordings, vehicle)
    found = float(re.search(r"about ([\d.]+) m off the origin", note)[1])
    assert found == pytest.approx(np.hypot(*lever), rel=0.1)
    assert "--effect lever" in note


@pytest.mark.system
def test_a_current_is_named_with_its_speed():
    vehicle, recordings = drives(carried(np.array([0.08, -0.06])))
    (finding,) = asked(output_error(recordings, vehicle))
    assert finding.kind is FindingKind.UNMODELLED_CURRENT
    assert finding.number("size") == pytest.approx(0.1, rel=0.1)
    assert "--effect current" in finding_text(finding)


def test_a_current_that_differs_between_places_is_named():
    vehicle, recordings = drives(sheared(0.02))
    (finding,) = asked(output_error(recordings, vehicle))
    assert finding.kind is FindingKind.UNEVEN_CURRENT
    places = [r.eta[r.valid, 1] for r in recordings]
    largest = 0.02 * max(float(np.abs(y - y.mean()).max()) for y in places)
    assert finding.number("size") == pytest.approx(largest, rel=0.5)  # of block means, a first step


@pytest.mark.parametrize("seed", [1, *(at_length(seed) for seed in range(2, 6))])
def test_a_current_that_turns_with_the_time_is_named(seed):
    vehicle, drive = driven({}, [both, both, both], bow=True, seconds=300.0, seed=seed)
    eta = turning(0.1, 300.0)(drive, drive.raw.copy())
    recording = make_recording("drive", drive.stamps, eta, drive.commands)
    (finding,) = asked(output_error([recording], vehicle))
    assert finding.kind is FindingKind.UNEVEN_CURRENT
    assert 0.1 < finding.number("size") < 0.2  # a first step, and ends of a polynomial


def test_nothing_is_named_where_nothing_acts_or_what_acts_is_none_of_these():
    vehicle, recordings = drives()
    assert asked(output_error(recordings, vehicle)) == ()
    vehicle, recordings = drives(pushed(0.03, 3.0))
    model = output_error(recordings, vehicle)
    assert max(model.noise.process.walk_linear, model.noise.process.disturbance_linear) > 1e-3
    assert asked(model) == ()


@pytest.mark.system
def test_what_is_sought_is_not_named():
    vehicle, recordings = drives(off_by((0.3, 0.0)))
    model = output_error(recordings, vehicle, settings=OutputErrorSettings(effects=("lever",)))
    assert asked(model) == ()
    assert model.vehicle.file.pose.lever == pytest.approx((0.3, 0.0), abs=0.01)


@pytest.mark.system
def test_select_says_it_beside_the_terms_that_stand_for_it():
    vehicle, recordings = drives(off_by((-0.05, 0.1)), seeds=(1, 2, 3, 4))
    found = select(recordings, vehicle, candidates=[])
    assert [finding.kind for finding in found.asked] == [FindingKind.UNMODELLED_LEVER_ARM]
    assert "--effect lever" in selection_text(found).splitlines()[-1]


@pytest.mark.parametrize("lever", [(0.2, -0.1), (1.5, 0.8), (-4.0, 2.0)])
def test_the_lever_arm_to_start_from_is_close_however_long_it_is(lever):
    vehicle, recordings = drives(off_by(lever))
    assert lever_from_poses(recordings, vehicle) == pytest.approx(
        lever, abs=0.05 + 0.02 * np.hypot(*lever)
    )


@pytest.mark.system
@pytest.mark.parametrize("seed", [1, on_request(4), on_request(5)])
def test_a_long_lever_arm_is_found(seed):
    vehicle, recordings = drives(off_by((1.5, 0.8)), seeds=(seed, seed + 10))
    settings = OutputErrorSettings(effects=("lever",))
    model = output_error(recordings, vehicle, settings=settings)
    assert model.vehicle.lever == pytest.approx((1.5, 0.8), abs=0.01)
    for name, value in TRUTH.items():
        assert model.values[name] == pytest.approx(value, abs=4.5 * model.standard_errors[name])


def test_poses_of_the_origin_are_less_lever_and_current():
    _, (drive,) = drives(seeds=(3,))
    lever, current = np.array([0.4, -0.2]), np.array([0.05, 0.02])
    moved = off_by(lever)(drive, drive.eta.copy())
    moved[:, :2] += drive.t[:, None] * current
    back = poses_of_origin(replace(drive, eta=moved), lever, current)
    np.testing.assert_allclose(back.eta, drive.eta, atol=1e-9)
    assert poses_of_origin(drive, np.zeros(2)) is drive


@pytest.mark.system
@pytest.mark.parametrize("seed", [2, on_request(5), on_request(7)])
def test_steady_wind_beside_gusts_is_named(seed):
    """Gusts hide it in the process noise, most of which stays; drag in yaw is 2.8 standard errors off without."""
    gusts = DisturbanceForce(0.03, 2.0, earth_fixed=True)
    vehicle, drives = hulls.driven(
        hulls.MIDDLE, {"latency": 0.1, "lag": 0.1},
        seed=seed, push=gusts, white=5e-3, rate=10.0, wind=(0.04, 0.02),
    )  # fmt: skip
    model = output_error(drives, vehicle)
    assert model.findings_of(FindingKind.UNMODELLED_WIND)
    named = output_error(drives, vehicle, settings=OutputErrorSettings(effects=("wind",)))
    wind = [[r.effects["wind_x"], r.effects["wind_y"]] for r in named.recordings]
    np.testing.assert_allclose(wind, [[0.04, 0.02]] * 2, atol=0.02)
    assert len(named.findings_of(FindingKind.UNMODELLED_WIND)) == 0


def test_a_late_heading_is_named_where_it_looks_like_a_model_mismatch():
    """Headings of an autopilot's filter on a lake: the fit of 1 s predictions has no process noise to show it."""
    plan = planned("lake", "L1", "L2", "L3", pose={"heading_delay": 0.3})
    vehicle = seatrial.load_vehicle("twin-thruster")
    model = seatrial.identify(driven_by(plan, vehicle), vehicle)
    assert model.findings_of(FindingKind.MODEL_MISMATCH)
    (delay,) = model.findings_of(FindingKind.UNMODELLED_DELAY)
    assert delay.number("size") == pytest.approx(0.3, abs=0.03)
