# SPDX-License-Identifier: MIT
"""The tracking controller's node with a real ROS 1: simulator, odometry node and controller, closed."""

import itertools
import signal
import time

import msgspec
import numpy as np
import pytest
import yaml
from conftest import ROOT, TABLE_II, make_model
from ros1_node_tools import messages, needed, nodes, stamp_of, track
from ros_drive import extrapolated, turn

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.control import Circle, Course, save_gains, save_ros, tune

pytestmark, ros = needed, nodes
RECORDED = ("/truth", "/odom", "/map_pose", "/reference", "/goal", "/joy", "/diagnostics")
HOLD = 4.0  # [s] at the first goal
COURSE = Course(Circle(0.3), 14.0)
LAST = HOLD + COURSE.duration + 1.2  # [s] the second goal, after a second without reference
SECOND = (0.1, 0.1, 1.0)
TIMEOUT = 0.5  # [s] of odometry and of references
PACE = 0.5  # simulated seconds in a second: a machine that stands still for 0.2 s delays the loop by 0.1 s
SCENE = """seatrial: scene 1
sensors:
  pose: {rate: 15, position_noise: 0.001, heading_noise: 0.001, delay: 0.05}
boats: [{start: [0.26, -0.03, 1.5]}]
"""


@pytest.fixture(scope="module")
def tuning(boat):
    return tune(boat, 1.0, draws=5)


@pytest.fixture(scope="module")
def files(boat, tuning, tmp_path_factory):
    folder = tmp_path_factory.mktemp("tracking")
    seatrial.save(boat, folder / "model.yaml")
    (folder / "scene.yaml").write_text(SCENE)
    save_gains(tuning, folder / "gains.yaml")
    save_ros(tuning, folder / "ros.yaml")
    rows = [("goal", 0.0, *COURSE.at(0.0).eta, 0.0, 0.0, 0.0)]
    for t in np.arange(0.0, COURSE.duration + 1e-9, 0.05):
        now = COURSE.at(t)
        rows.append(("reference", HOLD + t, *now.eta, *now.body()[0]))
    rows.append(("goal", LAST, *SECOND, 0.0, 0.0, 0.0))
    (folder / "course.txt").write_text("\n".join(" ".join(map(str, row)) for row in rows))
    return folder


@pytest.fixture(scope="module")
def recorded(ros, files, tmp_path_factory):
    """A goal, a course, a pause, another goal; then odometry ends, and then the controller."""
    out = tmp_path_factory.mktemp("recorded") / "out.bag"
    model = files / "model.yaml"
    recorder = ros.record("-O", out, topics=RECORDED)
    odometer = ros.node("odometry", model=model)
    tracker = ros.node("tracking", hears="/goal", model=model, gains=files / "gains.yaml")
    scene = files / "scene.yaml"
    simulator = ros.node("simulator", models=model, scene=scene, real_time_factor=PACE)
    ros.until(lambda: ros.connected("/joy") and ros.connected("/map_pose"), "connections")
    ros.run("rostopic", "echo", "-n10", "/joy")  # without any reference
    ros.finish(ros.start("python3", ROOT / "tests" / "ros1_course.py", files / "course.txt"))
    time.sleep(0.5 / PACE)  # on the way to the second goal
    ros.finish(odometer, signal.SIGINT)
    for _ in range(2):  # a second of simulated time each, or more
        ros.run("rostopic", "echo", "-n50", "/truth")
    for process in (tracker, recorder, simulator):
        ros.finish(process, signal.SIGINT)
    return out


def poses(bag, topic):
    """Stamps [s], poses (n, 3) and body velocities (n, 3)."""
    stamps, poses, velocities = track(bag, topic)
    return stamps * 1e-9, poses, velocities


def commands(bag):
    """Stamps [s] and commands (n, 3): surge, sway, yaw."""
    rows = [
        (stamp_of(m.header) * 1e-9, m.axes[1], m.axes[0], m.axes[3])
        for _, m in messages(bag, "/joy")
    ]
    found = np.array(rows)
    return found[:, 0], found[:, 1:]


def begin_of(bag):
    """Stamp [s] of the course's t = 0."""
    return stamp_of(messages(bag, "/goal")[0][1].header) * 1e-9


def away(pose, wanted):
    """Distance (n,) [m] and difference in heading (n,) [rad]."""
    turn = np.angle(np.exp(1j * (pose[:, 2] - wanted[:, 2])))
    return np.hypot(*(pose - wanted)[:, :2].T), np.abs(turn)


def test_the_course_is_tracked_within_two_centimetres_of_the_truth(recorded):
    t, pose, velocity = poses(recorded, "/truth")
    t = t - begin_of(recorded) - HOLD
    on = (t > 0.0) & (t < COURSE.duration)
    off, turned = away(pose[on], np.array([COURSE.at(x).eta for x in t[on]]))
    assert on.sum() > 400
    assert off.max() < 0.03, off.max()
    assert np.sqrt(np.mean(off**2)) < 0.02
    assert turned.max() < 0.1
    assert np.abs(velocity[on, 0]).max() > 0.12  # it went all the way round
    assert np.ptp(pose[on, 0]) > 0.55


def test_a_goal_is_reached_as_the_knob_says(recorded, tuning):
    """By the closed loop's (1 + 3 knob s) / (1 + knob s)^3, which the delay shifts: it overshoots by 20 %.

    Where the machine is busy, messages come later, too.
    """
    t, pose, _ = poses(recorded, "/truth")
    t = t - begin_of(recorded)
    goal = COURSE.at(0.0).eta
    way = (goal - pose[np.searchsorted(t, 0.0)])[:2]
    on = (t > 0.0) & (t < HOLD)
    left = (goal - pose[on])[:, :2] @ way / np.hypot(*way)

    def apart(later):
        x = np.maximum(t[on] - tuning.delay.mean() - later, 0.0) / tuning.knob
        want = np.hypot(*way) * np.exp(-x) * (1.0 + x - x**2)
        return float(np.abs(left - want).max())

    assert np.hypot(*way) > 0.04
    least = min(apart(later) for later in np.arange(0.0, 0.2, 0.02))
    assert least < 0.01, (least, apart(0.0))
    off, turned = away(pose[on][-20:], goal[None, :])
    assert off.max() < 0.02
    assert turned.max() < 0.05


def test_commands_are_those_of_the_controller_in_python(recorded, tuning, boat):
    """From the same messages; which of the last ones had come when it ticked, its command itself must tell.

    Where a message came later still, the integral takes another error once: an offset that stays.
    """
    t, given = commands(recorded)
    controller = seatrial.TrackingController(tuning, boat)
    lead = controller.gains.lead
    since = t - begin_of(recorded) - HOLD
    at, eta, _ = poses(recorded, "/map_pose")
    then, _, nu = poses(recorded, "/odom")
    targets = targets_of(recorded)
    stamps = at, then, [target[0] for target in targets]
    off, whole, ticks, last, stays = [], [], [], None, np.zeros(3)
    for i in np.flatnonzero(np.any(given != 0.0, axis=1) & (since < COURSE.duration)):
        now = t[i]
        could = []
        for p, v, r in itertools.product(*(latest(x, now) for x in stamps)):
            here = eta[p] + (now - at[p]) * turn(eta[p, 2]) @ nu[v]
            seen = here, nu[v], wanted(targets[r], now), wanted(targets[r], now + lead)
            # with no time gone by, nothing is integrated
            value = controller.command(now if last is None else last, *seen)
            could.append((np.abs(given[i] - value - stays).max(), given[i] - value, seen))
        least, apart, seen = min(could, key=lambda c: c[0])
        controller.command(now, *seen)
        last = now
        if least > 1e-4 and np.abs(apart).max() < 1e-3:  # not what drifts
            stays = apart
        off.append(least)
        whole.append(np.abs(apart).max())
        ticks.append(since[i])
    off, ticks = np.array(off), np.array(ticks)
    ramp = COURSE.ramp * COURSE.duration
    steady = (ticks > ramp) & (ticks < COURSE.duration - ramp)
    for part in (ticks < 0.0, (ticks > 0.0) & (ticks < ramp), steady):
        assert part.sum() > 100
        assert np.quantile(off[part], 0.98) < 1e-4  # the others: a message that came later still
    assert np.quantile(whole, 0.1) < 1e-4  # before the first of these messages there is no offset
    assert max(whole) < 0.05
    assert np.abs(given).max() > 0.3


def latest(stamps, now, count=4):
    """Indices of the messages that can have come last by now: the newest, or one that was still on its way."""
    newest = np.searchsorted(stamps, now, side="right") - 1
    return [i for i in range(newest, newest - count, -1) if i >= 0]


def targets_of(bag):
    """The goal and the references after it: stamp [s], pose, body velocity and its rate (3,) of each."""
    still = np.zeros(3)
    found = [(begin_of(bag), COURSE.at(0.0).eta, still, still)]
    before = None
    for stamp, pose, nu in zip(*poses(bag, "/reference"), strict=True):
        gained = still if before is None else (nu - before[1]) / (stamp - before[0])
        found.append((stamp, pose, nu, gained))
        before = stamp, nu
    return found


def wanted(target, time):
    """The reference at a time [s], with the body-fixed acceleration of its last two messages."""
    at, *motion = target
    return extrapolated(*motion, time - at)


def zero_from(bag, after):
    """Stamps [s] of the last command before, and of the first that is zero; whether they stay so for 0.3 s."""
    t, given = commands(bag)
    moving = np.any(given != 0.0, axis=1)
    first = np.flatnonzero(~moving & (t > after))[0]
    return t[first - 1], t[first], not np.any(moving[(t >= t[first]) & (t < t[first] + 0.3)])


def test_a_silent_reference_and_silent_odometry_end_commands_in_time(recorded):
    begin = begin_of(recorded)
    ends = {
        "no reference": begin + HOLD + COURSE.duration,
        "no odometry": poses(recorded, "/odom")[0][-1],
    }
    t, given = commands(recorded)
    for words, end in ends.items():
        assert np.any(given[(t > end - 0.3) & (t < end + 0.3)], axis=1).all(), words
        last, when, stays = zero_from(recorded, end)
        # at its first tick after that; ticks are late where the machine is busy
        assert last - end < TIMEOUT + 0.1, words
        assert when - end > TIMEOUT - 0.05, words
        assert stays
        said = [
            stamp_of(m.header) * 1e-9 for _, m in messages(recorded, "/diagnostics")
            if m.status[0].name == "seatrial_tracking: tracking" and words in m.status[0].message
            and stamp_of(m.header) * 1e-9 > end
        ]  # fmt: skip
        assert min(said) - when < 0.1, words


def test_without_any_reference_commands_are_zero(recorded):
    t, given = commands(recorded)
    before = t < begin_of(recorded)
    assert before.sum() > 5
    assert not given[before].any()


@pytest.fixture(scope="module")
def pulsed(mp, files):
    """The same boat, its thrusters commanded one by one in microseconds: model and ROS parameters."""
    raw = msgspec.to_builtins(mp.file)
    names = list(raw["thrusters"])
    columns = [
        {"column": name, "field": f"data[{i}]", "scale": 400.0, "offset": 1500.0}
        for i, name in enumerate(names)
    ]
    inputs = dict(zip(names, columns, strict=True))
    raw["commands"] = {"topic": "/pulses", "stamp": {"column": "t"}, "inputs": inputs}
    raw["allocation"] = {"scheme": "direct"}
    model = make_model(vehicle_from(raw, "pulsed"), TABLE_II["MP"])
    seatrial.save(model, files / "pulsed.yaml")
    tuning = tune(model, 1.0, action="pd", draws=5, allocation="null-space")
    save_ros(tuning, files / "pulsed-ros.yaml")
    return files / "pulsed.yaml", files / "pulsed-ros.yaml"


def test_thrusters_in_microseconds_by_gains_as_parameters(ros, pulsed):
    """A boat that stands still, 5 cm short of its goal; then the goal's frame, then the pose is at fault."""
    model, parameters = pulsed
    ros.until(lambda: "/seatrial_tracking" not in ros.subscribers("/goal"), "the other's end")
    ros.run("rosparam", "delete", "/seatrial_tracking")
    ros.run("rosparam", "set", "use_sim_time", "false")
    ros.run("rosparam", "load", parameters)
    node = ros.node("tracking", hears="/goal", model=model)

    def pulses():
        return yaml.safe_load(ros.run("rostopic", "echo", "-n1", "/pulses").split("---")[0])["data"]

    def says(words):
        ros.until(lambda: words in ros.run("rostopic", "echo", "-n1", "/diagnostics"), words)

    def go(frame, words):
        goal = ros.goal(frame)
        says(words)
        ros.finish(goal, signal.SIGINT)

    assert pulses() == [1500.0] * 4  # no odometry yet
    velocity = ros.stands("/odom", "nav_msgs/Odometry")
    pose = ros.stands("/map_pose", "geometry_msgs/PoseWithCovarianceStamped")
    go("map", "follows the reference")
    gains = yaml.safe_load(parameters.read_text())["seatrial_tracking"]
    share = np.array(gains["mix"]).reshape(4, 3)[:, 0] * gains["proportional"][0] * 0.05
    assert np.abs(share).max() > 0.1
    allocator = seatrial.Allocator(seatrial.load(model), "null-space")
    values = allocator.allocate(allocator.boat.T @ share)
    assert np.abs(values - share).max() > 0.03  # idle, all of them
    np.testing.assert_allclose(pulses(), 1500.0 + 400.0 * values, atol=0.01)
    go("odom", "in another frame")
    assert pulses() == [1500.0] * 4
    go("map", "follows the reference")
    ros.finish(pose, signal.SIGINT)
    doubt = f", covariance: {[0.16] + [0.0] * 35}"  # 0.4 m, of the 0.3 that may be
    pose = ros.stands("/map_pose", "geometry_msgs/PoseWithCovarianceStamped", doubt)
    says("too uncertain")
    assert pulses() == [1500.0] * 4
    for process in (pose, velocity, node):
        ros.finish(process, signal.SIGINT)
    ros.run("rosparam", "delete", "/seatrial_tracking")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("__name:=a",), "parameter model is empty"),
        (("__name:=b", "_model:={model}"), "parameter proportional has 0 numbers; expected 3"),
        (("__name:=c", "_model:={model}", "_gains:={model}"), "expected 'seatrial: gains 1'"),
        (("__name:=d", "_model:={model}", "_gains:={inputs}"), "the gains are for F_u, F_v, F_q"),
        (("__name:=e", "_model:={model}", "_gains:={other}"), "full command in sway gives 9.0"),
        (("__name:=f", "_model:={model}", "_gains:={gains}", "_timeout:=90.0"), "timeout is 90"),
        (("__name:=g", "_model:={model}", "_gains:={gains}", "_allocation:=auto"), "the gains have none"),
        (("__name:=h", "_model:={model}", "_gains:={thrusters}"), "the model's vehicle allocates by"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(ros, files, arguments, words):
    gains = yaml.safe_load((files / "gains.yaml").read_text())
    names = {name: files / f"{name}.yaml" for name in ("model", "gains", "inputs", "other")}
    names["inputs"].write_text(yaml.safe_dump({**gains, "inputs": ["F_u", "F_v", "F_q"]}))
    surge, _, yaw = gains["authority"]
    names["other"].write_text(yaml.safe_dump({**gains, "authority": [surge, 9.0, yaw]}))
    numbers = {"limits": [1.0] * 4, "idle_forward": [0.1] * 4, "idle_reverse": [0.1] * 4}
    allocation = {
        "scheme": "auto", "rank": [1, 1, 0], "hysteresis": 0.0, "effectiveness": [[1, 0, 0]] * 4, **numbers
    }  # fmt: skip
    names["thrusters"] = files / "thrusters.yaml"
    names["thrusters"].write_text(yaml.safe_dump({**gains, "allocation": allocation}))
    assert words in ros.complaint("tracking", *(a.format(**names) for a in arguments))
