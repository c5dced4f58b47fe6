# SPDX-License-Identifier: MIT
"""Vehicle files of boats whose poses and inputs are columns of one table."""

from collections.abc import Mapping, Sequence

from seatrial.boat.vehicle import Vehicle, vehicle_from

TWO_ASTERN = {
    "F_u": {"axis": "surge", "of": {"left": 0.5, "right": 0.5}},
    "F_r": {"axis": "yaw", "of": {"left": -0.5, "right": 0.5}},
}
TWIN = {  # added mass of its own along and across; no thrust in sway
    "surge": ["X_vr * v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
    "sway": ["Y_ur * u * r", "Y_v * v", "Y_vv * |v| * v"],
    "yaw": ["N_r * r", "N_rr * |r| * r", "N_F * F_r"],
}
TWIN_TRUTH = {
    "X_vr": 1.2, "X_u": -0.25, "X_uu": -1.0, "X_F": 0.5, "Y_ur": -0.6, "Y_v": -0.4, "Y_vv": -2.0,
    "N_r": -0.8, "N_rr": -0.5, "N_F": 1.5,
}  # fmt: skip


def by_columns(
    name: str, inputs: Sequence[str], structure: str | Mapping[str, Sequence[str]], **more: object
) -> Vehicle:
    """A vehicle whose poses and inputs are columns that are called as they are; more: further keys of its file."""
    column = {n: {"column": n} for n in ("t", "x", "y", "psi", *inputs)}
    content = {
        "seatrial": "vehicle 1", "name": name, "axes": "forward-left-up", "structure": structure,
        "pose": {"stamp": column["t"], "x": column["x"], "y": column["y"], "psi": column["psi"]},
        "commands": {"stamp": column["t"], "inputs": {n: column[n] for n in inputs}}, **more,
    }  # fmt: skip
    return vehicle_from(content, name)
