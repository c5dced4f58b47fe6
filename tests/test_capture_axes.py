# SPDX-License-Identifier: MIT
"""Axes of motion-capture takes: known by the system, and turned where the body's do not point to the bow."""

import re
from dataclasses import replace

import numpy as np
import pytest
from capture_logs import body, commands, far, minute, motive, read, taken
from odd_logs import columns
from scipy.spatial.transform import Rotation
from sheets import sheet
from test_motion_capture import EXPORTS

import seatrial
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.proposal.axes import FALLS, asked_axes
from seatrial.inspection.proposal.sources import Choices, Sureness
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Axes


@pytest.fixture(scope="module")
def log():
    return minute()


@pytest.mark.parametrize("kind", ["Motive, y up", "Motive, z up", "QTM", "Vicon"])
def test_the_axes_are_known(kind, log, tmp_path):
    """Right-handed, one axis up: nothing is asked, whatever would be answered; the file says why."""
    folder, pose = tmp_path / "run", far(log.pose)
    folder.mkdir()
    bodies = [body("Otter", pose), body("Seal", pose[::-1])]
    take = folder / ("take.tsv" if kind == "QTM" else "take.csv")
    commands(log, folder)
    for count in (1, 2):  # one body; which of two is not known yet
        EXPORTS[kind](take, log.pose_t, bodies[:count])
        assert asked_axes(folder, Choices(), pytest.fail) == Axes.FLU.value
    EXPORTS[kind](take, log.pose_t, bodies[:1])
    text = seatrial.init(folder, choices=Choices(axes_answered=True)).text
    up = "y" if kind == "Motive, y up" else "z"
    assert f"known: motion capture has right-handed axes, here with {up} up" in text
    assert "as answered" not in text
    other = seatrial.init(folder, choices=Choices(axes=Axes.FRD.value)).text
    assert f"check axes: motion capture has right-handed axes; with {up} up they are" in other


def test_columns_of_a_take_that_the_user_names_are_asked_about(log, tmp_path):
    """x and z of a take with y up are left-handed; the heading is not named by one column of its quaternion."""
    folder, asked = taken(log, tmp_path / "run"), []
    choices = Choices(pose="x=Position X,y=Position Z,heading=Rotation Y")

    def falls(question, options):
        asked.append(question)
        return FALLS

    assert asked_axes(folder, choices, falls) == Axes.FRD.value
    (question,) = asked
    assert (
        "What does the heading of the log (a quaternion, Rotation X, Rotation Y, Rotation Z, Rotation W) do?"
        in question
    )


def turned_take(folder, degrees):
    """The take of a boat with two thrusters, whose body's x axis lies this far to port of the bow."""
    c = columns()
    folder.mkdir()
    pose = np.column_stack([c["east"], c["north"], c["psi"] + np.radians(degrees)])
    motive(folder / "take.csv", c["t"], [body("boat", pose)], markers=0)
    sheet(folder / "commands.csv", "t,left,right", c["t"], c["left"], c["right"])


@pytest.mark.parametrize("degrees", [37, 135])
def test_axes_that_lie_aside_of_the_boat(degrees, tmp_path):
    """The angle is proposed; without it the check names it, and what it repairs is consistent."""
    folder = tmp_path / "run"
    turned_take(folder, degrees)
    proposal, vehicle, recording = read(folder)
    assert vehicle.file.pose.psi.offset == pytest.approx(np.radians(degrees), abs=0.012)
    assert "from the way that both thrusters drive the boat: turned by -" in proposal.text
    assert check_consistency([recording], vehicle).findings == ()
    file = folder.with_suffix(".yaml")
    file.write_text(re.sub(r", offset: [\d.]+\}", "}", proposal.text))
    vehicle = seatrial.load_vehicle(file)
    report = check_consistency([seatrial.read(folder, vehicle)], vehicle)
    (finding,) = report.findings
    off, offset = re.search(
        r"off by (\d+) deg.*set offset: ([\d.]+) at pose: psi", finding.text
    ).groups()
    assert int(off) == pytest.approx(degrees, abs=2)
    repaired = report.repaired(vehicle)
    assert repaired.file.pose.psi.offset == pytest.approx(float(offset), abs=1e-3)
    assert check_consistency([seatrial.read(folder, repaired)], repaired).findings == ()


def test_axes_that_point_to_the_stern(tmp_path):
    """Both readings are consistent: a comment names the other one, and the heading is no certain one."""
    turned_take(tmp_path / "run", 180)
    proposal, _, _ = read(tmp_path / "run")
    said = "# check: both inputs drive astern; where x points to the stern set offset: "
    assert proposal.text.count(said) == 1
    (heading,) = (r for r in proposal.sources.recognised if r.signal == "heading")
    assert "moves mostly astern: check" in heading.why and heading.sure is Sureness.GUESS


@pytest.mark.parametrize("up", ["y", "z"])
def test_axes_of_a_body_that_stand_up(up, log, tmp_path):
    """The axis whose heading is read points up: no heading, and no word of clocks."""
    boat = body("boat", far(log.pose))
    stood = Rotation.from_euler("x" if up == "y" else "y", 90, degrees=True)
    boat = replace(boat, turned=boat.turned * stood)
    folder = taken(log, tmp_path / "run", boat, up=up, markers=0)
    with pytest.raises(
        RecordingError, match=r"the axis of the heading is 8\d deg from level, and has"
    ):
        seatrial.init(folder)


@pytest.mark.parametrize("degrees", [30.0, -120.0])
def test_sticks_that_drive_aside_of_the_axes(degrees, log, tmp_path):
    """Surge and sway by their own inputs: both lie turned by one angle; the name of surge says by which quarter."""
    pose = log.pose + np.array([0.0, 0.0, np.radians(degrees)])
    folder = taken(log, tmp_path / "run", body("boat", pose), up="z", markers=0)
    proposal, vehicle, _ = read(folder)
    assert vehicle.file.pose.psi.offset == pytest.approx(np.radians(degrees), abs=0.03)
    assert "F_u: {column: F_u}" in proposal.text and "F_v: {column: F_v}" in proposal.text
