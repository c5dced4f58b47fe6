# SPDX-License-Identifier: MIT
"""Stamps of a bag's messages: of headers, of arrival, late, on change."""

import numpy as np
import pytest
from bag_tools import (
    SECOND,
    START,
    Sent,
    drive,
    header,
    joy_sent,
    pose,
    poses_sent,
    ros1,
    stamp,
    sticks,
    turn,
    vehicle,
)
from bags_same import JOY, LENGTH
from mcap_writer import mcap

import seatrial
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.timing import Clock


def test_headers_without_a_time_are_arrivals_and_the_stream_says_so(tmp_path):
    t, _ = turn(LENGTH)
    s, _ = sticks(LENGTH)
    sent = [
        m._replace(fields={**m.fields, "header": header(0, "map")}) for m in drive(LENGTH)
        if "header" in m.fields
    ]  # fmt: skip
    for path in (ros1(tmp_path / "run.bag", sent), mcap(tmp_path / "run.mcap", sent)):
        record = seatrial.read(path, vehicle())
        assert [x.clock for x in record.streams] == [Clock.ZERO, Clock.ZERO]
        np.testing.assert_array_equal(record.stamps, START + t + 3_000_000)
        np.testing.assert_array_equal(record.commands.stamps, START + s + 1_000_000)
        assert record.streams[0].delay is None


def test_the_bags_time_can_be_asked_for(tmp_path, sent):
    record = seatrial.read(
        ros1(tmp_path / "run.bag", sent), vehicle(pose={"clock": "bag"}, commands={"clock": "bag"})
    )
    np.testing.assert_array_equal(record.stamps, START + turn(LENGTH)[0] + 3_000_000)
    np.testing.assert_array_equal(record.commands.stamps, START + sticks(LENGTH)[0] + 1_000_000)
    assert {x.clock for x in record.streams} == {Clock.ARRIVAL}


@pytest.mark.parametrize("make", [ros1, mcap])
def test_a_joypad_that_publishes_on_change_is_not_silent_unless_a_timeout_says_so(tmp_path, make):
    changes = [(0.0, 0.0), (0.5, 0.3), (0.52, 0.4), (2.5, -1.0), (7.0, 0.0)]
    sent = poses_sent(9.0) + [
        Sent("/joy", JOY, START + round(t * 1e9),
             {"header": header(START + round(t * 1e9)), "axes": [x] * 4})
        for t, x in changes
    ]  # fmt: skip
    path = make(tmp_path / f"run.{'bag' if make is ros1 else 'mcap'}", sent)
    record = seatrial.read(path, vehicle())
    assert record.faults == ()
    assert record.valid.all()
    assert record.streams[1].on_change
    limited = seatrial.read(path, vehicle(command_timeout=1.0))
    assert [f.kind for f in limited.faults] == [FaultKind.SILENT] * 3
    assert [(f.start, f.end) for f in limited.faults] == [
        pytest.approx(pair, abs=0.07) for pair in ((1.52, 2.5), (3.5, 7.0), (8.0, 9.0))
    ]
    hidden = ((limited.t >= 1.52) & (limited.t < 2.5)) | ((limited.t >= 3.5) & (limited.t < 7.0))
    np.testing.assert_array_equal(~limited.valid, hidden | (limited.t >= 8.0))


def test_messages_that_arrive_late_are_put_aside_not_mixed_in(tmp_path):
    """Two stamps change places on their way; the later one counts."""
    sent = joy_sent(LENGTH)
    sent[10], sent[11] = (
        sent[11]._replace(time=sent[10].time), sent[10]._replace(time=sent[11].time),
    )  # fmt: skip
    record = seatrial.read(ros1(tmp_path / "run.bag", poses_sent(LENGTH) + sent), vehicle())
    assert len(record.commands.stamps) == 299
    assert record.streams[1].backward == 1


def test_a_stamp_of_a_header_is_exact_to_the_nanosecond(tmp_path):
    odd = [START + i * SECOND // 15 + i % 7 for i in range(45)]
    t, eta = turn(LENGTH)
    sent = [
        Sent("/slam/pose", "geometry_msgs/msg/PoseStamped", at + 5,
             {"header": {"stamp": stamp(at), "frame_id": "map"}, "pose": pose(*row)})
        for at, row in zip(odd, eta.tolist(), strict=True)
    ]  # fmt: skip
    del t
    record = seatrial.read(mcap(tmp_path / "run.mcap", sent + joy_sent(LENGTH)), vehicle())
    assert record.stamps.tolist() == odd
