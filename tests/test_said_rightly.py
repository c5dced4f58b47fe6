# SPDX-License-Identifier: MIT
"""Sentences about what is not wrong with a recording or a boat, and about what is."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, at_length, make_model
from survey_boat import TRUTH, boat, both, driven, even

import seatrial
from seatrial.boat.findings import FindingKind, finding_text, of_kinds
from seatrial.boat.physics import RUN, axis_physics, physics_line
from seatrial.boat.schema import Column, EnvelopeEntry
from seatrial.evaluation.validation import validate
from seatrial.inspection.overview import implausible_values
from seatrial.recording.signal import Signal
from seatrial.util.errors import SeatrialError


def test_noisy_fast_poses_are_not_in_other_units():
    noise = np.array([0.1, 0.1, 0.05])
    vehicle, recording = driven({}, [both, both], seconds=60.0, stamps=even(50.0), noise=noise)
    assert not [
        s for s in implausible_values(recording, vehicle) if "mm or cm" in s or "degrees" in s
    ]
    in_mm = replace(recording, eta=recording.eta * [1000.0, 1000.0, 1.0])
    assert [s for s in implausible_values(in_mm, vehicle) if "mm or cm" in s]


def test_a_stated_unit_is_the_answer_where_a_boat_is_as_quick_as_one_in_another_unit():
    """A toy of 0.5 kg turns at 400 degrees a second: with a heading that does not wrap it was refused for good."""
    quick, slow = 0.1, 100.0  # times the stamps; the second is 0.2 poses a second
    vehicle, recording = driven({}, [both, both], seconds=60.0)
    for times, entry, what in (
        (quick, {"psi": Column("psi", unit="rad")}, "is psi in degrees"),
        (slow, {"stamp": Column("t", unit="s")}, "unit of the stamps"),
    ):
        begin = recording.stamps[0]
        stamps = begin + np.round(times * (recording.stamps - begin)).astype(np.int64)
        found = replace(recording, stamps=stamps, eta=recording.eta * [1.0, 1.0, 5.0])
        assert any(what in s for s in implausible_values(found, vehicle))
        pose = msgspec.structs.replace(vehicle.file.pose, **entry)
        stated = replace(vehicle, file=msgspec.structs.replace(vehicle.file, pose=pose))
        assert not any(what in s for s in implausible_values(found, stated))


@pytest.mark.system
def test_slow_poses_are_said_where_their_velocities_are_used():
    _, recording = driven({}, [both, both], stamps=even(1.0))
    model = make_model(boat([{"latency": 0.05, "lag": 0.1}]), TRUTH)
    model = replace(model, envelope=EnvelopeEntry({"u": (-1.0, 1.0)}, {}))
    (row,) = validate(model, [recording]).recordings
    (slow,) = of_kinds(row.findings, FindingKind.SLOW_POSES)
    assert slow.number("period") == pytest.approx(1.0, rel=1e-3)
    assert "poses are 1 s apart: " in finding_text(slow)
    _, usual = driven({}, [both, both], seconds=100.0)
    (row,) = validate(model, [usual]).recordings
    assert not of_kinds(row.findings, FindingKind.SLOW_POSES)


@pytest.mark.parametrize("method", [at_length("output-error"), "weak-form"])
def test_commands_in_other_units_are_named_by_identify(method):
    vehicle, recording = driven({}, [both, both])
    c = recording.commands
    pulses = replace(recording, commands=Signal(c.names, c.stamps, 1500.0 + 400.0 * c.values))
    try:
        said = seatrial.identify([pulses], vehicle, method=method).warnings
    except SeatrialError as error:
        said = (str(error),)
    text = "; ".join(said)
    for name in ("left", "right"):
        assert f"{name} reaches 1" in text and "but full command is 1: give offset" in text


def test_a_fast_boat_is_not_unstable(mp):
    values = {**TABLE_II["AF"], "X_F": 3.0, "X_u": -0.1, "X_uu": -0.012, "N_ud": 0.0, "N_uu": 0.0}
    assert axis_physics(make_model(mp, values))[0].top_speed == pytest.approx(12.2, abs=0.1)


def test_a_craft_without_drag_is_not_unstable_and_one_that_its_drag_drives_is(mp):
    values = {**TABLE_II["AF"], "X_F": 0.8, "X_u": 0.0, "X_uu": 0.0, "N_ud": 0.0, "N_uu": 0.0}
    assert axis_physics(make_model(mp, values))[0].top_speed == pytest.approx(0.8 * RUN, rel=0.01)
    with pytest.raises(SeatrialError, match="surge passes 10 m/s"):
        axis_physics(make_model(mp, {**values, "X_u": 0.05}))


def test_the_top_speed_is_said_with_its_command_where_that_is_not_a_full_one(mp):
    model = make_model(mp, TABLE_II["AF"])
    assert "full command" not in physics_line(model)
    gentle = replace(model, envelope=EnvelopeEntry({}, {"F_u": (-0.5, 0.4)}))
    assert "m/s in surge at 50 % of full command, " in physics_line(gentle)
