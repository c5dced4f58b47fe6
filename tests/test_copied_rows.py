# SPDX-License-Identifier: MIT
"""A part of a log that is written twice, as after a reconnect: its rows count once, and nothing is lost."""

import numpy as np
import pytest
from survey_boat import boat

import seatrial
from seatrial.inspection.overview import inspect
from seatrial.recording.faults.pose_faults import FaultKind

COUNT = 600


def table(path, order, changed=()):
    """A table of rows 0.1 s apart in this order; the `changed` places of it have another pose."""
    t = 0.1 * np.arange(COUNT)
    x, y, psi = 3.0 * np.sin(0.2 * t), 3.0 * np.cos(0.2 * t), 0.2 * t
    left, right = np.sin(0.7 * t), np.sin(0.9 * t)
    rows = np.column_stack([t, x, y, psi, left, right])[order]
    rows[list(changed), 1] += 0.004
    lines = [",".join(f"{value:.6f}" for value in row) for row in rows]
    path.write_text("\n".join(["t,x,y,psi,left,right", *lines]) + "\n")
    return seatrial.read(path, boat())


PLAIN = np.arange(COUNT)
TWICE = {
    "a block again": np.concatenate([PLAIN[:400], PLAIN[300:400], PLAIN[400:]]),
    "from a block's start on": np.concatenate([PLAIN[:400], PLAIN[300:]]),
    "a block too early": np.concatenate([PLAIN[300:400], PLAIN]),
    "every row": np.repeat(PLAIN, 2),
}


@pytest.mark.parametrize("order", TWICE.values(), ids=TWICE)
def test_copies_count_once_and_nothing_is_left_out(order, tmp_path):
    whole, twice = table(tmp_path / "one.csv", PLAIN), table(tmp_path / "two.csv", order)
    np.testing.assert_array_equal(twice.stamps, whole.stamps)
    np.testing.assert_array_equal(twice.eta, whole.eta)
    np.testing.assert_array_equal(twice.commands.values, whole.commands.values)
    assert twice.valid.all() and not twice.faults
    assert twice.usable == 1.0
    (said,) = [r for r in twice.remarks if "copies" in r]
    assert said.startswith(
        f"two.csv: {len(order) - COUNT} of {len(order)} rows are copies of others"
    )
    assert not [r for r in whole.remarks if "copies" in r]
    (view,) = inspect([twice], boat()).recordings
    assert not [text for text in view.verdicts if "go back in time" in text or "equal that" in text]
    assert view.streams[0].count == COUNT


def test_rows_of_one_time_with_other_poses_are_no_copies(tmp_path):
    """Two publishers, or a clock that was set: what of it is left out is said."""
    order = TWICE["a block again"]
    again = range(400, 440)  # 40 of the 100 rows
    recording = table(tmp_path / "two.csv", order, again)
    late = sum(f.samples for f in recording.faults if f.kind is FaultKind.STAMP)
    assert late == len(again)
    assert [r for r in recording.remarks if r.startswith("two.csv: 60 of 700 rows are copies")]
    (view,) = inspect([recording], boat()).recordings
    assert [text for text in view.verdicts if "stamps go back in time" in text]
