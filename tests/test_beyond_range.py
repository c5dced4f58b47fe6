# SPDX-License-Identifier: MIT
"""A constant whose truth is beyond the range that is searched: the finding asks for it, and a stated one cures it."""

import numpy as np
import pytest
from conftest import at_length
from survey_boat import LAG, LATENCY, TRUTH, as_stated, boat, driven

import seatrial
from seatrial.boat.actuators import ABSENT_AT, BOUNDS
from seatrial.boat.finding_texts.estimate import BEYOND_RANGE
from seatrial.boat.findings import FindingKind, advice_of
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.likelihood.parameters import CHAIN_CONSTANTS, DELAY_NAMES
from seatrial.workflow.next_step import after_identify

BEYOND = {  # true constants, and the parameters that end at a bound
    "lag": ({"lag": 4.0}, {"lag"}),
    "latency": ({"latency": 2.3}, {"latency"}),
    "dead zone": (
        {"dead_zone": {"forward": 0.7, "reverse": 0.7}},
        {"edge_forward", "edge_reverse"},
    ),
}


def half(rng):
    return rng.uniform(0.2, 1.0) * rng.choice([-1.0, 1.0])


def bounds_of(model, kind):
    return {f.part("parameter"): f.number("bound") for f in model.findings_of(kind)}


@pytest.mark.parametrize(
    "stage", ["lag", *(at_length(stage) for stage in BEYOND if stage != "lag")]
)
def test_a_truth_beyond_the_range_asks_for_an_action(stage):
    """Before, one remark of -v said what a lag at its lower bound means, and `next:` to look for missing terms."""
    chain, names = BEYOND[stage]
    vehicle, recording = driven(chain, [half] * 2)
    model = seatrial.identify([recording], vehicle)
    found = bounds_of(model, FindingKind.BEYOND_RANGE)
    assert set(found) == names <= model.at_bounds
    assert found == {name: BOUNDS[name][1] for name in names}
    if stage != "latency":  # of which a doubt on the clocks comes first
        finding = model.findings_of(FindingKind.BEYOND_RANGE)[0]
        assert after_identify(model).do == advice_of(finding)


@pytest.mark.parametrize("stage", BEYOND)
def test_stated_it_leaves_the_others_right(stage):
    """What the advice says: the coefficients that were off by many standard errors are the truth's."""
    chain, _ = BEYOND[stage]
    _, recording = driven(chain, [half] * 2, seconds=400.0)
    vehicle = boat([{"latency": LATENCY, "lag": LAG, **chain}])
    model = seatrial.identify([recording], vehicle)
    assert not bounds_of(model, FindingKind.BEYOND_RANGE)
    assert as_stated(model, {n: TRUTH[n] for n in model.values}) == {}


def test_no_lag_and_no_dead_zone_ask_for_none():
    vehicle, recording = driven({"lag": 0.0, "latency": 0.0}, [half] * 2)
    model = seatrial.identify([recording], vehicle)
    assert bounds_of(model, FindingKind.AT_BOUND)
    assert not model.findings_of(FindingKind.BEYOND_RANGE)


def test_every_constant_that_is_searched_has_its_advice():
    advised = set(BEYOND_RANGE.words["stage"])
    assert advised == set(CHAIN_CONSTANTS) | set(DELAY_NAMES) == set(BOUNDS) | set(DELAY_NAMES)
    assert set(ABSENT_AT) < set(BOUNDS)


@pytest.mark.system
def test_a_position_that_is_later_than_any_delay():
    """By 6 s, of a range of 5 s."""
    vehicle, recording = driven({}, [half] * 2, late=(6.0, 0.0), noise=np.array([5e-3, 5e-3, 3e-3]))
    content = vehicle.to_mapping()
    content["pose"] |= {"delay": "estimate", "heading_delay": 0}
    model = seatrial.identify([recording], vehicle_from(content, "v.yaml"))
    found = bounds_of(model, FindingKind.BEYOND_RANGE)
    assert found == {"delay_position": 5.0}
    assert not model.findings_of(FindingKind.DELAY_DIFFERENCE)  # of 5 +- 0 s
