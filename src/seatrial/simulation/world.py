# SPDX-License-Identifier: MIT
"""Boats on one clock. The core (`core/include/seatrial/simulation/simulator.hpp`) steps them and their sensors.

Contact with walls and other boats is that of a disc around the origin: it is moved out, the normal
velocity is reflected with a coefficient of restitution, without friction. The LiDAR sees other boats
as their discs.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.model_file import model_of
from seatrial.simulation.readings import ImuReading, PoseReading, Reading, Scan, reading_of
from seatrial.simulation.scene import Scene, SceneFile, load_scene
from seatrial.simulation.sensors import Sensors, check, core_lidar, core_pose, filled
from seatrial.util.errors import ModelError, SimulatorError
from seatrial.util.frames import Array
from seatrial.util.rows import finite_row, row_of

R = TypeVar("R", bound=Reading)
ABREAST = 1.5  # [m] to port of each other, where no scene has starts
PLACEMENT_ADVICE = "place the boats with start: in the scene, or give a smaller radius"


class World:
    """A pool and the boats in it, from time 0 [s] on.

    scene: surfaces, a SceneFile, or the path of one; None: open water. current: (2,) [m/s] of the
    water, earth-fixed; by default the scene file's. The same seed and commands give the same motion
    and readings. Raises SimulatorError.
    """

    def __init__(
        self,
        scene: Scene | SceneFile | str | Path | None = None,
        *,
        current: Sequence[float] | None = None,
        seed: int = 0,
    ) -> None:
        self.file = _scene_file(scene)
        self.scene = scene if isinstance(scene, Scene) else self.file.surfaces
        given = self.file.current if current is None else current
        water = finite_row(given, "current", ("x [m/s]", "y [m/s]"), SimulatorError)
        if not 0 <= seed < 2**64:
            raise SimulatorError(f"seed {seed}: expected a whole number from 0 on")
        self.boats: list[SimulatedBoat] = []
        self._core = _core.Simulator(self.scene.core, water, seed)

    def add(
        self,
        model: Model | str | Path,
        *,
        name: str | None = None,
        start: Sequence[float] | None = None,
        radius: float | None = None,
        sensors: Sensors | None = None,
        lever: Sequence[float] | None = None,
    ) -> SimulatedBoat:
        """One more boat, before the first step; see `Simulator`. Raises SimulatorError."""
        return SimulatedBoat(
            self, model, name=name, start=start, radius=radius, sensors=sensors, lever=lever
        )

    @property
    def time(self) -> float:
        """[s]."""
        return self._core.time

    def advance(self, dt: float) -> list[Reading]:
        """Advance by dt [s]; the readings that arrive, in order. Raises ModelError."""
        return self.advance_to(self.time + dt)

    def advance_to(self, t: float) -> list[Reading]:
        """Advance to t [s]. Raises SimulatorError, and ModelError where a boat diverges."""
        if not self.time <= t < float("inf"):
            raise SimulatorError(
                f"can't advance from {self.time:g} s to {t:g} s; times must increase"
            )
        if not self._core.advance_to(t):
            raise ModelError(
                f"a boat diverges near {self.time:.2f} s: its model is unstable under these commands"
            )
        return [self.boats[row[1]]._recorded(row) for row in self._core.take()]


class SimulatedBoat:
    """A boat in a world; made by `World.add`."""

    def __init__(
        self,
        world: World,
        model: Model | str | Path,
        *,
        name: str | None = None,
        start: Sequence[float] | None = None,
        radius: float | None = None,
        sensors: Sensors | None = None,
        lever: Sequence[float] | None = None,
    ) -> None:
        self.model = model_of(model)
        self.world, self._core, self._place = world, world._core, len(world.boats)
        entries = world.file.boats
        entry = entries[self._place] if self._place < len(entries) else None
        chosen = (entry.name if entry else "") if name is None else name
        self.name = chosen or self._free_name()
        if self.name in [boat.name for boat in world.boats]:
            raise SimulatorError(f"two boats have the name {self.name}; give each its own")
        default = (0.0, ABREAST * self._place, 0.0)
        given = (entry.start if entry else default) if start is None else start
        begin = finite_row(given, "start", ("x [m]", "y [m]", "psi [rad]"), SimulatorError)
        own = (entry.radius if entry else None) if radius is None else radius
        self.radius = _core.HULL_RADIUS if own is None else own
        if not 0.0 <= self.radius < float("inf"):
            raise SimulatorError(f"radius {self.radius} m: expected 0 m or more")
        self._enter(begin, world.file.sensors if sensors is None else sensors, lever)
        self._last: dict[type[Reading], Reading] = {}

    def _free_name(self) -> str:
        """The model's name, with a number where another boat has it."""
        taken = [boat.name for boat in self.world.boats]
        names = (self.model.name, *(f"{self.model.name}-{i}" for i in range(2, len(taken) + 2)))
        return next(name for name in names if name not in taken)

    def _enter(self, start: Array, sensors: Sensors, lever: Sequence[float] | None) -> None:
        model, vehicle = self.model, self.model.vehicle
        arm = finite_row(
            vehicle.lever if lever is None else lever,
            "lever", ("forward [m]", "left [m]"), SimulatorError,
        )  # fmt: skip
        pose = core_pose(sensors.pose, (float(arm[0]), float(arm[1])), vehicle.delays)
        imu = filled(_core.Imu(), sensors.imu)
        self.lidar = core_lidar(sensors.lidar)
        check(pose, imu, self.lidar)
        if self.world.time > 0.0:
            raise SimulatorError(f"{self.name}: boats are added before the first step")
        if self._core.add(
            model.boat, vehicle.chain, model.constants, start, self.radius, pose, imu, self.lidar
        ) < 0:  # fmt: skip
            raise SimulatorError(
                f"{self.name} does not fit at ({start[0]:g}, {start[1]:g}) m with a radius of "
                f"{self.radius:g} m; {PLACEMENT_ADVICE}"
            )
        self.world.boats.append(self)

    def command(self, values: ArrayLike) -> None:
        """Commands (inputs,) to all inputs of the vehicle now, in command units, forward-left-up;

        they hold until the next. Raises SeatrialError.
        """
        row = row_of(values, f"{self.name}: command", self.model.vehicle.inputs, SimulatorError)
        if not np.all(np.abs(row) <= _core.STRONGEST_COMMAND):
            most = _core.STRONGEST_COMMAND
            raise SimulatorError(
                f"{self.name}: command {row.tolist()}: expected numbers from {-most:g} to {most:g}"
            )
        if not self._core.command(self._place, row):
            raise SimulatorError(f"{self.name}: too many commands within the thrusters' latency")

    @property
    def time(self) -> float:
        """[s]."""
        return self._core.time

    @property
    def eta(self) -> Array:
        """True pose (3,) of the origin: x, y [m], psi [rad], unwrapped."""
        return self._core.state(self._place)[:3]

    @property
    def nu(self) -> Array:
        """True velocity (3,) over ground, body-fixed: u, v [m/s], r [rad/s]."""
        return self._core.state(self._place)[3:]

    @property
    def forces(self) -> Array:
        """Generalised forces (forces,) after the actuator chain, in command units."""
        return self._core.forces(self._place, len(self.model.structure.forces))

    @property
    def touched(self) -> bool:
        """Whether it touched a surface or another boat in the last advance."""
        return self._core.touched(self._place)

    def pose(self) -> PoseReading | None:
        """The newest pose that has arrived."""
        return self._newest(PoseReading)

    def imu(self) -> ImuReading | None:
        """The newest reading of the inertial unit."""
        return self._newest(ImuReading)

    def scan(self) -> Scan | None:
        """The newest scan of the LiDAR."""
        return self._newest(Scan)

    def _newest(self, kind: type[R]) -> R | None:
        found = self._last.get(kind)
        assert found is None or isinstance(found, kind)
        return found

    def _recorded(self, row: tuple[int, int, float, float, Array]) -> Reading:
        reading = reading_of(row, self.name, self.lidar)
        self._last[type(reading)] = reading
        return reading


class Simulator(SimulatedBoat):
    """One boat in a world of its own.

    model: a Model or the path of its file. scene, current, seed: as of `World`. sensors: by default
    the scene file's. start: (3,) x, y [m], psi [rad]; at rest in the water. radius [m] of the disc for
    contact. lever: (2,) [m] of the measured point, forward and left of the origin; by default the vehicle
    file's, as `Odometer` expects (`Predictor` expects the origin: (0, 0)).
    Raises SeatrialError.
    """

    def __init__(
        self,
        model: Model | str | Path,
        *,
        scene: Scene | SceneFile | str | Path | None = None,
        current: Sequence[float] | None = None,
        sensors: Sensors | None = None,
        seed: int = 0,
        start: Sequence[float] | None = None,
        radius: float | None = None,
        lever: Sequence[float] | None = None,
    ) -> None:
        world = World(scene, current=current, seed=seed)
        super().__init__(world, model, start=start, radius=radius, sensors=sensors, lever=lever)

    def advance(self, dt: float) -> list[Reading]:
        """Advance by dt [s]; the readings that arrive, in order. Raises ModelError."""
        return self.world.advance(dt)

    def advance_to(self, t: float) -> list[Reading]:
        """Advance to t [s]; otherwise as `advance`."""
        return self.world.advance_to(t)


def _scene_file(scene: Scene | SceneFile | str | Path | None) -> SceneFile:
    if isinstance(scene, SceneFile):
        return scene
    return SceneFile() if scene is None or isinstance(scene, Scene) else load_scene(scene)
