# SPDX-License-Identifier: MIT
"""Health of signals: each fault is found within seconds, with what it means; a good drive has none."""

import tracemalloc
from dataclasses import replace

import msgspec
import numpy as np
import pytest
import yaml
from conftest import at_length
from live_advice_boat import known_boat
from poolside_sources import VEHICLE, vehicle
from sign_tables import faults, put_wrong, simulated

from seatrial.boat.findings import FindingKind, finding_of
from seatrial.poolside.drive_log import DriveLog
from seatrial.poolside.signal_health import SignalHealth

BEGIN = 1_700_000_000_000_000_000  # [ns]
SECOND = 1_000_000_000
INPUTS = ("F_u", "F_v", "F_r")


def boat_at(t):
    return np.array([0.5 * np.sin(0.4 * t), 0.4 * np.cos(0.3 * t), 0.2 * t])


def command_at(t):
    return np.array([np.sin(0.9 * t), 0.5 * np.sin(1.3 * t), 0.3 * np.cos(0.7 * t)])


def session(
    seconds=12.0,
    *,
    pose=lambda t: (t, boat_at(t)),
    command=lambda t: (t, command_at(t)),
    late=0.01,
    boat=None,
):
    """States after seconds of poses at 20 Hz and commands at 50 Hz; `pose` and `command` give stamp [s] and values."""
    health = SignalHealth(boat or vehicle())
    rng = np.random.default_rng(1)
    for i in range(int(seconds * 100)):
        t = 0.01 * i
        now = BEGIN + round((t + late + rng.exponential(0.002)) * SECOND)
        if i % 5 == 0 and pose is not None and (found := pose(t)) is not None:
            health.use("pose", BEGIN + round(found[0] * SECOND), found[1], now)
        if i % 2 == 0 and command is not None and (found := command(t)) is not None:
            health.use("command", BEGIN + round(found[0] * SECOND), found[1], now)
        if i % 20 == 0:
            health.states(now)
    return {s.name: s for s in health.states(BEGIN + round((seconds + late) * SECOND))}


def test_a_good_drive_has_no_finding():
    states = session()
    assert list(states) == ["pose", *INPUTS]
    assert [(s.level, s.finding, s.gaps, s.jumps) for s in states.values()] == [
        ("ok", "", 0, 0)
    ] * 4
    pose, command = states["pose"], states["F_v"]
    assert pose.rate == pytest.approx(20.0, rel=0.01)
    assert command.rate == pytest.approx(50.0, rel=0.01)
    assert pose.delay == pytest.approx(0.0115, abs=0.002)
    assert 0.0 <= pose.age < 0.1
    assert pose.jitter < 1e-6
    assert len(pose.value) == 3
    assert len(command.value) == 1


FAULTS = {
    "no poses for 5 s": ("pose", {"pose": None}),
    "no commands for 5 s": ("F_u", {"command": None}),
    "they have stopped": ("pose", {"pose": lambda t: (t, boat_at(t)) if t < 3 else None}),
    "a gap of 1": ("pose", {"pose": lambda t: None if 2.0 < t < 3.5 else (t, boat_at(t))}),
    "stamps advance 1e+03 s in one second: they are in another unit": (
        "pose", {"pose": lambda t: (1000 * t, boat_at(t))}),
    "stamps are 3 s ahead of those of the poses": ("F_u", {"command": lambda t: (t + 3.0, command_at(t))}),
    "commands are 2 h after the poses": ("F_r", {"command": lambda t: (t + 7200.0, command_at(t))}),
    "stamps of the last 10 s are not after": ("pose", {"pose": lambda t: (t - 0.3 * (round(20 * t) % 7 == 0), boat_at(t))}),
    "F_v reaches 1": ("F_v", {"command": lambda t: (t, 1500 + 400 * command_at(t))}),
    "the tracker is frozen": ("pose", {"pose": lambda t: (t, boat_at(min(t, 2.0)))}),
    "poses leap": ("pose", {"pose": lambda t: (t, boat_at(t) + (5.0 if round(20 * t) % 2 else 0.0))}),
}  # fmt: skip


@pytest.mark.parametrize("text", FAULTS)
def test_a_fault_is_found_within_seconds(text):
    """Five seconds of the session are enough."""
    name, wrong = FAULTS[text]
    said = text.replace("poses leap", "leap by about")
    state = session(5.0, **wrong)[name]
    assert said in state.finding
    assert state.level in ("warning", "error")


def test_clocks_ahead_and_behind_of_this_machine_are_warnings():
    ahead = session(5.0, late=-0.4)
    assert all("ahead of this machine's clock" in s.finding for s in ahead.values())
    behind = session(5.0, late=0.8)
    assert "arrive 0.8" in behind["pose"].finding
    own = session(5.0, late=1e6)  # a clock that counts since the sender's start
    assert {s.finding for s in own.values()} == {""}
    assert own["pose"].delay is None


def test_constant_and_saturated_commands():
    never = session(12.0, command=lambda t: (t, command_at(t) * [1, 0, 1]))
    assert "F_v has been 0 for 12 s" in never["F_v"].finding
    assert never["F_u"].finding == ""
    on_off = session(
        70.0, command=lambda t: (t, np.sign(command_at(t)) * [1, 0.5, 1] * (t % 10 > 1))
    )
    assert "at its largest value, 0.5" in on_off["F_v"].finding


def test_a_heading_in_degrees_is_found_at_its_first_turn():
    def pose(t):
        place = boat_at(t)
        place[2] = (90.0 * t) % 360.0
        return t, place

    boat = vehicle(pose={**VEHICLE["pose"], "psi": "psi"})
    state = session(5.0, pose=pose, boat=boat)["pose"]
    assert state.edit == "pose: psi: {column: psi, unit: deg}"
    assert "it is in degrees" in state.finding


UNITS = {  # factors on x, y, psi; what is said, and the line of the vehicle file
    "degrees": ((1.0, 1.0, 180.0 / np.pi), "is psi in degrees?", "pose: psi: {column: psi, unit: deg}"),
    "mm": ((1000.0, 1000.0, 1.0), "are x and y in mm or cm?", ""),
}  # fmt: skip


@pytest.mark.parametrize("by_columns", [True, False], ids=["columns", "lines"])
@pytest.mark.parametrize("name", UNITS)
def test_a_wrong_unit_of_the_poses_is_an_error_of_the_signal_within_seconds(name, by_columns):
    """A heading that never turns past 180 degrees, in a drive that is too short to check signs."""
    factors, said, line = UNITS[name]
    boat = vehicle(pose={**VEHICLE["pose"], "psi": "psi"})
    health, log = SignalHealth(boat, by_columns=by_columns), DriveLog(boat)
    for i in range(240):
        stamp, t = BEGIN + i * SECOND // 20, i / 20
        log.add("pose", stamp, [*boat_at(t)[:2], np.sin(0.9 * t)] * np.array(factors))
        log.add("command", stamp, command_at(t))
        health.use("pose", stamp, np.zeros(3), stamp)
    health.check(log.recording())
    state = health.states(BEGIN + 12 * SECOND)[0]
    assert state.level == "error"
    assert said in state.finding
    assert ("begin a new session" in state.finding) != by_columns
    assert state.edit == (line if by_columns else "")


@pytest.mark.parametrize("by_columns", [True, False], ids=["columns", "lines"])
def test_an_input_that_turns_the_boat_the_other_way_is_an_error_of_that_input(by_columns):
    """By the estimate, long before the check of signs has its two minutes."""
    good = known_boat(0.05)
    names = list(good.parameters)
    turned = good.coefficients * np.where(
        np.arange(len(good.coefficients)) == names.index("N_F"), -1, 1
    )
    health = SignalHealth(good.vehicle, by_columns=by_columns)
    for kind, row in (("pose", np.zeros(3)), ("command", np.zeros(3))):
        health.use(kind, BEGIN, row, BEGIN)
    health.check_estimate(good)
    assert [s.level for s in health.states(BEGIN)] == ["ok"] * 4
    health.check_estimate(replace(good, coefficients=turned))
    states = {s.name: s for s in health.states(BEGIN)}
    assert [name for name, s in states.items() if s.level == "error"] == ["F_r"]
    assert "is negative: F_r drives yaw backwards" in states["F_r"].finding
    mend = "inputs: F_r: sign" if by_columns else "correct the program that sends them"
    assert mend in states["F_r"].finding
    health.check_estimate(replace(known_boat(0.25), coefficients=turned))  # four standard errors
    assert {s.level for s in health.states(BEGIN)} == {"ok"}


def test_a_signal_that_the_source_can_not_use_says_why_none_comes():
    """What the source refuses, in place of a general hint to check port and topic."""
    health, refused = (
        SignalHealth(vehicle()),
        "line 3: command: expected 3 numbers: F_u, F_v, F_r; got 2",
    )
    health.use("pose", BEGIN, np.zeros(3), BEGIN)
    states = {s.name: s for s in health.states(BEGIN + 5 * SECOND, refused)}
    assert states["F_u"].finding == f"no commands for 5 s: {refused}"
    assert refused not in states["pose"].finding  # it came


def test_what_the_poses_show_that_the_model_lacks_is_said_of_the_poses():
    """As of a late receiver: intervals of the coefficients know nothing of it. Until a search finds it no more."""
    health, good = SignalHealth(vehicle()), known_boat()
    for kind, row in (("pose", np.zeros(3)), ("command", np.zeros(3))):
        health.use(kind, BEGIN, row, BEGIN)
    late = finding_of(FindingKind.UNMODELLED_DELAY, size=0.2)
    bound = finding_of(FindingKind.SHORT_BLOCKS, length=10.0)
    found = msgspec.structs.replace(good.estimator, findings=(bound, late))
    health.check_estimate(replace(good, estimator=found))
    pose, *inputs = health.states(BEGIN)
    assert pose.level == "warning" and {s.level for s in inputs} == {"ok"}
    assert "a delay of about 0.2 s between position and heading" in pose.finding
    assert "identify with --effect delay" in pose.finding
    health.check_estimate(good)
    assert health.states(BEGIN)[0].level == "ok"


def test_raw_commands_of_lines_are_mended_where_they_are_sent():
    """The vehicle file's offset and scale are not used on lines."""
    health = SignalHealth(vehicle(), by_columns=False)
    health.use("command", BEGIN, np.array([0.0, 64.15, 0.0]), BEGIN)
    state = {s.name: s for s in health.states(BEGIN)}["F_v"]
    assert state.finding.startswith("F_v reaches 64.15")
    assert "correct the program that sends them" in state.finding
    assert "give offset" not in state.finding


def test_jumps_are_counted_once():
    def pose(t):
        away = round(t * 20) in (60, 150, 151)
        return t, boat_at(t) + np.array([2.0, 0.0, 0.0]) * away

    state = session(14.0, pose=pose)["pose"]
    assert state.jumps == 2
    assert state.finding.startswith("2 jumps")


@pytest.mark.system
def test_memory_and_time_are_bounded():
    health = SignalHealth(vehicle())
    tracemalloc.start()
    sizes = []
    for i in range(120_000):
        t = 0.001 * i  # a kilohertz: more than the window keeps
        health.use("pose", BEGIN + round(t * SECOND), boat_at(t), BEGIN + round(t * SECOND))
        if i in (40_000, 119_999):
            sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert sizes[1] < 1.1 * sizes[0]
    assert health.states(BEGIN + 120 * SECOND)[0].rows == 120_000


EXPECTED = {  # the fault, and the signal and the entry that mends it
    "-F_v": ("F_v", "commands: inputs: F_v: {"),
    "-psi": ("pose", "pose: psi: {"),
    "degrees": ("pose", "unit: deg"),
    "F_u<>F_r": ("F_u", "commands: inputs: F_u: {"),
    "x<>y": ("pose", "pose: x: {"),
}


@pytest.mark.parametrize(
    "name", [n if n in ("-F_v", "degrees", "x<>y") else at_length(n) for n in EXPECTED]
)
def test_what_is_wrong_in_the_vehicle_file_is_named_with_the_line_that_mends_it(name):
    table, boat = simulated("hard", "S1", "mallard-mp")
    given, good, wrong = put_wrong([table], boat, faults(boat)[name])
    health = SignalHealth(wrong)
    fill(health, given[0].read(wrong))
    signal, entry = EXPECTED[name]
    state = {s.name: s for s in health.states(health.last)}[signal]
    assert state.level == "error"
    assert state.finding
    assert entry in state.edit
    *_, columns = state.edit.rpartition(": {")
    assert "column" in yaml.safe_load("{" + columns)  # as it would be read in a vehicle file
    mended = SignalHealth(good)
    fill(mended, given[0].read(good))
    assert [s.edit for s in mended.states(mended.last)] == [""] * 4


def fill(health, recording):
    """A recording's signals, and the check of it."""
    for stamp, eta in zip(recording.stamps.tolist(), recording.eta, strict=True):
        health.use("pose", stamp, eta, stamp)
    for stamp, row in zip(
        recording.commands.stamps.tolist(), recording.commands.values, strict=True
    ):
        health.use("command", stamp, row, stamp)
    health.check(recording)
    health.last = int(recording.stamps[-1])


def test_lines_are_mended_where_they_are_sent():
    table, boat = simulated("hard", "S1", "mallard-mp")
    given, _, wrong = put_wrong([table], boat, faults(boat)["-F_v"])
    health = SignalHealth(wrong, by_columns=False)
    fill(health, given[0].read(wrong))
    state = {s.name: s for s in health.states(health.last)}["F_v"]
    assert state.edit == ""
    assert "correct the program that sends them" in state.finding


def test_a_session_too_short_to_check_finds_nothing():
    health = SignalHealth(vehicle())
    log = DriveLog(vehicle())
    for i in range(20):
        log.add("pose", BEGIN + i * SECOND // 20, boat_at(i / 20))
        log.add("command", BEGIN + i * SECOND // 20, command_at(i / 20))
    health.check(log.recording())
    assert health.states(BEGIN)[0].edit == ""


def test_what_the_whole_drive_shows_of_the_poses_takes_the_place_of_jumps():
    health = SignalHealth(vehicle())
    for i in range(200):
        t = 0.05 * i
        away = np.array([2.0, 0.0, 0.0]) * (i in (60, 80))
        health.use("pose", BEGIN + round(t * SECOND), boat_at(t) + away, BEGIN + round(t * SECOND))
    now = BEGIN + 10 * SECOND
    assert health.states(now)[0].finding.startswith("2 jumps")
    health.remark("poses arrive in 9 bursts")
    state = health.states(now)[0]
    assert (state.level, state.finding) == ("warning", "poses arrive in 9 bursts")
    health.remark("x moves in steps of 0.5 m", usable=False)
    assert health.states(now)[0].level == "error"
    health.remark("")
    assert health.states(now)[0].finding.startswith("2 jumps")
