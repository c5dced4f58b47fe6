# SPDX-License-Identifier: MIT
"""Whether commands beside the poses are samples, by the likelihood, with terms that the user states."""

from dataclasses import replace

import numpy as np
import pytest
from recording_tools import beside_poses

import seatrial
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.schema import ChainGroup
from seatrial.identification.first_search import first_maximum
from seatrial.identification.selection.command_sampling import (
    LEAST_SAMPLING_GAIN,
    sampled_commands_of,
    stated_sampling,
)
from seatrial.recording.signal import Signal
from seatrial.workflow.next_step import after_identify
from tests.boats.hulls import MIDDLE, TICK, driven, sticks
from tests.test_sampled_commands import LAG, PERIOD, sampled


@pytest.fixture(scope="module")
def boat():
    """A vehicle, and two drives of it whose commands are samples."""
    vehicle, recordings = driven(MIDDLE, {"lag": LAG}, seed=3, white=0.003, drives=1)
    return vehicle, [sampled(r) for r in recordings]


def test_a_model_of_the_users_terms_says_so_where_the_recordings_show_it(boat):
    vehicle, recordings = boat
    looked_at = [replace(r, command_sampled=False) for r in recordings]
    model = seatrial.identify(looked_at, vehicle)
    (finding,) = model.findings_of(FindingKind.COMMANDS_LOOK_SAMPLED)
    assert finding.number("gain") > 100.0
    assert not model.warnings
    step = after_identify(model)
    assert step.do.startswith("State 'sampled: true' under 'commands:'")
    again = seatrial.identify(looked_at, vehicle.with_sampled_commands())
    assert not again.findings_of(FindingKind.COMMANDS_LOOK_SAMPLED)
    assert not again.warnings
    # changes at their rows
    _, changed = driven(MIDDLE, {"lag": LAG}, seed=3, white=0.003, drives=1)
    exact = seatrial.identify([beside_poses(r, PERIOD) for r in changed], vehicle)
    assert not exact.findings_of(FindingKind.COMMANDS_LOOK_SAMPLED)
    assert exact.warnings


def test_under_model_mismatch_the_doubt_stays(boat, monkeypatch):
    vehicle, recordings = boat
    looked_at = [beside_poses(replace(r, command_sampled=False), PERIOD) for r in recordings]
    found = (finding_of(FindingKind.MODEL_MISMATCH, horizon=0.8),)
    monkeypatch.setattr("seatrial.identification.methods._findings", lambda *_: found)
    model = seatrial.identify(looked_at, vehicle)
    assert not model.findings_of(FindingKind.COMMANDS_LOOK_SAMPLED)
    assert all("If a logger sampled them" in doubt for doubt in model.warnings)
    assert len(model.warnings) == len(looked_at)


def test_half_a_row_of_time_does_not_stand_for_an_error_of_a_stated_latency(boat):
    vehicle, _ = boat
    _, changed = driven(MIDDLE, {"lag": LAG}, seed=3, white=0.003, drives=1)
    exact = [replace(r, command_period=0.1) for r in changed]
    early = vehicle.with_chain([ChainGroup(latency=0.05)])
    assert stated_sampling(exact, early) == (early, ())


ROW, TICKS = 0.04, 2  # of the commands: [s], and in ticks of the drive


def with_slew_rate(rng, seconds):
    """Commands that change with a row at most, as the thrusters follow them: by 2.5 a second at most."""
    wanted = np.repeat(sticks(rng, seconds)[::TICKS], TICKS, axis=0)
    thrust = np.zeros_like(wanted)
    for i in range(1, len(wanted)):
        thrust[i] = thrust[i - 1] + np.clip(wanted[i] - thrust[i - 1], -2.5 * TICK, 2.5 * TICK)
    return thrust


def test_thrust_at_a_limited_slew_rate_is_no_samples():
    """It is off after each change, too, but by more than an error of a row's time."""
    none = {"lag": 0.0}
    vehicle, (followed,) = driven(
        MIDDLE, none, seed=4, white=0.01, drives=1, pattern=with_slew_rate
    )
    wanted = sticks(np.random.default_rng([4, 0]), 120.0)[::TICKS]
    known = Signal(followed.commands.names, followed.commands.stamps[::TICKS], wanted)
    exact = beside_poses(replace(followed, commands=known), ROW)
    at = first_maximum([exact], vehicle)
    there = first_maximum([exact], vehicle.with_sampled_commands())
    assert at.runs.cost - there.runs.cost > LEAST_SAMPLING_GAIN
    assert sampled_commands_of(at, vehicle) is None
