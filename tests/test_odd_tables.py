# SPDX-License-Identifier: MIT
"""Tables as users' own loggers write them: `init` and `read` give the boat's motion, or one line that says why not."""

import numpy as np
import pytest

from seatrial.boat.schema import as_column
from seatrial.inspection.proposal.channel_scales import scale_of
from tests.autopilot_logs import TWIN, trial
from tests.logs import drive
from tests.odd_logs import FEET, columns, logged, moves_as_the_boat, read, refusal, written


def test_forces_beside_the_poses_are_commands(tmp_path):
    """F_r follows the turning of the boat, and is no yaw rate."""
    log = drive(60.0)
    poses = np.column_stack([np.interp(log.command_t, log.pose_t, x) for x in log.pose.T])
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "psi", "F_u", "F_v", "F_r"),
        log.command_t, *poses.T, *log.command.T,
    )  # fmt: skip
    vehicle, _ = read(path)
    assert vehicle.inputs == ("F_u", "F_v", "F_r")
    assert vehicle.file.pose.yaw_rate is None


@pytest.mark.parametrize("stated", ["name", "line of units"])
def test_feet(tmp_path, stated):
    """A metre has 3.28 ft, in the name of a column or in the line below the header."""
    c = columns()
    x, y, below = "x_ft", "y_ft", ()
    if stated == "line of units":
        x, y, below = "x", "y", ("s,ft,ft,rad,-,-",)
    own = {x: c["east"] * FEET, y: c["north"] * FEET}
    path = logged(tmp_path, c | own, f"t {x} {y} yaw left right", below=below)
    moves_as_the_boat(read(path)[1])


def test_comments_headers_and_marks_among_the_rows(tmp_path):
    """A logger that was started again writes its header again; cells without a value say so."""
    c = columns()
    path = logged(tmp_path, c)
    lines = path.read_text().splitlines()
    for i, mark in zip(
        range(300, 1200, 100),
        ("N/A", "null", "None", "-", "NaN", "#N/A", "-1.#IND00", "1.#QNAN", "1.#INF"),
        strict=True,
    ):
        cells = lines[i].split(",")
        lines[i] = ",".join([cells[0], mark, mark, *cells[3:]])
    lines = [
        *lines[:900],
        lines[0],
        *lines[900:1500],
        "# second pilot, 20 knots",
        *lines[1500:],
        "# end",
    ]
    path.write_text("\n".join(lines) + "\n")
    recording = read(path)[1]
    assert any("3 lines among the rows" in r and "line 901" in r for r in recording.remarks)
    assert int((~recording.valid).sum()) == 9
    moves_as_the_boat(recording)


def test_measured_speeds_of_the_propellers_are_no_commands(tmp_path):
    """rpm_left follows rpm_cmd_left late."""
    c = columns()
    commanded = [3000 * np.sign(x) * np.sqrt(np.abs(x)) for x in (c["left"], c["right"])]
    measured = [np.convolve(x, np.full(4, 0.25))[: len(x)] for x in commanded]
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "yaw", "rpm_cmd_left", "rpm_cmd_right", "rpm_left", "rpm_right"),
        c["t"], c["east"], c["north"], c["psi"], *commanded, *measured,
    )  # fmt: skip
    vehicle, recording = read(path)
    assert vehicle.inputs == ("rpm_cmd_left", "rpm_cmd_right")
    moves_as_the_boat(recording)


def test_throttle_and_reverse_switch(tmp_path):
    """A throttle without a sign is no command, and neither is the switch beside it."""
    c = columns()
    sides = [
        ("throttle_left", "reverse_left", c["left"]),
        ("throttle_right", "reverse_right", c["right"]),
    ]
    head = ("t", "x", "y", "yaw", *(n for a, b, _ in sides for n in (a, b)))
    values = [v for _, _, x in sides for v in (np.abs(x), (x < 0).astype(float))]
    path = written(tmp_path / "log.csv", head, c["t"], c["east"], c["north"], c["psi"], *values)
    assert "none of them is ever negative: if gear or direction is another column" in refusal(path)


def test_numbers_with_a_unit_in_each_cell(tmp_path):
    """Columns of text are named."""
    c = columns()
    stated = {name: [f"{v:.3f} m" for v in c[name]] for name in ("east", "north")}
    assert "Columns with text, not numbers: x ('" in refusal(logged(tmp_path, c | stated))


def test_channels_logged_on_change_in_one_table(tmp_path):
    """A row holds a pose, or the one command that changed; an empty cell holds the last value."""
    c = columns()
    run = trial(TWIN, 120.0, 0)
    rows = [(t, f"{t:.4f},{x:.5f},{y:.5f},{psi:.5f},,") for t, x, y, psi in zip(c["t"], c["east"], c["north"], c["psi"], strict=True)]  # fmt: skip
    for i, cells in enumerate(("{:.4f},,,,{:.4f},", "{:.4f},,,,,{:.4f}")):
        for k in np.flatnonzero(np.diff(run.commands[:, i], prepend=1.0)).tolist():
            rows.append(
                (run.t[k] + 0.001 * i, cells.format(run.t[k] + 0.001 * i, run.commands[k, i]))
            )
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t,x,y,psi,left,right", *(row for _, row in sorted(rows))]) + "\n")
    vehicle, recording = read(path)
    assert vehicle.inputs == ("left", "right")
    moves_as_the_boat(recording)


@pytest.mark.parametrize(
    ("neutral", "full"), [(512, 511), (128, 127), (992, 820), (50, 50), (4915, 1638)]
)
def test_commands_whose_neutral_is_in_the_middle(tmp_path, neutral, full):
    """Analogue sticks, bytes, SBUS, per cent, duty cycles: rest is where the log begins."""
    c = columns()
    raw = {name: np.rint(neutral + full * c[name]) for name in ("left", "right")}
    vehicle, recording = read(logged(tmp_path, c | raw))
    assert [as_column(v).offset for v in vehicle.file.commands.inputs.values()] == [
        neutral,
        neutral,
    ]
    assert np.abs(recording.commands.values[0]).max() == 0.0
    moves_as_the_boat(recording)


def test_a_throttle_that_cruises_has_its_zero():
    """60 % most of the time, and 0 at the start: no neutral in the middle."""
    values = np.concatenate([np.zeros(50), np.full(500, 60.0), np.linspace(0.0, 100.0, 50)])
    assert scale_of(values) == {"scale": 100.0}
    at_rest_at_last = np.concatenate([np.linspace(1023.0, 0.0, 500), np.full(50, 512.0)])
    assert scale_of(at_rest_at_last) == {"offset": 512.0, "scale": 500.0}


def test_thrust_ahead_only_has_no_neutral_value():
    """A log that begins at half thrust, and ends at rest."""
    values = np.concatenate([np.full(50, 50.0), np.tile([100.0, 20.0, 75.0], 100), np.zeros(80)])
    assert scale_of(values) == {"scale": 100.0}
    assert scale_of(values[::-1]) == {"scale": 100.0}
