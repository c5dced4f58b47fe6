# SPDX-License-Identifier: MIT
"""Sources of a session by lines, datagrams and replays; hostile input ends none."""

import json
import socket
import sys
import time

import numpy as np
import pytest
from poolside_sources import VEHICLE, gathered, through_pipe, vehicle
from programs import piped
from waiting import PATIENCE, until

from seatrial.boat.vehicle import load_vehicle
from seatrial.onboard.live.endpoints import LONGEST_LINE
from seatrial.poolside.sources import open_source
from seatrial.poolside.sources.lines import datagrams
from seatrial.util.errors import LiveError, SeatrialError
from seatrial.util.frames import Axes


@pytest.fixture
def sender():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        yield opened


def test_lines_are_events_in_forward_left_up():
    boat = vehicle(axes="forward-right-down")
    text = b"""# a comment
{"t": 1.5, "pose": [1, 2, 0.5]}

command,1.6,0.1,0.2,0.3
{"stamp": 1700000000123456789, "position": [1, 2]}
{"t": 3, "heading": 0.25}
"""
    before = time.time_ns()
    events, said = through_pipe(text, boat)
    assert said == ()
    assert [e.kind for e in events] == ["pose", "command", "position", "heading"]
    assert [e.stamp for e in events[:3]] == [1_500_000_000, 1_600_000_000, 1700000000123456789]
    np.testing.assert_array_equal(events[0].values, [1, -2, -0.5])
    np.testing.assert_array_equal(events[1].values, [0.1, -0.2, -0.3])
    np.testing.assert_array_equal(events[2].values, [1, -2])
    np.testing.assert_array_equal(events[3].values, [-0.25])
    assert all(before <= e.arrival <= time.time_ns() for e in events)


def test_a_line_without_a_time_is_stamped_when_it_arrives():
    ((event,), _) = through_pipe(b'{"pose": [1, 2, 3]}\n', vehicle())
    assert event.stamp == event.arrival


BAD = [
    b"\xff\xfe\x00", b"nonsense", b"[" * 50_000, b'{"t": 1, "pose": [1, 2]}', b'{"t": 1, "pose": [1, 2, 1e300]}',
    b"pose,1,nan,2,3", b"pose,1,inf,2,3", b'{"t": 1e99, "pose": [1,2,3]}', b'{"stamp": 1e30, "pose": [1,2,3]}',
    b'{"t": 1, "command": [1]}', b'{"at": 3}', b'{"reload": true}', b'{"adapt": true}', b"x" * (LONGEST_LINE + 10),
    b'{"t": 1, "scale": [1]}', b"command,2,,,", b"\0" * 100,
]  # fmt: skip


def test_bad_lines_are_counted_and_end_nothing():
    good = b'{"t": 9, "pose": [1, 2, 3]}\n'
    events, (text,) = through_pipe(b"\n".join([*BAD, good]), vehicle())
    assert [e.stamp for e in events] == [9_000_000_000]
    number = int(text.split()[0])
    assert number >= len(BAD)  # the long line is several
    assert "lines could not be used; the last: line" in text
    assert len(text) < 400


@pytest.mark.parametrize("source", ["udp", "mavlink:udp"])
def test_a_udp_port_in_use_says_what_to_do(source):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        said = r"can't be opened \([^\[\]]*in use\); end the program that uses it, or give another$"
        with (
            pytest.raises(LiveError, match=said),
            open_source(f"{source}:{other.getsockname()[1]}", vehicle()),
        ):
            pass


def test_udp_is_on_loopback_unless_an_address_is_given(sender):
    source = datagrams("udp:0", vehicle())
    port = source._endpoint.port
    assert source._endpoint._socket.getsockname()[0] == "127.0.0.1"
    with gathered(source) as found:
        sender.sendto(
            b'{"t": 1, "pose": [1, 2, 3]}\n{"t": 1, "command": [0, 0, 0]}', ("127.0.0.1", port)
        )
        sender.sendto(b"junk", ("127.0.0.1", port))
        until(lambda: len(found) >= 2 and source.problems)
    assert [e.kind for e in found] == ["pose", "command"]
    again = datagrams(f"udp:127.0.0.1:{port}", vehicle())  # the port is free again
    again.close()


def test_lines_that_had_arrived_are_used_when_it_is_closed(sender):
    with datagrams("udp:0", vehicle()) as source:
        events = iter(source)
        place = ("127.0.0.1", source._endpoint.port)
        sender.sendto(b"pose,1,1,2,3", place)
        first = next(events)
        assert source.behind < PATIENCE
        for i in range(2, 102):
            sender.sendto(b"pose,%d,1,2,3" % i, place)
        source.close()  # loopback hands over at once what is sent
        assert [e.stamp for e in (first, *events)] == [i * 1_000_000_000 for i in range(1, 102)]
        assert source.behind == 0.0


def test_a_line_that_waits_shows_how_far_its_user_is_behind(sender):
    with datagrams("udp:0", vehicle()) as source:
        sender.sendto(b"pose,1,1,2,3\npose,2,1,2,3", ("127.0.0.1", source._endpoint.port))
        events = iter(source)
        next(events)
        behind = source.behind
        until(lambda: source.behind > behind + 0.1)


def test_an_empty_datagram_ends_nothing(sender):
    with datagrams("udp:0", vehicle()) as source:
        events = iter(source)
        place = ("127.0.0.1", source._endpoint.port)
        for text in (b"pose,1,1,2,3", b"", b"pose,2,1,2,3"):
            sender.sendto(text, place)
        assert [next(events).stamp for _ in range(2)] == [1_000_000_000, 2_000_000_000]


def test_options_of_a_replay_are_refused_for_a_stream(tmp_path):
    for text in ("-", "udp:0", "follow:here"):
        with pytest.raises(LiveError, match=r"--speed 2: .* is for a replay"):
            open_source(text, vehicle(), 2.0)
        with pytest.raises(LiveError, match=r"--salvage: .* is for a replay"):
            open_source(text, vehicle(), salvage=True)


@pytest.mark.parametrize(
    "text",
    ["udp:", "udp:x", "udp:99999", "udp:-1", "udp:1.2.3.4:", "udp:\u0663", "udp:300.1.1.1:9000", "mavlink:", "mavlink:x",
     "mavlink:/dev/none:57600", "mavlink:/dev/null:x", "mavlink:udp:x", "follow:/nowhere/at/all.csv", "follow:log.bin",
     "nothing.csv", ""],
)  # fmt: skip
def test_a_source_that_is_none_is_one_error(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    boat = vehicle(
        pose={"topic": "GPS_RAW_INT", "latitude": "lat", "longitude": "lon", "psi": {"topic": "ATTITUDE", "field": "yaw"}},
        commands={"topic": "SERVO_OUTPUT_RAW", "inputs": {"F_u": "servo1_raw", "F_v": "servo2_raw", "F_r": "servo3_raw"}},
    )  # fmt: skip
    with pytest.raises(SeatrialError):
        open_source(text, boat)


def test_standard_input_by_a_real_pipe(tmp_path):
    (tmp_path / "vehicle.yaml").write_text(json.dumps(VEHICLE))
    code = (
        "import sys\nfrom seatrial.boat.vehicle import load_vehicle\n"
        "from seatrial.poolside.sources import open_source\n"
        "s = open_source('-', load_vehicle(sys.argv[1]))\n"
        "print([(e.kind, e.stamp) for e in s], s.problems)"
    )
    done = piped(
        [sys.executable, "-c", code, str(tmp_path / "vehicle.yaml")],
        input="pose,1,1,2,3\nbad\n",
        check=True,
        timeout=PATIENCE,
    )
    assert done.stdout.startswith("[('pose', 1000000000)] ('1 of 2 lines could not be used")
    assert load_vehicle(tmp_path / "vehicle.yaml").inputs == ("F_u", "F_v", "F_r")
    assert np.all(Axes.FRD.signs == [1, -1, -1])
