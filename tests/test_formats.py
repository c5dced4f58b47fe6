# SPDX-License-Identifier: MIT
"""Logs of autopilots: pymavlink and pyulog read the same numbers; damage is counted, noise refused."""

import autopilot_logs
import numpy as np
import pytest
from autopilot_logs import ardupilot, binary_message, text_message
from autopilot_runs import RUN, WRITERS, samples
from mavlink_logs import telemetry
from px4_logs import px4

from seatrial.io.formats import is_log, open_log
from seatrial.io.log import Wanted
from seatrial.util.errors import FileError, RecordingError


def dataflash_rows(path, name, *fields, instance=None):
    """By pymavlink."""
    from pymavlink.DFReader import DFReader_binary, DFReader_text

    reader = (DFReader_text if path.suffix == ".log" else DFReader_binary)(
        str(path), zero_time_base=True
    )
    rows = []
    while (m := reader.recv_match(type=[name], strict=True)) is not None:
        if instance is None or instance == m.I:
            rows.append([m.TimeUS, *(getattr(m, f) for f in fields)])
    reader.close()
    return np.array(rows, dtype=float)


@pytest.mark.parametrize("name", ["run.BIN", "run.log"])
@pytest.mark.parametrize(
    ("topic", "instance", "fields"),
    [
        ("GPS", 0, ("Lat", "Lng", "HDop", "Status")),
        ("ATT", None, ("Yaw", "Roll")),
        ("IMU[1]", 1, ("GyrZ", "AccZ")),
        ("RCOU", None, ("C1", "C3")),
    ],
)
def test_pymavlink_reads_the_same_of_a_dataflash_log(tmp_path, name, topic, instance, fields):
    path = WRITERS[name](tmp_path / name, RUN)
    expected = dataflash_rows(path, topic.partition("[")[0], *fields, instance=instance)
    found = samples(open_log(path), topic, *fields)
    assert len(expected) > 50
    assert (found.stamps == expected[:, 0].astype(np.int64) * 1000).all()
    np.testing.assert_allclose(found.values, expected[:, 1:], rtol=1e-12)


@pytest.mark.parametrize("old", [False, True])
def test_pyulog_reads_the_same_of_a_ulog(tmp_path, old):
    from pyulog import ULog

    path = px4(tmp_path / "run.ulg", RUN, old=old)
    log, other = open_log(path), ULog(str(path))
    assert set(log.topics) == {d.name for d in other.data_list}
    assert log.parameters == pytest.approx(other.initial_parameters)
    for data in other.data_list:
        topic = log.topics[data.name]
        found = samples(log, data.name, *topic.fields)
        assert topic.messages == len(found.stamps) == len(data.data["timestamp"])
        assert (found.stamps == data.data["timestamp"].astype(np.int64) * 1000).all()
        for i, field in enumerate(topic.fields):
            expected = data.data[field].astype(float)
            if data.name == "actuator_motors":  # NaN is a stopped motor
                expected = np.nan_to_num(expected)
            assert np.array_equal(found.values[:, i], expected, equal_nan=True)
    assert "timestamp_sample" in log.topics["vehicle_attitude"].fields


@pytest.mark.parametrize("version", [1, 2])
def test_pymavlink_reads_the_same_of_a_tlog(tmp_path, version):
    from pymavlink import mavutil

    path = telemetry(tmp_path / "run.tlog", RUN, version=version)
    log = open_log(path)
    other = mavutil.mavlink_connection(str(path))
    rows = []
    while (m := other.recv_match(type=["ATTITUDE"])) is not None:
        rows.append([m._timestamp, m.time_boot_ms, m.yaw, m.yawspeed])
    other.close()
    expected = np.array(rows)
    found = samples(log, "ATTITUDE", "time_boot_ms", "yaw", "yawspeed")
    np.testing.assert_array_equal(found.values, expected[:, 1:])
    # arrival is late by 30 ms on average; stamps are the autopilot's own, evenly spaced
    assert np.ptp(np.diff(found.stamps)) <= 1_000_000
    late = expected[:, 0] - found.stamps * 1e-9
    assert late.min() > -0.002
    assert 0.02 < late.mean() < 0.06


def test_times_of_several_topics_of_a_tlog_stay_together(tmp_path):
    """A 32-bit time in microseconds wraps; GPS, attitude and servos share the boat's clock."""
    path = telemetry(tmp_path / "run.tlog", RUN)
    found = open_log(path).read(
        [Wanted(t, (f,)) for t, f in (
            ("ATTITUDE", "yaw"), ("SERVO_OUTPUT_RAW", "servo1_raw"), ("GPS_RAW_INT", "lat"))]
    )  # fmt: skip
    begins = np.array([s.stamps[0] for s in found]) * 1e-9
    np.testing.assert_allclose(begins - begins[1], [0.007, 0.0, 0.031], atol=0.0011)


def test_times_of_an_autopilot_that_started_again_are_those_of_arrival(tmp_path):
    path = telemetry(tmp_path / "run.tlog", RUN)
    again = path.read_bytes()
    later = bytearray()
    at = 0
    while at < len(again):  # the same, an hour later: its own clock begins anew
        size = 8 + 12 + again[at + 9]
        stamp = int.from_bytes(again[at : at + 8], "big") + 3_600_000_000
        later += stamp.to_bytes(8, "big") + again[at + 8 : at + size]
        at += size
    path.write_bytes(again + later)
    found = samples(open_log(path), "ATTITUDE", "yaw")
    assert found.stamps[len(found.stamps) // 2] - found.stamps[0] == pytest.approx(3600e9, rel=1e-3)


@pytest.mark.parametrize("name", WRITERS)
def test_a_log_is_known_by_its_content(tmp_path, name):
    path = WRITERS[name](tmp_path / name, RUN)
    renamed = path.rename(tmp_path / "download")
    assert is_log(renamed)
    assert open_log(renamed).topics


def test_other_files_are_no_logs(tmp_path):
    for name, content in {
        "a.csv": "t,x,y\n0,1,2\n", "a.log": "12:00 INFO: began\n", "a.mcap": "\x89MCAP0\r\n", "b.txt": "FMT\n",
    }.items():  # fmt: skip
        (tmp_path / name).write_text(content)
        assert not is_log(tmp_path / name)
    assert not is_log(tmp_path)
    assert not is_log(tmp_path / "none.csv")


@pytest.mark.parametrize("name", ["run.BIN", "run.bin", "run.ulg", "run.TLOG"])
@pytest.mark.parametrize("content", [b"", b"\0" * 5000, b"nothing", bytes(range(256)) * 400])
def test_what_only_its_name_makes_a_log_is_refused(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=name):
        open_log(path)


def test_a_log_that_is_not_there(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        open_log(tmp_path / "run.BIN")


def test_topics_have_units_instances_and_parameters(tmp_path):
    log = open_log(ardupilot(tmp_path / "run.BIN", RUN))
    assert {"GPS", "IMU", "IMU[1]", "ATT", "RCOU", "BAT"} <= set(log.topics)
    assert not {"FMT", "PARM", "UNIT"} & set(log.topics)
    assert log.topics["GPS"].units["Lat"] == "deglatitude"
    assert log.topics["IMU"].units["GyrZ"] == "rad/s"
    assert log.topics["GPS"].units["Spd"] == "m/s"
    assert log.parameters["SERVO3_FUNCTION"] == 74.0
    assert log.parameters["SERVO3_REVERSED"] == 1.0
    assert log.remarks == ()
    tlog = open_log(telemetry(tmp_path / "run.tlog", RUN))
    assert tlog.parameters == {k: v for k, v in log.parameters.items() if k in tlog.parameters}
    assert "HEARTBEAT@255.190" in tlog.topics


def test_units_behind_the_messages_still_tell_the_instances(tmp_path):
    """FMTU may follow the first messages."""
    path = ardupilot(tmp_path / "run.BIN", RUN)
    data = path.read_bytes()
    late = binary_message("FMTU", (0, 8, *autopilot_logs.UNITS["IMU"]))
    first = binary_message("FMTU", (autopilot_logs.BOOT, 8, *autopilot_logs.UNITS["IMU"]))
    assert first in data
    path.write_bytes(data.replace(first, b"") + late)
    log = open_log(path)
    assert log.topics["IMU[1]"].messages == log.topics["IMU"].messages == 1000
    assert len(samples(log, "IMU[1]", "GyrZ").stamps) == 1000


def test_units_behind_the_lines_still_tell_the_instances(tmp_path):
    path = ardupilot(tmp_path / "run.log", RUN, text=True)
    stated = text_message("FMTU", (autopilot_logs.BOOT, 8, *autopilot_logs.UNITS["IMU"]))
    data = path.read_bytes()
    assert stated in data
    path.write_bytes(data.replace(stated, b"") + stated)
    log = open_log(path)
    assert log.topics["IMU[1]"].messages == log.topics["IMU"].messages == 1000


@pytest.mark.parametrize("name", WRITERS)
def test_topics_can_be_read_without_fields(tmp_path, name):
    """For their stamps."""
    log = open_log(WRITERS[name](tmp_path / name, RUN))
    for topic, found in zip(
        log.topics.values(), log.read([Wanted(t, ()) for t in log.topics]), strict=True
    ):
        assert found.stamps.shape == (topic.messages,)
        assert found.values.shape == (topic.messages, 0)


@pytest.mark.parametrize("name", WRITERS)
def test_unknown_topics_and_fields_are_named(tmp_path, name):
    log = open_log(WRITERS[name](tmp_path / name, RUN))
    with pytest.raises(RecordingError, match="no topic NONE"):
        log.read([Wanted("NONE", ("x",))])
    topic = next(iter(log.topics.values()))
    with pytest.raises(RecordingError, match="no field 'none'"):
        log.read([Wanted(topic.name, ("none",))])


def test_messages_of_a_tlog_that_overtook_each_other_are_put_in_order(tmp_path):
    """By the autopilot's own times: a network delivers late, and not in order."""
    path = telemetry(tmp_path / "run.tlog", RUN)
    whole = samples(open_log(path), "ATTITUDE", "time_boot_ms", "yaw")
    data, records, at = path.read_bytes(), [], 0
    while at < len(data):
        size = 8 + 12 + data[at + 9]
        records.append(data[at : at + size])
        at += size
    arrivals = [r[:8] for r in records]
    order = np.argsort(
        np.arange(len(records)) + np.random.default_rng(0).uniform(0, 40, len(records))
    )
    path.write_bytes(b"".join(t + records[i][8:] for t, i in zip(arrivals, order, strict=True)))
    found = samples(open_log(path), "ATTITUDE", "time_boot_ms", "yaw")
    np.testing.assert_array_equal(found.values, whole.values)
    assert (np.diff(found.stamps) > 0).all()
