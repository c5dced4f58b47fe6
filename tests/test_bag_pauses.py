# SPDX-License-Identifier: MIT
"""Between two files of a bag the recorder may lose messages: commands are unknown from there to the next one."""

import numpy as np
import pytest
import yaml
from bag_tools import SECOND, START, joy_sent, poses_sent, split1, split2, vehicle

import seatrial
from seatrial.recording.faults.pose_faults import FaultKind

SPLIT = {
    "bag": split1,
    "mcap": lambda folder, sent, n: split2(folder, sent, "mcap", n=n),
    "db3": lambda folder, sent, n: split2(folder, sent, "sqlite3", n=n),
    "mcap without metadata": lambda folder, sent, n: split2(
        folder, sent, "mcap", metadata=False, n=n
    ),
}
LENGTH, CHANGE, REST = 12.0, 1.0, 5.2  # [s] of the drive, between commands, of the first file
LOST = 0.4  # [s]


def driven(lost: float):
    """Poses, and commands on change, in two files of as many messages; `lost` [s] between them."""
    first = [s for s in drive() if s.time < START + round(REST * SECOND)]
    second = [s for s in drive() if s.time >= START + round((REST + lost) * SECOND)]
    least = min(len(first), len(second))
    return [*first[-least:], *second[:least]]


def drive():
    sent = poses_sent(LENGTH) + joy_sent(LENGTH, rate=1 / CHANGE)
    return sorted(sent, key=lambda s: s.time)


@pytest.mark.parametrize("kind", SPLIT)
def test_commands_are_unknown_from_a_pause_to_the_next_one(tmp_path, kind):
    found = seatrial.read(SPLIT[kind](tmp_path / "run", driven(LOST), 2), vehicle())
    t = (found.stamps - START) * 1e-9
    hidden = (t > REST) & (t < 6.0)
    assert hidden.sum() > 1
    np.testing.assert_array_equal(found.valid, ~hidden)
    (fault,) = [f for f in found.faults if f.kind is FaultKind.PAUSED]
    assert fault.end - fault.start == pytest.approx(6.0 - REST, abs=0.08)
    (remark,) = [r for r in found.remarks if "between its 2 files" in r]
    assert "lost messages once, for up to 0.4" in remark


@pytest.mark.parametrize("kind", SPLIT)
def test_files_that_follow_each_other_lose_nothing(tmp_path, kind):
    found = seatrial.read(SPLIT[kind](tmp_path / "run", driven(0.0), 2), vehicle())
    assert found.valid.all()
    assert not found.remarks


@pytest.mark.parametrize("begin", [-(10**30), 10**30])
def test_times_of_files_that_are_none_are_no_pauses(tmp_path, begin):
    run = SPLIT["mcap"](tmp_path / "run", driven(LOST), 2)
    content = yaml.safe_load((run / "metadata.yaml").read_text())
    files = content["rosbag2_bagfile_information"]["files"]
    files[1]["starting_time"] = {"nanoseconds_since_epoch": begin}
    (run / "metadata.yaml").write_text(yaml.safe_dump(content))
    assert not seatrial.read(run, vehicle()).remarks
