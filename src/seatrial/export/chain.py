# SPDX-License-Identifier: MIT
"""An actuator chain for all languages: each actuator, and the steady part, allocation and curves."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

from seatrial.boat.allocation import Scheme
from seatrial.util.frames import Array

CURVE_STAGES = {"edge_forward": 0.0, "edge_reverse": 0.0, "reverse_ratio": 1.0, "power": 1.0}


@dataclass(frozen=True)
class Actuator:
    """One actuator: its constants by stage (absent: no such stage), its pair, the thrust it turns."""

    name: str
    constants: dict[str, str]  # of STAGES
    scale: int | None  # number of its scale signal
    tabulated: bool
    partner: int | None  # the pair's other actuator
    across: bool  # the pair's second component
    mirrored: bool  # its command has the opposite sign in the pair's vector
    steers: int | None = None  # the actuator whose thrust it turns: it is an angle [rad]


@dataclass(frozen=True)
class Allocation:
    """Commands to the boat into commands f of the actuators: by T+, then within the limits, then the offset."""

    inverse: Array  # T+ (actuators, inputs)
    # Table I and Eq. (11): twice the share, ahead only; astern is the opposite thruster's
    one_sided: bool
    each: float | None  # limit of every single command
    # limit of the largest command: beyond it the whole wrench is scaled, never one thruster
    whole: float | None
    offset: float


def allocation_of(inverse: Array, scheme: Scheme, limit: float | None, offset: float) -> Allocation:
    """The allocation of a scheme."""
    if scheme is Scheme.DIRECT:
        return Allocation(inverse, False, limit, None, 0.0)
    whole = None if limit is None else max(0.0, limit - offset)
    return Allocation(inverse, scheme is not Scheme.MP, None, whole, offset)


class Shape(str, Enum):
    """A curve by the function that has it; a line needs none."""

    LINE = ""
    CURVE = "curve"
    TABLE = "table"
    PAIR = "pair"


@dataclass(frozen=True)
class Argument:
    """A command f_k of a curve, with its sign and the constant that is added to it."""

    k: int
    negative: bool = False
    offset: str | None = None


@dataclass(frozen=True)
class SteadyCurve:
    """The level that an actuator tends to: thrust, or angle [rad]."""

    actuator: str
    shape: Shape
    arguments: tuple[Argument, ...]  # of a pair both components, the own one first
    constants: tuple[tuple[str | None, float], ...]  # names, None: the number beside it
    negative: bool  # minus the function
    gain: str | None
    full_angle: str | None  # [deg] an angle is this times the function, and the trim
    trim: str | None  # [deg]

    @property
    def plain(self) -> bool:
        """Whether the level is the command."""
        return self.shape is Shape.LINE and self.gain is None and self.full_angle is None


def curves_of(actuators: Sequence[Actuator]) -> tuple[SteadyCurve, ...]:
    """A curve for each actuator, in their order."""
    return tuple(_curve_of(actuators, k) for k in range(len(actuators)))


def _curve_of(actuators: Sequence[Actuator], k: int) -> SteadyCurve:
    own = actuators[k]
    shape, arguments, named = Shape.LINE, [Argument(k)], {}
    if own.partner is not None:
        shape, named = Shape.PAIR, {"pair_dead_zone": 0.0}
        arguments = [_component(actuators, i) for i in (k, own.partner)]
    elif own.tabulated:
        shape = Shape.TABLE
    elif set(CURVE_STAGES) & set(own.constants):
        shape, named = Shape.CURVE, CURVE_STAGES
    constants = tuple((own.constants.get(stage), neutral) for stage, neutral in named.items())
    gain, full_angle, trim = map(own.constants.get, ("gain", "full_angle", "angle_offset"))
    mirrored = own.mirrored and shape is Shape.PAIR
    return SteadyCurve(
        own.name, shape, tuple(arguments), constants, mirrored, gain, full_angle, trim
    )


def _component(actuators: Sequence[Actuator], k: int) -> Argument:
    """One component of a pair's vector."""
    own = actuators[k]
    offset = own.constants.get("pair_offset_across" if own.across else "pair_offset_along")
    return Argument(k, own.mirrored, offset)


@dataclass(frozen=True)
class Language:
    """How a language spells the parts of a curve."""

    command: Callable[[int], str]  # f_k
    constant: Callable[[str], str]
    number: Callable[[float], str]
    prefix: str  # of functions
    degree: str  # [rad]

    def text(self, curve: SteadyCurve) -> str:
        """A curve as an expression."""
        given = [self._argument(argument) for argument in curve.arguments]
        given += [
            self.number(neutral) if name is None else self.constant(name)
            for name, neutral in curve.constants
        ]
        function = f"{'-' * curve.negative}{self.prefix}{curve.shape.value}"
        value = f"{function}({', '.join(given)})" if curve.shape is not Shape.LINE else given[0]
        value = f"{self.constant(curve.gain)} * {value}" if curve.gain else value
        if curve.full_angle is None:
            return value
        trim = f" + {self.constant(curve.trim)}" if curve.trim else ""
        return f"{self.degree} * ({self.constant(curve.full_angle)} * {value}{trim})"

    def _argument(self, own: Argument) -> str:
        offset = f" + {self.constant(own.offset)}" if own.offset else ""
        return f"{'-' * own.negative}{self.command(own.k)}{offset}"
