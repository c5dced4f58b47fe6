# SPDX-License-Identifier: MIT
"""From an autopilot's log to a model, by the file that `init` proposes: the truth, within its standard errors."""

import numpy as np
import pytest
from autopilot_logs import HOLONOMIC, ardupilot, trial
from init_tools import proposed
from mavlink_logs import telemetry
from px4_logs import px4

import seatrial
from seatrial.boat.vehicle import vehicle_from
from tests.boats.hulls import FREE

WRITERS = [
    pytest.param("run.ulg", px4, id="px4"),
    pytest.param("run.BIN", ardupilot, id="ardupilot", marks=pytest.mark.system),
    pytest.param("run.tlog", telemetry, id="mavlink", marks=pytest.mark.system),
]


def truth():
    """By Newton's second law; thrust of a wrench of 1 is that of all thrusters."""
    m, n, i = HOLONOMIC.mass
    x, y, angle = np.array(HOLONOMIC.thrusters).T
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    force = HOLONOMIC.full * np.abs([c, s, x * s - y * c]).sum(axis=1)
    (du, dv, dr), (duu, dvv, drr) = HOLONOMIC.linear, HOLONOMIC.quadratic
    return {
        "X_vr": n / m, "X_u": -du / m, "X_uu": -duu / m, "X_F": force[0] / m,
        "Y_ur": -m / n, "Y_v": -dv / n, "Y_vv": -dvv / n, "Y_F": force[1] / n,
        "N_uv": (m - n) / i, "N_r": -dr / i, "N_rr": -drr / i, "N_F": force[2] / i,
    }  # fmt: skip


@pytest.mark.system
@pytest.mark.parametrize(("name", "write"), WRITERS)
def test_coefficients_are_the_truth_within_their_errors(tmp_path, name, write):
    """Position at 5 Hz, heading at 20 Hz, gyro at 50 Hz, motors at 10 Hz: each where it is new."""
    path = write(tmp_path / name, trial(HOLONOMIC, 240.0, 3))
    _, own = proposed(path, axes="forward-right-down")
    vehicle = vehicle_from({**own.to_mapping(), "structure": FREE}, "vehicle.yaml")
    model = seatrial.identify([seatrial.read(path, vehicle)], vehicle)
    off = {n: (model.values[n] - x) / model.standard_errors[n] for n, x in truth().items()}
    assert max(map(abs, off.values())) < 3.5, off
    for thrust in ("X_F", "Y_F", "N_F"):
        assert model.values[thrust] == pytest.approx(truth()[thrust], rel=0.15)
