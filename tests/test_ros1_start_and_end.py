# SPDX-License-Identifier: MIT
"""ROS 1 nodes that can't begin, and the last message of those that drive something: it stops what they drive."""

import signal

import numpy as np
import pytest
from ros1_node_tools import messages, needed, nodes

import seatrial
from seatrial.control import save_gains, tune
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model

pytestmark, ros = needed, nodes


@pytest.fixture(scope="module")
def files(mp, tmp_path_factory):
    folder = tmp_path_factory.mktemp("last")
    boat = plant_model(load_plan("paper-like"), mp)
    seatrial.save(boat, folder / "model.yaml")
    save_gains(tune(boat, 1.0, draws=5), folder / "gains.yaml")
    return folder


def driven(ros, program, files):
    """The node, what makes it drive, and the topic of what it drives."""
    if program == "mimic":
        node = ros.node("mimic", hears="/joy", model=files / "model.yaml")
        return node, [ros.joypad(3600.0, 0.0, 0.8, 0.0, 0.0)], "/cmd_vel"
    node = ros.node(
        "tracking", hears="/goal", model=files / "model.yaml", gains=files / "gains.yaml"
    )
    stands = [
        ros.stands("/odom", "nav_msgs/Odometry"),
        ros.stands("/map_pose", "geometry_msgs/PoseWithCovarianceStamped"),
    ]
    return node, [*stands, ros.goal()], "/joy"


@pytest.mark.parametrize("program", ["odometry", "simulator", "mimic", "tracking"])
def test_a_name_that_is_none_is_one_line(ros, program):
    said = ros.complaint(program, "__name:=a/b")
    assert said.startswith(f"seatrial_{program}: ")
    assert "a/b" in said


def numbers(message):
    """What is driven, of either topic."""
    return list(message.axes) if hasattr(message, "axes") else [message.linear.x, message.linear.y]


@pytest.mark.parametrize("by", ["the master", "a signal"])
@pytest.mark.parametrize("program", ["mimic", "tracking"])
def test_what_is_driven_is_stopped_at_the_end(ros, files, tmp_path, program, by):
    ros.run("rosparam", "set", "use_sim_time", "false")
    node, drivers, topic = driven(ros, program, files)
    recorder = ros.record("-O", tmp_path / "out.bag", topics=(topic,))
    row = (
        "rostopic",
        "echo",
        "-p",
        "-n1",
        topic + ("/linear/x" if program == "mimic" else "/axes"),
    )
    ros.until(lambda: any(np.atleast_1d(driven_row(ros.run(*row)))), f"{program} to drive")
    if by == "the master":
        ros.shut_down(f"/seatrial_{program}")
        ros.finish(node)
    else:
        ros.finish(node, signal.SIGTERM)
    for process in (*drivers, recorder):
        ros.finish(process, signal.SIGINT)
    given = np.array([numbers(m) for _, m in messages(tmp_path / "out.bag", topic)])
    assert given[-2].any()
    assert not given[-1].any()


def driven_row(said: str) -> list[float]:
    """The numbers of `rostopic echo -p` behind the time."""
    return [float(word) for word in said.splitlines()[-1].split(",")[1:]]
