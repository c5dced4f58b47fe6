# SPDX-License-Identifier: MIT
"""Recordings as tables of text."""

import numpy as np


def sheet(path, head, *columns, form="%.18e"):
    """A CSV table of columns (n,) or (n, k)."""
    rows = np.column_stack(columns)
    np.savetxt(path, rows, fmt=form, delimiter=",", header=head, comments="")
    return path


def two_sheets(folder, recording, *inputs, poses=None, values=None):
    """A recording's poses and commands, as they are or these (n, k)."""
    own = recording.commands
    poses = recording.raw if poses is None else poses
    values = own.values if values is None else values
    sheet(folder / "poses.csv", "t,x,y,psi", recording.t, poses)
    sheet(folder / "commands.csv", ",".join(("t", *inputs)), recording.seconds(own.stamps), values)
    return folder
