# SPDX-License-Identifier: MIT
"""Exports of Motive, QTM and Vicon: the boat's poses as they were, or one line that says why not."""

import re
from dataclasses import replace
from datetime import datetime, timezone
from functools import partial

import numpy as np
import pytest
from capture_logs import DRAUGHT, body, motive, qualisys, vicon
from init_tools import proposed
from logs import drive, half
from odd_logs import columns
from scipy.spatial.transform import Rotation

import seatrial
from seatrial.commands.cli import main
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.proposal.axes import FALLS, asked_axes
from seatrial.inspection.proposal.sources import Choices, Sureness
from seatrial.io.table import open_tables
from seatrial.simulation.plan import load_plan
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Axes

RATE = 30.0  # [Hz]
TILT = 0.02  # [rad] of the bodies; its square is the error of a heading by another axis of the body
BEGUN = 1_683_815_465.123  # [s] 2023-05-11 14:31:05.123 UTC
LOST = range(300, 330)  # rows without the boat


@pytest.fixture(scope="module")
def log():
    """A minute of a boat, whose poses are the truth here."""
    return drive(60.0, rate=RATE, sticks=half)


def far(pose):
    """The same motion over metres, through all headings; (n, 3)."""
    t = np.arange(len(pose)) / RATE
    psi = 0.4 * t + 0.3 * np.sin(t)
    steps = 0.3 / RATE * np.column_stack([np.cos(psi), np.sin(psi)])
    return np.column_stack([np.cumsum(steps, axis=0), psi])


def still(pose, x):
    """A body that lies at x [m], as cameras see it."""
    noise = np.random.default_rng(3).normal(size=pose.shape) * 1e-4
    return np.array([x, 1.0, 0.5]) + noise


def commands(log, folder, clock=lambda t: t):
    """The table of the commands beside the take."""
    rows = np.column_stack([clock(log.command_t), log.command])
    np.savetxt(
        folder / "commands.csv", rows, fmt="%.6f", delimiter=",", header="t,F_u,F_v,F_r", comments=""
    )  # fmt: skip


def taken(log, folder, *bodies, clock=lambda t: t, **how):
    """A folder with the take of these bodies, by default a boat's far motion, and the commands."""
    folder.mkdir(exist_ok=True)
    motive(folder / "take.csv", log.pose_t, bodies or [body("boat", far(log.pose))], **how)
    commands(log, folder, clock)
    return folder


def read(folder, **choices):
    """The proposal, its vehicle file and the recording by it."""
    proposal, vehicle = proposed(folder, **choices)
    return proposal, vehicle, seatrial.read(folder, vehicle)


def is_truth(recording, pose, t, missing=(), slack=1e-5):
    """Whether every pose is the boat's at its time; (n, 3) and (n,)."""
    seen = np.setdiff1d(np.arange(len(t)), list(missing))
    at = np.searchsorted(t[seen], recording.t + t[seen][0] - 1e-3)
    good = recording.valid
    assert good.sum() == len(seen)
    np.testing.assert_allclose(recording.t[good], t[seen] - t[0], atol=1e-5)
    error = recording.eta[good] - pose[seen][: len(at)]
    np.testing.assert_allclose(error[:, :2], 0.0, atol=slack)
    np.testing.assert_allclose(np.angle(np.exp(1j * error[:, 2])), 0.0, atol=2 * TILT**2)


MOTIVE = {
    "y up": {},
    "z up": {"up": "z"},
    "millimetres": {"length": "Millimeters"},
    "centimetres, 1.25": {"length": "Centimeters", "version": "1.25"},
    "Euler angles, y up": {"rotation": "XYZ"},
    "Euler angles, z up": {"rotation": "ZYX", "up": "z"},
    "without markers and errors": {"markers": 0, "error": False},
}
EXPORTS = {f"Motive, {name}": partial(motive, **how) for name, how in MOTIVE.items()} | {
    "QTM": lambda path, t, bodies: qualisys(path, 30, bodies),
    "QTM without frames": lambda path, t, bodies: qualisys(path, 30, bodies, frames=False, time=False),
    "QTM without times": lambda path, t, bodies: qualisys(path, 30, bodies, time=False, lost=""),
    "QTM without the matrix": lambda path, t, bodies: qualisys(path, 30, bodies, matrix=False),
    "Vicon": lambda path, t, bodies: vicon(path, 30, bodies),
    "Vicon in radians": lambda path, t, bodies: vicon(path, 30, bodies, kind="Objects", angle="rad"),
    "Vicon, quaternions": lambda path, t, bodies: vicon(path, 30, bodies, quaternion=True, more=True),
}  # fmt: skip


@pytest.mark.parametrize("kind", EXPORTS)
def test_poses_are_the_boats(kind, log, tmp_path):
    """Positions, headings and times of every row in which it was seen; a gap where it was not."""
    folder = tmp_path / "run"
    folder.mkdir()
    pose = far(log.pose)
    suffix = "tsv" if kind.startswith("QTM") else "csv"
    EXPORTS[kind](
        folder / f"take.{suffix}", log.pose_t, [body("Otter", pose, tilt=TILT, lost=LOST)]
    )
    commands(log, folder)
    _, vehicle, recording = read(folder)
    is_truth(recording, pose, log.pose_t, LOST)
    assert not any("zone" in remark for remark in recording.remarks)
    assert vehicle.file.pose.file == f"take.{suffix}"
    np.testing.assert_allclose(recording.commands.values, log.command, atol=1e-6)
    first = log.pose_t[0] * 1e9
    assert abs(int(recording.commands.stamps[0]) - int(recording.stamps[0]) + first) < 1e4


def test_columns_of_a_body(log, tmp_path):
    """Metres, seconds, a unit quaternion; height along y; NaN where it was not seen."""
    one = body("Otter", far(log.pose), lost=LOST)
    path = motive(tmp_path / "take.csv", log.pose_t, [one], length="Millimeters", rotation="YZX")
    (table,) = open_tables(path).values()
    assert table.name == "Otter"
    np.testing.assert_allclose(table.columns(["Time"])[:, 0], log.pose_t, atol=1e-6)
    clock = table.columns(["Capture Time"])[:, 0]
    np.testing.assert_allclose(clock - log.pose_t, BEGUN, atol=1e-5)
    height, quaternion = table.columns(["Position Y"])[:, 0], table.columns(table.names[5:9])
    assert np.nanmax(np.abs(height - DRAUGHT)) < 0.02
    assert not np.isfinite(table.columns(table.names[2:9])[list(LOST)]).any()
    turned = Rotation.from_quat(quaternion[one.seen])
    up = turned.apply([0.0, 1.0, 0.0])
    np.testing.assert_allclose(up[:, 1], 1.0, atol=2 * TILT**2)
    east = turned.apply([1.0, 0.0, 0.0])  # the bow, in x and -z
    heading = np.arctan2(-east[:, 2], east[:, 0])
    wrong = np.angle(np.exp(1j * (heading - far(log.pose)[one.seen, 2])))
    np.testing.assert_allclose(wrong, 0.0, atol=1e-5)


@pytest.mark.parametrize(
    "write", [motive, lambda p, _, b: qualisys(p, 30, b), lambda p, _, b: vicon(p, 30, b)]
)
def test_several_bodies(write, log, tmp_path, capsys):
    """The one that moves is proposed, the others are named, and --pose takes another."""
    folder = tmp_path / "run"
    folder.mkdir()
    pose = far(log.pose)
    bodies = [body("gate", still(pose, 3.0)), body("P 7", pose), body("dock", still(pose, -2.0))]
    path = write(folder / "take.csv", log.pose_t, bodies)
    commands(log, folder)
    names = [table.name for table in open_tables(path).values()]
    proposal, vehicle, recording = read(folder)
    assert vehicle.file.pose.file == f"take.csv:{names[1]}" and "P 7" in names[1]
    is_truth(recording, pose, log.pose_t)
    (x,) = (r for r in proposal.sources.recognised if r.signal == "x")
    assert all(any(name in other for other in x.others) for name in (names[0], names[2]))
    again = seatrial.init(folder, choices=Choices(pose=f"take.csv:{names[1]}"))
    assert again.text.count(f"take.csv:{names[1]}") == 1
    assert main(["inspect", str(folder)]) == 0
    assert all(f"take.csv:{name}: " in capsys.readouterr().out for name in names[:1])


def test_two_boats_are_a_question(log, tmp_path):
    """Both move, and neither is named boat: the user says which; a name decides."""
    pose = far(log.pose)
    folder = taken(log, tmp_path / "run", body("Otter", pose), body("Seal", pose[::-1]))
    with pytest.raises(
        RecordingError, match=r"take\.csv:Otter, take\.csv:Seal; name one with --pose"
    ):
        seatrial.init(folder)
    _, vehicle, recording = read(folder, pose="Seal")
    assert vehicle.file.pose.file == "take.csv:Seal"
    is_truth(recording, pose[::-1], log.pose_t)
    motive(folder / "take.csv", log.pose_t, [body("Seal", pose), body("my boat", pose[::-1])])
    assert "take.csv:my boat" in seatrial.init(folder).text


def seconds_late(recording):
    """The first command after the first pose [s]."""
    return (recording.commands.stamps[0] - recording.stamps[0]) * 1e-9


def test_commands_by_the_wall_clock(log, tmp_path):
    """Stamps since 1970: the poses count from the start of the capture."""
    folder = taken(log, tmp_path / "run", clock=lambda t: t + BEGUN)
    proposal, vehicle, recording = read(folder)
    assert vehicle.file.pose.stamp.column == "Capture Time"
    assert any("02.31.05.123 PM has no zone, and counts as UTC" in r for r in recording.remarks)
    assert seconds_late(recording) == pytest.approx(log.command_t[0] - log.pose_t[0], abs=1e-5)
    assert "offset" not in proposal.text.partition("inputs:")[0]


@pytest.mark.parametrize(
    "case",
    [
        (7200.0, "s", "is 2 h behind that of the poses, another time zone: offset -7200 written to commands: stamp"),
        (-20_700.0, "ms", "is 5.75 h ahead of that of the poses, another time zone: offset 20700000 written to commands"),
        (-19_800.0, "dates", "is 5.5 h ahead of that of the poses, another time zone: offset -19800 written to pose: stamp"),
    ],
)  # fmt: skip
def test_commands_of_another_time_zone(case, log, tmp_path, capsys):
    """The offset is proposed and stated; of stamps that take none, as dates, at those of the poses."""
    zone, unit, said = case
    file, factor = tmp_path / "boat.yaml", 1e3 if unit == "ms" else 1.0
    folder = taken(log, tmp_path / "run", clock=lambda t: (t + BEGUN - zone) * factor, markers=0)
    if unit == "dates":
        lines = [line.split(",", 1) for line in (folder / "commands.csv").read_text().splitlines()]
        dated = [
            f"{datetime.fromtimestamp(float(t), timezone.utc):%Y-%m-%dT%H:%M:%S.%f}Z,{rest}"
            for t, rest in lines[1:]
        ]
        (folder / "commands.csv").write_text("\n".join([",".join(lines[0]), *dated]))
    assert main(["init", str(folder), "-o", str(file)]) == 0
    console = capsys.readouterr().out.partition("structure: auto")[2]
    assert said in console and said in file.read_text()
    recording = seatrial.read(folder, seatrial.load_vehicle(file))
    assert seconds_late(recording) == pytest.approx(log.command_t[0] - log.pose_t[0], abs=1e-5)


@pytest.mark.parametrize(
    ("late", "said"),
    [(900.0, "that both were recorded together"), (3 * 86_400, r"commands run from 259200 s to 25926\d")],
)  # fmt: skip
def test_a_time_that_is_no_time_zone_is_refused(late, said, log, tmp_path):
    """A quarter of an hour, or days: two drives, not two clocks."""
    folder = taken(log, tmp_path / "run", clock=lambda t: t + BEGUN + late, markers=0)
    with pytest.raises(RecordingError, match=said):
        seatrial.init(folder)


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


@pytest.mark.parametrize("late", [3.0, -3.0, 20.0])
def test_commands_whose_clock_began_at_another_time(late, tmp_path):
    """A log that was started by hand: its offset is found up to 5 s; beyond it says what it may be."""
    folder, c = tmp_path / "run", columns()
    folder.mkdir()
    motive(
        folder / "take.csv",
        c["t"],
        [body("boat", np.column_stack([c[k] for k in ("east", "north", "psi")]))],
    )
    rows = np.column_stack([c["t"] + late, c["left"], c["right"]])
    np.savetxt(folder / "commands.csv", rows, delimiter=",", header="t,left,right", comments="")
    if late > 5.0:
        with pytest.raises(
            RecordingError, match="if each table has its own, set 'offset: SECONDS' at"
        ):
            seatrial.init(folder)
        return
    _, vehicle, recording = read(folder)
    side = "before" if late > 0 else "after"
    (finding,) = check_consistency([recording], vehicle).findings
    assert f"act about 3.0 s {side} their stamps" in finding.text
    assert f"'offset: {late:.1f}' at commands: stamp" in finding.text
    file = folder.with_suffix(".yaml")
    file.write_text(file.read_text().replace("{column: t}", f"{{column: t, offset: {late}}}"))
    vehicle = seatrial.load_vehicle(file)
    assert check_consistency([seatrial.read(folder, vehicle)], vehicle).findings == ()


def test_begins_that_can_not_be_read(log, tmp_path):
    """AM and PM in another language: stated, and not used."""
    path = motive(
        tmp_path / "take.csv", log.pose_t, [body("boat", log.pose)], begun="2023-11-28 10.27.58.765 DU."
    )  # fmt: skip
    (table,) = open_tables(path).values()
    assert "Capture Time" not in table.names
    assert any("'2023-11-28 10.27.58.765 DU.' is in no known format" in r for r in table.remarks)


def test_a_take_alone(log, tmp_path):
    """Without commands: where they belong."""
    path = motive(tmp_path / "take.csv", log.pose_t, [body("boat", log.pose)])
    with pytest.raises(
        RecordingError, match="has poses alone, and no commands: put it in a folder"
    ):
        seatrial.init(path)


REFUSED = {
    "markers": (lambda p, t, b: motive(p, t, [], markers=18), "no rigid body with position and rotation but 18 markers"),
    "local": (partial(motive, space="Local"), "Coordinate Space is Local"),
    "feet": (lambda p, t, b: _changed(motive(p, t, b), "Meters", "Feet"), "unit of lengths is 'Feet'"),
    "order": (lambda p, t, b: _changed(motive(p, t, b, rotation="XYZ"), "Type,XYZ", "Type,XYX"), "Rotation Type is 'xyx'"),
    "never seen": (lambda p, t, b: motive(p, t, [replace(b[0], seen=b[0].seen & False)]), "boat is seen in none of 1800 rows"),
    "devices": (lambda p, t, b: p.write_text("Devices\n100\n,,plate\nFrame,Sub Frame,Fx\n,,N\n1,0,2\n\n" + vicon(p, 30, b).read_text()),
                "in its first table, Devices"),
    "trajectories": (lambda p, t, b: _changed(vicon(p, 30, b), "Segments", "Trajectories", "R", "Q"), "make an object"),
    "3D": (lambda p, t, b: _changed(qualisys(p, 30, b), "Roll", "Q", "Rot[0]", "Q"), "has no rigid body"),
    "no columns": (lambda p, t, b: p.write_text("NO_OF_FRAMES\t7\nDATA_INCLUDED\t3D\n1.0\t2.0\n"), "export 6DOF data"),
    "no rate": (lambda p, t, b: _changed(qualisys(p, 30, b, time=False), "FREQUENCY\t30", "FREQUENCY\tEXT"),
                "the frame rate is 'EXT', not a number"),
    "columns": (lambda p, t, b: p.write_text(f"Format Version,1.23,Take Name,a\n,Name\nFrame,{'X,' * 20_000}\n"), "of at most 16384"),
    "bodies": (lambda p, t, b: motive(p, t[:3], [body(f"b{i}", b[0].place[:3]) for i in range(65)], markers=0),
               "65 rigid bodies, of at most 64"),
    "cut off": (lambda p, t, b: p.write_text(motive(p, t, b).read_text()[:5000].rpartition(",")[0].rpartition("\n")[0] + "\n8,0.2,0.1"),
                "3 cells, expected 22; is the file cut off?"),
}  # fmt: skip


def _changed(path, *pairs):
    text = path.read_text()
    for old, new in zip(pairs[::2], pairs[1::2], strict=True):
        text = text.replace(old, new)
    path.write_text(text)


@pytest.mark.parametrize("kind", REFUSED)
def test_refused_in_one_line(kind, log, tmp_path, capsys):
    """What was found, and what to do."""
    write, said = REFUSED[kind]
    write(tmp_path / "take.csv", log.pose_t, [body("boat", log.pose)])
    assert main(["inspect", str(tmp_path / "take.csv")]) == 1
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


def test_hostile_names(log, tmp_path):
    """Names of bodies come out printable, short and different."""
    names = ["../a/b", "../a\\b", "x" * 300, "x" * 301, "tab\x0bed", "a\u202eb"]
    bodies = [body(name, log.pose[:5], seed=i) for i, name in enumerate(names)]
    tables = open_tables(motive(tmp_path / "take.csv", log.pose_t[:5], bodies, markers=0))
    assert len(tables) == len(names)
    assert all(name.isprintable() and "/" not in name and len(name) < 50 for name in tables)


def test_a_marker_with_the_name_of_the_body(log, tmp_path):
    """The body's position is its own, whichever comes first."""
    path, pose = tmp_path / "take.csv", far(log.pose)[:50]
    motive(path, log.pose_t[:50], [body("Otter", pose)], up="z", markers=0, error=False)
    lines = [line.split(",") for line in path.read_text().splitlines()]
    for i, extra in enumerate(("Marker", "Otter", "7", "Position"), 2):
        lines[i][2:2] = [extra] * 3
    lines[6][2:2] = "XYZ"
    for row in lines[7:]:
        row[2:2] = ["9.0", "9.0", "9.0"]
    path.write_text("\n".join(map(",".join, lines)))
    (table,) = open_tables(path).values()
    assert table.name == "Otter"
    np.testing.assert_allclose(table.columns(["Position X", "Position Y"]), pose[:, :2], atol=1e-5)


PLAIN = (  # text, names of its columns
    ("Format Version,t,x\n1,0.0,1\n1,0.1,2\n", ["Format Version", "t", "x"]),
    ("Format Version,1.0\nt,x,y\n0,1,2\n1,2,3\n", ["t", "x", "y"]),
    ("Objects\n1\n2\n3\n", ["Objects"]),
    ("Objects,t\n1,0.0\n2,0.1\n", ["Objects", "t"]),
    ("Segments\n3\nFrame,x\n0,1\n1,2\n2,3\n", ["Frame", "x"]),
    ("NO_OF_FRAMES,t\n1,0.0\n2,0.1\n", ["NO_OF_FRAMES", "t"]),
    ("FILE_VERSION\t1\nt\tx\n0\t1\n1\t2\n", ["FILE_VERSION", "1"]),
    ("Frame,Time,x\n1,0.0,2\n2,0.1,3\n", ["Frame", "Time", "x"]),
)


@pytest.mark.parametrize(("text", "names"), PLAIN)
def test_tables_that_begin_as_exports(text, names, tmp_path):
    """One word in common is no export: the table is read as ever."""
    path = tmp_path / "log.csv"
    path.write_text(text)
    (table,) = open_tables(path).values()
    assert table.names == names


def test_exports_that_a_spreadsheet_saved(log, tmp_path):
    """QTM's with commas and lines of one length; Motive's with semicolons and decimal commas."""
    path, pose = tmp_path / "take.csv", far(log.pose)[:50]
    for mark in ",;":
        if mark == ",":
            text = qualisys(path, 30, [body("Otter", pose)]).read_text().replace(", ", " ")
            lines = [line.replace("\t", ",") for line in text.splitlines()]
            text = "\n".join(line + "," * (20 - line.count(",")) for line in lines)
        else:
            text = motive(path, log.pose_t[:50], [body("Otter", pose)], up="z").read_text()
            text = text.replace(",", ";").replace(".", ",")
        path.write_text(text)
        (table,) = open_tables(path).values()
        np.testing.assert_allclose(
            table.columns(["Position X", "Position Y"]), pose[:, :2], atol=1e-5
        )


def turned_take(folder, degrees):
    """The take of a boat with two thrusters, whose body's x axis lies this far to port of the bow."""
    c = columns()
    folder.mkdir()
    pose = np.column_stack([c["east"], c["north"], c["psi"] + np.radians(degrees)])
    motive(folder / "take.csv", c["t"], [body("boat", pose)], markers=0)
    rows = np.column_stack([c["t"], c["left"], c["right"]])
    np.savetxt(folder / "commands.csv", rows, delimiter=",", header="t,left,right", comments="")


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


def test_takes_one_after_the_other(log, tmp_path):
    """Two takes in one folder: each belongs into its own."""
    for i in (1, 2):
        motive(tmp_path / f"take{i}.csv", log.pose_t, [body("boat", far(log.pose))], markers=0)
    commands(log, tmp_path)
    with pytest.raises(
        RecordingError, match=r"2 takes: take1\.csv, take2\.csv; put each into a folder"
    ):
        seatrial.init(tmp_path)


@pytest.mark.parametrize("degrees", [30.0, -120.0])
def test_sticks_that_drive_aside_of_the_axes(degrees, log, tmp_path):
    """Surge and sway by their own inputs: both lie turned by one angle; the name of surge says by which quarter."""
    pose = log.pose + np.array([0.0, 0.0, np.radians(degrees)])
    folder = taken(log, tmp_path / "run", body("boat", pose), up="z", markers=0)
    proposal, vehicle, _ = read(folder)
    assert vehicle.file.pose.psi.offset == pytest.approx(np.radians(degrees), abs=0.03)
    assert "F_u: {column: F_u}" in proposal.text and "F_v: {column: F_v}" in proposal.text


def test_from_a_take_to_a_model(log, tmp_path, capsys):
    """`init` and `identify` by the default method: the coefficients of the boat that was simulated."""
    folder = taken(log, tmp_path / "pool", body("Boat", log.pose, lost=LOST))
    file = tmp_path / "boat.yaml"
    assert main(["init", str(folder), "-o", str(file)]) == 0
    text = file.read_text()
    assert 'y: {column: "Position Z", sign: -1}' in text
    file.write_text(text.replace("structure: auto", "structure: mallard"))
    assert main(["inspect", str(folder), "--vehicle", str(file)]) == 0
    assert (
        main(["identify", str(folder), "--vehicle", str(file), "-o", str(tmp_path / "model.yaml")])
        == 0
    )
    capsys.readouterr()
    model = seatrial.load(tmp_path / "model.yaml")
    true = load_plan("clean").plant.coefficients
    assert set(model.values) == set(true)
    for name, value in model.values.items():
        assert value == pytest.approx(true[name], abs=4 * model.standard_errors[name]), name
