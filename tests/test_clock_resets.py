# SPDX-License-Identifier: MIT
"""Two drives in one log, the second with stamps from the start again: both count, one after the other."""

from dataclasses import replace

import numpy as np
import pytest
from sheets import sheet
from survey_boat import TRUTH, both, driven

import seatrial
from seatrial.boat.schema import PoseSource
from seatrial.io.clock_resets import apart_by_resets
from seatrial.io.reader import read
from seatrial.io.signals import Request, Rows
from seatrial.recording.clocks import clock_verdicts
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.timing import Clock, describe

SECONDS = 100.0
BACK = 5.0  # [s] the second drive begins before the first one began


def drives():
    """The vehicle and two drives of it."""
    found = [driven({}, [both, both], seconds=SECONDS, seed=seed) for seed in (1, 2)]
    return found[0][0], [replace(one, name=f"drive{i}") for i, (_, one) in enumerate(found)]


def written(folder, recordings, rows=lambda i, table: table):
    """Tables of poses and commands, one drive behind the other, each from its own zero."""
    folder.mkdir()
    for name, head in (("poses", "t,x,y,psi"), ("commands", "t,left,right")):
        parts = []
        for i, r in enumerate(recordings):
            own = (r.stamps, r.raw) if name == "poses" else (r.commands.stamps, r.commands.values)
            t = 1e-9 * own[0] - BACK * i + 100.0
            parts.append(rows(i, np.column_stack([t, own[1]])))
        sheet(folder / f"{name}.csv", head, np.concatenate(parts))
    return folder


def test_both_drives_are_read_with_their_own_times(tmp_path):
    vehicle, recordings = drives()
    found = read(written(tmp_path / "run", recordings), vehicle)
    first, second = recordings
    n = len(first.stamps)
    np.testing.assert_allclose(found.raw, np.concatenate([first.raw, second.raw]))
    np.testing.assert_allclose(np.diff(found.t[n:]), np.diff(second.t), atol=1e-6)
    assert found.segment[n - 1] != found.segment[n]
    assert found.valid[: n - 5].all() and found.valid[n:].all()
    (fault,) = [f for f in found.faults if f.kind is FaultKind.PAUSED]
    assert found.t[n - 1] <= fault.start <= fault.end <= found.t[n]
    (remark,) = [text for text in found.remarks if "back in time once, by " in text]
    assert "read as 2 drives" in remark
    assert not any("out of order" in f.kind.value for f in found.faults)


def test_the_model_of_both_is_the_truth(tmp_path):
    """As sure as the model of two logs."""
    vehicle, recordings = drives()
    together = seatrial.identify([read(written(tmp_path / "run", recordings), vehicle)], vehicle)
    apart = seatrial.identify(recordings, vehicle)
    for name in vehicle.structure.coefficients:
        error = together.standard_errors[name]
        assert abs(together.values[name] - TRUTH[name]) < 3.5 * error, name
        assert error == pytest.approx(apart.standard_errors[name], rel=0.15), name


def test_rows_that_are_written_twice_are_no_drive(tmp_path):
    """The first drive again behind itself, as of a block that is sent again."""
    vehicle, (first, _) = drives()
    folder = written(
        tmp_path / "run",
        [first, first],
        lambda i, table: table + [BACK * i, 0, 0, 0][: table.shape[1]],
    )
    found = read(folder, vehicle)
    assert found.duration == pytest.approx(first.duration)
    assert any("copies of others" in text for text in found.remarks)


@pytest.mark.parametrize("wrong", [3.0, 5000.0])
def test_a_few_wrong_stamps_are_no_drive(tmp_path, wrong):
    vehicle, (first, _) = drives()

    def spoiled(_, table):
        table[500:503, 0] = wrong + table[:3, 0]
        return table

    found = read(written(tmp_path / "run", [first], spoiled), vehicle)
    assert found.duration == pytest.approx(first.duration)
    assert not any("drives, one after" in text for text in found.remarks)


def test_poses_alone_that_go_back_are_left_out(tmp_path):
    """Where the commands do not, nothing says which of them belong to the second part."""
    vehicle, (first, second) = drives()
    folder = written(tmp_path / "run", [first, second])
    own = first.commands
    sheet(folder / "commands.csv", "t,left,right", 1e-9 * own.stamps + 100.0, own.values)
    found = read(folder, vehicle)
    assert not any("drives, one after" in text for text in found.remarks)
    assert any(f.kind is FaultKind.STAMP for f in found.faults)
    assert any("split the log there" in text for text in clock_verdicts(found.streams))


def test_stamps_beyond_all_time_stay():
    """Their sums would not fit into a number."""
    late = np.iinfo(np.int64).max - 10**12
    stamps = late + np.concatenate([np.arange(100), np.arange(100)]) * 10**9
    rows = Rows(
        stamps,
        np.zeros((200, 3)),
        describe("poses", "t", "table", clock=Clock.COLUMN, stamps=stamps),
    )
    request = Request("poses", "t", ("x",), (), (), PoseSource(), ())
    (found,), said = apart_by_resets([rows], [request])
    assert found is rows and not said
