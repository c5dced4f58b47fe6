# SPDX-License-Identifier: MIT
"""Dynamic models of small surface vehicles from a recording: identify, prove, use."""

from seatrial.allocate import Allocator
from seatrial.control import TrackingController, Tuning, tune
from seatrial.errors import SeatrialError
from seatrial.identify import EquationErrorSettings, identify
from seatrial.init import init
from seatrial.inspect import inspect
from seatrial.io import read
from seatrial.mimic import Carrier, Mimic
from seatrial.model import Model, load, save
from seatrial.odometer import Odometer, Odometry
from seatrial.predict import Prediction, predict
from seatrial.predictor import Estimate, Health, Predictor, Taken
from seatrial.recording import Recording
from seatrial.sim import Scene, Sensors, Simulator, World
from seatrial.validate import Scores, validate
from seatrial.vehicle import Vehicle, load_vehicle
from seatrial.velocity import Motion, motion

__all__ = [
    "Allocator",
    "Carrier",
    "EquationErrorSettings",
    "Estimate",
    "Health",
    "Mimic",
    "Model",
    "Motion",
    "Odometer",
    "Odometry",
    "Prediction",
    "Predictor",
    "Recording",
    "Scene",
    "Scores",
    "SeatrialError",
    "Sensors",
    "Simulator",
    "Taken",
    "TrackingController",
    "Tuning",
    "Vehicle",
    "World",
    "identify",
    "init",
    "inspect",
    "load",
    "load_vehicle",
    "motion",
    "predict",
    "read",
    "save",
    "tune",
    "validate",
]
