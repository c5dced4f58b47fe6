# SPDX-License-Identifier: MIT
"""The ROS tracking node without ROS beside Python's controller: the same gains file, the same commands."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from conftest import make_model
from cpp_tools import built, fed
from ros_drive import extrapolated
from steered_boat import known
from survey_boat import LAG, LATENCY, TRUTH, boat
from tune_tools import mallard, without_guidance

import seatrial
from seatrial.control import (
    Reference,
    TrackingController,
    at_speed,
    ros_parameters,
    rounded_square,
    save_gains,
    tune,
)

pytestmark = pytest.mark.system
BEGIN = 1_000_000_000_000  # [ns]
COURSE = at_speed(rounded_square(6.0, 1.5), 0.25, 4.0)
GOAL = np.array([1.0, 4.0, 0.3])
FOLLOWING, UNCERTAIN = {"0", "1"}, "4"  # Conduct: follows, limited
# of the vehicle's command topic: the survey boat has columns, a bag's topic here
TOPIC = {"left": "axes[0]", "right": "axes[1]"}


def survey(dead_zone=0.0):
    """Two thrusters astern, commanded by a joypad's axes."""
    chain = {
        "latency": LATENCY,
        "lag": LAG,
        "dead_zone": {"forward": dead_zone, "reverse": dead_zone},
    }
    own = boat([chain])
    content = own.to_mapping()
    content["pose"] = {
        "topic": "/pose", "x": "pose.position.x", "y": "pose.position.y", "psi": "pose.orientation",
    }  # fmt: skip
    content["commands"] = {
        "topic": "/joy",
        "inputs": {name: {"field": f} for name, f in TOPIC.items()},
    }
    model = make_model(seatrial.boat.vehicle.vehicle_from(content, "survey"), TRUTH)
    return dataclasses.replace(model, covariance=np.zeros_like(model.covariance))


def outboard():
    """One thrust and its angle, the same way."""
    own = known()
    content = own.vehicle.to_mapping()
    content["pose"] = survey().vehicle.to_mapping()["pose"]
    fields = {"motor": "axes[0]", "helm": "axes[1]"}
    content["commands"] = {"topic": "/joy", "inputs": {n: {"field": f} for n, f in fields.items()}}
    found = make_model(seatrial.boat.vehicle.vehicle_from(content, "outboard"), own.values)
    return dataclasses.replace(found, covariance=np.zeros_like(found.covariance))


CASES = {
    "a thrust and its angle": lambda: tune(outboard(), 1.5),
    "two thrusters": lambda: tune(survey(), 1.0),
    "two thrusters by an allocator": lambda: tune(survey(0.08), 1.0, allocation="auto"),
    "three axes": lambda: tune(mallard(spread=0.0), 1.0),
}


@pytest.fixture(scope="module")
def program() -> Path:
    """The node, under the sanitizers."""
    return built("tracking")


@pytest.fixture(scope="module", params=CASES)
def written(request, tmp_path_factory):
    """A tuning, and the folder of its model and gains file."""
    tuning = CASES[request.param]()
    folder = tmp_path_factory.mktemp("tracking")
    seatrial.save(tuning.model, folder / "model.yaml")
    save_gains(tuning, folder / "gains.yaml")
    return tuning, folder


def motions(ticks: int):
    """Seconds, pose and velocity of a boat somewhere about the course, then about the goal."""
    rng = np.random.default_rng(3)
    off = np.cumsum(rng.normal(size=(ticks, 3)), axis=0) * [0.02, 0.02, 0.03]
    for i in range(ticks):
        t = 0.02 * i
        near = COURSE.at(t).eta if i < ticks // 2 else GOAL
        yield t, near + off[i], rng.normal(size=3) * [0.1, 0.05, 0.1]


def line(t, kind, eta=(), nu=()):
    """An event."""
    return " ".join([str(BEGIN + round(1e9 * t)), kind, *(repr(float(x)) for x in (*eta, *nu))])


def script(ticks: int) -> list[str]:
    """Odometry and a reference before every tick; a goal in the second half."""
    found = []
    for i, (t, eta, nu) in enumerate(motions(ticks)):
        found += [line(t, "odom", eta, nu), line(t, "map_pose", eta, nu)]
        if i < ticks // 2:
            now = COURSE.at(t)
            found.append(line(t, "reference", now.eta, now.body()[0]))
        elif i == ticks // 2:
            found.append(line(t, "goal", GOAL, np.zeros(3)))
        found.append(line(t, "tick"))
    return found


def expected(tuning, folder: Path, ticks: int) -> np.ndarray:
    """Python's controller on the same messages: acceleration by the difference of body velocities."""
    controller = TrackingController(folder / "gains.yaml", folder / "model.yaml")
    rows, before = [], None
    for i, (t, eta, nu) in enumerate(motions(ticks)):
        if i < ticks // 2:
            wanted = COURSE.at(t)
            own, _ = wanted.body()
            gained = np.zeros(3) if before is None else (own - before) / 0.02
            before = own
            now, ahead = (
                extrapolated(wanted.eta, own, gained, dt) for dt in (0.0, tuning_lead(controller))
            )
        else:
            now = ahead = Reference.still(GOAL)
        rows.append(controller.command(t, eta, nu, now, ahead))
    return np.array(rows)


def tuning_lead(controller) -> float:
    """As the node rounds it."""
    return round(1e9 * controller.gains.lead) * 1e-9


def run(program: Path, events: list[str], **settings: object) -> tuple[int, list[list[str]], str]:
    """Return code, answers, error."""
    done = fed(program, events, **settings)
    return done.returncode, [row.split() for row in done.stdout.splitlines()], done.stderr


def test_the_node_gives_the_commands_of_python(program, written):
    tuning, folder = written
    code, rows, error = run(
        program, script(400), model=folder / "model.yaml", gains=folder / "gains.yaml"
    )
    assert (code, error) == (0, "")
    assert {row[0] for row in rows} <= FOLLOWING
    given = np.array([[float.fromhex(x) for x in row[1:]] for row in rows])
    np.testing.assert_allclose(given, expected(tuning, folder, 400), atol=1e-6)
    assert np.abs(given).max() > 0.2


def test_parameters_do_as_the_file(program, written):
    tuning, folder = written
    numbers = {
        name: ",".join(repr(float(x)) for x in value) if isinstance(value, list) else value
        for name, value in ros_parameters(tuning).items()
        if name not in ("knob", "action")
    }
    by_file, by_parameters = (
        run(program, script(100), model=folder / "model.yaml", **given)
        for given in ({"gains": folder / "gains.yaml"}, numbers)
    )
    assert by_parameters[0] == 0, by_parameters[2]
    for one, two in zip(by_file[1], by_parameters[1], strict=True):
        assert [float.fromhex(x) for x in one[1:]] == pytest.approx(
            [float.fromhex(x) for x in two[1:]], abs=1e-9
        )


@pytest.mark.parametrize("in_map", ["true", "false"])
def test_a_velocity_of_which_nothing_is_known_gives_zero_commands(program, written, in_map):
    """After a divergence the odometry node goes on publishing zeros, as before its first pose."""
    tuning, folder = written
    odometer, events = seatrial.Odometer(tuning.model), [line(0.0, "goal", GOAL, np.zeros(3))]
    for i in range(3):
        variance = np.diag(odometer.look(BEGIN + i * 10**8).covariance)[3:]
        odometer.pose(BEGIN + i * 10**8, np.zeros(3))
        rest = np.zeros(3)
        events += [line(0.1 * i, "map_pose", rest, rest), line(0.1 * i, "odom", rest, [*rest, *variance])]  # fmt: skip
        events.append(line(0.1 * i, "tick"))
    given = {"model": folder / "model.yaml", "gains": folder / "gains.yaml"}
    code, rows, error = run(program, events, control_in_map=in_map, **given)
    assert (code, error) == (0, "")
    assert rows[0][0] == UNCERTAIN
    assert not any(float.fromhex(x) for x in rows[0][1:])
    assert rows[2][0] in FOLLOWING
    assert any(float.fromhex(x) for x in rows[2][1:])


def test_messages_out_of_order_are_not_used(program, written):
    """Each one once more, 40 ms late: the commands stay. A clock that was set back by a second is followed."""
    _, folder = written
    given = {"model": folder / "model.yaml", "gains": folder / "gains.yaml"}
    plain = script(400)
    mixed = []
    for i, event in enumerate(plain):
        mixed.append(event)
        words = event.split()
        if words[1] in ("odom", "map_pose", "reference") and i > 10:
            late = [str(int(words[0]) - 40_000_000), words[1], *(["9"] * 6)]
            mixed.append(" ".join(late))
    assert len(mixed) > len(plain) + 500
    assert run(program, mixed, **given) == run(program, plain, **given)
    back = [f"{int(event.split()[0]) - 10**9} {event.split(maxsplit=1)[1]}" for event in plain]
    _, rows, _ = run(program, [*plain, *back], **given)
    assert {row[0] for row in rows[400:]} <= FOLLOWING


def test_gains_without_guidance_are_refused_for_a_boat_without_sway(program, tmp_path):
    tuning = tune(survey(), 1.0)
    seatrial.save(tuning.model, tmp_path / "model.yaml")
    gains = without_guidance(tuning, tmp_path / "gains.yaml")
    code, _, error = run(program, [], model=tmp_path / "model.yaml", gains=gains)
    assert code == 1
    assert (
        "authority is 0 in sway; expected more than 0, and 0 in sway with guidance: tune it"
        in error
    )
