# SPDX-License-Identifier: MIT
"""Start values: near the truth, whatever delay and dead zone the boat has, and from spoilt poses."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import CSE1
from method_trials import changed, driven, pulses_of, truth

import seatrial
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.identification.estimator import with_free_stages
from seatrial.identification.regression.start_values import (
    START_DURATION,
    spread_pieces,
    start_values,
)
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import load_plan
from seatrial.util.errors import IdentificationError
from tests.boats.plans import planned


def started(vehicle, recordings):
    """Coefficients and constants by name, all constants free."""
    whole = with_free_stages(vehicle, recordings)
    names = whole.constants.names
    theta, constants = start_values(recordings, whole, range(len(names)))
    return (
        dict(zip(whole.structure.coefficients, theta, strict=True)),
        dict(zip(names, constants, strict=True)),
    )


def assert_near(theta, true, share=0.05):
    for name, value in true.items():
        assert theta[name] == pytest.approx(value, rel=share, abs=0.02), name


@pytest.mark.parametrize("vehicle", ["mallard-mp", "mallard-af"])
@pytest.mark.parametrize("plan", ["clean", "paper-like", "hard"])
def test_starts_are_near_the_truth_whatever_the_noise(plan, vehicle):
    theta, constants = started(*driven(plan, vehicle, 1))
    assert_near(theta, truth(plan, vehicle))
    delay = 0.08 - load_plan(plan).joypad.clock_offset  # [s] the plant's lag, by the poses' clock
    assert constants["latency"] + constants["lag"] == pytest.approx(delay, abs=0.006)
    if vehicle == "mallard-mp":
        assert constants["edge_forward"] == pytest.approx(0.08, abs=0.006)
        assert constants["edge_reverse"] == pytest.approx(0.08, abs=0.006)


@pytest.mark.parametrize("late", [-0.45, 0.37, 0.7])
def test_a_delay_is_found_wherever_it_is(late):
    vehicle, recordings = driven("hard", "mallard-mp", 2)
    shifted = []
    for r in recordings:
        given = r.commands
        stamps = given.stamps - round(late * 1e9)
        shifted.append(replace(r, commands=Signal(given.names, stamps, given.values)))
    theta, constants = started(vehicle, shifted)
    assert constants["latency"] + constants["lag"] == pytest.approx(0.06 + late, abs=0.01)
    assert_near(theta, truth("hard", "mallard-mp"))


@pytest.mark.parametrize("edge", [0.0, 0.2, 0.35])
def test_a_dead_zone_is_found_however_wide(edge, mp):
    chain = [ChainGroup(lag=0.08, dead_zone=DeadZone(edge, edge + 0.05))]
    # so little thrust is left that 4 mm of noise count
    plan = planned("paper-like", plant={"chain": chain})
    theta, constants = started(mp, pulses_of(plan, mp))
    assert constants["edge_forward"] == pytest.approx(edge, abs=0.015)
    assert constants["edge_reverse"] == pytest.approx(edge + 0.05, abs=0.015)
    assert_near(theta, truth("paper-like", "mallard-mp"))


def test_delays_that_differ_by_group_are_found_apart(mp):
    plan = load_plan("paper-like")
    bow, stern = mp.actuators[:2], mp.actuators[2:]
    chain = [
        ChainGroup(name="bow", actuators=list(bow), latency=0.3),
        ChainGroup(name="stern", actuators=list(stern), latency=0.05),
        ChainGroup(lag=0.08, dead_zone=DeadZone(0.08, 0.08)),
    ]
    recordings = pulses_of(planned(plan, plant={"chain": chain}), mp)
    unknown = [msgspec.structs.replace(g, latency=0.0) for g in chain[:2]]
    whole = mp.with_chain([*unknown, chain[2]])
    free = [i for i, name in enumerate(whole.constants.names) if name.startswith("latency")]
    _, constants = start_values(recordings, whole, free)
    found = dict(zip(whole.constants.names, constants, strict=True))
    assert found["latency.bow"] == pytest.approx(
        0.28, abs=0.01
    )  # by the joypad's clock, 0.02 s off
    assert found["latency.stern"] == pytest.approx(0.03, abs=0.01)


@pytest.mark.system
def test_of_long_recordings_pieces_are_enough(af):
    """An hour: a part of it is looked at."""
    recordings = pulses_of(planned("paper-like", "S1", "S2", "S3", seconds=1200), af)
    looked_at = spread_pieces(recordings)
    assert sum(r.duration for r in looked_at) == pytest.approx(START_DURATION, rel=0.1)
    assert {r.name for r in looked_at} == {r.name for r in recordings}
    theta, constants = started(af, recordings)
    assert_near(theta, truth("paper-like", "mallard-af"))
    assert constants["latency"] + constants["lag"] == pytest.approx(0.06, abs=0.006)


def test_only_what_is_free_is_changed():
    vehicle, recordings = driven("paper-like", "mallard-mp", 1)
    whole = with_free_stages(vehicle, recordings)
    _, constants = start_values(recordings, whole)
    np.testing.assert_array_equal(constants, whole.constants.values)
    place = whole.constants.names.index("edge_forward")
    _, constants = start_values(recordings, whole, [place])
    same = np.arange(len(constants)) != place
    np.testing.assert_array_equal(constants[same], whole.constants.values[same])
    assert constants[place] != whole.constants.values[place]


def test_where_the_latency_is_given_the_lag_takes_the_delay():
    vehicle, recordings = driven("paper-like", "mallard-af", 1)
    whole = with_free_stages(vehicle.with_chain([ChainGroup(latency=-0.02)]), recordings)
    place = whole.constants.names.index("lag")
    _, constants = start_values(recordings, whole, [place])
    assert constants[place] == pytest.approx(0.08, abs=0.01)


def test_jumps_and_drop_outs_do_little():
    """2 % of the poses elsewhere by 0.1 to 1 m, and three drop-outs of 3 s in every recording."""
    vehicle, recordings = driven("hard", "mallard-mp", 3)
    rng = np.random.default_rng(3)
    spoilt = []
    for r in recordings:
        eta = r.raw.copy()
        away = rng.random(len(eta)) < 0.02
        angle, size = rng.uniform(-np.pi, np.pi, away.sum()), rng.uniform(0.1, 1.0, away.sum())
        eta[away, :2] += size[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        kept = np.all([np.abs(r.t - c) > 1.5 for c in rng.uniform(20, 180, 3)], axis=0)
        spoilt.append(changed(r, eta[kept], r.stamps[kept]))
    theta, constants = started(vehicle, spoilt)
    assert_near(theta, truth("hard", "mallard-mp"), 0.08)
    assert constants["edge_forward"] == pytest.approx(0.08, abs=0.01)


def test_a_real_ship_has_the_delay_that_others_measured():
    """A quarter of a second, by a least-squares scan: data/cse1/PROVENANCE.md."""
    given = seatrial.load_vehicle(CSE1 / "coupled.yaml")
    stated = given.with_chain([g for g in given.file.chain if g.latency is None])
    recordings = [seatrial.read(p, stated) for p in sorted((CSE1 / "csv").glob("*.csv"))]
    _, constants = started(stated, recordings)
    assert constants["latency"] + constants["lag"] == pytest.approx(0.25, abs=0.05)
    assert constants["scale_power.propellers"] == 2.0  # nothing is known of it here


def test_recordings_in_shreds_are_refused_in_words():
    vehicle, recordings = driven("paper-like", "mallard-mp", 1)
    r = recordings[0]
    kept = np.arange(len(r.t)) % 32 < 12
    shreds = changed(r, r.raw[kept], r.stamps[kept])
    with pytest.raises(IdentificationError, match="no second without drop-outs; record longer"):
        start_values([shreds], vehicle)


def test_no_recording_is_refused_in_words(mp):
    with pytest.raises(IdentificationError, match="no recording given"):
        start_values([], mp)
