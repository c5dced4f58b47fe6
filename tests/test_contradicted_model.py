# SPDX-License-Identifier: MIT
"""A model of recordings that contradict the vehicle file: said first, and fit for nothing."""

from dataclasses import replace

import pytest
from survey_boat import boat, driven

import seatrial
from seatrial.boat.findings import FindingKind, finding_of, finding_text
from seatrial.evaluation.assessment import assess
from seatrial.evaluation.validation import scores_of
from seatrial.identification.console import summary
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.report.evidence.model_evidence import evidence_of
from seatrial.report.evidence.verdict import following, headline
from seatrial.workflow.fitness import Criterion, Level
from seatrial.workflow.next_step import after_validate

EXCHANGED = "x and y are exchanged"


@pytest.fixture(scope="module")
def drives():
    """Two drives with the columns of x and y exchanged."""
    found = []
    for seed in (1, 2):
        _, drive = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=150.0, seed=seed)
        other = drive.raw[:, [1, 0, 2]]
        found.append(make_recording(f"r{seed}", drive.stamps, other, drive.commands))
    return found


@pytest.fixture(scope="module")
def model(drives):
    return seatrial.identify(drives[:1], boat())


@pytest.mark.parametrize("brief", [True, False])
def test_the_summary_begins_with_it(model, brief):
    (found,) = model.findings_of(FindingKind.CONTRADICTED)
    said = summary(model, brief=brief)
    assert said.startswith(finding_text(found))
    assert EXCHANGED in finding_text(found)
    assert said.count(finding_text(found)) == 1
    assert said.count(f"doubt: {EXCHANGED}") == 1


def test_it_is_fit_for_nothing_and_the_report_says_what_to_correct(model, drives):
    found = assess(model, drives[1:], 1.0)
    evidence = evidence_of(model, found, scores_of(model, found, 1.0))
    assert {one.level for one in evidence.fitness} == {Level.NOT_FIT}
    assert {one.reason.criterion for one in evidence.fitness} == {Criterion.CONTRADICTED}
    assert "Not fit for simulation, control and odometry" in headline(evidence)
    assert following(evidence).startswith("Next: recordings and vehicle file contradict each other")
    assert EXCHANGED in following(evidence)


def test_validate_does_not_send_to_a_report_of_it(model, drives):
    found = assess(model, drives[1:], 1.0)
    contradicted = model.findings_of(FindingKind.CONTRADICTED)
    scores = scores_of(model, found, 1.0)
    step = after_validate("m.yaml", scores, ["b.csv"], contradicted=contradicted)
    assert step.do == "Correct that, then identify again"
    assert EXCHANGED in step.why


def test_a_wrong_clock_is_in_the_latency_alone(drives):
    _, drive = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=150.0)
    own = drive.commands
    late = replace(drive, commands=Signal(own.names, own.stamps + 900_000_000, own.values))
    model = seatrial.identify([late], boat())
    assert model.warnings[0].startswith("commands act about")
    assert not model.findings_of(FindingKind.CONTRADICTED)


def test_its_constants_tell_nothing_of_the_commands(drives, monkeypatch):
    late = finding_of(FindingKind.LATE_COMMANDS, "latency", lead=0.2, error=0.01)
    monkeypatch.setattr("seatrial.identification.methods.late_command_findings", lambda _: [late])
    spoilt = seatrial.identify(drives[:1], boat())
    assert not spoilt.findings_of(FindingKind.LATE_COMMANDS)
    vehicle, drive = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=150.0)
    assert seatrial.identify([drive], vehicle).findings_of(FindingKind.LATE_COMMANDS)
