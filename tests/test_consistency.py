# SPDX-License-Identifier: MIT
"""Units, signs and order put wrong in files of good recordings: found every time, never cried wolf."""

import tracemalloc
from dataclasses import replace
from importlib import import_module
from unittest.mock import Mock

import msgspec
import numpy as np
import pytest
from conftest import CSE1, at_length
from sign_tables import (
    Table,
    assert_found,
    direct,
    faults,
    inputs_edited,
    put_wrong,
    read_all,
    simulated,
    tabulated,
    untouched,
)

import seatrial
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.channel_assignment import assignments
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.gains import gains, read_runs, without_drag
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.inspection.consistency.repair import apply_repair
from seatrial.recording.excitation import even_times
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import load_plan, with_seed
from seatrial.simulation.trials import simulate
from seatrial.util.errors import IdentificationError
from tests.boats.hulls import MIDDLE


@pytest.fixture(scope="module")
def ship(cse1, cse1_vehicle) -> list[Table]:
    marks = [
        np.genfromtxt(CSE1 / "csv" / f"CSE1_data_{n}.csv", delimiter=",", names=True)["pose_valid"]
        for n in cse1
    ]
    runs = [run.cut(0.0, 240.0) for run in cse1.values()]
    return [
        tabulated(r, cse1_vehicle, m[: len(r.t)] > 0.5) for r, m in zip(runs, marks, strict=True)
    ]


@pytest.mark.parametrize(
    "which",
    [
        ("hard", "S1", "mallard-mp"),
        at_length(("hard", "S6", "mallard-af")),
        at_length(("paper-like", "S7", "mallard-mp")),
    ],
)
def test_every_fault_in_one_trial_is_found(which):
    table, vehicle = simulated(*which)
    for name, fault in faults(vehicle).items():
        assert_found([table], vehicle, name, fault)


@pytest.mark.system
def test_every_fault_in_three_trials_together_is_found():
    chosen = [simulated("hard", trial, "mallard-af") for trial in ("S1", "S2", "S3")]
    for which, fault in faults(chosen[0][1]).items():
        assert_found([t for t, _ in chosen], chosen[0][1], which, fault)


def test_every_fault_is_found_in_recordings_so_long_that_fewer_windows_must_do(monkeypatch):
    monkeypatch.setattr("seatrial.inspection.consistency.check.MOST_WINDOWED", 120.0)  # of 600 s
    test_every_fault_in_three_trials_together_is_found()


@pytest.mark.system
def test_faults_of_thrusters_that_are_commanded_themselves_are_found(mp):
    table, vehicle = direct(simulated("hard", "S7", "mallard-mp")[0], mp)
    for name, fault in faults(vehicle).items():
        assert_found([table], vehicle, name, fault)


@pytest.mark.system
def test_faults_in_the_ships_recordings_are_found(ship, cse1_vehicle):
    harmless = "port_sway<>starboard_sway"  # only their mean enters
    for name, fault in faults(cse1_vehicle).items():
        if name != harmless:
            assert_found(ship[1:], cse1_vehicle, name, fault)
    given, _, wrong = put_wrong(ship[1:], cse1_vehicle, faults(cse1_vehicle)[harmless])
    assert not check_consistency(read_all(given, wrong), wrong).findings


@pytest.mark.system
def test_signs_in_a_single_run_of_the_ship_are_found(ship, cse1_vehicle):
    for name, fault in faults(cse1_vehicle).items():
        if name.startswith("-") or name in ("degrees", "x<>y", "other hand"):
            assert_found([ship[0]], cse1_vehicle, name, fault)


@pytest.mark.parametrize(
    ("units", "stated"),
    [((None, None, "deg"), "rad"), at_length(("mm", "mm", None), "m"), (("cm", "cm", None), "m")],
)
def test_a_unit_that_should_not_have_been_stated_is_found(ship, cse1_vehicle, units, stated):
    table, mallard = simulated("hard", "S4", "mallard-mp")
    for tables, vehicle in (([table], mallard), (ship[2:], cse1_vehicle)):
        wrong = apply_repair(vehicle, replace(untouched(vehicle), units=units))
        report = check_consistency(read_all(tables, wrong), wrong)
        assert [u for u in report.repair.units if u] == [stated for u in units if u]
        assert not check_consistency(read_all(tables, report.repaired(wrong)), vehicle).findings


@pytest.mark.system
def test_good_trials_of_any_seed_are_not_cried_at(mp, af):
    for plan, vehicle, seed in (("hard", mp, 7), ("paper-like", af, 8)):
        for trial in simulate(with_seed(load_plan(plan), seed), vehicle):
            record = trial.recording
            assert not check_consistency([record], vehicle).findings, trial.name
            assert not check_consistency([record.cut(0.0, 60.0)], vehicle).findings, trial.name


@pytest.mark.system
def test_pieces_of_the_ships_recordings_are_not_cried_at(cse1, cse1_vehicle):
    for record in cse1.values():
        assert not check_consistency([record], cse1_vehicle).findings
        for length in (60.0, 120.0):
            for start in np.arange(0.0, record.duration - length, length / 2):
                piece = record.cut(float(start), float(start + length))
                assert not check_consistency([piece], cse1_vehicle).findings, (record.name, start)


def test_units_that_are_stated_rightly_are_not_cried_at():
    table, vehicle = simulated("hard", "S4", "mallard-mp")
    stated = apply_repair(vehicle, replace(untouched(vehicle), units=("mm", "mm", "deg")))
    assert not check_consistency(
        [table.in_units(0.001, 0.001, np.pi / 180).read(stated)], stated
    ).findings


def test_where_no_model_is_found_what_is_wrong_with_the_signs_is_said_first(monkeypatch):
    table, vehicle = simulated("hard", "S7", "mallard-mp")
    given, _, wrong = put_wrong([table], vehicle, faults(vehicle)["F_u<>F_v"])

    def nothing(*_, **__):
        raise IdentificationError("no solution: the search does not converge")

    monkeypatch.setattr(import_module("seatrial.identification.methods"), "fit", nothing)
    with pytest.raises(IdentificationError, match=r"F_u and F_v are swapped.*; no solution"):
        seatrial.identify(read_all(given, wrong), wrong)


def test_findings_name_the_line_to_change():
    table, vehicle = simulated("hard", "S7", "mallard-mp")
    said = {}
    for name, fault in faults(vehicle).items():
        given, _, wrong = put_wrong([table], vehicle, fault)
        said[name] = check_consistency(read_all(given, wrong), wrong).findings
    (found,) = said["-F_v"]
    assert found.kind is InconsistencyKind.NEGATED
    assert found.text.startswith("F_v moves sway to the right (t ")
    assert found.text.endswith("set sign: 1 at commands: inputs: F_v")
    (found,) = said["F_u<>F_v"]
    assert found.kind is InconsistencyKind.PERMUTED
    assert found.text.startswith("F_u and F_v are swapped: F_u moves sway")
    assert found.text.endswith("(F_u: F_u or axes[1], F_v: F_v or axes[0])")
    assert said["degrees"][0].text.endswith("set unit: deg at pose: psi")
    assert said["millimetres"][0].text.endswith("set unit: mm at pose: x and pose: y")
    assert said["-y"][0].text.endswith("set sign: 1 at pose: y")
    assert "exchange their entries under pose (x: x, y: y)" in said["x<>y"][0].text
    assert [f.kind for f in said["other hand"]] == [InconsistencyKind.HANDED]
    assert [f.kind for f in said["degrees, negated"]] == [
        InconsistencyKind.ANGLE,
        InconsistencyKind.NEGATED,
    ]


def test_commands_of_the_other_hand_are_one_finding():
    """F_v and F_r reversed is the same as y and psi reversed: one sentence for both."""
    table, vehicle = simulated("hard", "S7", "mallard-mp")
    wrong = apply_repair(vehicle, inputs_edited(vehicle, negated=(1, 2)))
    (found,) = check_consistency([table.read(wrong)], wrong).findings
    assert found.kind is InconsistencyKind.HANDED
    assert "forward-right-down" in found.text


def test_gains_are_those_of_the_simulated_plant(af):
    """Independent truth: X_F, Y_F, N_F of the plan, less what the thrusters' dead zone takes."""
    report = check_consistency(
        [simulated("clean", n, "mallard-af")[0].recording for n in ("S1", "S2", "S3")], af
    )
    gains = {(g.input, g.axis): g.value for g in report.table}
    truth = load_plan("clean").plant.coefficients
    for (name, axis), coefficient in {
        ("F_u", 0): "X_F",
        ("F_v", 1): "Y_F",
        ("F_r", 2): "N_F",
    }.items():
        assert gains[name, axis] == pytest.approx(truth[coefficient], rel=0.1)
    assert abs(gains["F_u", 1]) < 0.01
    assert report.text[0].startswith("F_u moves surge forward (t ")


def test_what_could_not_be_checked_is_said(mp):
    """A recording in which only surge is ever driven tells nothing of sway and yaw."""
    record = simulated("clean", "S1", "mallard-mp")[0].recording
    values = np.array(record.commands.values) * [1.0, 0.0, 0.0]
    quiet = make_recording(
        "S1", record.stamps, record.raw, Signal(mp.inputs, record.commands.stamps, values)
    )
    report = check_consistency([quiet], mp)
    assert not report.findings
    for name in ("F_v", "F_r"):
        assert f"{name}: hardly excited; its sign is not checked" in report.text
        assert name in report.unexcited
    short = record.cut(0.0, 8.0)
    assert check_consistency([short], mp).text[0].startswith("too short")


def test_an_unlabelled_joypad_is_assigned():
    """Channels of a PWM receiver in some order, one reversed, one a switch."""
    record = simulated("paper-like", "S7", "mallard-mp")[0].recording
    F = record.commands.values
    rng = np.random.default_rng(4)
    switch = np.repeat(rng.integers(0, 2, len(F) // 500 + 1), 500)[: len(F)]
    values = np.column_stack(
        [1500 + 400 * F[:, 2], switch, 1500 - 400 * F[:, 0], 1500 + 400 * F[:, 1]]
    )
    names = tuple(f"axes[{i}]" for i in range(4))
    (run,) = read_runs([record], [Signal(names, record.commands.stamps, values)])
    found = list(assignments(names, np.array([g.t for g in gains([run], *without_drag([run]))])))
    assert {(a.axis, a.channel, a.sign) for a in found} == {
        (0, "axes[2]", -1), (1, "axes[3]", 1), (2, "axes[0]", 1),
    }  # fmt: skip
    assert all(a.trusted for a in found)


def test_more_inputs_than_can_be_enumerated_are_searched_edit_by_edit(mp):
    """Six thrusters, two of them doubled: found without going through all 46080 readings."""
    table, four = direct(simulated("paper-like", "S7", "mallard-mp")[0], mp)
    thrusters = dict(four.file.thrusters)
    extra = {"F_5": "F_1", "F_6": "F_4"}
    columns = dict(table.columns)
    rng = np.random.default_rng(5)
    for new, old in extra.items():
        thrusters[new] = thrusters[old]
        share = 0.5 + 0.3 * np.repeat(rng.uniform(-1, 1, len(columns[old]) // 300 + 1), 300)
        columns[new] = columns[old] * share[: len(columns[old])]
        columns[old] = columns[old] - columns[new]
    inputs = msgspec.structs.replace(four.file.commands, inputs={n: n for n in thrusters})
    vehicle = Vehicle(msgspec.structs.replace(four.file, thrusters=thrusters, commands=inputs))
    given = replace(table, columns=columns)
    assert not check_consistency([given.read(vehicle)], vehicle).findings
    for fault in (inputs_edited(vehicle, negated=(2,)), inputs_edited(vehicle, (1, 3))):
        assert_found([given], vehicle, "six", fault)


def test_a_boat_that_never_moved_or_was_never_driven_is_not_cried_at(mp):
    record = simulated("clean", "S1", "mallard-mp")[0].recording
    still, silent = np.zeros_like(record.raw), np.zeros_like(record.commands.values)
    for raw, values in ((still, record.commands.values), (still, silent), (record.raw, silent)):
        signal = Signal(mp.inputs, record.commands.stamps, values)
        resting = make_recording("S1", record.stamps, raw, signal)
        report = check_consistency([resting], mp)
        assert not report.findings
        if not raw.any():
            stated = apply_repair(mp, replace(untouched(mp), units=("mm", "mm", "deg")))
            assert not check_consistency([resting], stated).findings
        assert sum("not checked" in line for line in report.text) == 3
        assert values.any() or not report.table  # nothing that it moves, by no margin


def test_stamps_in_the_wrong_unit_cost_no_more_memory_than_others():
    """Milliseconds read as seconds make days of minutes; grids in time must not grow with them."""
    table, vehicle = simulated("paper-like", "S4", "mallard-mp")
    table = read_all([table], vehicle)[0]
    slow = Signal(table.commands.names, table.commands.stamps * 1000, table.commands.values)
    days = make_recording("days", table.stamps * 1000, table.raw, slow)
    assert days.duration > 24 * 3600
    assert len(even_times(days)) <= 1_000_001
    tracemalloc.start()
    check_consistency([days], vehicle)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 200e6


def test_a_heading_within_a_turn_is_in_radians_whatever_fits_better(monkeypatch):
    """As degrees the boat did not turn; sideways drift by a current fits that as well."""
    table, vehicle = simulated("hard", "S7", "mallard-mp")
    recording = read_all([table], vehicle)[0]
    poses = import_module("seatrial.inspection.consistency.pose_units")
    found = []
    for size, least in ((0.5, poses.RADIAN_RANGE), (5.0, poses.RADIAN_RANGE), (5.0, 0.0)):
        raw = recording.raw * [1.0, 1.0, size / np.ptp(recording.raw[recording.valid, 2])]
        moved = make_recording("drift", recording.stamps, raw, recording.commands)
        (run,) = read_runs([moved], [moved.commands])
        with monkeypatch.context() as patch:
            patch.setattr(poses, "RADIAN_RANGE", least)
            # degrees fit clearly better: they are not refused, then taken
            patch.setattr(poses, "clearly_better", Mock(side_effect=[False, True]))
            found.append(poses.heading_unit([run], vehicle, (1.0, 1.0))[0])
    assert found == [None, None, "deg"]


@pytest.mark.parametrize("heading", [0.6, 1.3, -2.5])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_straight_way_shows_no_hand(heading, seed):
    """Mirrored it is as straight; with drag of two velocities there is more to explain a poor curve with."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 150.0, 0.05)
    stick, u, thrust = np.zeros((3, len(t)))
    k = 20
    while k < len(t):
        lasts, rests = rng.integers(20, 100), rng.integers(0, 60)
        stick[k : k + lasts] = rng.uniform(0.3, 1.0) * rng.choice([-1.0, 1.0])
        k += lasts + rests
    for k in range(len(t) - 1):  # with a dead zone, and less thrust astern
        felt = (
            np.sign(stick[k]) * max(0.0, abs(stick[k]) - 0.08) * (1.0 if stick[k] > 0.0 else 0.75)
        )
        thrust[k + 1] = thrust[k] + 0.05 / 0.15 * (felt - thrust[k])
        u[k + 1] = u[k] + 0.05 * (5.0 * thrust[k] - 0.3 * u[k] - 0.7 * abs(u[k]) * u[k])
    way = np.cumsum(u) * 0.05
    eta = np.column_stack([way * np.cos(heading), way * np.sin(heading), np.full(len(t), heading)])
    eta += rng.normal(size=eta.shape) * [0.01, 0.01, 0.005]
    stamps = np.rint(t * 1e9).astype(np.int64)
    forces = np.column_stack([stick, 0 * stick, 0 * stick])
    commands = Signal(("F_u", "F_v", "F_r"), stamps, forces)
    recording = make_recording("straight", stamps[::4], eta[::4], commands)
    assert check_consistency([recording], MIDDLE.vehicle([])).findings == ()


def test_a_wrong_vehicle_file_is_named_before_poses_that_are_left_out(cse1, cse1_vehicle):
    """The first doubt is the next step: exchange the entries, not look at the poses."""
    run = cse1["run1"]
    swapped = replace(run, eta=run.eta[:, [1, 0, 2]], raw=run.raw[:, [1, 0, 2]])
    model = seatrial.identify([swapped], cse1_vehicle, method="equation-error")
    assert model.warnings[0].startswith("x and y are exchanged")
    assert any("poses are left out" in warning for warning in model.warnings[1:])
