# SPDX-License-Identifier: MIT
"""A simulator to develop against: identified boats in a pool, with walls, current and sensors."""

from seatrial.simulation.readings import ImuReading, PoseReading, Reading, Scan
from seatrial.simulation.scene import Scene, SceneFile, load_scene
from seatrial.simulation.sensors import ImuSettings, LidarSettings, PoseSettings, Sensors
from seatrial.simulation.world import SimulatedBoat, Simulator, World

__all__ = [
    "ImuReading", "ImuSettings", "LidarSettings", "PoseReading", "PoseSettings", "Reading", "Scan", "Scene",
    "SceneFile", "Sensors", "SimulatedBoat", "Simulator", "World", "load_scene",
]  # fmt: skip
