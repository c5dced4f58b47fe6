# SPDX-License-Identifier: MIT
"""Thrusters that do not thrust alike: named with their gains, and only where commands tell them apart."""

from dataclasses import replace

import numpy as np
import pytest
from survey_boat import TRUTH, boat, driven
from test_unmodelled_effects import asked, both

from seatrial.boat.findings import FindingKind, finding_text
from seatrial.boat.schema import ChainGroup, ScaleUse
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.diagnostics.thruster_gains import GainProblem, with_gains
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.identification.problem_setup import problem_with
from seatrial.identification.selection.actuator_stages import with_free_stages
from seatrial.recording.signal import Signal

GAINS = {"left": 1.15, "right": 0.85}
NONE = {"dead_zone": {"forward": 0.0, "reverse": 0.0}}


def drives(gains, seeds=(1, 2), sizes=(both, both, both)):
    curve = [{"name": "props", "gains": gains}, {"name": "edges", **NONE}] if gains else NONE
    found = [driven(curve, sizes, bow=True, seconds=100.0, seed=seed) for seed in seeds]
    return found[0][0], [recording for _, recording in found]


def gains_in(finding):
    return dict(zip(finding.subject, finding.values["gains"], strict=True))


@pytest.fixture(scope="module")
def weak_propeller():
    vehicle, recordings = drives(GAINS)
    return vehicle, recordings, output_error(recordings, vehicle)


def test_gains_are_named_as_the_vehicle_file_takes_them(weak_propeller):
    _, recordings, model = weak_propeller
    (finding,) = asked(model)
    assert finding.kind is FindingKind.UNEQUAL_THRUSTER_GAINS
    group = gains_in(finding)
    assert f"{{gains: {{left: {group['left']:.4g}, right: " in finding_text(finding)
    assert group == pytest.approx(GAINS, abs=0.01)
    assert np.mean(list(group.values())) == pytest.approx(1.0, abs=1e-12)
    stated = boat([{"name": "props", "gains": group}], bow=True)
    again = output_error(recordings, stated)
    assert asked(again) == ()
    got, errors = again.values, again.standard_errors
    assert {n: got[n] for n in TRUTH if abs(got[n] - TRUTH[n]) > 4.5 * errors[n]} == {}
    assert again.noise.process.disturbance_linear < 0.5 * model.noise.process.disturbance_linear


def test_a_prior_is_no_hindrance(weak_propeller):
    vehicle, _, model = weak_propeller
    _, (other,) = drives({"left": 0.9, "right": 1.1}, seeds=(3,))
    (finding,) = asked(output_error([other], vehicle, prior=model))
    assert gains_in(finding) == pytest.approx({"left": 0.9, "right": 1.1}, abs=0.03)


def test_alike_thrusters_are_not_named():
    vehicle, recordings = drives(None)
    assert asked(output_error(recordings, vehicle)) == ()


def problem(vehicle, recordings):
    whole = with_free_stages(vehicle, recordings)
    found = problem_with(whole, vehicle, recordings, OutputErrorSettings())
    return found, np.zeros(len(found.names))


def test_gains_are_sought_of_actuators_with_forces_in_common_but_of_one():
    vehicle, recordings = drives(None)
    before, theta = problem(vehicle, recordings)
    wider = with_gains(before, theta)
    assert wider.kinds == (("left", "right"),)  # the bow thruster's gain is its force's coefficient
    assert [wider.problem.names[i] for i in wider.places] == ["gain.right"]
    names = {wider.problem.names[i] for i in wider.problem.free}
    assert names == {before.names[i] for i in before.free} | {"gain.right"}
    assert dict(zip(wider.problem.names, wider.theta, strict=True))["gain.left"] == 1.0


def test_nothing_is_sought_where_commands_or_the_file_leave_nothing_to_seek():
    vehicle, recordings = drives(None)
    stated = boat([{"gains": GAINS}], bow=True)
    assert with_gains(*problem(stated, recordings)) is None
    still = drives(None, sizes=(both, lambda rng: 0.0, both))[1]  # right is never commanded
    assert with_gains(*problem(vehicle, still)) is None


@pytest.mark.parametrize("reference", [1.0, 3000.0])
def test_gains_are_sought_at_the_reference_of_a_known_scale(reference):
    """Of two propellers, one with its speed logged: what its unit is makes no difference."""
    plain, recordings = drives(None)
    content = plain.to_mapping()
    content["scales"] = {"rpm": {"column": "rpm", "reference": reference}}
    scaled = vehicle_from(content, "survey").with_chain(
        [ChainGroup(actuators=["left"], scale=ScaleUse("rpm", 2.0))]
    )
    known = [
        replace(r, scales=Signal(("rpm",), r.commands.stamps[:1], np.full((1, 1), reference)))
        for r in recordings
    ]
    wider = with_gains(*problem(scaled, known))
    assert wider is not None
    assert wider.kinds == (("left", "right"),)


@pytest.mark.parametrize(
    ("gains", "grouped"),
    [
        ([0.9, 0.88, 1.1, 1.12], True),  # fore and aft: as a force off the middle does
        ([1.07, 1.07, 0.796, 1.064], False),  # one propeller
        ([0.8, 1.2, 0.95, 1.05], False),
        ([0.9, 1.05, 1.05], False),
    ],
)
def test_a_weak_thruster_is_told_from_a_force_off_the_middle(gains, grouped):
    names = tuple(f"t{k}" for k in range(len(gains)))
    found = GainProblem(None, np.array(gains), (), (names,), 0)
    assert found.in_groups(np.array(gains)) is grouped
