# SPDX-License-Identifier: MIT
"""Whether commands beside the poses are samples, by the likelihood, with terms that the user states."""

from dataclasses import replace

import pytest

import seatrial
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.schema import ChainGroup
from seatrial.identification.selection.command_sampling import stated_sampling
from seatrial.workflow.next_step import after_identify
from tests.boats.hulls import MIDDLE, driven
from tests.test_sampled_commands import LAG, sampled


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
    exact = seatrial.identify([replace(r, command_period=0.1) for r in changed], vehicle)
    assert not exact.findings_of(FindingKind.COMMANDS_LOOK_SAMPLED)
    assert exact.warnings


def test_under_model_mismatch_the_doubt_stays(boat, monkeypatch):
    vehicle, recordings = boat
    looked_at = [replace(r, command_sampled=False) for r in recordings]
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
