# SPDX-License-Identifier: MIT
"""Poses from transforms are those of matrices multiplied one by one."""

import numpy as np
import pytest
from bag_tools import SECOND, START, Sent, header, joy_sent, poses_sent, ros1, vehicle
from mcap_writer import mcap
from scipy.spatial.transform import Rotation, Slerp

import seatrial
from seatrial.io.bags.contents import contents
from seatrial.io.bags.opening import open_bag
from seatrial.recording.clocks import clock_verdicts
from seatrial.recording.timing import Clock
from seatrial.util.errors import SeatrialError

LENGTH = 3.0  # [s]
TF = "tf2_msgs/msg/TFMessage"


def transform(at: int, parent: str, child: str, place, turn: Rotation) -> dict:
    x, y, z = (float(v) for v in place)
    q = dict(zip("xyzw", (float(v) for v in turn.as_quat()), strict=True))
    return {
        "header": header(at, parent), "child_frame_id": child,
        "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": q},
    }  # fmt: skip


def place(t: float, k: int) -> np.ndarray:
    return np.array([np.sin(0.4 * t + k), 0.5 * np.cos(0.6 * t + k), 0.1 * np.sin(t * k)])


def turn(t: float, k: int) -> Rotation:
    """Mostly yaw, with some pitch and roll: products do not commute."""
    return Rotation.from_euler("zyx", [0.8 * t + k, 0.2 * np.sin(2 * t), 0.1 * k * np.cos(t)])


def matrix(position, rotation: Rotation) -> np.ndarray:
    whole = np.eye(4)
    whole[:3, :3] = rotation.as_matrix()
    whole[:3, 3] = position
    return whole


def between(times: np.ndarray, t: float, k: int) -> np.ndarray:
    """What tf2 makes of samples at `times`: lines for positions, arcs for rotations."""
    rotations = Rotation.concatenate([turn(s, k) for s in times])
    row = min(max(int(np.searchsorted(times, t)), 1), len(times) - 1)
    a, b = times[row - 1 : row + 1]
    line = place(a, k) + (t - a) / (b - a) * (place(b, k) - place(a, k))
    return matrix(line, Slerp(times, rotations)(t))


def sent_at(times, k: int, parent: str, child: str, topic: str = "/tf") -> list[Sent]:
    return [
        Sent(topic, TF, START + round(t * 1e9) + 2_000_000,
             {"transforms": [transform(START + round(t * 1e9), parent, child, place(t, k), turn(t, k))]})
        for t in times.tolist()
    ]  # fmt: skip


def fixed(pairs: list, topic: str = "/tf_static") -> list[Sent]:
    items = [transform(0, parent, child, *rest) for parent, child, *rest in pairs]
    return [Sent(topic, TF, START, {"transforms": items})]


SLOW = np.arange(0, LENGTH, 0.25)  # [s] map -> odom
FAST = np.arange(0.01, LENGTH - 0.3, 0.04)  # [s] odom -> imu
MOUNT = ([0.3, -0.1, 0.2], Rotation.from_euler("zyx", [0.5, -0.2, 0.3]))  # base_link -> imu
RISE = ([0.0, 0.0, 1.5], Rotation.from_euler("z", 0.1))  # base_link -> mast


def tree() -> list[Sent]:
    """map -> odom -> imu move, base_link -> imu is fixed: the boat is against the arrow."""
    return (
        sent_at(SLOW, 1, "map", "odom")
        + sent_at(FAST, 2, "odom", "imu")
        + fixed([("base_link", "imu", *MOUNT), ("base_link", "mast", *RISE)])
        + joy_sent(LENGTH)
    )


def boat(parent: str, child: str, topic: str = "/tf") -> seatrial.Vehicle:
    return vehicle(pose={"topic": topic, "parent": parent, "child": child})


def expected(chain) -> np.ndarray:
    """x, y and heading of 4x4 matrices."""
    rows = [(m[0, 3], m[1, 3], np.arctan2(m[1, 0], m[0, 0])) for m in chain]
    rows = np.array(rows)
    rows[:, 2] = np.unwrap(rows[:, 2])
    return rows


def assert_same_turns(found: np.ndarray, wanted: np.ndarray) -> None:
    """Equal, but for whole turns of all headings."""
    turns = np.round((found[0, 2] - wanted[0, 2]) / (2 * np.pi))
    np.testing.assert_allclose(found, wanted + np.array([0, 0, 2 * np.pi * turns]), atol=1e-9)


MAST = np.linalg.inv(matrix(*MOUNT)) @ matrix(*RISE)
CHAINS = {
    ("map", "base_link"): lambda t: (
        between(SLOW, t, 1) @ matrix(place(t, 2), turn(t, 2)) @ np.linalg.inv(matrix(*MOUNT))
    ),
    ("map", "imu"): lambda t: between(SLOW, t, 1) @ matrix(place(t, 2), turn(t, 2)),
    ("odom", "mast"): lambda t: matrix(place(t, 2), turn(t, 2)) @ MAST,
    ("imu", "odom"): lambda t: np.linalg.inv(matrix(place(t, 2), turn(t, 2))),
    ("mast", "odom"): lambda t: np.linalg.inv(matrix(place(t, 2), turn(t, 2)) @ MAST),
}


@pytest.mark.parametrize("make", [ros1, mcap])
@pytest.mark.parametrize("frames", CHAINS)
def test_a_chain_of_frames_is_the_product_of_their_matrices(tmp_path, make, frames):
    path = make(tmp_path / f"run.{'bag' if make is ros1 else 'mcap'}", tree())
    record = seatrial.read(path, boat(*frames))
    np.testing.assert_array_equal(record.stamps, START + np.rint(FAST * 1e9).astype(int))
    wanted = expected([CHAINS[frames](t) for t in FAST])
    assert_same_turns(record.eta, wanted)
    assert record.streams[0].kind == f"tf2_msgs/TFMessage {frames[0]} -> {frames[1]}"
    assert record.streams[0].delay.median == pytest.approx(0.002)


def test_where_the_moving_frame_nearest_the_boat_is_the_slow_one_its_stamps_count(tmp_path):
    path = ros1(tmp_path / "run.bag", tree())
    record = seatrial.read(path, boat("imu", "map"))  # from the imu: odom, then map
    inside = np.array([t for t in SLOW if FAST[0] <= t <= FAST[-1]])  # beyond, odom is not known
    np.testing.assert_array_equal(record.stamps, START + np.rint(inside * 1e9).astype(int))
    chain = [
        np.linalg.inv(matrix(place(t, 1), turn(t, 1)) @ between(FAST, t, 2)) for t in inside
    ]  # fmt: skip
    np.testing.assert_allclose(record.eta, expected(chain), atol=1e-9)


def test_one_message_may_hold_the_whole_tree_and_ros_1_its_slashes(tmp_path):
    times = np.arange(0, LENGTH, 0.05)
    apart = sent_at(times, 1, "map", "odom") + sent_at(times, 2, "odom", "base_link")
    together = [
        Sent("/tf", "tf/msg/tfMessage", a.time, {"transforms": [
            *({**f, "header": {**f["header"], "frame_id": f"/{f['header']['frame_id']}"},
               "child_frame_id": f"/{f['child_frame_id']}"}
              for m in (a, b) for f in m.fields["transforms"]),
            transform(0, "map", "dock", [0, 0, 0], Rotation.identity()),
        ]})
        for a, b in zip(apart[: len(times)], apart[len(times) :], strict=True)
    ]  # fmt: skip
    one = seatrial.read(
        ros1(tmp_path / "a.bag", apart + joy_sent(LENGTH)), boat("map", "base_link")
    )
    two = seatrial.read(
        ros1(tmp_path / "b.bag", together + joy_sent(LENGTH)), boat("/map", "/base_link")
    )
    np.testing.assert_array_equal(one.stamps, two.stamps)
    np.testing.assert_array_equal(one.eta, two.eta)


def test_two_robots_in_one_tree_are_told_apart_by_their_frames(tmp_path):
    times = np.arange(0, LENGTH, 0.05)
    sent = joy_sent(LENGTH)
    for k in (1, 2):
        sent += sent_at(times, k, "map", f"robot{k}/odom")
        sent += fixed(
            [(f"robot{k}/odom", f"robot{k}/base_link", [0.1 * k, 0, 0], Rotation.identity())]
        )
    path = mcap(tmp_path / "run.mcap", sent)
    for k in (1, 2):
        record = seatrial.read(path, boat("map", f"robot{k}/base_link"))
        chain = [
            matrix(place(t, k), turn(t, k)) @ matrix([0.1 * k, 0, 0], Rotation.identity())
            for t in times
        ]
        np.testing.assert_allclose(record.eta, expected(chain), atol=1e-9)
    between_them = seatrial.read(path, boat("robot1/base_link", "robot2/base_link"))
    offset = [matrix([0.1 * k, 0, 0], Rotation.identity()) for k in (1, 2)]
    chain = [
        np.linalg.inv(matrix(place(t, 1), turn(t, 1)) @ offset[0])
        @ matrix(place(t, 2), turn(t, 2)) @ offset[1]
        for t in times
    ]  # fmt: skip
    assert_same_turns(between_them.eta, expected(chain))


def test_a_robots_own_tf_topic_has_its_own_static_one(tmp_path):
    times = np.arange(0, LENGTH, 0.05)
    sent = joy_sent(LENGTH)
    for k in (1, 2):  # the same names of frames, apart by topic
        sent += sent_at(times, k, "map", "odom", f"/robot{k}/tf")
        mount = ("odom", "base_link", [0.1 * k, 0, 0], Rotation.identity())
        sent += fixed([mount], f"/robot{k}/tf_static")
    path = ros1(tmp_path / "run.bag", sent)
    for k in (1, 2):
        record = seatrial.read(path, boat("map", "base_link", f"/robot{k}/tf"))
        chain = [
            matrix(place(t, k), turn(t, k)) @ matrix([0.1 * k, 0, 0], Rotation.identity())
            for t in times
        ]
        np.testing.assert_allclose(record.eta, expected(chain), atol=1e-9)


@pytest.mark.parametrize(
    ("parent", "child", "words"),
    [
        ("map", "boat", "no transforms lead from 'map' to 'boat'; the bag has base_link -> imu, "
         "base_link -> mast, map -> odom, odom -> imu"),
        ("map", "dock", "no transforms lead from 'map' to 'dock'.*pier -> dock"),
        ("base_link", "mast", "from base_link to mast are all static; name frames that move"),
    ],
)  # fmt: skip
def test_frames_that_do_not_lead_to_each_other_are_refused_with_those_there_are(
    tmp_path, parent, child, words
):
    sent = tree()
    if child == "dock":
        sent += sent_at(SLOW, 3, "pier", "dock")
    path = ros1(tmp_path / "run.bag", sent)
    with pytest.raises(SeatrialError, match=words) as caught:
        seatrial.read(path, boat(parent, child))
    assert "\n" not in str(caught.value)


def test_tf_without_its_frames_named_says_what_to_name(tmp_path):
    path = ros1(tmp_path / "run.bag", tree())
    with pytest.raises(SeatrialError, match="carries transforms: name parent and child"):
        seatrial.read(path, vehicle(pose={"topic": "/tf"}))


def test_rotations_of_any_length_count_and_those_of_none_are_left_out(tmp_path):
    times = np.arange(0, LENGTH, 0.05)
    sent = sent_at(times, 1, "map", "base_link")
    scales = {3: 1e-200, 4: 1e200, 5: 0.0, 6: float("nan"), 7: float("inf"), 8: -1.0}
    for i, scale in scales.items():
        q = sent[i].fields["transforms"][0]["transform"]["rotation"]
        sent[i].fields["transforms"][0]["transform"]["rotation"] = {
            name: 0.0 if scale == 0 else value * scale for name, value in q.items()
        }
    record = seatrial.read(
        ros1(tmp_path / "run.bag", sent + joy_sent(LENGTH)), boat("map", "base_link")
    )
    kept = [i for i in range(len(times)) if i not in (5, 6, 7)]
    wanted = expected([matrix(place(t, 1), turn(t, 1)) for t in times])[kept]
    np.testing.assert_array_equal(record.stamps, START + np.rint(times[kept] * 1e9).astype(int))
    np.testing.assert_allclose(record.eta, wanted, atol=1e-9)


def test_a_tf_topic_beside_pose_messages_is_left_alone(tmp_path):
    path = ros1(tmp_path / "run.bag", tree() + poses_sent(LENGTH))
    assert seatrial.read(path, vehicle()).streams[0].source == "/slam/pose"


def test_times_of_the_other_transforms_may_be_far_away(tmp_path):
    """A map -> odom that ended before the boat moved says nothing about later."""
    late = SLOW - 60.0
    sent = (
        sent_at(late, 1, "map", "odom") + sent_at(FAST, 2, "odom", "base_link") + joy_sent(LENGTH)
    )
    sent = [s._replace(time=max(s.time, START - 70 * SECOND)) for s in sent]
    with pytest.raises(SeatrialError, match="0 poses") as caught:
        seatrial.read(ros1(tmp_path / "run.bag", sent), boat("map", "base_link"))
    assert "\n" not in str(caught.value)


def test_of_a_split_recording_the_first_file_alone_has_the_static_transforms(tmp_path):
    sent = tree()
    late = [s for s in sent if s.time >= START + SECOND and not s.topic.endswith("_static")]
    first = [s for s in sent if s not in late]
    (tmp_path / "run").mkdir()
    ros1(tmp_path / "run" / "run_0.bag", first)
    second = ros1(tmp_path / "run" / "run_1.bag", late)
    whole = seatrial.read(ros1(tmp_path / "whole.bag", sent), boat("map", "base_link"))
    found = seatrial.read(tmp_path / "run", boat("map", "base_link"))
    np.testing.assert_array_equal(found.eta, whole.eta)
    with pytest.raises(SeatrialError, match=r"no tf_static.*give the folder with all of them"):
        seatrial.read(second, boat("map", "base_link"))


def test_transforms_have_stamps_of_their_own(tmp_path):
    path = ros1(tmp_path / "run.bag", tree())
    with open_bag(path) as bag:
        (entry,) = contents(bag, path).of("poses")
    assert entry.stream.clock is Clock.TRANSFORMS
    assert not any("transport delay" in verdict for verdict in clock_verdicts([entry.stream]))
