# SPDX-License-Identifier: MIT
"""Hector mapping, the paper's SLAM, in the loop with the odometry node: the study in short, and the launch file."""

import ast
import signal
from pathlib import Path

import hector_tools
import numpy as np
import pytest
from ros1_node_tools import NODE, heading, messages, needed, nodes, stamp_of

import seatrial
from seatrial.boat.model_file import save
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model

pytest.importorskip("small_gicp")
from benchmarks.studies.hector import ros as play
from benchmarks.studies.hector import study, tables
from benchmarks.studies.slam import lidar
from benchmarks.studies.slam.scene import POOL, pool_scene
from benchmarks.studies.slam.se2 import between
from benchmarks.studies.slam.study import driven, error

ROOT = Path(__file__).resolve().parents[1]
LAUNCH = ROOT / "ros" / "ros1" / "launch" / "slam.launch"
SEED = 51
ros = nodes
system = [
    *needed,
    pytest.mark.skipif(
        hector_tools.program() is None,
        reason=f"{hector_tools.VARIABLE} names no hector_mapping, or its build folder",
    ),
]


def marked(test):
    """A test with ROS 1 and Hector."""
    for mark in system:
        test = mark(test)
    return test


def test_a_scan_as_ranges_is_the_scan():
    rng, pose = np.random.default_rng(1), np.array([1.0, -1.0, 0.5])
    found = lidar.scan(pool_scene(), lambda t: np.tile(pose, (len(t), 1)), 3.0, 0.0, rng)
    given = play.ranges(found)
    assert len(given) == lidar.BEAMS
    beams = [k for k, r in enumerate(given) if r is not None]
    angle = play.LIDAR["angle_min"] + np.array(beams) * play.LIDAR["angle_increment"]
    r = np.array([given[k] for k in beams])
    points = np.column_stack([r * np.cos(angle), r * np.sin(angle)])
    np.testing.assert_allclose(points, found.points, atol=6e-4)
    lost = lidar.Scan(found.stamp, found.t[5:], found.points[5:])
    assert play.ranges(lost)[:6] == [None] * 5 + given[5:6]


def test_tables_count_what_was_used_false_and_lost():
    case = study.Case("gentle", study.ALONE, 3)
    good = np.full((10, 2), [0.01, 0.001])
    bad = good.copy()
    bad[[2, 3, 8, 9]] = [0.6, 0.0]
    made = [
        study.Outcome(case, seed, 20, 10, off, 2.0 * off, np.array([0.01, 0.3]), np.zeros((2, 2)))
        for seed, off in ((1, good), (2, bad))
    ]
    assert [o.false_matches for o in made] == [0, 2]
    assert tables.matched([case], made).splitlines()[-1] == (
        "| 5 Hz | Hector alone | 50 | 1200 | 2 | 20 | 2 | 1 of 2 | 600 | 1 | 50 |"
    )
    # of ten matches and a scan at rest the sixth scan is forced: matches from the fifth on
    forced = study.Outcome(case, 1, 10, 10, bad, bad, np.array([0.3]), np.zeros((1, 2)))
    assert len(forced.after) == 5
    assert tables.forced([case], [forced]).splitlines()[-1] == (
        "| gentle | Hector alone | 40 | 1 of 1 | 100 |"
    )


def test_hector_is_found_by_its_program_or_the_folder_it_was_built_in(tmp_path, monkeypatch):
    program = tmp_path / "devel" / hector_tools.PLACE
    program.parent.mkdir(parents=True)
    for given in (tmp_path, program):
        monkeypatch.setenv(hector_tools.VARIABLE, str(given))
        assert hector_tools.program() is None
    program.touch()
    for given in (tmp_path, program):
        monkeypatch.setenv(hector_tools.VARIABLE, str(given))
        assert hector_tools.program() == program
    monkeypatch.delenv(hector_tools.VARIABLE)
    assert hector_tools.program() is None


def test_the_launch_file_of_ros_2_gives_the_odometry_node_parameters_that_it_has():
    text = (ROOT / "ros" / "common" / "include" / "seatrial_ros" / "settings.hpp").read_text()
    tree = ast.parse((ROOT / "ros" / "ros2" / "launch" / "slam.launch.py").read_text())
    words = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    given = {"model", "pose_topic", "command_topic", "publish_map_to_odom"}
    assert given <= words
    assert all(f'Parameter{{"{name}"' in text for name in given)


def played(ros, folder, case, seconds, **more):
    """The first seconds of a case; the error of every pose (n, 2)."""
    scans = [s for s in study.given(case, SEED) if s.end < seconds]
    made = driven(case.driving, SEED)
    found = play.play(ros, study.STARTS[case.start], made, scans, folder, **more)
    assert len(found.t) == len(scans) - 1  # none was dropped
    true = between(study.at_rest(case.driving, SEED), made.poses(found.t))
    return error(true, found.pose)


@pytest.fixture(scope="module")
def identified(ros, tmp_path_factory):
    """A folder with a model that only Hector's poses of one drive are behind, and those poses' errors."""
    folder = tmp_path_factory.mktemp("hector")
    off = played(
        ros, folder, study.Case("gentle", study.ALONE), 90.0, bag=folder / "run.bag"
    )  # fmt: skip
    vehicle = seatrial.load_vehicle(hector_tools.vehicle(folder))
    save(
        seatrial.identify([seatrial.read(folder / "run.bag", vehicle)], vehicle),
        folder / "model.yaml",
    )
    return folder, off


@marked
def test_the_model_of_hector_s_own_poses_keeps_it_from_false_matches(ros, identified):
    folder, off = identified
    assert np.percentile(off[:, 0], 95) < 0.1  # [m] gentle, Hector alone
    assert (off < study.FALSE).all()
    hard = study.Case("aggressive", study.ALONE, 3)
    alone = played(ros, folder, hard, 20.0)
    assert np.mean((alone > study.FALSE).any(axis=1)) > 0.5
    with_node = played(ros, folder, study.Case("aggressive", study.BY_NODE, 3), 20.0)
    assert (with_node < study.FALSE).all()


@marked
def test_after_a_forced_false_match_hector_begins_where_the_node_knows_the_boat(ros, identified):
    folder, _ = identified
    errors = {}
    for start in (study.ODOMETRY, study.BY_NODE):
        case = study.Case("gentle", start, 3, forced=True)
        forced = play.Forced(30, study.FALSE_START)
        errors[start] = played(ros, folder, case, 12.0, forced=forced)
        assert (errors[start][:29] < study.FALSE).all()
        assert (errors[start][29] > study.FALSE).any()  # that match is false
    assert (errors[study.ODOMETRY][30:] > study.FALSE).any(axis=1).mean() > 0.5
    assert (errors[study.BY_NODE][31:] < study.FALSE).all()


SCENE = f"""seatrial: scene 1
pool: {{length: {POOL.length:g}, width: {POOL.width:g}}}
boxes: [{{x: 2.4, y: -0.1, length: 0.5, width: 0.4, turn_deg: 23}}]
posts: [{{x: 0, y: 0.1, radius: 0.15}}, {{x: -2.6, y: -0.2, radius: 0.1}}]
sensors: {{pose: null, imu: null, lidar: {{beams: 811}}}}
boats: [{{name: tug, start: [-1.2, -1.2, 0.2]}}]
"""
SECONDS = 10.0  # of driving, at half of real time: Hector drops scans that it has no time for


@marked
def test_the_launch_file_runs_hector_on_the_simulator_s_scans(ros, tmp_path, mp):
    """Simulator, Hector, odometry: as on a boat, nobody waits for anybody."""
    model, scene, bag = tmp_path / "model.yaml", tmp_path / "scene.yaml", tmp_path / "out.bag"
    seatrial.save(plant_model(load_plan("hard"), mp), model)
    scene.write_text(SCENE)
    ros.environment |= hector_tools.packages(ROOT / "ros", NODE.parents[2])
    assert ros.run("roslaunch", "--nodes", LAUNCH).split() == [hector_tools.NODE]
    launched = ros.start("roslaunch", LAUNCH, f"model:={model}")
    ros.until(lambda: "/seatrial_odometry" in ros.subscribers("/joy"), "odometry node")
    ros.until(lambda: hector_tools.NODE in ros.subscribers("/scan"), "hector")
    recorder = ros.record("-O", bag, topics=(hector_tools.POSE, "/truth", "/scan", "/tf"))
    simulator = ros.node("simulator", models=model, scene=scene, real_time_factor=0.5)
    ros.until(lambda: ros.connected("/scan"), "simulator")
    ros.finish(
        ros.joypad(3.0, 0.0, 0.0, 0.0, 0.0)
    )  # the first start estimates have no odometry yet
    ros.finish(ros.joypad(SECONDS, 0.0, 0.6, 0.0, 0.25))
    for process in (recorder, launched, simulator):
        ros.finish(process, signal.SIGINT)
    poses, truth = messages(bag, hector_tools.POSE), messages(bag, "/truth")
    t = np.array([stamp_of(m.header) for _, m in poses]) * 1e-9
    pose = np.array([placed(m.pose) for _, m in poses])
    at = np.array([stamp_of(m.header) for _, m in truth]) * 1e-9
    true = np.array([placed(m.pose.pose) for _, m in truth])
    true[:, 2] = np.unwrap(true[:, 2])
    middle = t + 0.5 * play.SWEEP
    known = np.column_stack([np.interp(middle, at, true[:, i]) for i in range(3)])
    off = error(between(known[0], known), pose)
    moving = t > t[0] + 4.0
    scans = np.array([stamp_of(m.header) for _, m in messages(bag, "/scan")]) * 1e-9
    given = np.sum((scans > t[0] + 4.0) & (scans <= t[-1]))
    assert np.ptp(true[:, :2], axis=0).max() > 0.4  # [m] it did move
    assert abs(true[-1, 2] - true[0, 2]) > 1.0  # [rad]
    assert moving.sum() > 0.9 * given  # nearly every scan was matched
    assert (off[moving] < study.FALSE).all()
    parents = {
        (transform.header.frame_id, transform.child_frame_id)
        for _, m in messages(bag, "/tf") for transform in m.transforms
    }  # fmt: skip
    assert {("map", "odom"), ("odom", "base_link")} <= parents


def placed(pose):
    return pose.position.x, pose.position.y, heading(pose.orientation)
