# SPDX-License-Identifier: MIT
"""Exports of Motive, QTM and Vicon: the boat's poses as they were, beside commands of any clock."""

from datetime import datetime, timezone
from functools import partial

import numpy as np
import pytest
from capture_logs import (
    DRAUGHT,
    body,
    commands,
    far,
    minute,
    motive,
    qualisys,
    read,
    taken,
    vicon,
)
from odd_logs import columns
from scipy.spatial.transform import Rotation
from sheets import sheet

import seatrial
from seatrial.commands.cli import main
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.proposal.sources import Choices
from seatrial.io.table import open_tables
from seatrial.simulation.plan import load_plan
from seatrial.util.errors import RecordingError

TILT = 0.02  # [rad] of the bodies; its square is the error of a heading by another axis of the body
BEGUN = 1_683_815_465.123  # [s] 2023-05-11 14:31:05.123 UTC
LOST = range(300, 330)  # rows without the boat


@pytest.fixture(scope="module")
def log():
    return minute()


def still(pose, x):
    """A body that lies at x [m], as cameras see it."""
    noise = np.random.default_rng(3).normal(size=pose.shape) * 1e-4
    return np.array([x, 1.0, 0.5]) + noise


def is_truth(recording, pose, t, missing=()):
    """Whether every pose is the boat's at its time; (n, 3) and (n,)."""
    seen = np.setdiff1d(np.arange(len(t)), list(missing))
    at = np.searchsorted(t[seen], recording.t + t[seen][0] - 1e-3)
    good = recording.valid
    assert good.sum() == len(seen)
    np.testing.assert_allclose(recording.t[good], t[seen] - t[0], atol=1e-5)
    error = recording.eta[good] - pose[seen][: len(at)]
    np.testing.assert_allclose(error[:, :2], 0.0, atol=1e-5)
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
    sheet(folder / "commands.csv", "t,left,right", c["t"] + late, c["left"], c["right"])
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
