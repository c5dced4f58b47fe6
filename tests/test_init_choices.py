# SPDX-License-Identifier: MIT
"""Init where there is a choice or a riddle: tf, two boats, odd names, a terminal."""

import contextlib
import io
import json

import numpy as np
import pytest
import yaml
from bag_tools import START, Sent, header, quaternion, ros2
from hypothesis import example, given, settings
from hypothesis import strategies as st
from init_tools import NAMES, refused, tables
from logs import AXES_OF_JOY, JOY, POSE, drive, half
from sheets import sheet

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.commands.cli import main
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.util.errors import RecordingError

# Which topics. #


def tf_log(log, frames=(("map", "odom"), ("odom", "base_link"))):
    """Poses as transforms by way of odom, which stands still; and sticks."""
    sent = []
    for t, (x, y, psi) in zip(
        (log.pose_t * 1e9).astype(int).tolist(), log.pose.tolist(), strict=True
    ):
        still = {"translation": {"x": 0.0, "y": 0.0, "z": 0.0}, "rotation": quaternion(0.0)}
        moved = {"translation": {"x": x, "y": y, "z": 0.0}, "rotation": quaternion(psi)}
        transforms = [
            {"header": header(START + t, parent), "child_frame_id": child, "transform": where}
            for (parent, child), where in zip(frames, (still, moved), strict=True)
        ]
        sent.append(
            Sent("/tf", "tf2_msgs/msg/TFMessage", START + t + 2_000_000, {"transforms": transforms})
        )
    for t, row in zip(
        (log.command_t * 1e9).astype(int).tolist(), log.command.tolist(), strict=True
    ):
        axes = [0.0] * 4
        for at, value in zip(AXES_OF_JOY, row, strict=True):
            axes[at] = value
        sent.append(
            Sent(
                JOY,
                "sensor_msgs/msg/Joy",
                START + t + 1_000_000,
                {"header": header(START + t), "axes": axes},
            )
        )
    return sent


def test_poses_from_tf_with_the_usual_frames(tmp_path, propose, capsys):
    log = drive(joypad=20.0, sticks=half)
    path = ros2(tmp_path / "pool", tf_log(log))
    vehicle, text = propose(path)
    assert yaml.safe_load(text)["pose"] == {"topic": "/tf", "parent": "map", "child": "base_link"}
    record = seatrial.read(path, vehicle)
    np.testing.assert_allclose(record.eta[:, :2], log.pose[:, :2], atol=1e-9)
    assert check_consistency([record], vehicle).findings == ()
    odd = ros2(tmp_path / "odd", tf_log(log, (("lake", "dock"), ("dock", "duck"))))
    line = refused(capsys, odd, "-o", tmp_path / "v.yaml")
    assert "name the world's frame with --parent and the boat's with --child" in line
    assert "dock -> duck (moves)" in line
    vehicle, text = propose(odd, "--parent", "lake", "--child", "duck")
    assert yaml.safe_load(text)["pose"] == {"topic": "/tf", "parent": "lake", "child": "duck"}
    np.testing.assert_allclose(seatrial.read(odd, vehicle).eta[:, 0], log.pose[:, 0], atol=1e-9)


@pytest.fixture
def two_boats(log, tmp_path):
    """Two robots in one bag, each with its pose and its sticks."""
    topics = []
    for i, name in enumerate(("duck", "swan")):
        for topic in log.but(pose=np.add(log.pose, [3.0 * i, 0, 0])).topics():
            topics.append(
                BagTopic(f"/{name}{topic.name}", topic.type_name, topic.arrival, topic.stamps, topic.columns)
            )  # fmt: skip
    return write_bag(tmp_path / "lake.bag", topics)


def test_of_two_boats_one_must_be_named(two_boats, log, tmp_path, propose, capsys):
    line = refused(capsys, two_boats, "-o", tmp_path / "v.yaml")
    assert (
        "several candidates for the poses: /duck/slam/pose, /swan/slam/pose; name one with --pose"
        in line
    )
    assert "of two boats in one recording" in line
    for choices in (Choices(pose="/swan/slam/pose"), Choices(commands="/swan/joy")):
        content = yaml.safe_load(init(two_boats, choices=choices).text)  # the rest is that boat's
        assert content["pose"]["topic"] == "/swan/slam/pose"
        assert content["commands"]["topic"] == "/swan/joy"
    line = refused(capsys, two_boats, "-o", tmp_path / "v.yaml", "--pose", "/goose/pose")
    assert "no topic /goose/pose (--pose); the topics are" in line
    vehicle, text = propose(
        two_boats, "--pose", "/swan/slam/pose", "--commands", "swan/joy", "--name", "swan"
    )
    content = yaml.safe_load(text)
    assert (content["pose"]["topic"], content["commands"]["topic"]) == (
        "/swan/slam/pose",
        "/swan/joy",
    )
    assert content["name"] == "swan"
    assert "# other candidates: /duck/slam/pose (geometry_msgs/PoseStamped)" in text
    record = seatrial.read(two_boats, vehicle)
    assert record.eta[0, 0] == pytest.approx(log.pose[0, 0] + 3.0)


def test_of_two_boats_the_user_chooses_one(two_boats):
    asked = []

    def ask(question, options):
        asked.append((question, tuple(options)))
        return options[1]

    content = yaml.safe_load(init(two_boats, ask=ask).text)
    assert (content["pose"]["topic"], content["commands"]["topic"]) == (
        "/swan/slam/pose",
        "/swan/joy",
    )
    assert asked == [("Which are the poses of the boat?", ("/duck/slam/pose", "/swan/slam/pose"))]


def test_nothing_is_asked_that_is_known(log, tmp_path):
    def ask(question, options):
        pytest.fail(f"{question} {options}")

    odometry = log.topics(pose_type="nav_msgs/msg/Odometry")[0]
    odometry = BagTopic(
        "/odometry/filtered", odometry.type_name, odometry.arrival, odometry.stamps, odometry.columns,
    )  # fmt: skip
    path = write_bag(tmp_path / "pool.mcap", [*log.topics(), odometry])
    assert yaml.safe_load(init(path, ask=ask).text)["pose"]["topic"] == POSE
    chosen = init(path, choices=Choices(pose="/odometry/filtered"), ask=ask).text
    assert yaml.safe_load(chosen)["pose"]["topic"] == "/odometry/filtered"


def test_of_several_tables_that_of_the_commands_is_found_or_named(log, tmp_path, propose, capsys):
    folder = tables(log, tmp_path / "pool")
    sheet(folder / "battery.csv", "t,volt", np.arange(90.0), np.linspace(25, 24, 90))
    _, text = propose(folder)
    assert yaml.safe_load(text)["commands"]["file"] == "commands.csv"
    (folder / "commands.csv").rename(folder / "sent.csv")
    _, text = propose(folder, "--force")  # by the names of its columns
    assert yaml.safe_load(text)["commands"]["file"] == "sent.csv"
    (folder / "asked.csv").write_bytes((folder / "sent.csv").read_bytes())
    line = refused(capsys, folder, "-o", tmp_path / "v.yaml")
    assert (
        "several candidates for the commands: asked.csv, sent.csv; name one with --commands" in line
    )
    vehicle, text = propose(folder, "--commands", "sent.csv", "--force")
    assert yaml.safe_load(text)["commands"]["file"] == "sent.csv"
    assert len(seatrial.read(folder, vehicle).commands.stamps) == len(log.command_t)
    line = refused(capsys, folder, "-o", tmp_path / "v.yaml", "--commands", "nothing.csv")
    assert (
        "no table nothing.csv (--commands); there are asked.csv, battery.csv, poses.csv, sent.csv"
        in line
    )


def test_columns_with_empty_cells_are_left_out(log, tmp_path, propose):
    folder = tables(log, tmp_path / "pool")
    lines = (folder / "commands.csv").read_text().splitlines()
    lines = [
        f"{lines[0]},battery",
        *(f"{line},{i if i % 50 == 0 else ''}" for i, line in enumerate(lines[1:])),
    ]
    (folder / "commands.csv").write_text("\n".join(lines) + "\n")
    vehicle, text = propose(folder)
    assert "not used, with empty cells: battery" in text
    assert vehicle.inputs == NAMES
    assert len(seatrial.read(folder, vehicle).commands.stamps) == len(log.command_t)


BARE = {
    "no poses": (lambda log, out: write_bag(out / "a.bag", log.topics()[1:]), "no topic has a type of poses; name one with --pose. The topics are /joy (sensor_msgs/Joy)"),
    "no commands": (lambda log, out: write_bag(out / "a.mcap", log.topics()[:1]), "no topic has a type of commands; name one with --commands"),
    "empty": (lambda log, out: write_bag(out / "a.db3", []), "no topic has a type of poses; name one with --pose. The topics are none"),
    "at rest": (lambda log, out: log.but(command=0 * log.command).write(out / "a.bag"), "no command ever changes; record while the boat is driven"),
    "still at rest": (lambda log, out: tables(log.but(command=0 * log.command), out / "a"), "no column besides poses and stamps changes, so there are no commands"),
    "no headings": (lambda log, out: tables(log, out / "a", pose="t,x,y,foo"), "no table has columns named like x, y and psi"),
    "no time": (lambda log, out: tables(log.but(pose_t=log.pose_t[::-1]), out / "a", pose="back,x,y,psi"), "no column of stamps; it has back, x, y, psi"),
    "nowhere": (lambda log, out: out / "none.bag", "none.bag: no such file or folder"),
    "no bag": (lambda log, out: out, "is an empty folder; expected a bag"),
}  # fmt: skip


@pytest.mark.parametrize("case", BARE)
def test_what_can_not_be_proposed_is_one_line(case, log, tmp_path, capsys):
    make, words = BARE[case]
    (tmp_path / "in").mkdir()
    line = refused(capsys, make(log, tmp_path / "in"), "-o", tmp_path / "v.yaml")
    assert words in line
    assert not (tmp_path / "v.yaml").exists()


# The file. #


def test_an_existing_file_is_not_written_over_unless_it_is_said(log, tmp_path, propose, capsys):
    path = log.write(tmp_path / "pool.bag")
    out = tmp_path / "pool.bag.yaml"
    out.write_text("mine")
    line = refused(capsys, path, "-o", out)
    assert "exists already; give another name, or --force to write over it" in line
    assert out.read_text() == "mine"
    vehicle, _ = propose(path, "--force")
    assert vehicle.name == "pool"


ODD = (
    "x y", "yes", "off", "null", "~", "1e3", "0x10", "a: b", "a #b", "- a", "{a}", "a\"b", "back\\slash", "'",
    "*", "&a", "!tag", "%", "@", "`", "|", ">", "?", "Ä", "推力", "a\u2028b", "\x7f", "🛥", "=", "<<", ".nan", "1:30", "NO",
)  # fmt: skip


@pytest.mark.parametrize("words", list(zip(*[iter(ODD)] * 3, strict=True)))
def test_names_that_yaml_would_take_for_something_else(words, log, tmp_path):
    folder = tables(log, tmp_path / "log", commands=",".join(("t", *words)))
    text = init(folder, choices=Choices(name=words[0])).text
    content = yaml.safe_load(text)
    assert content["name"] == "".join(c if c.isprintable() else "_" for c in words[0])
    assert [e["column"] for e in content["commands"]["inputs"].values()] == list(words)
    vehicle = vehicle_from(content, "proposed")
    assert len(seatrial.read(folder, vehicle).commands.stamps) == len(log.command_t)


@pytest.mark.parametrize("word", ["x y", "yes", "a: b", 'a"b', "back\\slash", "- a", "1e3"])
def test_names_of_topics(word, log, tmp_path):
    """A recorder's names are checked by nobody."""
    poses, sticks = log.topics()
    topics = [
        BagTopic(f"/{word}/pose", poses.type_name, poses.arrival, poses.stamps, poses.columns),
        BagTopic(word, sticks.type_name, sticks.arrival, sticks.stamps, sticks.columns),
    ]
    path = write_bag(tmp_path / "pool.mcap", topics)
    content = yaml.safe_load(init(path).text)
    assert content["pose"]["topic"] == f"/{word}/pose"
    assert content["commands"]["topic"] == word
    assert len(seatrial.read(path, vehicle_from(content, "proposed")).t) == len(log.pose_t)


headers = st.text(
    st.characters(exclude_categories=("Cs",), exclude_characters="\n\r,;\t\0"), min_size=1, max_size=8
) | st.sampled_from(["t", "x", "y", "psi", "valid", "F_u", "yaw", "x [mm]", "a_b", "a b", "z", "stamp"])  # fmt: skip


@pytest.mark.system
@settings(max_examples=40)
# S: seconds by its name, a position by its values
@example(["F:U", "S", "Y", "Psi", "X0MM"], False)
@given(st.lists(headers, min_size=3, max_size=9), st.booleans())
def test_whatever_the_columns_are_called_there_is_a_file_or_one_line(
    log, tmp_path_factory, names, usual
):
    names = ["t", "x", "y", "psi", *names] if usual else names
    at = np.searchsorted(log.command_t, log.pose_t)
    data = np.column_stack(
        [log.pose_t, log.pose, log.command[at], -log.command[at], log.pose, log.pose]
    )
    folder = tmp_path_factory.mktemp("names")
    path, out = folder / "log.csv", folder / "v.yaml"
    body = "\n".join(",".join(map(repr, row)) for row in data[:, : len(names)].tolist())
    path.write_text(f"{','.join(names)}\n{body}\n", encoding="utf-8")
    shown, wrong = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(shown), contextlib.redirect_stderr(wrong):
        code = main(["init", str(path), "-o", str(out), "-q"])
    if code == 0:
        vehicle = seatrial.load_vehicle(out)
        assert len(seatrial.read(path, vehicle).t) == len(log.pose_t)
        json.dumps(yaml.safe_load(out.read_text()))
    else:
        assert code == 1
        assert wrong.getvalue().startswith("seatrial: ")
        assert wrong.getvalue().count("\n") == 1
        assert not out.exists()


def test_init_is_there_in_python_too(log, tmp_path):
    path = log.write(tmp_path / "pool.bag")
    found = seatrial.init(path)
    assert found.sources.pose == {"topic": POSE}
    assert found.drive.undriven == ()
    with pytest.raises(RecordingError, match="no topic has a type of poses"):
        seatrial.init(write_bag(tmp_path / "joy.bag", log.topics()[1:]))


@pytest.mark.parametrize("answers", [["2"], ["x", ""]])
def test_at_a_terminal_the_axes_are_asked_for(answers, log, tmp_path, monkeypatch, capsys):
    axes = "right-down" if answers == ["2"] else "left-up"  # enter is the first
    bag = log.write(tmp_path / "log.bag")
    given = iter(answers)
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda _: next(given))
    assert main(["init", str(bag), "-o", str(tmp_path / "v.yaml")]) == 0
    assert "turns to the left" in " ".join(capsys.readouterr().out.split())
    assert seatrial.load_vehicle(tmp_path / "v.yaml").axes.value == f"forward-{axes}"
    assert ", as answered" in (tmp_path / "v.yaml").read_text()
    assert (
        main(["init", str(bag), "--axes", "forward-left-up", "-o", str(tmp_path / "w.yaml")]) == 0
    )
    assert "turns to the left" not in " ".join(capsys.readouterr().out.split())
