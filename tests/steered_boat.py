# SPDX-License-Identifier: MIT
"""A boat with one outboard or rudder, and a drive of it with known constants."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import yaml
from conftest import make_model

import seatrial
from seatrial import _core
from seatrial.boat.model import thrust_trace
from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal

OUTBOARD = """
seatrial: vehicle 1
name: outboard
axes: forward-left-up
pose: {file: log.csv, stamp: t, x: x, y: y, psi: psi}
commands: {file: log.csv, stamp: t, inputs: {motor: m, helm: s}}
forces:
  F_u: {axis: surge, of: {motor: 1}}
  F_v: {axis: sway, of: {helm: 1}}
  F_r: {axis: yaw, of: {helm: -0.6}}
chain:
  - {name: motor, actuators: [motor], latency: 0.1, lag: 0.3}
  - {name: helm, actuators: [helm], latency: 0.1, lag: 0, steered: {of: [[motor, helm]], angle_deg: 35}}
structure:
  surge: [v * r, X_u * u, X_uu * |u| * u, X_F * F_u]
  sway: [-1 * u * r, Y_v * v, Y_r * r, Y_F * F_v]
  yaw: [N_v * v, N_r * r, N_F * F_r]
"""
COEFFICIENTS = {
    "X_u": -0.15, "X_uu": -0.25, "X_F": 0.6, "Y_v": -0.7, "Y_r": -0.1, "Y_F": 0.4,
    "N_v": -0.3, "N_r": -1.1, "N_F": 1.6,
    "Y_ud": 0.25, "N_ud": -0.5, "N_Fv": -1.0,
}  # fmt: skip
BOW_THRUSTER = {  # one beside: no single steered thruster
    "commands": {"file": "log.csv", "stamp": "t", "inputs": {"motor": "m", "helm": "s", "bow": "b"}},
    "forces": {
        "F_u": {"axis": "surge", "of": {"motor": 1}},
        "F_v": {"axis": "sway", "of": {"helm": 1, "bow": 1}},
        "F_r": {"axis": "yaw", "of": {"helm": -0.6, "bow": 0.5}},
    },
}  # fmt: skip
ACROSS = {  # as `init` proposes it: the thrust across turns the boat
    "forces": {
        "F_u": {"axis": "surge", "of": {"motor": 1}},
        "F_v": {"axis": "sway", "of": {"helm": 1}},
    },
    "structure": {
        "surge": ["v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
        "sway": ["-1 * u * r", "Y_v * v", "Y_r * r", "Y_F * F_v"],
        "yaw": ["N_v * v", "N_r * r", "N_Fv * F_v"],
    },
}
AZIMUTHS = {  # two thrusters, each with an angle
    "commands": {
        "file": "log.csv", "stamp": "t",
        "inputs": {"bow": "b", "bow angle": "c", "stern": "s", "stern angle": "d"},
    },
    "forces": {
        "F_u": {"axis": "surge", "of": {"bow": 1, "stern": 1}},
        "F_v": {"axis": "sway", "of": {"bow angle": 1, "stern angle": 1}},
        "F_r": {"axis": "yaw", "of": {"bow angle": 0.4, "stern angle": -0.4}},
    },
    "chain": [
        {
            "latency": 0.1,
            "lag": 0.2,
            "steered": {"of": [["bow", "bow angle"], ["stern", "stern angle"]], "angle_deg": 90},
        }
    ],
}  # fmt: skip
RUDDER = {  # a propeller whose race misses the rudder: its yaw is that of the flow
    "forces": {
        "F_u": {"axis": "surge", "of": {"motor": 1}},
        "F_d": {"axis": "yaw", "deflection": {"helm": -0.6}},
    },
    "structure": {
        "surge": ["v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
        "sway": ["-1 * u * r", "Y_v * v", "Y_r * r"],
        "yaw": ["N_v * v", "N_r * r", "N_ud * |u| * u * F_d"],
    },
}
TRUTH = {"steer_angle": 35.0, "steer_offset": -4.0, "steer_rate": 40.0, "steer_dead_zone": 0.08}


def outboard(entry: Mapping[str, Any] | None = None, **changed: Any) -> Vehicle:
    """The boat with this steered entry beside `of`, and other keys of the file."""
    content = yaml.safe_load(OUTBOARD)
    content["chain"][1]["steered"] |= dict(entry or {})
    return vehicle_from({**content, **changed}, "outboard")


def rudder(arm: float) -> dict[str, Any]:
    """Forces and structure of a rudder behind the propeller, at `arm` [m], and in the flow."""
    return {
        "forces": {
            "F_u": {"axis": "surge", "of": {"motor": 1}},
            "F_v": {"axis": "sway", "of": {"helm": 1}},
            "F_r": {"axis": "yaw", "of": {"helm": arm}},
            "F_d": {"axis": "yaw", "deflection": {"helm": -0.6}},
        },
        "structure": {
            "surge": ["v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
            "sway": ["-1 * u * r", "Y_v * v", "Y_r * r", "Y_F * F_v"],
            "yaw": ["N_v * v", "N_r * r", "N_F * F_r", "N_ud * |u| * u * F_d"],
        },
    }


def known(entry: Mapping[str, Any] | None = None, **changed: Any) -> seatrial.Model:
    """The boat with its true constants."""
    truth = {"offset_deg": -4.0, "rate_deg": 40.0, "dead_zone": 0.08, **(entry or {})}
    boat = outboard(truth, **changed)
    return make_model(boat, {n: COEFFICIENTS[n] for n in boat.structure.coefficients}, step=1 / 60)


def driven(
    model: seatrial.Model, seed: int, duration: float = 240.0, least: float = 0.1
) -> Recording:
    """Random commands, held for 1 to 4 s; poses at 10 Hz with noise of 5 mm and 3 mrad. least: of the thrust."""
    rng = np.random.default_rng(seed)
    t_c = np.cumsum(rng.uniform(1.0, 4.0, int(duration / 2.5)))
    t_c = np.concatenate([[0.0], t_c[t_c < duration]])
    rows = np.column_stack([rng.uniform(least, 1.0, len(t_c)), rng.uniform(-1.0, 1.0, len(t_c))])
    commands = Signal(model.vehicle.inputs, (t_c * 1e9).astype(np.int64), rows)
    t = np.arange(0.0, duration, 0.1)
    stamps = np.rint(t * 1e9).astype(np.int64)
    trace = thrust_trace(
        model.vehicle,
        model.constants,
        make_recording("run", stamps, np.zeros((len(t), 3)), commands),
    )
    poses = _core.simulate(model.boat, trace, np.zeros(6), t, False)[0][:, :3]
    noisy = poses + rng.normal(0.0, 1.0, poses.shape) * [5e-3, 5e-3, 3e-3]  # [m], [m], [rad]
    return make_recording("run", stamps, noisy, commands)
