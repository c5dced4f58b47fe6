# SPDX-License-Identifier: MIT
"""Models to tune, and their loops: in the simulator, and built another way."""

import dataclasses

import numpy as np
from conftest import TABLE_II, make_model

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.control.gains_file import save_gains
from seatrial.simulation import Sensors, Simulator

LAG, LATENCY = 0.08, 0.05  # [s]
CHAIN = [{"latency": LATENCY, "lag": LAG, "dead_zone": {"forward": 0.08, "reverse": 0.08}}]


def with_chain(name, chain=CHAIN, **changes):
    """A vehicle that comes with seatrial, with an actuator chain and other keys changed."""
    content = seatrial.load_vehicle(name).to_mapping()
    return vehicle_from({**content, "chain": chain, **changes}, name)


def mallard(scheme="MP", spread=0.05, chain=CHAIN, **values):
    """Table II's boat; coefficients known to `spread` of their values."""
    model = make_model(with_chain(f"mallard-{scheme.lower()}", chain), {**TABLE_II["AF"], **values})
    n = len(model.coefficients)
    covariance = np.zeros((n + len(model.constants),) * 2)
    covariance[:n, :n] = np.diag((spread * model.coefficients) ** 2)
    return dataclasses.replace(model, covariance=covariance)


def without_guidance(tuning, path):
    """The file of gains, as of a boat with sway thrust."""
    save_gains(tuning, path)
    text = path.read_text()
    begin = text.index("guidance:")
    end = text.index("\n", text.index("approach:", begin)) + 1
    path.write_text(text[:begin] + text[end:])
    return path


def in_loop(plant, controller, reference, seconds, *, rate=50.0, **scene):
    """Time, pose, velocity and command at every call of a controller in the simulator, by the true motion.

    reference: of time and pose; with a later one, as the controller takes them.
    """
    sea = Simulator(plant, sensors=Sensors(pose=None, imu=None, lidar=None), **scene)
    for i in range(round(seconds * rate)):
        t, eta, nu = i / rate, sea.eta, sea.nu
        command = controller.command(t, eta, nu, *reference(t, eta))
        sea.command(command)
        yield t, eta, nu, command
        sea.advance(1.0 / rate)


def boat_by_hand(c, nu):
    """A and B of Eq. (12) about nu, for Table II's names."""
    u, v, r = nu
    surge = np.array([c["X_u"] + 2 * c["X_uu"] * abs(u), r, v])
    sway = np.array([-r, c["Y_v"] + 2 * c["Y_vv"] * abs(v), -u])
    yaw = np.array([2 * c["N_uu"] * abs(u), 0.0, c["N_r"] + 2 * c["N_rr"] * abs(r)])
    A = np.vstack([surge, sway, yaw + c["N_ud"] * surge])
    B = np.diag([c["X_F"], c["Y_F"], c["N_F"]])
    B[2, 0] = c["N_ud"] * c["X_F"]
    return A, B


def poles_by_pade(c, nu, table, mix, *, earth=True):
    """Closed-loop poles about nu; arguments as of `closed_loop`."""
    return np.linalg.eigvals(closed_loop(c, nu, table, mix, earth=earth))


def closed_loop(c, nu, table, mix, *, earth=True, latency=LATENCY, order=6):
    """State matrix about nu: delays by Pade, the integral fixed to earth or body.

    States: pose error (3), velocity (3), integral (3), thrusters.
    """
    import control

    A, B = boat_by_hand(c, nu)
    u, v, r = nu
    S = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    W = np.array([[0.0, 0.0, -v], [0.0, 0.0, u], [0.0, 0.0, 0.0]])
    kp, ki, kd = (np.diag(table[:, k]) for k in range(3))
    thrust = control.ss(control.tf(*control.pade(latency, order)) * control.tf([1], [LAG, 1]))
    n = thrust.nstates
    size = 9 + 3 * n  # pose error, velocity, integral; a lag and a delay an axis command
    M = np.zeros((size, size))
    M[:3, :3], M[:3, 3:6] = W - r * S, np.eye(3)
    M[3:6, 3:6] = A
    M[6:9, :3], M[6:9, 6:9] = np.eye(3), -r * S * earth
    asked = -np.hstack([kp + kd @ W, kd, ki])  # of pose error, velocity, integral
    effect = B @ mix
    for j in range(3):
        rows = slice(9 + j * n, 9 + (j + 1) * n)
        M[rows, rows] = thrust.A
        M[rows, :9] = np.outer(thrust.B[:, 0], asked[j])
        M[3:6, rows] = np.outer(effect[:, j], thrust.C[0])
        M[3:6, :9] += np.outer(effect[:, j], asked[j]) * thrust.D[0, 0]
    return M
