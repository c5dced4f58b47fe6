# SPDX-License-Identifier: MIT
"""Write data/cse1/mcap from data/cse1/csv: the same runs as a ROS 2 robot would have left them."""

from pathlib import Path

import numpy as np

from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.io.table import CsvTable, Table

FOLDER = Path(__file__).resolve().parents[1] / "data" / "cse1"
EPOCH = 1_300_000_000 * 10**9  # [ns] some time in March 2011; the runs' date is not known
SET_POINTS = ["u1", "u2", "u3", "u4", "u5", "vsp_speed", "bt_limit"]


def write_run(table: Table) -> Path:
    """One run: poses with header, poses marked bad as not a number, set-points without header."""
    raw = table.columns(["t", "x", "y", "z", "psi", "pose_valid", *SET_POINTS])
    stamps = EPOCH + np.rint(raw[:, 0] * 1e9).astype(np.int64)
    x, y, z, psi = np.where(raw[:, 5:6] > 0.5, raw[:, 1:5], np.nan).T
    pose = {
        "pose.position.x": x, "pose.position.y": y, "pose.position.z": z,
        "pose.orientation.z": np.sin(psi / 2), "pose.orientation.w": np.cos(psi / 2),
    }  # fmt: skip
    data = {f"data[{i}]": column for i, column in enumerate(raw[:, 6:].T)}
    topics = [
        BagTopic("/qualisys/cse1/pose", "geometry_msgs/msg/PoseStamped", stamps, stamps, pose,
                 {"header.frame_id": "basin"}),
        BagTopic("/thrusters", "std_msgs/msg/Float64MultiArray", stamps, stamps, data),
    ]  # fmt: skip
    return write_bag(FOLDER / "mcap" / f"{table.path.stem}.mcap", topics)


if __name__ == "__main__":
    for path in sorted((FOLDER / "csv").glob("*.csv")):
        print(write_run(CsvTable(path)))
