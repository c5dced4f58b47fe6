# SPDX-License-Identifier: MIT
"""Logs that pLogger of MOOS writes of the trials in autopilot_logs.py, as on a Heron or a BlueBoat."""

from pathlib import Path

import numpy as np
from autopilot_logs import Trial

LOGSTART = 1_760_000_000.25  # [s] from 1970
BANNER = """\
%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%
%% LOG FILE:       ./LOG_HERON/LOG_HERON.alog
%% FILE OPENED ON  Thu Oct  9 08:53:20 2025
%% LOGSTART           {start:.2f}
%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%%
"""
THRUSTERS = ("PYDIR_THRUST_L", "PYDIR_THRUST_R")


def moos(
    path: Path,
    run: Trial,
    *,
    names: tuple[str, ...] = THRUSTERS,
    marked: bool = False,
    absolute: bool = False,
    position: float = 0.02,
) -> Path:
    """Navigation at 5 Hz with `position` [m] of noise, commands in percent where they change, texts between them.

    marked: each value says whether it is a number; absolute: times count from 1970.
    """
    rng = np.random.default_rng(1)
    rows: list[tuple[float, str, str, object]] = [(0.0, "DB_UPTIME", "MOOSDB_heron", 0.0)]
    for t in np.arange(0.031, run.seconds, 0.2):
        north, east, psi, u, v, _ = run.at(np.array([t]))[0]
        heading = np.degrees(psi + rng.normal(0.0, 0.0035)) % 360.0
        rows += [
            (t, "NAV_X", "iM300", east + rng.normal(0.0, position)),
            (t + 2e-5, "NAV_Y", "iM300", north + rng.normal(0.0, position)),
            (t + 4e-5, "NAV_HEADING", "iM300", heading),
            (t + 6e-5, "NAV_SPEED", "iM300", float(np.hypot(u, v))),
        ]
    changed = np.flatnonzero((np.diff(run.commands, axis=0) != 0.0).any(axis=1)) + 1
    for step in (0, *changed):
        rows += [
            (run.t[step] + 1e-5 * i, name, "iM300", 100.0 * value)
            for i, (name, value) in enumerate(zip(names, run.commands[step], strict=True))
        ]
    for t in np.arange(0.5, run.seconds, 1.0):
        rows += [
            (t, "MODE", "pHelmIvP", "MODE@ACTIVE:SURVEYING"),
            (t, "APPCAST", "iM300", "proc=iM300!@#messages=" + "x" * 9000),
        ]
    rows.sort(key=lambda row: row[0])
    with path.open("w", encoding="ascii") as file:
        file.write(BANNER.format(start=LOGSTART))
        for t, name, source, value in rows:
            time = f"{t + LOGSTART:.5f}" if absolute else f"{t:.5f}"
            text = f"{value:.6g}" if isinstance(value, float) else str(value)
            mark = "" if not marked else "D:" if isinstance(value, float) else "S:"
            file.write(f"{time:<18}{name:<25}{source:<20}{mark}{text}\n")
    return path
