# SPDX-License-Identifier: MIT
"""ROS 1 itself, from Debian: what it records seatrial reads, what seatrial writes it plays."""

import ast
import re
import signal
from contextlib import ExitStack
from pathlib import Path
from threading import Thread

import msgspec
import numpy as np
import pytest
from cli_tools import done
from conftest import ROOT
from ros1_tools import DRIVE, JOY_CHANGES, PARTS, PATIENCE, RATE, Ros1, circle, read_by_rosbag

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.commands.cli import main
from seatrial.io.trial_files import BAG_EPOCH, write_trial
from seatrial.poolside.sources import open_source
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.timing import Clock
from seatrial.simulation.plan import TrialEntry, load_plan
from seatrial.simulation.trials import simulate
from seatrial.util.errors import RecordingError

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(
        not all(part.exists() for part in PARTS), reason="Debian's ROS 1 is not installed"
    ),
]
TOPICS = ("/slam/pose", "/joy")
DRIVEN = ("/odom", "/joy", "/cmd_wrench", "/tf", "/tf_static")
LAUNCH = ROOT / "docs" / "recording" / "record.launch"
RECORDERS = {  # options of rosbag record, by the bag's name
    "plain": (), "bz2": ("--bz2",), "lz4": ("--lz4",), "split": ("--split", "--duration=1"),
    "killed": ("--chunksize=8",), "killed-young": (),
}  # fmt: skip


@pytest.fixture(scope="module")
def ros(tmp_path_factory):
    with Ros1(tmp_path_factory.mktemp("ros1")) as ros:
        yield ros
    assert ros.processes() == []


@pytest.fixture(scope="module")
def trial(mp):
    plan = load_plan("paper-like")
    joypad = msgspec.structs.replace(plan.joypad, rate=50.0)
    short = {"S7": TrialEntry("courses", 20.0)}
    return next(iter(simulate(msgspec.structs.replace(plan, joypad=joypad, trials=short), mp)))


@pytest.fixture(scope="module")
def ours(trial, tmp_path_factory):
    """The trial as seatrial writes it."""
    return write_trial(trial, tmp_path_factory.mktemp("ours"), "bag")


@pytest.fixture(scope="module")
def recorded(ros, trial, ours):
    """The same, played by rosbag and recorded by rosbag, in every way; two recorders killed."""
    running = {}
    for name, options in RECORDERS.items():
        folder = ros.folder / name
        folder.mkdir()
        running[name] = ros.record("-O", folder / "run.bag", *options, topics=TOPICS)
    counts = {"/slam/pose": len(trial.pose_stamps), "/joy": len(trial.command_stamps)}
    ros.play(ours, 5.0, counts)
    for name, process in running.items():
        ros.finish(process, signal.SIGKILL if name.startswith("killed") else signal.SIGINT)
    return ros.folder


@pytest.fixture(scope="module")
def driven(ros):
    """A node of Python drives; rosbag record, started by docs/recording/record.launch, records."""
    arguments = ["pose:=/odom", "commands:=/joy /cmd_wrench", f"prefix:={ros.folder}/driven"]
    launched = ros.start("roslaunch", LAUNCH, *arguments)
    ros.until(lambda: all(map(ros.subscribers, DRIVEN)), "record.launch")
    ros.run("python3", ROOT / "tests" / "ros1_tools.py", "drive")
    ros.finish(launched, signal.SIGINT)
    (bag,) = ros.folder.glob("driven_*.bag")
    return bag


def assert_part(found, original, share):
    """Messages of the original, in its order, to the bit: a starved recorder drops from its queue."""
    for ours, theirs, values in (
        (found, original, "raw"),
        (found.commands, original.commands, "values"),
    ):
        kept = np.isin(theirs.stamps, ours.stamps)
        assert np.array_equal(ours.stamps, theirs.stamps[kept])
        assert np.array_equal(getattr(ours, values), getattr(theirs, values)[kept])
        assert kept.mean() > share


@pytest.mark.parametrize("name", ["plain", "bz2", "lz4", "split"])
def test_what_rosbag_plays_and_records_comes_back_exactly(ros, recorded, ours, mp, name):
    original = seatrial.read(ours, mp)
    path = recorded / name if name == "split" else recorded / name / "run.bag"
    bags = sorted(path.glob("*.bag")) if name == "split" else [path]
    by_rosbag = [read_by_rosbag(ros, bag) for bag in bags]
    found = seatrial.read(path, mp)
    assert_part(found, original, 0.95)
    for topic, stamps in (("/slam/pose", found.stamps), ("/joy", found.commands.stamps)):
        recorded_stamps = [row[1] for part in by_rosbag for row in part.get(topic, [])]
        np.testing.assert_array_equal(stamps, recorded_stamps)
    assert [s.clock for s in found.streams] == [Clock.HEADER, Clock.HEADER]
    assert [s.source for s in found.streams] == list(TOPICS)
    assert {f.kind for f in found.faults} <= {f.kind for f in original.faults} | {
        FaultKind.GAP,  # where the recorder has dropped
        FaultKind.SILENT,
    }
    assert found.remarks == ()
    if name == "split":
        assert len(found.sources) >= 3


def test_the_original_is_the_trial_to_the_bit_of_what_a_bag_holds(ours, trial, mp):
    original = seatrial.read(ours, mp)
    kept = np.isin(trial.pose_stamps + BAG_EPOCH, original.stamps)
    assert kept.sum() == len(original.stamps) == len(trial.pose_stamps)
    np.testing.assert_array_equal(original.raw[:, :2], trial.pose[:, :2])
    turn = original.raw[:, 2] - trial.pose[:, 2]
    np.testing.assert_allclose(np.sin(turn), 0, atol=1e-12)
    np.testing.assert_array_equal(original.commands.values, trial.command.astype(np.float32))


def test_rosbags_own_reader_finds_in_our_bag_what_we_wrote(ros, ours, trial):
    found = read_by_rosbag(ros, ours)
    assert set(found) == set(TOPICS)
    for topic, arrival, stamps in (
        ("/slam/pose", trial.pose_arrival, trial.pose_stamps),
        ("/joy", trial.command_arrival, trial.command_stamps),
    ):
        assert [row[0] for row in found[topic]] == (arrival + BAG_EPOCH).tolist()
        assert [row[1] for row in found[topic]] == (stamps + BAG_EPOCH).tolist()
    poses = np.array([row[2] for row in found["/slam/pose"]])
    np.testing.assert_array_equal(poses[:, :2], trial.pose[:, :2])
    np.testing.assert_array_equal(poses[:, [2, 3, 4]], 0.0)
    np.testing.assert_array_equal(poses[:, 5], np.sin(trial.pose[:, 2] / 2))
    np.testing.assert_array_equal(poses[:, 6], np.cos(trial.pose[:, 2] / 2))
    axes = np.array([row[2] for row in found["/joy"]])
    np.testing.assert_array_equal(axes[:, [1, 0, 3]], trial.command.astype(np.float32))


def test_rosbag_info_and_check_have_no_complaint_about_our_bag(ros, ours, trial):
    said = " ".join(ros.run("rosbag", "info", ours).split())
    assert f"messages: {len(trial.pose_stamps) + len(trial.command_stamps)}" in said
    assert f"/slam/pose {len(trial.pose_stamps)} msgs : geometry_msgs/PoseStamped" in said
    assert f"/joy {len(trial.command_stamps)} msgs : sensor_msgs/Joy" in said
    assert "geometry_msgs/PoseStamped [d3812c3cbc69362b77dc0b19b345f8f5]" in said
    assert "sensor_msgs/Joy [5a9ea5f83505693b71e785041e67a8bb]" in said
    # definitions without comments are other texts, but of the same types by their sums
    said = ros.run("rosbag", "check", ours)
    assert re.findall(r"From: +(.*)", said) == re.findall(r"To: +(.*)", said) != []
    assert "All rules defined." in said


def test_a_recorder_that_was_killed_leaves_a_bag_for_salvage(recorded, ours, mp):
    path = recorded / "killed" / "run.bag.active"
    with pytest.raises(RecordingError) as refused:
        seatrial.read(path, mp)
    assert str(path) in str(refused.value)
    assert "--salvage" in str(refused.value)
    assert "\n" not in str(refused.value)
    original = seatrial.read(ours, mp)
    found = seatrial.read(path, mp, salvage=True)
    assert_part(found, original, 0.9)
    assert found.remarks[0].startswith("salvaged")


def test_a_recorder_that_was_killed_before_its_first_chunk_was_full(recorded, ours, mp):
    """A chunk of the usual 768 KiB lasts a minute; `rosbag reindex` loses it, too."""
    original = seatrial.read(ours, mp)
    found = seatrial.read(recorded / "killed-young" / "run.bag.active", mp, salvage=True)
    assert_part(found, original, 0.9)


def test_what_rosbag_records_is_followed_while_it_does(ros, trial, ours, mp):
    found: dict[str, list] = {name: [] for name in ("follow-plain", "follow-split")}
    running, paths = {}, {}
    counts = {"/slam/pose": len(trial.pose_stamps), "/joy": len(trial.command_stamps)}
    with ExitStack() as stack:
        for name, events in found.items():
            folder = ros.folder / name
            folder.mkdir()
            options = RECORDERS[name.partition("-")[2]]
            running[name] = ros.record("-O", folder / "run.bag", *options, topics=TOPICS)
            path = paths[name] = folder if options else folder / "run.bag"
            ros.until(lambda folder=folder: any(folder.iterdir()), "record")
            source = stack.enter_context(open_source(f"follow:{path}", mp))
            thread = Thread(target=lambda s=source, f=events: f.extend(s))
            thread.start()
            stack.callback(thread.join, PATIENCE)
            stack.callback(source.close)
        ros.play(ours, 5.0, counts)
        whole = sum(counts.values())
        # messages of a chunk that is not full, but for what the recorder has not flushed
        ros.until(lambda: len(found["follow-plain"]) > 0.9 * whole, "follow an open chunk")
        for process in running.values():
            ros.finish(process, signal.SIGINT)
        # a starved recorder drops from its queue: what it has written is what is to be followed
        written = {name: seatrial.read(one, mp) for name, one in paths.items()}
        ros.until(lambda: all(_heard(found[n], w) for n, w in written.items()), "follow to the end")
    for name, events in found.items():
        poses = np.array([e.values for e in events if e.kind == "pose"])
        assert len(poses) > 0.9 * counts["/slam/pose"]
        assert len(poses) > len(written[name].raw) - 3  # before both topics had a message
        np.testing.assert_array_equal(poses, written[name].raw[-len(poses) :])
        commands = [e.stamp for e in events if e.kind == "command"]
        assert len(commands) > 0.9 * counts["/joy"]
        np.testing.assert_array_equal(commands, written[name].commands.stamps[-len(commands) :])


def _heard(events, written):
    """Whether the last pose and the last command of a recording are among the events."""
    last = {event.kind: event.stamp for event in list(events)}
    return last["pose"] == written.stamps[-1] and last["command"] == written.commands.stamps[-1]


POSES = {
    "odometry": {"topic": "/odom"},
    "tf": {"topic": "/tf", "parent": "odom", "child": "base_link"},
    "tf below a static one": {"topic": "/tf", "parent": "map", "child": "base_link"},
}
JOY = {"topic": "/joy", "inputs": {n: {"field": f"axes[{i}]"} for n, i in
                                   (("F_u", 1), ("F_v", 0), ("F_r", 3))}}  # fmt: skip
WRENCH = {"topic": "/cmd_wrench", "inputs": {"F_u": {"field": "force.x"}, "F_v": {"field": "force.y"},
                                             "F_r": {"field": "torque.z"}}}  # fmt: skip


def boat(mp, pose, commands, **more):
    content = mp.to_mapping() | {"pose": pose, "commands": commands} | more
    return vehicle_from(content, "test")


@pytest.mark.parametrize("commands", [JOY, WRENCH], ids=["joy", "wrench"])
@pytest.mark.parametrize("pose", POSES)
def test_odometry_tf_joy_on_change_and_wrench_as_rospy_publishes_them(driven, mp, pose, commands):
    found = seatrial.read(driven, boat(mp, POSES[pose], commands))
    t = np.arange(int(DRIVE * RATE) + 1) / RATE
    x, y, psi = np.array([circle(one) for one in t]).T
    if "static" in pose:  # map to odom: 10 m, 20 m and a quarter turn
        x, y, psi = 10.0 - y, 20.0 + x, psi + np.pi / 2
    np.testing.assert_allclose(found.t, t, atol=2e-9)
    np.testing.assert_allclose(found.eta[:, :2], np.column_stack([x, y]), atol=1e-12)
    np.testing.assert_allclose(np.sin((found.eta[:, 2] - psi) / 2), 0.0, atol=1e-12)
    poses, driving = found.streams
    assert poses.clock is Clock.HEADER
    assert poses.rate == pytest.approx(RATE, rel=1e-6)
    at = found.seconds(found.commands.stamps)
    if commands is JOY:
        assert driving.clock is Clock.HEADER
        assert driving.on_change
        np.testing.assert_allclose(at, [0.0, *(c[0] for c in JOY_CHANGES)], atol=2e-9)
        assert found.commands.values[:, 0].tolist() == [0.0, *(c[1] for c in JOY_CHANGES)]
        assert found.faults == ()
    else:
        assert driving.clock is Clock.ARRIVAL
        assert driving.delay is None
        np.testing.assert_array_equal(found.commands.values, np.column_stack([t, -t, 0.5 * t]))
        assert np.all(np.diff(at) > 0)


def test_a_joypad_on_change_with_a_timeout_is_known_only_so_long(driven, mp):
    found = seatrial.read(driven, boat(mp, POSES["odometry"], JOY, command_timeout=0.5))
    silent = [f for f in found.faults if f.kind is FaultKind.SILENT]
    assert [f.start for f in silent] == pytest.approx([0.5, 1.5, 2.5, 3.5, 4.5])
    assert [f.end for f in silent] == pytest.approx([1.0, 2.0, 3.0, 4.0, 6.0])
    assert found.valid.sum() == pytest.approx(5 * 0.5 * RATE, abs=5)  # of five commands


def test_the_chain_of_the_document_runs_on_what_rosbag_recorded(recorded, tmp_path, capsys):
    bag, vehicle = str(recorded / "plain" / "run.bag"), str(tmp_path / "vehicle.yaml")
    shown = done(capsys, "inspect", bag)
    assert all(word in shown for word in (*TOPICS, "geometry_msgs/PoseStamped", "sensor_msgs/Joy"))
    assert main(["init", bag, "-o", vehicle, "-q"]) == 1  # 20 s do not show what moves the boat
    assert "20 s do not show which of axes_0" in capsys.readouterr().err
    assert not Path(vehicle).exists()
    assert main(["inspect", bag, "--vehicle", "mallard-mp"]) == 0


def test_a_mistyped_topic_is_named_with_the_one_that_is_meant(recorded, mp):
    vehicle = boat(mp, {"topic": "/slam/pos"}, JOY)
    with pytest.raises(RecordingError, match=r"no topic /slam/pos .* did you mean /slam/pose\?"):
        seatrial.read(recorded / "plain" / "run.bag", vehicle)


def test_the_documents_line_for_rosbag_record_records(ros):
    page = (LAUNCH.parents[1] / "recording.md").read_text()
    _, *arguments = re.search(r"^rosbag record .*run1\.bag.*$", page, re.MULTILINE)[0].split()
    topics = tuple(a for a in arguments if a.startswith("/"))
    assert topics == (*TOPICS, "/tf", "/tf_static")
    process = ros.record(*arguments[1 : -len(topics)], topics=topics)
    ros.until(lambda: any(ros.folder.glob("run1.bag*")), "the recorder's file")
    ros.finish(process, signal.SIGINT)
    # rosbag's wrapper may end before the recorder that it started has closed the file
    ros.until((ros.folder / "run1.bag").exists, "the recorder's closed file")


def test_the_launch_file_is_what_roslaunch_takes_it_for(ros):
    assert ros.run("roslaunch", "--nodes", LAUNCH).split() == ["/record_trial"]
    said = ros.run("roslaunch", "--args", "/record_trial", LAUNCH, "pose:=/mocap/pose")
    assert "/mocap/pose /joy /tf /tf_static" in said
    assert set(ros.run("roslaunch", "--ros-args", LAUNCH).split()) >= {
        "pose", "commands", "extra", "prefix"
    }  # fmt: skip


def test_the_launch_file_of_ros_2_is_python_with_the_same_arguments():
    tree = ast.parse((LAUNCH.parent / "record.launch.py").read_text())
    names = [
        node.args[0].value for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "_argument"
    ]  # fmt: skip
    assert names == ["pose", "commands", "extra", "output"]
