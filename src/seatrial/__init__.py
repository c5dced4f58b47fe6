# SPDX-License-Identifier: MIT
"""Dynamic models of small surface vehicles from a recording: identify, prove, use."""

from seatrial.boat.model import Model, load, save
from seatrial.boat.vehicle import Vehicle, load_vehicle
from seatrial.control import TrackingController, Tuning, tune
from seatrial.control.allocation import Allocator
from seatrial.evaluation.prediction import Prediction, predict
from seatrial.evaluation.scores import Scores
from seatrial.evaluation.validation import validate
from seatrial.identification.methods import EquationErrorSettings, identify
from seatrial.inspection.overview import inspect
from seatrial.inspection.proposal.propose import init
from seatrial.io import read
from seatrial.onboard.odometer import Odometer, Odometry
from seatrial.onboard.predictor import Estimate, Health, Predictor, Taken
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion, motion
from seatrial.simulation import Scene, Sensors, Simulator, World
from seatrial.simulation.mimic import Carrier, Mimic
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import simulate
from seatrial.util.errors import SeatrialError

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
    "load_plan",
    "load_vehicle",
    "motion",
    "predict",
    "read",
    "save",
    "simulate",
    "tune",
    "validate",
]
