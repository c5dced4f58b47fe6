# SPDX-License-Identifier: MIT
"""Dead zones of thrusters that push to one side, hardly to the other, at one thrust, or are of two kinds."""

import numpy as np
import pytest
from survey_boat import LAG, LATENCY, TRUTH, as_stated, boat, both, driven

import seatrial
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.model_file import load, save
from seatrial.evaluation.comparison.compare import compare
from seatrial.identification.estimator import output_error
from seatrial.util.errors import SeatrialError

EDGE = 0.1
ZONE = {"dead_zone": {"forward": EDGE, "reverse": EDGE}}
KNOWN = {
    **{n: x for n, x in TRUTH.items() if n not in ("Y_F", "N_b")},
    "lag": LAG,
    "latency": LATENCY,
}


def ahead(rng):
    return rng.uniform(0.0, 1.0)


def test_thrusters_that_only_push_ahead_show_their_edge():
    vehicle, recording = driven(ZONE, [ahead, ahead])
    model = output_error([recording], vehicle)
    assert model.vehicle.constants.names == ("latency", "edge_forward", "lag")
    assert not as_stated(model, {**KNOWN, "edge_forward": EDGE})
    assert model.standard_errors["X_u"] < 0.001
    one_edge = finding_of(FindingKind.DEAD_ZONE_ONE_EDGE, "left", "right", side="astern")
    assert one_edge in model.estimator.findings


@pytest.mark.parametrize("power", [1.6, "estimate"])
def test_an_edge_is_sought_beside_a_power_that_the_file_has(power):
    """Without one the power stood for it: 1.85 instead of 1.6, and 1.27 of thrusters that are linear."""
    true = {"power": 1.6, "dead_zone": {"forward": 0.06, "reverse": 0.1}}
    _, recording = driven(true, [both, both], seconds=200.0)
    model = output_error([recording], boat([{"power": power}]))
    known = {**KNOWN, "edge_forward": 0.06, "edge_reverse": 0.1, "power": 1.6}
    assert set(known) <= {*model.values, *model.vehicle.constants.names}
    assert not as_stated(model, known)


@pytest.mark.parametrize("seed", [4, 7, 8])
def test_a_curve_is_found_in_two_minutes(seed):
    """Of so few blocks no score is manifest; the likelihood promises hundreds."""
    true = {"power": 1.6, "reverse_ratio": 0.75, "dead_zone": {"forward": 0.06, "reverse": 0.1}}
    vehicle, recording = driven(true, [both, both], seconds=120.0, seed=seed)
    model = output_error([recording], vehicle)
    known = {**KNOWN, "edge_forward": 0.06, "edge_reverse": 0.1, "power": 1.6}
    assert not as_stated(model, {**known, "reverse_ratio": 0.75})


def test_an_edge_for_both_sides_stays_one_in_a_model_file(tmp_path):
    vehicle, recording = driven(ZONE, [ahead, ahead], seconds=150.0)
    model = output_error([recording], vehicle)
    save(model, tmp_path / "model.yaml")
    again = load(tmp_path / "model.yaml")
    assert again.vehicle.constants.names == model.vehicle.constants.names
    each = again.vehicle.constants.of_each
    for side in ("forward", "reverse"):
        np.testing.assert_allclose(each(f"edge_{side}", again.constants), EDGE, atol=1e-3)


@pytest.mark.parametrize("stated", [0.1, "estimate"])
def test_reverse_as_forward_is_one_constant(stated):
    constants = boat([{"dead_zone": {"forward": stated, "reverse": "forward"}}]).constants
    assert constants.names == ("edge_forward",)
    assert constants.estimated == (() if stated == 0.1 else ("edge_forward",))
    with pytest.raises(SeatrialError, match="forward: got 'forward'"):
        boat([{"dead_zone": {"forward": "forward", "reverse": 0.1}}])


def test_thrusters_that_are_never_idle_show_their_edge_by_the_force_that_it_takes():
    vehicle, recording = driven(ZONE, [lambda rng: rng.uniform(0.2, 1.0)] * 2, idle=0.0)
    model = output_error([recording], vehicle)
    assert not as_stated(model, {**KNOWN, "edge_forward": EDGE})
    assert model.standard_errors["edge_forward"] < 0.005


def test_one_thrust_beside_none_says_nothing_of_an_edge():
    vehicle, recording = driven(ZONE, [lambda rng: 0.8] * 2)
    model = output_error([recording], vehicle)
    assert model.vehicle.constants.names == ("latency", "lag")
    (hidden,) = model.findings_of(FindingKind.DEAD_ZONE_NOT_IDENTIFIABLE)
    assert hidden.subject == ("left", "right")
    share = (0.8 - EDGE) / (1.0 - EDGE) / 0.8  # the coefficients include it
    gains = {n: share * TRUTH[n] for n in ("X_F", "N_F")}
    assert not as_stated(model, {**KNOWN, **gains})


def test_thrusters_of_another_kind_have_an_edge_of_their_own():
    zones = [
        {"name": "stern", "actuators": ["left", "right"], "dead_zone": {"forward": 0.15, "reverse": 0.15}},
        {"name": "bow", "actuators": ["bow"], "dead_zone": {"forward": 0.03, "reverse": 0.06}},
    ]  # fmt: skip
    vehicle, recording = driven(zones, [ahead, ahead, lambda rng: rng.uniform(-1, 1)], bow=True)
    model = output_error([recording], vehicle)
    edges = {
        "edge_forward.dead_zone_F_u": 0.15,
        "edge_forward.dead_zone_F_b": 0.03,
        "edge_reverse.dead_zone_F_b": 0.06,
    }
    assert set(edges) == {n for n in model.vehicle.constants.names if n.startswith("edge")}
    assert not as_stated(model, {**KNOWN, **edges, "Y_F": TRUTH["Y_F"], "N_b": TRUTH["N_b"]})


def test_the_curves_power_is_found_though_thrusters_push_to_one_side_only():
    vehicle, recording = driven({**ZONE, "power": 2.0}, [ahead, ahead])
    model = output_error([recording], vehicle)
    assert not as_stated(model, {**KNOWN, "edge_forward": EDGE, "power": 2.0})


@pytest.mark.parametrize("seed", [1, 2])
def test_a_stage_is_told_in_a_short_recording_too(seed):
    """16 blocks: a statistic of scores that are not centred can't exceed their number."""
    sizes = [both] * 2
    vehicle, recording = driven({**ZONE, "power": 2.0}, sizes, seconds=150.0, seed=seed)
    model = output_error([recording], vehicle)
    found = dict(zip(model.vehicle.constants.names, model.constants, strict=True))
    assert found["power"] == pytest.approx(2.0, abs=0.02)
    assert not as_stated(model, {**KNOWN, "edge_forward": EDGE, "edge_reverse": EDGE})


def test_what_was_one_edge_before_is_two_where_the_new_data_show_both():
    zone = {"dead_zone": {"forward": EDGE, "reverse": 2 * EDGE}}
    vehicle, one_sided = driven(zone, [ahead, ahead], seconds=150.0)
    before = output_error([one_sided], vehicle)
    _, new = driven(zone, [lambda rng: rng.uniform(-1, 1)] * 2, seconds=150.0, seed=9)
    model = seatrial.identify([new], vehicle, prior=before)
    assert not as_stated(model, {**KNOWN, "edge_forward": EDGE, "edge_reverse": 2 * EDGE})
    assert before.findings_of(FindingKind.DEAD_ZONE_ONE_EDGE)
    assert not model.findings_of(FindingKind.DEAD_ZONE_ONE_EDGE)
    assert any(
        "A has one dead-zone edge for both directions" in note
        for note in compare(before, model).notes
    )
