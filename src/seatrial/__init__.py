# SPDX-License-Identifier: MIT
"""Dynamic models of small surface vehicles from a recording: identify, prove, use.

A name is imported when it is first used, so that `import seatrial` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

_MODULES = {
    "Allocator": "control.allocation",
    "BoatChange": "onboard.boat_change",
    "Carrier": "simulation.mimic",
    "ChangeDetector": "monitoring.change_detector",
    "EquationErrorSettings": "identification.methods",
    "Estimate": "onboard.predictor",
    "Health": "onboard.predictor",
    "Mimic": "simulation.mimic",
    "Model": "boat.model",
    "Motion": "recording.velocity",
    "Odometer": "onboard.odometer",
    "Odometry": "onboard.odometer",
    "Prediction": "evaluation.predicted",
    "Predictor": "onboard.predictor",
    "Recording": "recording.recording",
    "Scene": "simulation",
    "Scores": "evaluation.scores",
    "SeatrialError": "util.errors",
    "Sensors": "simulation",
    "Simulator": "simulation",
    "Taken": "onboard.predictor",
    "TrackingController": "control",
    "Tuning": "control",
    "Vehicle": "boat.vehicle",
    "World": "simulation",
    "auto": "guide",
    "compare": "evaluation.comparison.compare",
    "convert": "io.convert",
    "identify": "identification.methods",
    "init": "inspection.proposal.propose",
    "inspect": "inspection.overview",
    "load": "boat.model_file",
    "load_plan": "simulation.plan",
    "load_vehicle": "boat.vehicle",
    "motion": "recording.velocity",
    "predict": "evaluation.prediction",
    "read": "io",
    "save": "boat.model_file",
    "show_progress": "util.progress",
    "simulate": "simulation.trials",
    "tune": "control",
    "validate": "evaluation.validation",
}
__all__ = list(_MODULES)

if TYPE_CHECKING:  # the same for type checkers and editors; a test compares them
    from seatrial.boat.model import Model as Model
    from seatrial.boat.model_file import load as load
    from seatrial.boat.model_file import save as save
    from seatrial.boat.vehicle import Vehicle as Vehicle
    from seatrial.boat.vehicle import load_vehicle as load_vehicle
    from seatrial.control import TrackingController as TrackingController
    from seatrial.control import Tuning as Tuning
    from seatrial.control import tune as tune
    from seatrial.control.allocation import Allocator as Allocator
    from seatrial.evaluation.comparison.compare import compare as compare
    from seatrial.evaluation.predicted import Prediction as Prediction
    from seatrial.evaluation.prediction import predict as predict
    from seatrial.evaluation.scores import Scores as Scores
    from seatrial.evaluation.validation import validate as validate
    from seatrial.guide import auto as auto
    from seatrial.identification.methods import EquationErrorSettings as EquationErrorSettings
    from seatrial.identification.methods import identify as identify
    from seatrial.inspection.overview import inspect as inspect
    from seatrial.inspection.proposal.propose import init as init
    from seatrial.io import read as read
    from seatrial.io.convert import convert as convert
    from seatrial.monitoring.change_detector import ChangeDetector as ChangeDetector
    from seatrial.onboard.boat_change import BoatChange as BoatChange
    from seatrial.onboard.odometer import Odometer as Odometer
    from seatrial.onboard.odometer import Odometry as Odometry
    from seatrial.onboard.predictor import Estimate as Estimate
    from seatrial.onboard.predictor import Health as Health
    from seatrial.onboard.predictor import Predictor as Predictor
    from seatrial.onboard.predictor import Taken as Taken
    from seatrial.recording.recording import Recording as Recording
    from seatrial.recording.velocity import Motion as Motion
    from seatrial.recording.velocity import motion as motion
    from seatrial.simulation import Scene as Scene
    from seatrial.simulation import Sensors as Sensors
    from seatrial.simulation import Simulator as Simulator
    from seatrial.simulation import World as World
    from seatrial.simulation.mimic import Carrier as Carrier
    from seatrial.simulation.mimic import Mimic as Mimic
    from seatrial.simulation.plan import load_plan as load_plan
    from seatrial.simulation.trials import simulate as simulate
    from seatrial.util.errors import SeatrialError as SeatrialError
    from seatrial.util.progress import show_progress as show_progress
else:

    def __getattr__(name: str) -> object:
        """A public name, from where it is; else a package below this one."""
        if name in _MODULES:
            found = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
            globals()[name] = found
            return found
        if not name.startswith("__"):
            try:
                return import_module(f"{__name__}.{name}")
            except ModuleNotFoundError as error:
                if error.name != f"{__name__}.{name}":
                    raise
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
