# SPDX-License-Identifier: MIT
"""Actuators of unlike kinds, a bow thruster beside two astern: each kind's own curve and lag are found."""

import pytest
from conftest import at_length, on_request
from survey_boat import LAG, LATENCY, TRUTH, as_stated, driven, past_idle

from seatrial.boat.findings import FindingKind, finding_of
from seatrial.identification.estimator import output_error
from seatrial.identification.selection.actuator_stages import STAGES_SELECTED

STERN, BOW = ["left", "right"], ["bow"]


def edges(forward):
    return {"dead_zone": {"forward": forward, "reverse": forward}}


KINDS = {  # stages of the two astern, of the bow thruster, and constants of them that are found
    "power": (edges(0.06), {"power": 2.0, **edges(0.1)}, {
        "power.power_F_u": 1.0, "power.power_F_b": 2.0,
        "edge_forward.dead_zone_F_u": 0.06, "edge_forward.dead_zone_F_b": 0.1,
    }),
    # else the latencies of the two take its place, and the bow's gains are 10 standard errors off
    "lag": ({"lag": LAG, **edges(0.06)}, {"lag": 0.5, **edges(0.06)}, {
        "latency": LATENCY, "lag.lag_F_u": LAG, "lag.lag_F_b": 0.5,
    }),
    "reverse_ratio": (edges(0.06), {"reverse_ratio": 0.6, **edges(0.06)}, {
        "reverse_ratio.reverse_ratio_F_u": 1.0, "reverse_ratio.reverse_ratio_F_b": 0.6,
    }),
}  # fmt: skip


@pytest.mark.parametrize("seed", [1, at_length(2), on_request(8)])
@pytest.mark.parametrize("stage", KINDS)
def test_a_kind_has_a_stage_of_its_own(stage, seed):
    stern, bow, found = KINDS[stage]
    curves = [{"name": "s", "actuators": STERN, **stern}, {"name": "b", "actuators": BOW, **bow}]
    vehicle, recording = driven(curves, [past_idle] * 3, seed=seed, bow=True, seconds=200.0)
    model = output_error([recording], vehicle)
    selected = finding_of(FindingKind.GROUP_STAGES_SELECTED, "F_u", "F_b", stage=stage)
    assert selected in model.estimator.findings
    assert as_stated(model, {**TRUTH, **found}) == {}


def test_one_kind_has_one_curve():
    vehicle, recording = driven(
        {"power": 1.5, **edges(0.1)}, [past_idle] * 3, bow=True, seconds=200.0
    )
    found = output_error([recording], vehicle).findings_of(*STAGES_SELECTED)
    assert found == (finding_of(FindingKind.CURVE_STAGE_SELECTED, stage="power"),)
