# SPDX-License-Identifier: MIT
"""Vehicles and models that the readers on board must read as Python does."""

from dataclasses import replace

import numpy as np
import yaml
from conftest import CSE1, make_model
from test_model import frd

import seatrial
from seatrial.boat.schema import (
    ChainGroup,
    CorrelatedEntry,
    DeadZone,
    EnvelopeEntry,
    EstimatorEntry,
    NoiseEntry,
    ProcessEntry,
    RecordingEntry,
)
from seatrial.boat.vehicle import Vehicle, load_vehicle, vehicle_from

STAGES = [
    ChainGroup(
        latency=0.02,
        dead_zone=DeadZone(0.08, 0.09),
        lag=0.1,
        power=1.3,
        reverse_ratio=0.8,
        slew_rate=2.0,
    )
]
TWO_EDGES = [ChainGroup(latency=0.02, dead_zone=DeadZone(0.08, 0.03), lag=0.1)]
ONE_EDGE = [ChainGroup(latency=0.02, dead_zone=DeadZone(0.08, "forward"), lag=0.1)]
TABLE = [ChainGroup(table=[(-1.0, -0.8), (-0.07, 0.0), (0.07, 0.0), (1.0, 1.0)], latency=-0.03)]
SKIFF = """
seatrial: vehicle 1
name: skiff
axes: forward-left-up
pose: {topic: /odom, parent: map, clock: bag, lever: [0.1, -0.2], delay: 0.2, heading_delay: 0.05,
  x: {unit: mm, offset: 12}, psi: {field: "state.angles[2]", unit: deg, sign: -1, offset: 90}}
commands:
  topic: /rc
  clock: bag
  sampled: true
  inputs:
    port: {field: "channels[2]", offset: 1500, scale: 400, sign: -1}
    starboard: {topic: /other, field: channels, index: 0, offset: 1500, scale: 400}
command_timeout: 0.4
scales:
  volts: {column: {field: "cells[0].voltage", topic: /battery, scale: 2}, reference: 12}
forces:
  F_u: {axis: surge, of: {port: 0.5, starboard: 0.5}}
  F_r: {axis: yaw, of: {port: -0.5, starboard: 0.5}}
chain:
  - {name: props, lag: 0.2, scale: {signal: volts, power: 1.5}, gains: {port: 1.1, starboard: 0.9}}
  - {name: left, actuators: [port], latency: 0.05, dead_zone: {forward: 0.05, reverse: 0.1}}
structure:
  surge: [v * r, X_u u, X_uu |u| u, 0.5 X_F F_u, -.25 * F_u]
  sway: ["- u r", Y_v v, Y_r r]
  yaw: [N_ud udot, N_r r, N_F * F_r, -1e-2 * F_u]
"""  # fmt: skip


def skiff() -> Vehicle:
    return vehicle_from(yaml.safe_load(SKIFF), "skiff")


def changed(vehicle: Vehicle, **parts: object) -> Vehicle:
    return vehicle_from({**vehicle.to_mapping(), **parts}, "changed")


def wrench(axes: str) -> Vehicle:
    """No thrusters: surge and yaw are commanded."""
    content = {**yaml.safe_load(SKIFF), "axes": axes}
    for key in ("forces", "chain", "scales"):
        del content[key]
    content["commands"] = {"inputs": {"F_r": "axes[3]", "F_u": {"field": "axes", "index": 1}}}
    return vehicle_from(content, "wrench")


def direct(vehicle: Vehicle) -> Vehicle:
    """Thrusters that are commanded themselves, in another order than they are listed."""
    inputs = {name: f"data[{i}]" for i, name in enumerate(reversed(vehicle.file.thrusters))}
    return changed(vehicle, commands={"topic": "/t", "inputs": inputs}, allocation={})


def with_rudder(axes: str) -> Vehicle:
    """A propeller with a rudder in its race and in the flow, and an azimuth thruster."""
    content = {**yaml.safe_load(SKIFF), "axes": axes}
    inputs = {name: {"topic": "/rc", "field": f"channels[{i}]"} for i, name in enumerate(ANGLED)}
    angle = {"of": [["motor", "rudder"]], "angle_deg": 35, "offset_deg": "estimate", "rate_deg": 60}
    content["commands"] = {"inputs": inputs}
    content["forces"] = {
        "F_u": {"axis": "surge", "of": {"motor": 1, "pod": 0.7}},
        "F_v": {"axis": "sway", "of": {"rudder": 1, "turn": 0.7}, "deflection": {"rudder": 0.2}},
        "F_r": {"axis": "yaw", "of": {"motor": -0.1, "rudder": -0.6, "turn": 0.35}},
        "F_d": {"axis": "yaw", "deflection": {"rudder": -0.6}},
    }
    content["chain"] = [
        {"name": "m", "actuators": ["motor", "pod"], "lag": 0.2, "slew_rate": 2.0, "dead_zone": "estimate",
         "scale": {"signal": "volts", "power": 1.5}},
        {"name": "rudder", "actuators": ["rudder"], "latency": 0.05, "steered": angle | {"dead_zone": 0.06}},
        {"name": "turn", "actuators": ["turn"], "lag": 0.1,
         "steered": {"of": [["pod", "turn"]], "angle_deg": 180, "rate_deg": 90}},
    ]  # fmt: skip
    content["structure"]["sway"] = ["- u r", "Y_v v", "Y_r r", "Y_F F_v"]
    content["structure"]["yaw"] = ["N_r r", "N_F F_r", "N_uuF |u| u F_d"]
    return vehicle_from(content, "with rudder")


ANGLED = ("motor", "rudder", "pod", "turn")
VEHICLES = {
    "mallard-mp": lambda: load_vehicle("mallard-mp"),
    "mallard-af": lambda: load_vehicle("mallard-af"),
    "mp with stages": lambda: load_vehicle("mallard-mp").with_chain(STAGES),
    "mp with one edge": lambda: load_vehicle("mallard-mp").with_chain(ONE_EDGE),
    "af with a table": lambda: load_vehicle("mallard-af").with_chain(TABLE),
    "mp, right-down": lambda: frd(load_vehicle("mallard-mp")).with_chain(STAGES),
    "af, right-down": lambda: frd(load_vehicle("mallard-af")).with_chain(STAGES),
    "mp, direct": lambda: direct(load_vehicle("mallard-mp")),
    "cse1": lambda: load_vehicle(CSE1 / "vehicle.yaml"),
    "cse1 coupled": lambda: load_vehicle(CSE1 / "coupled.yaml"),
    "cse1 pair": lambda: load_vehicle(CSE1 / "pair.yaml"),
    "skiff": skiff,
    "skiff, right-down": lambda: changed(skiff(), axes="forward-right-down"),
    "wrench": lambda: wrench("forward-left-up"),
    "wrench, right-down": lambda: wrench("forward-right-down"),
    "wrench with two edges, right-down": lambda: wrench("forward-right-down").with_chain(TWO_EDGES),
    "rudder and azimuth": lambda: with_rudder("forward-left-up"),
    "rudder and azimuth, right-down": lambda: with_rudder("forward-right-down"),
}
NOISES = (
    NoiseEntry(0.004, 0.003),
    NoiseEntry(0.004, 0.003, ProcessEntry(0.002, 0.01, 0.01, 0.03, 4.0, 0.4), CorrelatedEntry(0.002, 0.001, 0.2)),
    NoiseEntry(0.004, 0.003, ProcessEntry(0.002, 0.01, 0.01, 0.03, 4.0, earth_fixed=True), CorrelatedEntry(0.02, 0.01, 5.0, 2.1)),
)  # fmt: skip


def identified(vehicle: Vehicle, seed: int) -> seatrial.Model:
    """A stable boat, with a covariance, an envelope and noise as an identification gives them."""
    random = np.random.default_rng(seed)
    drag = {"X_u", "X_uu", "Y_v", "Y_vv", "N_r", "N_rr"}
    values = {
        name: -0.4 if name in drag else random.uniform(0.05, 0.15) + 0.4 * ("F" in name)
        for name in vehicle.structure.coefficients
    }
    scheme, step = [("runge-kutta", 1 / 60), ("forward-euler", 1 / 15)][seed % 2]
    model = make_model(vehicle, values, scheme, step)
    root = 0.02 * random.standard_normal(model.covariance.shape)
    if seed % 3 == 0:
        speeds = {"u": (-0.4, 0.6), "v": (-0.3, 0.2), "r": (-0.5, 0.9)}
        forces = {f.name: (-0.6, 0.8) for f in vehicle.forces[:-1]}
        recording = RecordingEntry("S1", 200.0, without=[(0.0, 4.0), (60.0, 62.0)])
        model = replace(model, envelope=EnvelopeEntry(speeds, forces), recordings=(recording,))
    estimator = EstimatorEntry("output-error", {"belief": (None, 0.0, 0.8)[seed // 3 % 3]})
    return replace(
        model, covariance=root @ root.T / len(root), noise=NOISES[seed % len(NOISES)],
        estimator=estimator,
    )  # fmt: skip
