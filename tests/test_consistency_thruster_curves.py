# SPDX-License-Identifier: MIT
"""Thrusters with dead zones and curves push an axis that nobody meant to drive: that is no wrong sign."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import at_length, make_model, on_request
from recording_tools import turned
from survey_boat import pulses

from seatrial.inspection.consistency.between_recordings import check_each_recording
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.recording.signal import Signal
from tests.boats.motions import recorded, states_at
from tests.boats.vehicles import by_columns

TRUTH = {
    "X_u": -0.2, "X_uu": -0.8, "X_F": 0.6, "Y_v": -0.3, "Y_vv": -1.2, "Y_F": 0.5,
    "N_r": -0.6, "N_rr": -0.5, "N_F": 1.8,
}  # fmt: skip
PLACES = {
    "triangle": [(0.3, 0.0, 90.0), (-0.15, 0.26, 210.0), (-0.15, -0.26, 330.0)],
    "bow pair": [(0.4, 0.2, -45.0), (0.4, -0.2, 45.0), (-0.4, 0.2, 0.0), (-0.4, -0.2, 0.0)],
}  # x, y [m], angle [deg]
EDGES = {"dead_zone": {"forward": 0.15, "reverse": 0.15}}
CURVE = {"dead_zone": {"forward": 0.1, "reverse": 0.1}, "power": 1.7}


def few(end: int) -> list[object]:
    """Seed 1; 2 at length, the others up to `end` on request."""
    return [1, at_length(2), *map(on_request, range(3, end))]


def shares(places):
    """Shares (3, n) of surge, sway and yaw."""
    x, y, angle = np.array(places).T
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    rows = np.array([c, s, x * s - y * c])
    return np.round(rows / np.abs(rows).sum(axis=1)[:, None], 4)


def boat(places, chain=()):
    names = [f"T{i + 1}" for i in range(len(places))]
    forces = {
        force: {"axis": axis, "of": dict(zip(names, map(float, row), strict=True))}
        for force, axis, row in zip(
            ("F_u", "F_v", "F_r"), ("surge", "sway", "yaw"), shares(places), strict=True
        )
    }
    structure = {
        "surge": ["X_u * u", "X_uu * |u| * u", "X_F * F_u"],
        "sway": ["Y_v * v", "Y_vv * |v| * v", "Y_F * F_v"],
        "yaw": ["N_r * r", "N_rr * |r| * r", "N_F * F_r"],
    }
    return by_columns("raft", names, structure, forces=forces, chain=list(chain))


def one_by_one(places, curve, seed=3, seconds=150.0, others=0.0):
    """Recordings in which one axis at a time is driven, by thrusters with this curve; the others by a share."""
    rng = np.random.default_rng(seed)
    truth = make_model(boat(places, [{"latency": 0.05, "lag": 0.1, **curve}]), TRUTH)
    vehicle, found = boat(places), []
    t, begin = np.arange(0.0, seconds, 0.1), np.arange(0.0, seconds, 0.05)
    for axis in range(3):
        wanted = pulses(rng, seconds, lambda r: r.uniform(0.25, 0.9) * r.choice([-1, 1]), 0.2)
        besides = [pulses(rng, seconds, lambda r: others * r.normal(), 0.2) for _ in range(3)]
        force = np.where(np.arange(3) == axis, wanted[:, None], np.column_stack(besides))
        values = force @ np.linalg.pinv(shares(places)).T
        values /= np.abs(values).max()
        states = states_at(truth, t, begin, values)
        eta = states[:, :3] + rng.normal(size=(len(t), 3)) * [2e-3, 2e-3, 3e-3]
        found.append(recorded(f"S{axis + 1}", vehicle, (t, eta), (begin, values)))
    return vehicle, found


@pytest.mark.parametrize("curve", [EDGES, CURVE], ids=["edges", "curve"])
@pytest.mark.parametrize("places", PLACES.values(), ids=PLACES)
def test_a_right_file_is_right_for_each_axis_driven_alone(places, curve):
    vehicle, recordings = one_by_one(places, curve)
    assert check_each_recording(recordings, vehicle).findings == ()
    for recording in recordings:
        assert check_consistency([recording], vehicle).findings == ()


@pytest.mark.parametrize("places", [at_length(PLACES["triangle"]), PLACES["bow pair"]], ids=PLACES)
def test_what_is_wrong_is_found_all_the_same(places):
    vehicle, recordings = one_by_one(places, CURVE)
    for name in vehicle.inputs:
        signs = [-1.0 if name == n else 1.0 for n in vehicle.inputs]
        found = check_consistency([turned(r, *signs) for r in recordings], vehicle).findings
        assert any(name in f.text for f in found)
    odd = [recordings[0], turned(recordings[1], -1.0), recordings[2]]
    found = check_each_recording(odd, vehicle).findings
    assert found and all(f.text.startswith("S2 contradicts") for f in found)


CORNERS = [(0.3, 0.22, -45.0), (0.3, -0.22, 45.0), (-0.3, 0.22, 45.0), (-0.3, -0.22, -45.0)]


@pytest.mark.parametrize("seed", few(7))
def test_poses_of_a_point_off_the_origin_are_no_wrong_sign(seed):
    """When it turns the point moves aside; of the one recording that turns it was said that a thruster is wrong."""
    vehicle, recordings = one_by_one(CORNERS, EDGES, seed=seed, seconds=180.0, others=0.08)
    moved = [off(recording, 0.25) for recording in recordings]
    assert check_each_recording(moved, vehicle).findings == ()
    odd = [moved[0], turned(moved[1], -1.0), moved[2]]
    found = check_each_recording(odd, vehicle).findings
    assert found and all(f.text.startswith("S2 contradicts") for f in found)


TUG = [(-0.6, 0.25, 0.0), (-0.6, -0.25, 0.0), (0.6, 0.0, 90.0)]  # two astern, one at the bow


@pytest.mark.parametrize("seed", few(5))
def test_a_boat_that_sways_as_it_turns_is_no_wrong_sign(seed):
    """Looked at each for itself, as it is recorded: x, y and a thruster were said to be wrong."""
    vehicle, recordings = one_by_one(TUG, CURVE, seed=seed, seconds=180.0)
    moved = [off(recording, -0.05) for recording in recordings]
    for recording in moved:
        assert check_consistency([recording], vehicle).findings == ()


@pytest.mark.parametrize("seed", few(4))
@pytest.mark.parametrize("wrong", ["swapped", "turned"])
def test_one_mistake_in_the_file_is_one_finding_for_recordings_of_one_axis_each(wrong, seed):
    """The recordings of the axis that it does not touch are no reason to leave the others out."""
    vehicle, recordings = one_by_one(TUG, CURVE, seed=seed, seconds=180.0)
    signs = [1.0, 1.0, -1.0] if wrong == "turned" else [1.0, 1.0, 1.0]
    order = [1, 0, 2] if wrong == "swapped" else [0, 1, 2]
    odd = [exchanged(turned(off(r, -0.05), *signs), order) for r in recordings]
    found = check_each_recording(odd, vehicle).findings
    assert [f.kind for f in found] == [
        InconsistencyKind.PERMUTED if wrong == "swapped" else InconsistencyKind.NEGATED
    ]
    assert "contradicts" not in found[0].text


def off(recording, ahead):
    """With poses of a point so far ahead [m]."""
    c, s = np.cos(recording.eta[:, 2]), np.sin(recording.eta[:, 2])
    eta = recording.eta.copy()
    eta[:, :2] += ahead * np.column_stack([c, s])
    return replace(recording, eta=eta)


def exchanged(recording, order):
    """With columns of commands in another order."""
    c = recording.commands
    return replace(recording, commands=Signal(c.names, c.stamps, c.values[:, order]))
