# SPDX-License-Identifier: MIT
"""Two thrusters that follow their commands at different times: not one that is weak."""

import numpy as np
import pytest
import yaml
from conftest import at_length
from sheets import two_sheets
from survey_boat import TRUTH, as_stated, both, driven

import seatrial
from seatrial.boat.findings import FindingKind

CASES = {  # entries of each motor's chain, and the names of the two constants
    "lag": (({"lag": 0.2}, {"lag": 0.8}), (0.2, 0.8)),
    "latency": (({"latency": 0.1}, {"latency": 0.5}), (0.1, 0.5)),
}


def of_two(stage, seed):
    (left, right), _ = CASES[stage]
    groups = [
        {"name": name, "actuators": [name], **own}
        for name, own in (("left", left), ("right", right))
    ]
    return driven(groups, [both] * 2, seed=seed)


@pytest.mark.parametrize("seed", [1, *(at_length(seed) for seed in range(2, 6))])
@pytest.mark.parametrize("stage", CASES)
def test_each_motor_has_its_own(stage, seed, tmp_path):
    """By the file that init writes: the slower one's force counts as much as the other's."""
    _, recording = of_two(stage, seed)
    two_sheets(tmp_path, recording, "left", "right")
    content = yaml.safe_load(seatrial.init(tmp_path).text)
    assert content["forces"]["F_u"]["of"] == {"left": 0.5, "right": 0.5}
    assert content["forces"]["F_r"]["of"] == {"left": -0.5, "right": 0.5}
    vehicle, recording = of_two(stage, seed)
    model = seatrial.identify([recording], vehicle)
    assert as_stated(model, {n: TRUTH[n] for n in model.values}) == {}
    names = [f"{stage}.{stage}_{motor}" for motor in ("left", "right")]
    got = [model.parameter_values[n] for n in names]
    errors = [model.standard_errors[n] for n in names]
    assert np.abs(np.subtract(got, CASES[stage][1])).max() < 4.5 * max(errors)
    (finding,) = model.findings_of(FindingKind.GROUP_STAGES_SELECTED)
    assert finding.subject == ("left", "right")
    assert not model.findings_of(FindingKind.UNEQUAL_THRUSTER_GAINS)


@pytest.mark.parametrize("seed", [1, 2, *(at_length(seed) for seed in range(3, 9))])
def test_motors_that_are_alike_have_one(seed):
    vehicle, recording = driven({}, [both] * 2, seed=seed)
    model = seatrial.identify([recording], vehicle)
    assert "lag" in model.parameter_values
    assert not model.findings_of(FindingKind.GROUP_STAGES_SELECTED)
