# SPDX-License-Identifier: MIT
"""`convert`: the new recording, read by the vehicle file beside it, is the old one."""

import numpy as np
import pytest
from autopilot_logs import HOLONOMIC, TWIN, ardupilot, trial
from cli_tools import done, refused
from mavlink_logs import telemetry
from px4_logs import px4

from seatrial.boat.vehicle import load_vehicle
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.io.convert import convert, write_table
from seatrial.io.formats import open_log
from seatrial.io.log import Wanted
from seatrial.io.reader import read
from seatrial.recording.sampled_commands import sampling_doubt
from seatrial.util.errors import FileError, RecordingError

TABLE_VEHICLE = """
seatrial: vehicle 1
name: boat
axes: forward-left-up
pose: {file: log.csv, stamp: time, x: x, y: y, psi: psi}
commands: {file: log.csv, stamp: time, inputs: {t: a, t_ns: b, valid: c}}
forces:
  F_u: {axis: surge, of: {t: 1}}
  F_v: {axis: sway, of: {t_ns: 1}}
  F_r: {axis: yaw, of: {valid: 1}}
structure: auto
"""
WRITERS = {"run.BIN": ardupilot, "run.ulg": px4, "run.tlog": telemetry}


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """Logs and their vehicle files."""
    folder = tmp_path_factory.mktemp("logs")
    made = {}
    for name, write in WRITERS.items():
        path = write(folder / name, trial(HOLONOMIC if name.endswith("ulg") else TWIN))
        file = folder / f"{name}.yaml"
        file.write_text(init(path, choices=Choices(axes="forward-right-down")).text)
        made[name] = path, file
    return made


def same(found, expected, exact=True):
    close = np.testing.assert_array_equal if exact else np.testing.assert_allclose
    more = {} if exact else {"atol": 1e-6, "rtol": 1e-12}
    np.testing.assert_array_equal(found.stamps, expected.stamps)
    close(found.eta, expected.eta, **more)
    assert found.command_period == pytest.approx(expected.command_period, rel=1e-3)
    assert found.command_sampled == expected.command_sampled
    for part in ("commands", "scales"):
        mine, its = getattr(found, part), getattr(expected, part)
        assert mine.names == its.names
        np.testing.assert_array_equal(mine.stamps, its.stamps)
        close(mine.values, its.values, **more)
    np.testing.assert_array_equal(found.asynchronous.stamps, expected.asynchronous.stamps)


@pytest.mark.parametrize("name", WRITERS)
def test_tables_hold_the_same_recording(given, tmp_path, name):
    """To the last digit, stamps since 1970 included."""
    path, file = given[name]
    written = convert(path, tmp_path / "out", load_vehicle(file))
    assert {p.name for p in written} == {
        "poses.csv", "heading.csv", "yaw_rate.csv", "commands.csv", "scales.csv", "vehicle.yaml",
    }  # fmt: skip
    same(back(tmp_path / "out"), read(path, load_vehicle(file)))


def back(folder):
    """What was converted into a folder, by its own vehicle file."""
    return read(folder, load_vehicle(folder / "vehicle.yaml"))


def rows_alike(found, expected, kept=slice(None)):
    """To the bit, of the poses that are kept."""
    np.testing.assert_array_equal(found.stamps, expected.stamps[kept])
    np.testing.assert_array_equal(found.eta, expected.eta[kept])
    np.testing.assert_array_equal(found.commands.stamps, expected.commands.stamps)
    np.testing.assert_array_equal(found.commands.values, expected.commands.values)


GAPS = {  # rows of 40 without a pose, without commands
    "each row has both": (0, 0), "commands alone": (3, 0), "poses alone": (0, 3), "either": (3, 4),
}  # fmt: skip


def one_table(folder, gaps, valid=""):
    """A table of poses and commands, a row each tenth of a second, and its vehicle."""
    without_pose, without_command = gaps
    (folder / "log").mkdir()
    rows = []
    for k in range(40):
        pose = ",," if without_pose and k % without_pose == 1 else f"{k},0,{0.01 * k}"
        driven = ",," if without_command and k % without_command == 2 else f"{k / 40},1,0.5"
        rows.append(f"{k // 10}.{k % 10},{pose},{driven},{int(k % 7 > 0)}\n")
    (folder / "log" / "log.csv").write_text(f"time,x,y,psi,a,b,c,ok\n{''.join(rows)}")
    (folder / "vehicle.yaml").write_text(TABLE_VEHICLE.replace("pose: {", f"pose: {{{valid}"))
    return folder / "log", load_vehicle(folder / "vehicle.yaml")


@pytest.mark.parametrize("valid", ["", "valid: ok, "])
@pytest.mark.parametrize("gaps", GAPS.values(), ids=GAPS)
def test_commands_in_the_rows_of_the_poses_may_be_samples_in_a_new_table_too(tmp_path, gaps, valid):
    log, vehicle = one_table(tmp_path, gaps, valid)
    convert(log, tmp_path / "out", vehicle)
    found, expected = back(tmp_path / "out"), read(log, vehicle)
    assert sampling_doubt(found) == sampling_doubt(expected) != []
    rows_alike(found, expected)
    np.testing.assert_array_equal(found.valid, expected.valid)


@pytest.mark.parametrize("kind", ["mcap", "bag", "db3"])
@pytest.mark.parametrize("valid", ["", "valid: ok, "])
@pytest.mark.parametrize("gaps", [GAPS["each row has both"], GAPS["commands alone"]])
def test_commands_in_the_rows_of_the_poses_may_be_samples_in_a_bag_too(tmp_path, gaps, valid, kind):
    log, vehicle = one_table(tmp_path, gaps, valid)
    bag, file = convert(log, tmp_path / f"out.{kind}", vehicle)
    found, expected = read(bag, load_vehicle(file)), read(log, vehicle)
    assert sampling_doubt(found) == sampling_doubt(expected) != []
    rows_alike(found, expected, expected.valid)  # the others are not in it


@pytest.mark.parametrize("epoch", [0, 1_700_000_000])  # [s] stamps of one column, of two
def test_a_table_of_all_signals_stays_one_whatever_its_commands_are_called(tmp_path, epoch):
    """Its commands, a tenth of a second apart, may be samples, in the new table as in the old one."""
    (tmp_path / "log").mkdir()
    rows = "".join(f"{epoch + k // 10}.{k % 10},{k},0,0,{k * 0.01},1,0.5\n" for k in range(40))
    (tmp_path / "log" / "log.csv").write_text(f"time,x,y,psi,a,b,c\n{rows}")
    (tmp_path / "vehicle.yaml").write_text(TABLE_VEHICLE)
    vehicle = load_vehicle(tmp_path / "vehicle.yaml")
    convert(tmp_path / "log", tmp_path / "out", vehicle)
    found, expected = back(tmp_path / "out"), read(tmp_path / "log", vehicle)
    rows_alike(found, expected)
    assert found.command_period == pytest.approx(expected.command_period)
    assert not found.command_sampled


@pytest.mark.parametrize("kind", ["mcap", "bag", "db3"])
def test_a_bag_holds_the_same_recording(given, tmp_path, kind):
    path, file = given["run.tlog"]
    bag, vehicle = convert(path, tmp_path / f"out.{kind}", load_vehicle(file))
    same(read(bag, load_vehicle(vehicle)), read(path, load_vehicle(file)), exact=False)


def test_tables_of_a_bag_hold_the_same_recording(given, tmp_path):
    """There and back."""
    path, file = given["run.BIN"]
    bag, first = convert(path, tmp_path / "out.mcap", load_vehicle(file))
    convert(bag, tmp_path / "back", load_vehicle(first))
    same(back(tmp_path / "back"), read(bag, load_vehicle(first)))


def test_all_topics_of_a_log_become_tables(given, tmp_path):
    path, _ = given["run.BIN"]
    written = convert(path, tmp_path / "out")
    log = open_log(path)
    assert {p.name for p in written} == {
        "ARM.csv", "ATT.csv", "BAT.csv", "GPS.csv", "IMU.csv", "IMU_1.csv", "MSG.csv", "POS.csv",
        "RCOU.csv", "parameters.csv",
    }  # fmt: skip
    (gps,) = log.read([Wanted("GPS", log.topics["GPS"].fields)])
    lines = (tmp_path / "out" / "GPS.csv").read_text().splitlines()
    assert lines[0] == "t," + ",".join(log.topics["GPS"].fields)
    rows = [[float(x) for x in line.split(",")[1:]] for line in lines[1:]]
    np.testing.assert_array_equal(rows, gps.values)
    assert [int(line.split(",")[0]) for line in lines[1:]] == gps.stamps.tolist()
    assert "SERVO3_REVERSED,1.0" in (tmp_path / "out" / "parameters.csv").read_text().splitlines()


def test_what_can_not_be_converted_is_named(given, tmp_path):
    path, file = given["run.BIN"]
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    for out, message in (("full", "not empty"), ("x.csv", "expected a folder")):
        with pytest.raises(FileError, match=message):
            convert(path, tmp_path / out, load_vehicle(file))
    with pytest.raises(RecordingError, match="give --vehicle, or a folder"):
        convert(path, tmp_path / "out.mcap")
    (tmp_path / "a.csv").write_text("t,x,y\n0,1,2\n")
    with pytest.raises(RecordingError, match="only logs of autopilots"):
        convert(tmp_path / "a.csv", tmp_path / "out")
    assert (tmp_path / "full" / "mine.txt").read_text() == "mine"


def test_a_table_that_can_not_be_written_leaves_nothing(tmp_path, monkeypatch):
    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("seatrial.util.files.os.fsync", full)
    stamps = np.arange(3) * 10**9
    with pytest.raises(FileError, match=r"poses\.csv: can't be written \(No space left"):
        write_table(tmp_path / "poses.csv", ["t"], ["x"], stamps, np.zeros((3, 1)))
    assert list(tmp_path.iterdir()) == []


def test_the_command_names_what_it_wrote(given, tmp_path, capsys):
    path, file = given["run.ulg"]
    out = tmp_path / "out.mcap"
    shown = done(capsys, "convert", path, "--vehicle", file, "-o", out)
    assert f"seatrial inspect {out} --vehicle {out.with_suffix('.yaml')}" in shown
    assert "exists" in refused(capsys, "convert", path, "--vehicle", file, "-o", out)


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_stamps_before_zero_have_no_place_in_a_bag(tmp_path, kind):
    """Commands begin half a second before the poses, whose stamps begin at 0."""
    stamps = np.array([-500_000_000, 0, 500_000_000])
    columns = {"linear.x": np.zeros(3)}
    topic = BagTopic("/cmd_vel", "geometry_msgs/msg/Twist", stamps, stamps, columns)
    out = tmp_path / f"out.{kind}"
    with pytest.raises(FileError, match=r"stamps begin at -0\.5 s, and a bag has none before 0"):
        write_bag(out, [topic])
    assert list(tmp_path.iterdir()) == []
