# SPDX-License-Identifier: MIT
"""Boats that between them have every stage, and the core's answer to a drive, in the boats' axes."""

import shutil
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
import yaml
from conftest import ROOT, TABLE_II, make_model
from programs import printed
from steered_boat import COEFFICIENTS, OUTBOARD, known, outboard

import seatrial
from seatrial import _core
from seatrial.boat.vehicle import vehicle_from
from seatrial.util.frames import Axes
from tests.boats.plans import driven_by, planned

STATE_SIGNS = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])  # forward-right-down


@dataclass(frozen=True)
class Drive:
    """Commands of a simulated S7, in a boat's own axes, and what its known signals did."""

    t: np.ndarray  # (n,) [s]
    commands: np.ndarray  # (n, inputs)
    scales: np.ndarray  # (n, scales)

    def first(self, seconds: float) -> "Drive":
        n = int(np.searchsorted(self.t, seconds))
        return Drive(self.t[:n], self.commands[:n], self.scales[:n])

    def every(self, n: int) -> "Drive":
        return Drive(*(np.ascontiguousarray(a[::n]) for a in (self.t, self.commands, self.scales)))


def program(*names: str) -> None:
    for name in names:
        if shutil.which(name) is None:
            pytest.skip(f"no {name}")


def run(*command, cwd=None, stdin=None) -> str:
    return printed(*command, cwd=cwd, input=stdin)


@cache
def sticks() -> seatrial.Recording:
    """S7 of the paper, without noise: 400 s of joypad at 100 Hz."""
    return driven_by(planned("clean", "S7"), seatrial.load_vehicle("mallard-mp"))[0]


def _mallard(base: str, chain: list, **changes) -> seatrial.Model:
    content = seatrial.load_vehicle(base).to_mapping() | {"chain": chain} | changes
    return make_model(vehicle_from(content, base), TABLE_II["AF"], step=1 / 60)


def always_forward() -> seatrial.Model:
    """The paper's boat, always-forward, with the chain that the simulator has, and a latency."""
    return _mallard(
        "mallard-af",
        [{"latency": 0.0707, "lag": 0.08, "dead_zone": {"forward": 0.08, "reverse": 0.06}}],
    )


def right_down() -> seatrial.Model:
    """Forward-right-down axes; every constant of single curves, other ones by group; one thruster without."""
    chain = [
        {"name": "bow", "actuators": ["F_1", "F_2"], "latency": 0.113, "power": 1.4, "reverse_ratio": 0.7,
         "dead_zone": {"forward": 0.05, "reverse": 0.11}, "lag": 0.21, "slew_rate": 2.0},
        {"name": "stern", "actuators": ["F_3"], "latency": 0.031, "lag": 0.0, "slew_rate": 1.5, "reverse_ratio": 0.9},
        {"gains": {"F_1": 1.1, "F_2": 0.9, "F_3": 1.05, "F_4": 0.95}},
    ]  # fmt: skip
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    thrusters = {
        n: {"x": t["x"], "y": -t["y"], "angle_deg": -t["angle_deg"]}
        for n, t in content["thrusters"].items()
    }
    return _mallard("mallard-mp", chain, axes="forward-right-down", thrusters=thrusters)


def bare() -> seatrial.Model:
    """Commands that are the forces, a tabulated curve, no lag and no latency, no acceleration terms."""
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    content |= {
        "thrusters": {},
        "allocation": {"scheme": "direct", "limit": 0.8},
        "structure": {
            "surge": ["v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u", "X_0"],
            "sway": ["-1 * u * r", "Y_v * v", "Y_F * F_v", "0.5 * Y_vr * |v| * r"],
            "yaw": ["N_r * r", "N_F * F_r", "N_vvu * v * |v| * |r| * u"],
        },
        "chain": [{"table": [(-1.0, -0.6), (-0.1, 0.0), (0.2, 0.0), (0.6, 0.5), (1.0, 1.0)]}],
    }
    values = {"X_u": -0.2, "X_uu": -1.7, "X_F": 0.14, "X_0": 0.002, "Y_v": -0.3, "Y_F": 0.2,
              "Y_vr": -0.1, "N_r": -0.5, "N_F": 1.3, "N_vvu": 0.05}  # fmt: skip
    return make_model(vehicle_from(content, "bare"), values, step=1 / 60)


def ship() -> seatrial.Model:
    """The model ship's vehicle: pairs, a known signal, four latencies, five forces, forward-right-down."""
    vehicle = seatrial.load_vehicle(ROOT / "data" / "cse1" / "pair.yaml")
    stated = dict.fromkeys(vehicle.constants.names, 0.05) | {
        "scale_power.propellers": 1.8, "latency.surge": 0.21, "latency.sway": 0.13, "latency.bow": 0.4,
        "lag": 0.3, "pair_offset_across.propellers": -0.02, "pair_dead_zone.propellers": 0.2,
    }  # fmt: skip
    values = {c: 0.02 * (-1) ** i for i, c in enumerate(vehicle.structure.coefficients)}
    values |= {"X_u": -0.1, "X_uu": -0.5, "Y_v": -0.2, "Y_vv": -1.0, "N_r": -0.6, "N_rr": -0.4}
    values |= {"X_vr": 1.0, "Y_ur": -1.0}
    return make_model(vehicle.with_stated(stated), values, step=1 / 60)


def azimuths() -> seatrial.Model:
    """Two steered thrusts, forward-right-down: one with a rate limit, a rudder in the flow and a known signal,
    one with a lag alone and a curve of its angle."""
    forces = {
        "F_u": {"axis": "surge", "of": {"motor": 1.0, "pod": 0.4}},
        "F_v": {"axis": "sway", "of": {"wheel": 0.3, "helm": 1.0}},
        "F_r": {"axis": "yaw", "of": {"helm": -0.6, "wheel": 0.5, "motor": 0.1}},
        "F_d": {"axis": "yaw", "deflection": {"helm": -0.6}},
    }
    chain = [
        {"name": "thrust", "actuators": ["motor", "pod"], "latency": 0.113, "lag": 0.3, "slew_rate": 3.0, "power": 1.4,
         "dead_zone": {"forward": 0.05, "reverse": 0.11}, "reverse_ratio": 0.6},
        {"name": "battery", "actuators": ["motor"], "scale": {"signal": "volt", "power": 1.7}},
        {"name": "helm", "actuators": ["helm"], "latency": 0.07, "lag": 0.15, "steered": {
            "of": [["motor", "helm"]], "angle_deg": 35.0, "offset_deg": -4.0, "rate_deg": 40.0,
            "dead_zone": 0.08}},
        {"name": "wheel", "actuators": ["wheel"], "latency": 0.0, "lag": 0.2, "power": 1.3,
         "steered": {"of": [["pod", "wheel"]], "angle_deg": 80.0}},
    ]  # fmt: skip
    structure = yaml.safe_load(OUTBOARD)["structure"]
    structure["yaw"].append("N_d * |u| * u * F_d")
    boat = outboard(
        axes="forward-right-down", forces=forces, chain=chain, structure=structure,
        scales={"volt": {"column": "v", "reference": 12.0}},
        commands={"file": "log.csv", "stamp": "t", "inputs": {
            "motor": "m", "wheel": "w", "helm": "s", "pod": "p"}},
    )  # fmt: skip
    values = COEFFICIENTS | {"N_d": 0.7}
    return make_model(boat, {n: values[n] for n in boat.structure.coefficients}, step=1 / 60)


BOATS = {
    "always_forward": always_forward, "right_down": right_down, "bare": bare, "ship": ship,
    "outboard": known, "azimuths": azimuths,
}  # fmt: skip


@cache
def boat(name: str) -> seatrial.Model:
    return BOATS[name]()


@cache
def drive(name: str) -> Drive:
    """S7's sticks, given to each input in turn, the boat's own axes; known signals go up and down."""
    model, commands = boat(name), sticks().commands
    t = (commands.stamps - commands.stamps[0]) * 1e-9
    of = [k % 3 for k in range(len(model.vehicle.inputs))]
    reference = np.array([s.reference for s in model.vehicle.file.scales.values()])
    scales = reference * (1.0 + 0.3 * np.sin(0.1 * t)[:, None])
    values = commands.values[:, of] * model.vehicle.input_signs
    if scales.size:  # every row differs: a recording breaks at each, as what is driven live
        values = values + 1e-6 * np.sin(7.0 * t)[:, None]
    return Drive(t, np.ascontiguousarray(values), scales)


def in_own_axes(model: seatrial.Model, states: np.ndarray) -> np.ndarray:
    return states * (STATE_SIGNS if model.vehicle.axes is Axes.FRD else 1.0)


def plant_states(model: seatrial.Model, run: Drive) -> np.ndarray:
    """States (n, 6) at the drive's stamps by the core, driven live; in the boat's own axes."""
    plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
    states = np.zeros((len(run.t), 6))
    recorded = np.ascontiguousarray(run.commands * model.vehicle.input_signs)
    for i, t in enumerate(run.t.tolist()):
        assert plant.advance_to(t)
        states[i] = plant.state
        assert plant.command(t, recorded[i])
    return in_own_axes(model, states)


def trace_states(model: seatrial.Model, run: Drive) -> np.ndarray:
    """The same as `predict` and `validate` have it: along a recording, with known signals."""
    vehicle, t = model.vehicle, np.ascontiguousarray(run.t)
    recorded = np.ascontiguousarray(run.commands * vehicle.input_signs)
    scale_t = t if vehicle.scales else np.zeros(0)
    trace = _core.ThrustTrace(
        vehicle.chain, model.constants, t, recorded, scale_t, run.scales[: len(scale_t)]
    )
    states, _ = _core.simulate(model.boat, trace, np.zeros(6), t)
    return in_own_axes(model, states)


def core_states(model: seatrial.Model, run: Drive) -> np.ndarray:
    """The core's states along a drive. Its plant takes known signals to be at their references."""
    return (trace_states if model.vehicle.scales else plant_states)(model, run)


@cache
def truth(name: str) -> np.ndarray:
    return core_states(boat(name), drive(name))
