# SPDX-License-Identifier: MIT
"""Model predictive control in the simulator: a figure of eight, SLAM's noise, a current. Needs casadi.

Usage: python examples/nmpc.py [MODEL]
"""

import sys

import numpy as np

import seatrial
from seatrial.control import Eight, fitted
from seatrial.control.mpc import Nmpc
from seatrial.simulation import PoseReading, PoseSettings, Sensors, Simulator
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model

PERIOD = 0.1  # [s] of the controller
LASTS = 40.0  # [s]
CURRENT = (0.02, 0.0)  # [m/s] known: an identified model would be told of it by the poses
SLAM_DELAY = 0.05  # [s]

plan = load_plan("paper-like")
table_two = plant_model(plan, seatrial.load_vehicle("mallard-mp"))
model = seatrial.load(sys.argv[1]) if sys.argv[1:] else table_two

course = fitted(Eight(1.1, 0.45), model)
controller = Nmpc(model, pool=(plan.pool.length, plan.pool.width), clearance=0.3)
predictor = seatrial.Predictor(controller.model, current=CURRENT)
sensors = Sensors(pose=PoseSettings.of_plan(plan.pose, SLAM_DELAY), imu=None, lidar=None)
boat = Simulator(
    controller.model, sensors=sensors, current=CURRENT, start=course.at(0.0).eta, seed=1
)

off = []
while boat.time < LASTS:
    if boat.pose() is not None:
        acts = boat.time + controller.latency
        found = predictor.at(acts)
        ahead = [course.at(acts + dt) for dt in controller.grid.times.tolist()]
        wanted = np.array([np.concatenate([one.eta, one.body()[0]]) for one in ahead])
        commands = controller.command(
            boat.time, found.pose, found.velocity, wanted, found.disturbance
        )
        boat.command(commands)
        predictor.command(boat.time, commands)
    for reading in boat.advance(PERIOD):
        if isinstance(reading, PoseReading):
            predictor.pose(reading.stamp, reading.eta)
    off.append(boat.eta[:2] - course.at(boat.time).eta[:2])

rms = np.sqrt(np.mean(np.sum(np.square(off[50:]), axis=1)))
print(
    f"{LASTS:g} s on a figure of eight of {course.duration:.0f} s: {1e3 * rms:.1f} mm RMS from it"
)
