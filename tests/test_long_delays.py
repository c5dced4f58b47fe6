# SPDX-License-Identifier: MIT
"""Positions and headings that are a second or more apart: the check names the delay, the estimate begins there."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from conftest import at_length
from sheets import sheet
from survey_boat import TRUTH, as_stated, both, driven

import seatrial
from seatrial.boat.findings import FindingKind, finding_text
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.simulation.trials import simulate
from tests.boats.plans import planned

APART = [(1.3, 0.0), at_length((0.0, 1.3)), at_length((3.4, 0.2))]


def named(recording, vehicle):
    """Delays [s] of position and heading in the file as the check corrects it; None: no delay is found."""
    report = check_consistency([recording], vehicle)
    kinds = {finding.kind for finding in report.findings}
    return report.repaired(vehicle).delays if kinds == {InconsistencyKind.DELAY} else None


@pytest.mark.parametrize("seed", [1, *(at_length(seed) for seed in range(2, 6))])
@pytest.mark.parametrize("late", APART)
def test_a_long_delay_is_named_and_then_estimated(late, seed):
    vehicle, recording = driven({}, [both] * 2, seed=seed, late=late)
    recording = recording.cut(
        4.0, 300.0
    )  # before the first command it is at rest, whatever that is
    true = late[0] - late[1]
    position, heading = named(recording, vehicle)
    assert position - heading == pytest.approx(true, abs=0.35)  # a window is 1.2 s
    spoilt = seatrial.identify([recording], vehicle)
    (finding,) = spoilt.findings_of(FindingKind.CONTRADICTED)
    assert f"set delay: {position:g} and heading_delay: {heading:g} at pose" in finding_text(
        finding
    )
    model = seatrial.identify([recording], vehicle, effects=["delay"])
    assert not model.findings_of(FindingKind.CONTRADICTED)
    assert as_stated(model, {n: TRUTH[n] for n in model.values}) == {}
    (finding,) = model.findings_of(FindingKind.DELAY_DIFFERENCE)
    assert abs(finding.number("delay") - abs(true)) < 4.5 * finding.number("error")


@pytest.mark.parametrize("seed", range(1, 4))
@pytest.mark.parametrize("late", [(0.0, 0.0), (0.4, 0.0), (1.3, 1.3), (3.0, 3.0)])
def test_a_short_delay_or_one_of_both_is_none(late, seed):
    vehicle, recording = driven({}, [both] * 2, seed=seed, late=late)
    kinds = {finding.kind for finding in check_consistency([recording], vehicle).findings}
    assert InconsistencyKind.DELAY not in kinds


def test_init_writes_the_delay(tmp_path):
    _, recording = driven({}, [both] * 2, late=(1.3, 0.0))
    poses = np.column_stack([recording.t, recording.raw])
    sheet(tmp_path / "poses.csv", "t,x,y,psi", *poses.T)
    commands = recording.commands
    seconds = 1e-9 * (commands.stamps - recording.stamps[0])
    sheet(tmp_path / "commands.csv", "t,left,right", seconds, *commands.values.T)
    content = yaml.safe_load(seatrial.init(tmp_path).text)
    assert content["pose"]["delay"] == pytest.approx(1.3, abs=0.35)
    assert content["pose"]["heading_delay"] == 0
    assert content["forces"]["F_u"]["of"] == {"left": 0.5, "right": 0.5}


@pytest.mark.parametrize("arm", [(0.4, -0.2), at_length((-0.5, 0.2)), at_length((1.0, 0.0))])
def test_a_measured_point_beside_the_origin_is_none(arm):
    """Where the boat turns most of the time its point moves as if the headings were late."""
    vehicle = seatrial.load_vehicle("twin-thruster")
    (trial,) = simulate(planned("lake", "L2"), vehicle.with_lever(arm))
    unstated = replace(trial, vehicle=trial.vehicle.with_lever((0.0, 0.0))).recording
    assert not check_consistency([unstated], vehicle).findings
