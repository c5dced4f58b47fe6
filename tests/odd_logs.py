# SPDX-License-Identifier: MIT
"""Logs of a boat, integrated in autopilot_logs.py, as users' own loggers write them, and what was read of them."""

import numpy as np
import pytest

import seatrial
from seatrial.util.errors import RecordingError
from tests.autopilot_logs import TWIN, trial
from tests.init_tools import proposed

RATE = 20.0  # [Hz]
STEP = 0.4  # [s] over which velocities are compared
FEET = 1 / 0.3048
MOTIONS = ("u", "v", "r")
NAMES = {"x": "east", "y": "north", "yaw": "psi"}


def columns(rate=RATE):
    """The boat at the rows of a log: t [s], east, north [m], heading [deg], psi [rad], commands (n,)."""
    run = trial(TWIN, 120.0, 0)
    t = np.arange(0.0, 119.9, 1 / rate)
    state = run.at(t)
    noise = np.random.default_rng(1).normal(size=(len(t), 3)) * [0.005, 0.005, 0.003]
    north, east, heading = (state[:, :3] + noise).T
    left, right = run.command_at(t).T
    return {
        "t": t, "east": east, "north": north, "heading": np.degrees(heading) % 360,
        "psi": np.pi / 2 - heading, "left": left, "right": right,
    }  # fmt: skip


def written(path, head, *values, sep=",", below=()):
    """A table; values are numbers (n,) or texts."""
    cells = [[v if isinstance(v, str) else f"{v:.6f}" for v in column] for column in values]
    lines = [sep.join(head), *below, *(sep.join(row) for row in zip(*cells, strict=True))]
    path.write_text("\n".join(lines) + "\n")
    return path


def logged(folder, values, head="t x y yaw left right", **more):
    """A table of some of the columns, by their own names or those of NAMES."""
    names = head.split()
    own = [values[name] if name in values else values[NAMES[name]] for name in names]
    return written(folder / "log.csv", names, *own, **more)


def read(path):
    """The vehicle file that `init` proposes, and the recording by it."""
    _, vehicle = proposed(path)
    return vehicle, seatrial.read(path, vehicle)


def motion(t, eta, at):
    """u, v (to port), r (n, 3) about the times `at` [s]."""
    good = np.isfinite(eta).all(axis=1)
    before, now, after = (
        np.column_stack([np.interp(at + d, t[good], x) for x in eta[good].T])
        for d in (-STEP / 2, 0, STEP / 2)
    )
    x, y, r = ((after - before) / STEP).T
    c, s = np.cos(now[:, 2]), np.sin(now[:, 2])
    return np.column_stack([c * x + s * y, c * y - s * x, r])


def moves_as_the_boat(recording, slack=0.03, until=118.0):
    """Whether velocities are those of the truth, forward-left-up, at its times, and commands too."""
    run = trial(TWIN, 120.0, 0)
    north, east, heading = run.state[:, :3].T
    at = np.arange(1.0, until, 0.05)
    found = motion(recording.t, recording.eta, at)
    true = motion(run.t, np.column_stack([east, north, np.pi / 2 - heading]), at)
    for name, f, w in zip(MOTIONS, found.T, true.T, strict=True):
        assert f @ w / (w @ w) == pytest.approx(1.0, abs=slack), name
        assert np.corrcoef(f, w)[0, 1] > 0.9, name
    commands = recording.commands
    rows = np.searchsorted(recording.seconds(commands.stamps), at, side="right") - 1
    full = np.abs(commands.values).max(axis=0)
    for i, true_command in enumerate(run.command_at(at).T):
        assert np.corrcoef(commands.values[rows, i] / full[i], true_command)[0, 1] > 0.93


def refusal(path):
    """The line with which `init` refuses a log."""
    with pytest.raises(RecordingError) as error:
        read(path)
    return str(error.value)
