# SPDX-License-Identifier: MIT
"""The model as CasADi functions, for optimal control: same coefficients, exact derivatives by CasADi.

States x are [x, y, psi, u, v, r] (m, m, rad, m/s, m/s, rad/s), forces F and commands in command units.
In the library the axes are forward-left-up; in a file they are the vehicle file's.
"""

import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from seatrial.boat.model import Model
from seatrial.export.chain import Actuator, Shape
from seatrial.export.content import Content
from seatrial.util.errors import ExportError
from seatrial.util.frames import SYMBOLS, Axes

if TYPE_CHECKING:
    import casadi

Symbol = Any  # casadi has no types: an SX
STATE_SIZE = 6
SERIES_LIMIT = 1e-2  # step over lag below which a series avoids cancellation
ARRIVED = 1e-9  # [rad] beyond the end of the rate limit: rounding, as in the core


def casadi_dynamics(model: Model, *, smooth: float = 0.0) -> "casadi.Function":
    """rate(x, F) -> x_dot: Eqs. (1) and (12), forward-left-up.

    x (6,), F (forces,). `smooth` [m/s and rad/s]: |a| is sqrt(a^2 + smooth^2), for solvers with
    second derivatives; it changes a drag term by at most smooth times its other factors.
    Raises ExportError without casadi.
    """
    return Functions(Content(model, Axes.FLU), smooth).rate()


def casadi_step(model: Model, *, smooth: float = 0.0) -> "casadi.Function":
    """step(x, F, dt) -> x_next: one Runge-Kutta step of dt [s] with F held, as the core's."""
    return Functions(Content(model, Axes.FLU), smooth).step()


def casadi_targets(model: Model) -> "casadi.Function":
    """targets(command) -> steady thrust of each actuator, rad of an angle: allocation, then its curve."""
    return Functions(Content(model, Axes.FLU)).targets()


def casadi_mix(model: Model) -> "casadi.Function":
    """mix(level, scale) -> F = T f + D sin(angle): forces of the actuators' thrust, with known signals."""
    return Functions(Content(model, Axes.FLU)).mix()


def casadi_drive(model: Model, *, smooth: float = 0.0) -> "casadi.Function":
    """drive(x, level, target, scale, dt) -> (x_next, level_next): boat and lagging thrusters.

    Targets are held over dt [s]; lag and rate limit are exact, as in the core. Latency is not included: give
    the targets of the delayed command.
    """
    return Functions(Content(model, Axes.FLU), smooth).drive()


def write(content: Content) -> bytes:
    """All functions serialized, `rate` first: Function.load reads that one, a FileDeserializer all."""
    ca = casadi_module()
    functions = Functions(content)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "functions"
        file = ca.FileSerializer(str(path))
        for function in (
            functions.rate(),
            functions.step(),
            functions.targets(),
            functions.mix(),
            functions.drive(),
        ):
            file.pack(function)
        del file  # closes it
        return path.read_bytes()


class Functions:
    """The functions of one boat."""

    def __init__(self, content: Content, smooth: float = 0.0) -> None:
        if not 0 <= smooth < float("inf"):
            raise ExportError(f"smooth {smooth:g}: expected a speed >= 0 [m/s]")
        self.ca = casadi_module()
        self.content, self.smooth = content, smooth

    def rate(self) -> "casadi.Function":
        """See `casadi_dynamics`."""
        x, force = self._symbol("x", STATE_SIZE), self._symbol("F", len(self.content.forces))
        return self._function("rate", {"x": x, "F": force}, {"x_dot": self._rate(x, force)})

    def step(self) -> "casadi.Function":
        """See `casadi_step`."""
        x, force = self._symbol("x", STATE_SIZE), self._symbol("F", len(self.content.forces))
        dt = self._symbol("dt", 1)
        after = self._runge_kutta(x, [force] * 3, dt)
        return self._function("step", {"x": x, "F": force, "dt": dt}, {"x_next": after})

    def targets(self) -> "casadi.Function":
        """See `casadi_targets`."""
        command = self._symbol("command", len(self.content.inputs))
        target = self._curves(self._allocate(command))
        return self._function("targets", {"command": command}, {"target": target})

    def mix(self) -> "casadi.Function":
        """See `casadi_mix`."""
        level, scale = self._symbol("level", len(self.content.actuators)), self._scale()
        force = self._mix(level, scale)
        return self._function("mix", {"level": level, "scale": scale}, {"F": force})

    def drive(self) -> "casadi.Function":
        """See `casadi_drive`."""
        n = len(self.content.actuators)
        x, level, target = (
            self._symbol("x", STATE_SIZE),
            self._symbol("level", n),
            self._symbol("target", n),
        )
        scale, dt = self._scale(), self._symbol("dt", 1)
        after, reached, rest = x, level, dt
        # parts in which no angle reaches the end of its rate limit
        for _ in range(sum(map(self.content.limited, self.content.actuators))):
            part = self._smooth_part(reached - target, rest)
            after, reached = self._driven(after, reached, target, scale, part)
            rest = rest - part
        after, reached = self._driven(after, reached, target, scale, rest)
        given = {"x": x, "level": level, "target": target, "scale": scale, "dt": dt}
        return self._function("drive", given, {"x_next": after, "level_next": reached})

    def _driven(
        self, x: Symbol, level: Symbol, target: Symbol, scale: Symbol, h: Symbol
    ) -> tuple[Symbol, Symbol]:
        """Boat and actuators after one Runge-Kutta step of h."""
        away = level - target
        levels = [target + decay * away for decay in self._fades(h)]
        for k, a in enumerate(self.content.actuators):
            if self.content.limited(a):
                for node, share in enumerate((0.0, 0.5, 1.0)):
                    levels[node][k] = target[k] + self._rate_limited(a, away[k], share * h)
        after = self._runge_kutta(x, [self._mix(f, scale) for f in levels], h)
        return after, levels[2]

    def _rate_limited(self, actuator: Actuator, away: Symbol, h: Symbol) -> Symbol:
        """What is left of an angle's distance to its target after h: at the rate limit, then by the lag."""
        ca, rate, knee, lag = self.ca, *self._gear(actuator)
        size = ca.fabs(away)
        until = ca.fmax(size - knee, 0.0) / rate
        left = size - rate * ca.fmin(h, until)
        if lag > 0.0:
            left = left * ca.exp(-ca.fmax(h - until, 0.0) / lag)
        return ca.sign(away) * left

    def _smooth_part(self, away: Symbol, length: Symbol) -> Symbol:
        """Of `length` the part in which no angle reaches the end of its rate limit."""
        ca = self.ca
        for k, a in enumerate(self.content.actuators):
            if self.content.limited(a):
                rate, knee, _ = self._gear(a)
                past = ca.fabs(away[k]) - knee
                length = ca.if_else(past > ARRIVED, ca.fmin(length, past / rate), length)
        return length

    def _gear(self, actuator: Actuator) -> tuple[float, float, float]:
        """Rate limit of the level [1/s], the distance at which the lag takes over, and the lag [s]."""
        rate = self._own(actuator, "slew_rate", 0.0)
        rate = rate if actuator.steers is None else math.radians(rate)
        lag = self._own(actuator, "lag", 0.0) if self.content.lagged(actuator) else 0.0
        return rate, rate * lag, lag

    def _symbol(self, name: str, size: int) -> Symbol:
        return self.ca.SX.sym(name, size)

    def _scale(self) -> Symbol:
        return self._symbol("scale", len(self.content.scales))

    def _function(
        self, name: str, given: dict[str, Symbol], found: dict[str, Symbol]
    ) -> "casadi.Function":
        function: casadi.Function = self.ca.Function(
            name, list(given.values()), list(found.values()), list(given), list(found)
        )
        return function

    def _abs(self, value: Symbol) -> Symbol:
        return self.ca.sqrt(value**2 + self.smooth**2) if self.smooth > 0 else self.ca.fabs(value)

    def _rate(self, x: Symbol, force: Symbol) -> Symbol:
        cos, sin = self.ca.cos(x[2]), self.ca.sin(x[2])
        along, across = cos * x[3] - sin * x[4], sin * x[3] + cos * x[4]  # Eq. (1)
        return self.ca.vertcat(along, across, x[5], self._acceleration(x[3:6], force))

    def _acceleration(self, nu: Symbol, force: Symbol) -> Symbol:
        """Eq. (12): (I - A) nu_dot = g."""
        ca, content = self.ca, self.content
        known = {s: nu[i] for i, s in enumerate(SYMBOLS)}
        known |= {f"|{s}|": self._abs(nu[i]) for i, s in enumerate(SYMBOLS)}
        known |= {name: force[j] for j, name in enumerate(content.forces)}
        g, a = ca.SX.zeros(3, 1), ca.SX.zeros(3, 3)
        for term in content.structure.terms:
            value = ca.SX(
                term.number * (content.values[term.coefficient] if term.coefficient else 1.0)
            )
            for factor in term.factors:
                value = value * known[factor]
            if term.acceleration is None:
                g[term.axis] += value
            else:
                a[term.axis, term.acceleration] += value
        left = ca.SX.eye(3) - a
        return ca.mtimes(ca.inv_minor(ca.DM(left)), g) if left.is_constant() else ca.solve(left, g)

    def _runge_kutta(self, x: Symbol, force: list[Symbol], h: Symbol) -> Symbol:
        k1 = self._rate(x, force[0])
        k2 = self._rate(x + 0.5 * h * k1, force[1])
        k3 = self._rate(x + 0.5 * h * k2, force[1])
        k4 = self._rate(x + h * k3, force[2])
        return x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def _allocate(self, command: Symbol) -> Symbol:
        ca, own = self.ca, self.content.allocation
        inverse = ca.DM(own.inverse)
        if own.one_sided:  # Table I and Eq. (11)
            f = ca.sum2(ca.fmax(2.0 * inverse * ca.repmat(command.T, inverse.shape[0], 1), 0.0))
        else:  # Eq. (10)
            f = ca.mtimes(inverse, command)
        if own.each is not None:
            f = ca.fmin(ca.fmax(f, -own.each), own.each)
        if own.whole is not None:
            f = f * own.whole / ca.fmax(own.whole, ca.norm_inf(f))
        return f + own.offset

    def _own(self, actuator: Actuator, stage: str, neutral: float) -> float:
        return self._value(actuator.constants.get(stage), neutral)

    def _value(self, name: str | None, neutral: float) -> float:
        return neutral if name is None else self.content.values[name]

    def _curves(self, f: Symbol) -> Symbol:
        functions: dict[Shape, Callable[..., Symbol]] = {
            Shape.LINE: lambda own: own,
            Shape.CURVE: self._curve,
            Shape.TABLE: self._table,
            Shape.PAIR: self._pair,
        }
        found = []
        for one in self.content.curves:
            given = [
                (-f[a.k] if a.negative else f[a.k]) + self._value(a.offset, 0.0)
                for a in one.arguments
            ]
            g = functions[one.shape](*given, *(self._value(*named) for named in one.constants))
            g = self._value(one.gain, 1.0) * (-g if one.negative else g)
            if one.full_angle is not None:
                g = self._value(one.full_angle, 0.0) * g + self._value(one.trim, 0.0)
                g = math.pi / 180.0 * g
            found.append(g)
        return self.ca.vertcat(*found)

    def _curve(
        self, f: Symbol, forward: float, reverse: float, ratio: float, power: float
    ) -> Symbol:
        def past(size: Symbol, edge: float) -> Symbol:
            share = self.ca.fmax(size - edge, 0.0) / (1.0 - edge)
            return share if power == 1.0 else share**power

        return self.ca.if_else(f >= 0, past(f, forward), -ratio * past(-f, reverse))

    def _table(self, f: Symbol) -> Symbol:
        commands, thrusts = zip(*self.content.table, strict=True)
        held = self.ca.fmin(self.ca.fmax(f, commands[0]), commands[-1])
        return self.ca.pw_lin(held, self.ca.DM(list(commands)), self.ca.DM(list(thrusts)))

    def _pair(self, own: Symbol, other: Symbol, dead: float) -> Symbol:
        ca = self.ca
        length = ca.sqrt(own**2 + other**2)
        share = ca.fmax(ca.fmin(length, 1.0) - dead, 0.0) / (1.0 - dead)
        return ca.if_else(length > dead, own / ca.fmax(length, 1e-300) * share, 0.0)

    def _mix(self, f: Symbol, scale: Symbol) -> Symbol:
        ca, references = self.ca, list(self.content.scales.values())
        given = []
        for k, a in enumerate(self.content.actuators):
            if a.scale is None:
                given.append(f[k])
                continue
            ratio = ca.fmax(scale[a.scale], 0.0) / references[a.scale]
            given.append(ratio ** self._own(a, "scale_power", 1.0) * f[k])
        sines = ca.SX.zeros(len(given))
        for k, thrust in self.content.angles:
            size, sines[k] = given[thrust], ca.sin(f[k])
            given[thrust], given[k] = size * ca.cos(f[k]), size * sines[k]
        forces = ca.mtimes(ca.DM(self.content.mix), ca.vertcat(*given))
        return forces + ca.mtimes(ca.DM(self.content.deflection), sines)

    def _fades(self, h: Symbol) -> tuple[Symbol, Symbol, Symbol]:
        """Decay of the distance to the targets by the lags, at begin, middle and end of h, as in the core."""
        ca, found = self.ca, []
        for a in self.content.actuators:
            if not self.content.lagged(a):
                found.append((ca.SX(0.0),) * 3)
                continue
            x = h / self.content.values[a.constants["lag"]]
            far = ca.fmax(x, SERIES_LIMIT)  # has a derivative at 0, too
            mean = ca.if_else(x < SERIES_LIMIT, _series(x, 1), -ca.expm1(-far) / far)
            moment = ca.if_else(x < SERIES_LIMIT, _series(x, 2), (1.0 - mean) / far)
            end = ca.exp(-x)
            middle = 3.0 * mean - 0.5 * end - 3.0 * moment
            found.append((12.0 * moment - 6.0 * mean + end, middle, end))
        begin, middle, end = (ca.vertcat(*node) for node in zip(*found, strict=True))
        return begin, middle, end


def _series(x: Symbol, first: int) -> Symbol:
    """1 / first! - x / (first + 1)! + ..., six terms."""
    return sum((-1.0) ** k / math.factorial(first + k) * x**k for k in range(6))


def casadi_module() -> ModuleType:
    """CasADi, imported late because the import is slow. Raises ExportError where it is not installed."""
    try:
        import casadi  # noqa: PLC0415
    except ImportError:
        raise ExportError("CasADi is not installed: pip install 'seatrial[mpc]'") from None
    return casadi
