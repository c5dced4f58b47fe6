# SPDX-License-Identifier: MIT
"""The model as parameters of Gazebo's hydrodynamics and thruster plugins.

The engine moves a rigid body: m (u_dot - v r) = X, m (v_dot + u r) = Y, I r_dot = N. The plugin adds
the sums of coefficient * velocity, * velocity * |velocity|, * velocity * velocity and * acceleration.
Its parameters are the coefficients times (mass + added mass). The equations of motion do not depend
on the stated added mass.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial import _core
from seatrial.boat.allocation import Thruster
from seatrial.boat.structure import Term
from seatrial.export.content import Content
from seatrial.export.hull import Hull
from seatrial.export.spelling import identifiers
from seatrial.util.errors import ExportError
from seatrial.util.frames import AXES, SYMBOLS, Array

BASE_LINK = "base_link"
PLUGIN_AXES = "xyn"  # of the plugin's parameters: surge, sway, yaw
NEGLIGIBLE = 1e-9  # of mass: a smaller term is rounding error
UNEVEN = 1e-3  # of thrust: what a turned thrust may differ from that ahead


@dataclass(frozen=True)
class Propeller:
    """A thruster with the force of an actuator: position, direction, thrust at full command."""

    name: str  # of its link
    joint: str
    x: float  # [m]
    y: float  # [m]
    angle: float  # [rad] from forward, towards port
    reach: tuple[float, float]  # [N] at full command astern and ahead
    gear: "Gear | None" = None


@dataclass(frozen=True)
class Gear:
    """The link that turns a propeller."""

    name: str  # of its link
    joint: str
    side: float  # 1: positive angles are counter-clockwise; or -1
    rate: float | None  # [rad/s] limit


@dataclass(frozen=True)
class Gazebo:
    """A boat in forward-left-up axes with mass and size.

    Raises ExportError for terms that Gazebo does not have.
    """

    content: Content  # in forward-left-up axes
    hull: Hull

    @cached_property
    def hydrodynamics(self) -> dict[str, float]:
        """Parameters of the plugin by name, in N and N m per velocities and accelerations."""
        found = {"xVR": -self.hull.mass, "yUR": self.hull.mass}  # the engine adds these itself
        for axis, added in enumerate(self.hull.added):
            found[f"{PLUGIN_AXES[axis]}Dot{SYMBOLS[axis].upper()}"] = -added
        for term in self.content.structure.terms:
            if self._force_of(term) is None:
                name = f"{PLUGIN_AXES[term.axis]}{self._factors(term)}"
                found[name] = found.get(name, 0.0) + self._dimensional(term)
        return {
            name: value for name, value in found.items() if abs(value) > NEGLIGIBLE * self.hull.mass
        }

    @cached_property
    def delayed(self) -> Array:
        """Forces (3, 3) per acceleration, which the plugin applies one step late."""
        own = self.hydrodynamics
        return np.array(
            [[own.get(f"{a}Dot{s.upper()}", 0.0) for s in SYMBOLS] for a in PLUGIN_AXES]
        )

    def check_stable(self) -> None:
        """Raise ExportError where the delayed accelerations diverge.

        With D the delayed added mass, a_k = M^-1 (F + D a_(k-1)) converges if and only if all
        eigenvalues of M^-1 D are below 1.
        """
        growth = float(np.abs(np.linalg.eigvals(self.delayed / self.hull.rigid[:, None])).max())
        if growth >= 1.0:
            shares = (
                f"{AXES[i]} {self.hull.added[i]:g} of {self.hull.rigid[i]:g}" for i in range(3)
            )
            raise ExportError(
                f"added mass is too large for Gazebo's plugin ({', '.join(shares)}): it applies it one "
                f"step late, and errors grow {growth:.2g} times per step; give less than the mass, or add part "
                "of it to the mass"
            )

    @cached_property
    def propellers(self) -> list[Propeller]:
        """One for each thrust; together they give exactly the model's wrench.

        The identified X_F, Y_F and N_F are inconsistent with the measured positions. Direction and thrust
        are therefore the model's, and the position is shifted to give the model's moment.
        """
        wrench = np.zeros((3, len(self.content.actuators)))
        for term in self.content.structure.terms:
            force = self._force_of(term)
            if force is not None:
                wrench[term.axis] += self._dimensional(term) * self.content.mix[force]
        turned = {thrust: angle for angle, thrust in self.content.angles}
        return [
            self._turned(k, turned[k], wrench) if k in turned else self._propeller(k, *column)
            for k, column in enumerate(wrench.T.tolist())
            if k not in turned.values()
        ]

    @cached_property
    def _names(self) -> list[tuple[str, str]]:
        """Link and joint of each actuator."""
        names = [actuator.name for actuator in self.content.actuators]
        links = identifiers(names, {BASE_LINK})
        joints = identifiers([f"{name}_joint" for name in names], {BASE_LINK, *links.values()})
        return [(links[name], joints[f"{name}_joint"]) for name in names]

    def _propeller(self, k: int, surge: float, sway: float, yaw: float) -> Propeller:
        name, size = self.content.actuators[k].name, float(np.hypot(surge, sway))
        if size <= NEGLIGIBLE * max(1.0, abs(yaw)):
            raise ExportError(
                f"{name} gives a moment without a force, which is not a thruster in Gazebo; describe the "
                "boat's thrusters in the vehicle file, or export to fmu or c"
            )
        along = np.array([surge, sway]) / size
        placed = {t.name: (t.x, t.y) for t in self._thrusters()}
        x, y = placed.get(name, (0.0, 0.0))
        shift = yaw / size - (x * along[1] - y * along[0])
        return Propeller(
            *self._names[k], x + shift * along[1], y - shift * along[0], float(np.arctan2(sway, surge)),
            self._reach(k, size),
        )  # fmt: skip

    def _reach(self, k: int, thrust: float) -> tuple[float, float]:
        """[N] of actuator k at full command astern and ahead, known signals at their references."""
        model, content = self.content.model, self.content
        commands = np.zeros((2, len(content.actuators)))
        commands[:, k] = np.array([-1.0, 1.0]) * (1.0 if content.limit is None else content.limit)
        # a pair's other component is zero at minus its offset
        for other in content.curves[k].arguments[1:]:
            offset = 0.0 if other.offset is None else content.values[other.offset]
            commands[:, other.k] = offset if other.negative else -offset
        levels = _core.curve(model.vehicle.chain, model.constants, k, commands)
        astern, ahead = (thrust * levels).tolist()
        return astern, ahead

    def _turned(self, k: int, angle: int, wrench: Array) -> Propeller:
        """Thrust f of actuator k, turned by an angle: its wrenches of f cos and of f sin give its position."""
        name, own = self.content.actuators[angle].name, self.content.actuators[angle]
        if self.content.deflection[:, angle].any():
            raise ExportError(
                f"{name} is a rudder in the flow (deflection:), which Gazebo's thruster is not; export to fmu or c"
            )
        ahead, across = wrench[:2, k], wrench[:2, angle]
        size = float(np.hypot(*ahead))
        side = float(np.sign(ahead[0] * across[1] - ahead[1] * across[0]))
        even = side * np.array([-ahead[1], ahead[0]])  # the same thrust, turned by a quarter
        if size <= 0.0 or np.hypot(*(across - even)) > UNEVEN * size:
            raise self._uneven(k, angle, ahead, across)
        x, y = np.linalg.solve(
            [[ahead[1], -ahead[0]], [even[1], -even[0]]], [wrench[2, k], wrench[2, angle]]
        )
        rate = own.constants.get("slew_rate")
        limit = None if rate is None else float(np.deg2rad(self.content.values[rate]))
        gear = Gear(*self._names[angle], side, limit)
        heading = float(np.arctan2(ahead[1], ahead[0]))
        return Propeller(*self._names[k], float(x), float(y), heading, self._reach(k, size), gear)

    def _uneven(self, k: int, angle: int, ahead: Array, across: Array) -> ExportError:
        names = [self.content.actuators[i].name for i in (k, angle)]
        size, other = float(np.hypot(*ahead)), float(np.hypot(*across))
        added = self.hull.effective[1] * size / other - self.hull.mass if other > 0.0 else -1.0
        fits = ahead[1] == 0.0 and across[0] == 0.0 and 0.0 <= added < self.hull.mass
        advice = f"give {added:.6g} kg as added mass in sway, or " if fits else ""
        return ExportError(
            f"{names[0]} has {size:.4g} N ahead and {other:.4g} N across, which {names[1]} turns; in Gazebo a "
            f"turned thrust keeps its size; {advice}export to fmu or c"
        )

    def _thrusters(self) -> tuple[Thruster, ...]:
        vehicle = self.content.model.vehicle
        return vehicle.thrusters if vehicle.file.thrusters else ()

    def _dimensional(self, term: Term) -> float:
        value = 1.0 if term.coefficient is None else self.content.values[term.coefficient]
        return float(self.hull.effective[term.axis] * term.number * value)

    def _force_of(self, term: Term) -> int | None:
        """Number of the force, if the term is a thruster force."""
        forces = [f for f in term.factors if f in self.content.forces]
        if not forces:
            return None
        if len(term.factors) > 1 or term.acceleration is not None:
            raise self._refused(term)
        return self.content.forces.index(forces[0])

    def _factors(self, term: Term) -> str:
        """A term's factors as in the plugin's parameters: U, UabsU, VR, DotU."""
        plain = sorted((f for f in term.factors if "|" not in f), key=SYMBOLS.index)
        sizes = [f.strip("|") for f in term.factors if "|" in f]
        if term.acceleration is not None and not term.factors:
            return f"Dot{SYMBOLS[term.acceleration].upper()}"
        kind = (len(plain), len(sizes))
        if term.acceleration is not None or kind not in {(1, 0), (1, 1), (2, 0)}:
            raise self._refused(term)
        return "".join(plain).upper() + "".join(f"abs{size.upper()}" for size in sizes)

    def _refused(self, term: Term) -> ExportError:
        return ExportError(
            f"Gazebo's hydrodynamics has no term like '{term.text()}' in {AXES[term.axis]}: it has products "
            "of a velocity with one more velocity or its size; use only such terms, or export to fmu or c"
        )
