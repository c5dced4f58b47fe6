# SPDX-License-Identifier: MIT
"""Logs of MOOS (.alog): the proposed file reads the truth, and the model of it is the boat's; damage ends in words."""

import numpy as np
import pytest
from autopilot_logs import TWIN, trial
from moos_logs import LOGSTART, THRUSTERS, moos

import seatrial
from seatrial.commands.cli import main
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.io.formats import moos as reader
from seatrial.io.formats import open_log
from seatrial.io.log import Wanted
from seatrial.util.errors import RecordingError

DESIRED = ("DESIRED_THRUST_L", "DESIRED_THRUST_R")


def proposed(path, **choices):
    found = init(path, choices=Choices(**{"axes": "forward-right-down", **choices}))
    (path.parent / "vehicle.yaml").write_text(found.text)
    return seatrial.load_vehicle(path.parent / "vehicle.yaml")


def log_of(folder, *rows, start="%% LOGSTART 1000.0\n"):
    path = folder / "own.alog"
    path.write_text(start + "".join(f"{row}\n" for row in rows))
    return open_log(path)


def samples(log, topic, *fields):
    return log.read([Wanted(topic, fields)])[0]


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("run.alog", {}),
        ("run.log", {"names": DESIRED, "absolute": True}),  # known by its banner
        ("run.alog", {"names": DESIRED, "marked": True}),
    ],
)
@pytest.mark.parametrize("axes", ["forward-right-down", "forward-left-up"])
def test_the_proposed_file_reads_the_truth(tmp_path, name, how, axes):
    """Positions and headings to their noise, each change of a command at the time of its posting."""
    run = trial(TWIN)
    path = moos(tmp_path / name, run, position=0.001, **how)
    vehicle = proposed(path, axes=axes)
    assert vehicle.inputs == how.get("names", THRUSTERS)
    recording = seatrial.read(path, vehicle)
    seconds = recording.stamps * 1e-9 - LOGSTART
    north, east, psi, *_ = run.at(seconds).T
    flat = (
        np.column_stack([north, -east, -psi])
        if axes == "forward-right-down"
        else np.column_stack([east, north, np.pi / 2 - psi])
    )
    off = (recording.eta - flat)[recording.valid]
    assert len(off) > 590
    assert np.abs(off[:, :2]).max() < 0.006
    assert np.abs(np.sin(off[:, 2])).max() < 0.02
    # the second of two thrusters is posted 10 us after the first: then both are as commanded
    both = recording.commands.stamps[::2] * 1e-9 - LOGSTART
    np.testing.assert_allclose(recording.commands.values[::2], run.command_at(both), atol=1e-6)
    assert len(both) == 1 + (np.diff(run.commands, axis=0) != 0.0).any(axis=1).sum()
    assert not recording.command_period  # each is a command, none a sample


def test_coefficients_are_the_truth_within_their_errors(tmp_path):
    """By Newton's second law, thrust of both motors ahead as 1."""
    path = moos(tmp_path / "run.alog", trial(TWIN, 240.0, 3))
    vehicle = proposed(path)
    model = seatrial.identify([seatrial.read(path, vehicle)], vehicle)
    (m, _, i), (du, _, dr), (duu, _, drr) = TWIN.mass, TWIN.linear, TWIN.quadratic
    truth = {
        "X_u": -du / m, "X_uu": -duu / m, "X_F": 2 * TWIN.full / m,
        "N_r": -dr / i, "N_rr": -drr / i, "N_F": 2 * 0.3 * TWIN.full / i,
    }  # fmt: skip
    off = {n: (model.values[n] - x) / model.standard_errors[n] for n, x in truth.items()}
    assert max(map(abs, off.values())) < 3.5, off
    assert model.values["X_F"] == pytest.approx(truth["X_F"], rel=0.01)


def test_tables_of_it_say_that_each_command_is_exact(tmp_path):
    """A table alone leaves open whether its commands are samples."""
    path = moos(tmp_path / "run.alog", trial(TWIN))
    recording = seatrial.read(path, proposed(path))
    out = tmp_path / "tables"
    assert (
        main(["convert", str(path), "--vehicle", str(tmp_path / "vehicle.yaml"), "-o", str(out)])
        == 0
    )
    vehicle = seatrial.load_vehicle(out / "vehicle.yaml")
    assert vehicle.file.commands.sampled is False
    again = seatrial.read(out, vehicle)
    assert not again.command_period
    np.testing.assert_array_equal(again.commands.values, recording.commands.values)


def test_thrust_and_rudder_are_inputs_together(tmp_path):
    path = moos(tmp_path / "run.alog", trial(TWIN), names=("DESIRED_THRUST", "DESIRED_RUDDER"))
    assert proposed(path).inputs == ("DESIRED_THRUST", "DESIRED_RUDDER")


def test_a_receiver_comes_before_the_navigation_and_either_can_be_named(tmp_path):
    path = moos(tmp_path / "run.alog", trial(TWIN))
    more = "".join(
        line.replace("NAV_", "GPS_")
        for line in path.read_text().splitlines(keepends=True)
        if "NAV_X" in line or "NAV_Y" in line
    )
    path.write_text(path.read_text() + more)
    assert proposed(path).file.pose.topic == "GPS_XY"
    assert proposed(path, pose="NAV_XY").file.pose.topic == "NAV_XY"


def test_coordinates_belong_together_by_their_times(tmp_path):
    """A posting without its other one is no position; rows may be out of order."""
    found = samples(
        log_of(
            tmp_path,
            "0.100 NAV_X pNav 1", "0.101 NAV_Y pNav 2",
            "0.200 NAV_X pNav 3",
            "0.301 NAV_Y pNav 6", "0.300 NAV_X pNav 5",
            "0.400 NAV_Y pNav 8",
        ),
        "NAV_XY", "NAV_Y", "NAV_X",
    )  # fmt: skip
    assert found.values.tolist() == [[2.0, 1.0], [6.0, 5.0]]
    assert found.stamps.tolist() == [1_000_100_000_000, 1_000_300_000_000]


def test_logs_one_behind_the_other_have_a_start_each(tmp_path):
    log = log_of(tmp_path, "0.5 DEPTH pNav 1", "%% LOGSTART 2000.25", "0.5 DEPTH pNav 2")
    assert samples(log, "DEPTH", "DEPTH").stamps.tolist() == [1_000_500_000_000, 2_000_750_000_000]


@pytest.mark.parametrize("start", ["", "%% LOGSTART 1..5\n", "%% LOGSTART 1e999\n"])
def test_without_a_start_times_count_from_zero(tmp_path, start):
    log = log_of(tmp_path, "0.5 DEPTH pNav 1", "1e300 DEPTH pNav 2", "-1 DEPTH pNav 2", start=start)
    assert samples(log, "DEPTH", "DEPTH").stamps.tolist() == [500_000_000]


def test_texts_and_broken_lines_are_no_numbers(tmp_path):
    log = log_of(
        tmp_path,
        "0.1 DEPTH pNav 1.5", "0.2 DEPTH pNav unknown", "0.3 DEPTH", "x DEPTH pNav 2", "nan DEPTH pNav 2",
        "0.4 DEPTH pNav 2.5 ", "0.5 MODE pHelmIvP ACTIVE", "0.6 DEPTH pNav " + "9" * 5000, "0.7 DEPTH pNav 3",
    )  # fmt: skip
    assert list(log.topics) == ["DEPTH"]
    assert samples(log, "DEPTH", "DEPTH").values[:, 0].tolist() == [1.5, 2.5, 3.0]


def test_what_is_no_log_is_refused_in_a_line(tmp_path, monkeypatch):
    with pytest.raises(RecordingError, match="no variable holds numbers"):
        log_of(tmp_path, "0.5 MODE pHelmIvP ACTIVE")
    monkeypatch.setattr(reader, "MOST_VARIABLES", 3)
    with pytest.raises(RecordingError, match="more than 3 variables"):
        log_of(tmp_path, *(f"0.1 A{i} pNav 1" for i in range(5)))


def test_inspect_lists_a_topic_a_line(tmp_path, capsys):
    """Characters of a log that a terminal obeys are none of them."""
    path = moos(tmp_path / "run.alog", trial(TWIN, 30.0))
    path.write_text(path.read_text() + "1.0 BAD\x1b[2J pNav 3\n")
    assert main(["inspect", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if "commands" in line] == list(THRUSTERS)
    assert [line.split()[0] for line in lines if "position" in line] == ["NAV_XY"]
    assert "BAD?[2J" in [line.split()[0] for line in lines[2:]]
