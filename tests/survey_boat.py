# SPDX-License-Identifier: MIT
"""A boat with two thrusters astern, and a bow thruster if wanted, driven at random by direct commands."""

import numpy as np
from conftest import make_model

from tests.boats.motions import recorded, states_at, traced
from tests.boats.vehicles import TWIN, TWIN_TRUTH, TWO_ASTERN, by_columns

TRUTH = {**TWIN_TRUTH, "Y_F": 0.15, "N_b": 0.2}
LATENCY, LAG = 0.05, 0.1  # [s]
NOISE = np.array([2e-3, 2e-3, 3e-3])  # [m], [rad]


def boat(chain=(), *, bow=False):
    """The vehicle, with this actuator chain."""
    own, forces, structure = ["left", "right"], TWO_ASTERN, TWIN
    if bow:
        own, forces = [*own, "bow"], {**forces, "F_b": {"axis": "sway", "of": {"bow": 1.0}}}
        more = {"sway": "Y_F * F_b", "yaw": "N_b * F_b"}
        structure = {**TWIN, **{axis: [*TWIN[axis], term] for axis, term in more.items()}}
    return by_columns("survey", own, structure, forces=forces, chain=list(chain))


def both(rng):
    """A size to either side."""
    return rng.uniform(-1.0, 1.0)


def past_idle(rng):
    """A size to either side, none of them small."""
    return rng.uniform(0.2, 1.0) * rng.choice([-1.0, 1.0])


def pulses(rng, seconds, size, idle):
    """Commands (n,) at 20 Hz, held for half a second to three; size(rng): of one that is not idle."""
    out = np.zeros(round(20 * seconds))
    at = 0
    while at < len(out):
        hold = int(rng.uniform(10, 60))
        out[at : at + hold] = 0.0 if rng.random() < idle else size(rng)
        at += hold
    return out


def even(rate):
    """Stamps of poses, so many a second."""
    return lambda rng, seconds: np.arange(0.0, seconds, 1.0 / rate)


TEN_HZ = even(10.0)


def driven(
    curve,
    sizes,
    *,
    seconds=300.0,
    seed=1,
    idle=0.3,
    bow=False,
    stamps=TEN_HZ,
    noise=NOISE,
    late=(0.0, 0.0),
    effect=None,
):
    """The vehicle without a chain, and a recording; curve: entries of the true chain beside latency and lag.

    late: [s] by which positions and headings are older than their stamps. effect: (n, thrusters) by the time (n,),
    times the commands that the boat follows.
    """
    rng = np.random.default_rng(seed)
    stages = {"latency": LATENCY, "lag": LAG}
    if isinstance(curve, dict):
        groups = [{**stages, **curve}]
    else:  # kinds of thrusters; a stage that they have of their own is not stated for all
        own = {stage for group in curve for stage in group}
        groups = [{k: v for k, v in stages.items() if k not in own}, *curve]
    truth = make_model(boat(groups, bow=bow), TRUTH)
    values = np.column_stack([pulses(rng, seconds, size, idle) for size in sizes])
    t = 1e-9 * np.round(1e9 * stamps(rng, seconds))
    begin = np.arange(len(values)) / 20.0
    followed = values if effect is None else values * effect(begin)
    positions, headings = (
        states_at(truth, np.maximum(t - delay, 0.0), begin, followed) for delay in late
    )
    eta = np.column_stack([positions[:, :2], headings[:, 2]])
    eta += rng.normal(size=(len(t), 3)) * noise
    vehicle = boat(bow=bow)
    return vehicle, recorded("drive", vehicle, (t, eta), (begin, values))


def as_stated(model, truth, sigmas=4.5):
    """Names whose truth is further off than so many standard errors."""
    got = {**model.values, **dict(zip(model.vehicle.constants.names, model.constants, strict=True))}
    errors = model.standard_errors
    return {
        n: (got[n] - x) / errors[n]
        for n, x in truth.items()
        if abs(got[n] - x) > sigmas * errors[n]
    }


def blown(wind, lever=0.0, side=1.0, *, rate=5.0, seconds=300.0, seed=1):
    """The survey boat in a wind (2,) [m/s^2], earth-fixed: Euler's steps of 2 ms.

    lever: [rad/m] by which its part across turns the boat; side: times more that it moves sway.
    """
    rng = np.random.default_rng(seed)
    truth = make_model(boat([{"latency": LATENCY, "lag": LAG}]), TRUTH)
    values = np.column_stack(
        [pulses(rng, seconds, lambda g: g.uniform(-1, 1), 0.3) for _ in range(2)]
    )
    begin, dt = np.arange(len(values)) / 20.0, 0.002
    trace = traced(truth, begin, values)
    force = np.asarray(trace.forces((np.arange(round(seconds / dt)) + 0.5) * dt))
    p, every = TRUTH, round(1.0 / rate / dt)
    x, y, psi, u, v, r = np.zeros(6)
    poses = []
    for k, (f_u, f_r) in enumerate(force.tolist()):
        if k % every == 0:
            poses.append((x, y, psi))
        c, s = np.cos(psi), np.sin(psi)
        x, y = x + dt * (c * u - s * v), y + dt * (s * u + c * v)
        psi += dt * r
        across = c * wind[1] - s * wind[0]
        du = (
            p["X_vr"] * v * r
            + p["X_u"] * u
            + p["X_uu"] * abs(u) * u
            + p["X_F"] * f_u
            + c * wind[0]
            + s * wind[1]
        )
        dv = p["Y_ur"] * u * r + p["Y_v"] * v + p["Y_vv"] * abs(v) * v + side * across
        dr = p["N_r"] * r + p["N_rr"] * abs(r) * r + p["N_F"] * f_r + lever * across
        u, v, r = u + dt * du, v + dt * dv, r + dt * dr
    eta = np.array(poses) + rng.normal(size=(len(poses), 3)) * [2e-3, 2e-3, 3e-3]
    vehicle = boat()
    t = np.arange(len(eta)) / rate
    return vehicle, recorded("blown", vehicle, (t, eta), (begin, values))
