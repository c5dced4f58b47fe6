# SPDX-License-Identifier: MIT
"""The odometer on DDS: Fast DDS from Debian and Cyclone DDS from PyPI, with ROS 2's names, types and QoS.

Both talk over the loopback interface of a network namespace of their own.
"""

import math
import random
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, TABLE_II, make_model
from cpp_tools import run
from dds_tools import Order, canonical, exchange, line

import seatrial

BEGIN = 1_770_000_000  # [s]
START, HEADING = (3.0, -2.0), 0.5  # [m], [rad]
SPEED, TURN = 0.15, 0.2  # [m/s], [rad/s] along a circle
DRIVE = 4.0  # [s]
ODD = (-0.0, 5e-324, -1.7e308, math.inf, -math.inf, math.nan, 1e-40, 0.1)
ODD_32 = (-0.0, 2.0**-149, -3.0e38, math.inf, -math.inf, math.nan, 1e-40, 0.1)
FRAMES = ("", "m", "map", "öst", "a_frame_with_a_long_name/of_a_boat")


def missing() -> str:
    """What isn't there, if anything."""
    parts = {
        "cyclonedds from PyPI": find_spec("cyclonedds"),
        "libfastrtps-dev": Path("/usr/include/fastdds").exists(),
        "libyaml-cpp-dev": Path("/usr/include/yaml-cpp").exists(),
        "ip from iproute2": shutil.which("ip"),
        "a C++ compiler": shutil.which("c++"),
        "a network namespace": shutil.which("unshare")
        and subprocess.run(["unshare", "-rn", "true"], check=False).returncode == 0,
    }
    return ", ".join(name for name, there in parts.items() if not there)


pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(bool(missing()), reason=f"no {missing()}"),
]


@pytest.fixture(scope="module")
def model(mp, tmp_path_factory):
    """The mallard of the paper's Table II, which reads axes 1, 0 and 3; its file."""
    path = tmp_path_factory.mktemp("dds") / "model.yaml"
    seatrial.save(make_model(mp, TABLE_II["MP"]), path)
    return path


@pytest.fixture(scope="module")
def talk(model):
    """Let the program and Cyclone exchange messages."""
    build = ROOT / "build" / "wire"
    run("cmake", "-S", str(ROOT / "ros" / "wire"), "-B", str(build))
    run("cmake", "--build", str(build))
    program = build / "odometry_over_dds"

    def run_both(verb, profile, messages, subscriber=""):
        return exchange(program, Order(verb, profile, str(model), messages, subscriber))

    return run_both


def header(t: float, frame: str = "map") -> dict:
    sec, rest = divmod(t, 1.0)
    return {"stamp": {"sec": BEGIN + int(sec), "nanosec": int(1e9 * rest)}, "frame_id": frame}


def pose(head, x, y, psi) -> tuple[str, dict]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(psi / 2), "w": math.cos(psi / 2)}
    place = {"x": x, "y": y, "z": 0.0}
    return "pose", {"header": head, "pose": {"position": place, "orientation": turn}}


def joy(head, axes, buttons=()) -> tuple[str, dict]:
    return "joy", {"header": head, "axes": list(axes), "buttons": list(buttons)}


def circle(t: float) -> tuple[float, float, float]:
    """x, y, psi of a boat that surges and turns steadily."""
    psi = HEADING + TURN * t
    radius = SPEED / TURN
    x = START[0] + radius * (math.sin(psi) - math.sin(HEADING))
    y = START[1] - radius * (math.cos(psi) - math.cos(HEADING))
    return x, y, psi


def drive() -> list[tuple[str, dict]]:
    """Poses along the circle at 16 Hz, and the thrust that keeps the boat there."""
    found = []
    c = TABLE_II["MP"]  # Eq. (12), steady
    surge = -(c["X_u"] + c["X_uu"] * SPEED) * SPEED / c["X_F"]
    sway = SPEED * TURN / c["Y_F"]
    yaw = -((c["N_r"] + c["N_rr"] * TURN) * TURN + c["N_uu"] * SPEED**2) / c["N_F"]
    axes = [sway, surge, 0.25, yaw]
    for k in range(int(16 * DRIVE)):
        found.append(pose(header(k / 16), *circle(k / 16)))
        found.append(joy(header(k / 16 + 1 / 32), axes, range(k % 13)))
    return found


def odd_messages() -> list[tuple[str, dict]]:
    """Whatever a message can hold, after one pose that makes the odometer begin."""
    draw = random.Random(7)
    found = [pose(header(0.0), *circle(0.0))]
    for k in range(1, 60):
        head = header(k / 64, draw.choice(FRAMES))
        numbers = [draw.choice((*ODD, draw.gauss(0.0, 1.0))) for _ in range(7)]
        part = {"position": dict(zip("xyz", numbers[:3], strict=True)),
                "orientation": dict(zip("xyzw", numbers[3:], strict=True))}  # fmt: skip
        axes = [draw.choice((*ODD_32, draw.uniform(-1.0, 1.0))) for _ in range(draw.randint(4, 9))]
        buttons = [draw.randint(-(2**31), 2**31 - 1) for _ in range(draw.randint(0, 12))]
        found += [("pose", {"header": head, "pose": part}), joy(head, axes, buttons)]
    return found


def members(text: str) -> dict[str, str]:
    return dict(word.partition("=")[::2] for word in text.split()[1:])


def numbers(text: str, *names: str) -> list[float]:
    found = members(text)
    return [float.fromhex(found[name]) for name in names]


@pytest.fixture(scope="module")
def scripted(talk):
    """The drive from lines of text."""
    return talk("script", "default", drive())


def test_cyclone_receives_what_fast_dds_published_to_the_bit(scripted):
    assert scripted.error == ""
    assert len(scripted.published) == len(drive())
    assert scripted.received == scripted.published


@pytest.mark.parametrize("profile", ["default", "sensor-data"])
def test_poses_and_commands_go_there_and_odometry_comes_back_as_without_dds(
    talk, scripted, profile
):
    found = talk("serve", profile, drive())
    assert found.error == ""
    assert len(found.sent) == len(drive())
    assert found.got == found.sent
    assert found.received == found.published == scripted.published


def test_whatever_a_message_can_hold_arrives(talk):
    found = talk("serve", "default", odd_messages())
    assert found.error == ""
    assert len(found.got) == 2 * 59 + 1
    assert found.got == found.sent
    assert found.received == found.published
    assert len({members(text)["header.frame_id"] for text in found.got}) == len(FRAMES)


def in_message(planar) -> list[float]:
    """A covariance of x, y and yaw among z, roll and pitch, of which nothing is known."""
    full = np.diag([0.0, 0.0, 1e6, 1e6, 1e6, 0.0])
    full[np.ix_([0, 1, 5], [0, 1, 5])] = planar
    return full.ravel().tolist()


def said_by_python(model) -> list[dict]:
    """The drive by `seatrial.Odometer`, as members of messages."""
    odometer = seatrial.Odometer(model)
    found = []
    for kind, values in drive():
        stamp = values["header"]["stamp"]
        at = 10**9 * stamp["sec"] + stamp["nanosec"]
        if kind == "pose":
            place, turn = values["pose"]["position"], values["pose"]["orientation"]
            odometer.pose(at, [place["x"], place["y"], 2 * math.atan2(turn["z"], turn["w"])])
        else:
            odometer.command(at, np.float32([values["axes"][i] for i in (1, 0, 3)]))
        now = odometer.at(at)
        (x, y, psi), (u, v, r) = now.pose, now.motion.velocity
        turn = {"x": 0.0, "y": 0.0, "z": math.sin(psi / 2), "w": math.cos(psi / 2)}
        place = {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turn}
        rates = {"linear": {"x": u, "y": v, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": r}}
        spreads = in_message(now.covariance), in_message(now.motion.covariance[3:, 3:])
        found.append({
            "header": {"stamp": stamp, "frame_id": "odom"}, "child_frame_id": "base_link",
            "pose": {"pose": place, "covariance": spreads[0]},
            "twist": {"twist": rates, "covariance": spreads[1]},
        })  # fmt: skip
    return found


def test_the_odometry_is_python_s(scripted, model):
    for expected, text in zip(said_by_python(model), scripted.received, strict=True):
        wanted, got = members(line("odometry", expected)), members(text)
        assert list(got) == list(wanted)
        floats = [name for name, value in wanted.items() if "0x" in value]
        assert len(floats) == 7 + 36 + 6 + 36
        assert all(got[name] == wanted[name] for name in wanted if name not in floats)
        np.testing.assert_allclose(
            numbers(text, *floats), [float.fromhex(wanted[name]) for name in floats],
            rtol=1e-9, atol=1e-12,
        )  # fmt: skip


def test_the_odometry_is_that_of_the_boat_that_was_driven(scripted):
    last = scripted.received[-1]
    velocity = numbers(last, *(f"twist.twist.{n}" for n in ("linear.x", "linear.y", "angular.z")))
    np.testing.assert_allclose(velocity, [SPEED, 0.0, TURN], atol=1e-5)
    x, y, _ = circle(DRIVE - 1 / 32)
    way = (complex(x, y) - complex(*START)) * complex(math.cos(HEADING), -math.sin(HEADING))
    place = numbers(last, "pose.pose.position.x", "pose.pose.position.y")
    np.testing.assert_allclose(
        place, [way.real, way.imag], atol=0.01
    )  # its speed was unknown at first


def test_a_subscriber_of_sensor_data_hears_a_default_publisher(talk, scripted):
    found = talk("script", "default", drive(), "sensor-data")
    assert found.error == ""
    assert found.received == found.published == scripted.published


def test_a_default_subscriber_is_told_that_it_asks_a_best_effort_publisher_for_too_much(talk):
    found = talk("script", "sensor-data", drive(), "default")
    assert found.error == (
        "rt/odom: a subscriber asks for reliable, offered is best effort; publish as 'default', "
        "or subscribe as best effort\n"
    )
    assert found.received == found.published == []


def test_a_joypad_with_too_few_axes_ends_the_program_with_a_line(talk):
    messages = [pose(header(0.0), *circle(0.0)), joy(header(0.1), [0.0, 0.0])]
    found = talk("serve", "default", messages)
    assert found.error == "joy: got 2 axes, expected 4 or more, as the model file reads them\n"
    assert len(found.received) == 1


def test_lines_of_text_keep_every_bit():
    """What the comparisons above rest on."""
    kind, values = joy(header(0.5), ODD_32)
    again = members(canonical(line(kind, values)))
    got = np.array([float.fromhex(again[f"axes[{i}]"]) for i in range(len(ODD_32))], np.float32)
    np.testing.assert_array_equal(got.view(np.uint32), np.array(ODD_32, np.float32).view(np.uint32))
    assert canonical("odometry x=-0x0p+0 y=0x1p+0 z=-nan n=-7") == (
        "odometry x=-0x0.0p+0 y=0x1.0000000000000p+0 z=nan n=-7"
    )
