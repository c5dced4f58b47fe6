# SPDX-License-Identifier: MIT
"""A recording that is replayed to a session: the same events as the reader of logs finds, in their time."""

import threading

import numpy as np
import pytest
from bag_tools import joy_sent, poses_sent
from bag_tools import vehicle as bag_boat
from mcap_writer import mcap
from poolside_sources import VEHICLE, poses_of, table, vehicle

from seatrial.io.reader import read
from seatrial.poolside.sources import open_source
from seatrial.util.errors import LiveError, RecordingError


def test_a_replay_is_the_recording(tmp_path):
    table(tmp_path / "run.csv")
    boat = vehicle()
    source = open_source(str(tmp_path / "run.csv"), boat, 0.0)
    events = list(source)
    recording = read(tmp_path / "run.csv", boat)
    poses = poses_of(events)
    assert [e.stamp for e in poses] == recording.stamps.tolist()
    np.testing.assert_allclose([e.values for e in poses], recording.eta, atol=1e-12)
    commands = [e for e in events if e.kind == "command"]
    np.testing.assert_array_equal([e.values for e in commands], recording.commands.values)
    arrivals = [e.arrival for e in events]
    assert arrivals == sorted(arrivals)
    assert source.now() == arrivals[-1]
    assert source.recorded


def test_a_replay_gives_the_measured_point_not_the_origin(tmp_path):
    table(tmp_path / "run.csv")
    plain, levered = vehicle(), vehicle(pose={**VEHICLE["pose"], "lever": [0.5, -0.2]})
    both = [poses_of(open_source(str(tmp_path / "run.csv"), b, 0.0)) for b in (plain, levered)]
    np.testing.assert_array_equal(*[[e.values for e in events] for events in both])


def test_a_replay_keeps_rows_that_are_out_of_order(tmp_path):
    lines = table(tmp_path / "run.csv")
    lines[50], lines[60] = lines[60], lines[50]
    (tmp_path / "run.csv").write_text("t,x,y,psi,F_u,F_v,F_r\n" + "\n".join(lines) + "\n")
    events = list(open_source(str(tmp_path / "run.csv"), vehicle(), 0.0))
    stamps = [e.stamp for e in poses_of(events)]
    assert sorted(stamps) != stamps
    assert len(stamps) == 200
    arrivals = [e.arrival for e in events]
    assert arrivals == sorted(arrivals)


class Clock:
    """A clock that goes on only while somebody waits, as a source's `Event` waits."""

    def __init__(self, closed_at: float = np.inf) -> None:
        self.now, self.closed_at = 100.0, 100.0 + closed_at

    def monotonic(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        self.now += seconds

    def is_set(self) -> bool:
        return self.now >= self.closed_at


def test_a_replay_at_speed_takes_its_share_of_the_time(tmp_path, monkeypatch):
    table(tmp_path / "run.csv", 41)

    def replayed(speed, closed_at=np.inf):
        source, clock = open_source(str(tmp_path / "run.csv"), vehicle(), speed), Clock(closed_at)
        monkeypatch.setattr("seatrial.poolside.sources.replay.time", clock)
        source._closed = clock
        return [(clock.now - 100.0, event) for event in source]

    events = replayed(4.0)
    begin = events[0][1].arrival
    for at, event in events:
        assert at == pytest.approx((event.arrival - begin) * 1e-9 / 4.0)
    assert events[-1][0] == pytest.approx(0.5)  # 2 s of recording
    assert [event.stamp for _, event in replayed(4.0, 0.25)] == [
        event.stamp for at, event in events if at < 0.25
    ]
    source = open_source(str(tmp_path / "run.csv"), vehicle(), 0.01)
    monkeypatch.undo()
    threading.Timer(0.3, source.close).start()
    assert len(list(source)) < 10  # a wait ends where it is closed
    with pytest.raises(LiveError):
        open_source(str(tmp_path / "run.csv"), vehicle(), float("nan"))


def test_a_bag_that_is_cut_off_is_replayed_by_wish(tmp_path):
    bag = mcap(tmp_path / "run.mcap", poses_sent(2.0) + joy_sent(2.0), compression="")
    bag.write_bytes(bag.read_bytes()[:-200])
    with pytest.raises(RecordingError, match="--salvage reads what is left"):
        open_source(str(bag), bag_boat())
    kinds = [event.kind for event in open_source(str(bag), bag_boat(), 0.0, salvage=True)]
    assert {"pose", "command"} == set(kinds) and len(kinds) > 20
