# SPDX-License-Identifier: MIT
"""What tests of bags share: the same content in two formats."""

import numpy as np
from bag_tools import START, Sent, poses_sent, ros1, vehicle
from mcap_writer import mcap

import seatrial

LENGTH = 3.0  # [s]


JOY = "sensor_msgs/msg/Joy"


def assert_same(found: seatrial.Recording, wanted: seatrial.Recording) -> None:
    """Everything that numbers are made of."""
    for name in ("stamps", "eta", "raw", "valid", "segment"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), err_msg=name)
    np.testing.assert_array_equal(found.commands.stamps, wanted.commands.stamps)
    np.testing.assert_array_equal(found.commands.values, wanted.commands.values)
    assert found.commands.names == wanted.commands.names
    assert found.faults == wanted.faults


def through(fields, folder, *, topic="/cmd", kind=JOY, rate=20.0, **changes):
    """A recording with commands of a type, as a .bag and as an .mcap; both are the same."""
    times = np.arange(0, LENGTH, 1 / rate)
    commands = [
        Sent(topic, kind, START + round(t * 1e9), fields(t, START + round(t * 1e9))) for t in times
    ]
    boat = vehicle(commands={"topic": topic, "inputs": changes.pop("inputs")}, **changes)
    records = [
        seatrial.read(make(folder / name, poses_sent(LENGTH) + commands), boat)
        for make, name in ((ros1, "run.bag"), (mcap, "run.mcap"))
    ]
    assert_same(*records)
    return times, records[0]
