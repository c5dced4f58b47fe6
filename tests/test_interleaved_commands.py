# SPDX-License-Identifier: MIT
"""Commands of two sources, row by row in one log, are doubted; a lively drive by one source is not."""

import numpy as np
import pytest
from sheets import sheet
from survey_boat import driven, pulses

import seatrial
from seatrial.recording.faults.interleaved_commands import interleaving_doubt
from seatrial.recording.signal import Signal

NAMES = ("left", "right")


def signal(t, values):
    return Signal(NAMES, np.rint(1e9 * t).astype(np.int64), values)


def stick(seed=1, seconds=120.0):
    """Commands (n, 2) at 20 Hz."""
    rng = np.random.default_rng(seed)
    return np.column_stack([pulses(rng, seconds, lambda g: g.uniform(-1, 1), 0.3) for _ in NAMES])


@pytest.mark.parametrize("other", [0.0, 0.4])
@pytest.mark.parametrize("later", [0.01, 0.025, 0.04])
def test_a_second_source_between_the_rows_of_the_first_is_doubted(other, later):
    own = stick()
    t = np.arange(len(own)) / 20.0
    both = np.stack([own, np.full_like(own, other)], axis=1).reshape(-1, 2)
    (doubt,) = interleaving_doubt(signal(np.column_stack([t, t + later]).ravel(), both))
    assert "of the changes of left and right are undone by the next row" in doubt


def test_identify_and_the_recording_say_so(tmp_path):
    """The boat follows the first source: thrust is twice what it is, or more."""
    vehicle, drive = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=120.0)
    values, seconds = drive.commands.values, drive.seconds(drive.commands.stamps)
    rows = np.column_stack([seconds, values, seconds + 0.02, 0.0 * values]).reshape(-1, 3)
    folder = tmp_path / "mixed"
    folder.mkdir()
    sheet(folder / "poses.csv", "t,x,y,psi", drive.t, drive.raw, form="%.6f")
    sheet(folder / "commands.csv", "t,left,right", rows, form="%.6f")
    recording = seatrial.read(folder, vehicle)
    (doubt,) = recording.doubts
    assert f"mixed: {doubt}" in seatrial.identify([recording], vehicle).warnings


@pytest.mark.parametrize("kind", ["pulses", "noise", "flicker", "on change", "rest"])
def test_one_source_is_not_doubted(kind):
    rng, own = np.random.default_rng(2), stick()
    t = np.arange(len(own)) / 20.0
    if kind == "noise":  # a controller of noisy measurements
        own = rng.normal(0.0, 0.3, own.shape)
    elif kind == "flicker":  # of the last digit
        own = own + 0.002 * (np.arange(len(own)) % 2)[:, None]
    elif kind == "on change":  # a row a pulse: on, off
        own = np.outer(np.arange(100) % 2, [1.0, 0.5])
        t = np.cumsum(rng.uniform(0.5, 3.0, len(own)))
    elif kind == "rest":
        own = np.zeros_like(own)
    assert interleaving_doubt(signal(t, own)) == []
    assert interleaving_doubt(signal(t[:2], own[:2])) == []
