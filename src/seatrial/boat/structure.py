# SPDX-License-Identifier: MIT
"""Model structures as data: for each axis a list of terms, each a product of factors.

A term is one line of text, for instance ``X_uu * |u| * u``: an optional number, an optional
coefficient (a SNAME name that begins with X_, Y_ or N_), then factors out of u, v, r, |u|, |v|,
|r|, a force (F_u, ...), and at most one acceleration of another axis (u_dot, v_dot, r_dot).
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib import resources

from seatrial import _core
from seatrial.util.errors import StructureError
from seatrial.util.file_content.yaml_dialect import DIGITS
from seatrial.util.files import read_yaml
from seatrial.util.frames import AXES, SYMBOLS
from seatrial.util.frozen import ByFields

VELOCITIES = ("u", "v", "r", "|u|", "|v|", "|r|")  # in the order of the core's Signal codes
ACCELERATIONS = ("u_dot", "v_dot", "r_dot")
_COEFFICIENT = re.compile(r"[XYN]_\w{1,62}")  # at most 64 characters, as all names
LONGEST_SHOWN = 40  # [characters] of an unknown name in a message
_ALIASES = {"udot": "u_dot", "vdot": "v_dot", "rdot": "r_dot"}
_ODD_FACTORS = frozenset({"v", "r", "v_dot", "r_dot"})  # change sign with the axes


@dataclass(frozen=True)
class Force:
    """A generalised force F_j in command units, and the axis that it acts along."""

    name: str
    axis: int  # 0 surge, 1 sway, 2 yaw


@dataclass(frozen=True)
class Term:
    """One term of one axis."""

    axis: int  # the equation it stands in
    coefficient: str | None  # None: known
    number: float  # constant multiplier
    factors: tuple[str, ...]  # velocities and forces
    acceleration: int | None  # axis of the acceleration factor

    def text(self) -> str:
        """The term as it stands in a file."""
        parts = (
            []
            if self.number == 1.0 and (self.coefficient or self.factors)
            else [f"{self.number:.{DIGITS}g}"]
        )
        parts += [self.coefficient] if self.coefficient else []
        parts += self.factors
        parts += [ACCELERATIONS[self.acceleration]] if self.acceleration is not None else []
        return " * ".join(parts)

    def flips(self, odd_forces: frozenset[str]) -> bool:
        """Whether it changes sign between forward-left-up and forward-right-down."""
        names = [*self.factors]
        names += [ACCELERATIONS[self.acceleration]] if self.acceleration is not None else []
        odd = sum(name in _ODD_FACTORS or name in odd_forces for name in names)
        return (odd + (self.axis > 0)) % 2 == 1

    @property
    def of_masses(self) -> bool:
        """Whether its coefficient consists of masses only: an added-mass term, or a Coriolis and
        centripetal one (Fossen, Handbook of Marine Craft, 2nd ed., section 6.3)."""
        return self.acceleration is not None or (
            len(self.factors) == 2 and {*self.factors} <= {*SYMBOLS}
        )

    def unit(self) -> str:
        """SI unit of its coefficient; forces are in command units, so dimensionless."""
        metre, second, radian = (1, -2, 0) if self.axis < 2 else (0, -2, 1)
        for name in self.factors:
            if name.strip("|") in ("u", "v"):
                metre, second = metre - 1, second + 1
            elif name.strip("|") == "r":
                radian, second = radian - 1, second + 1
        if self.acceleration is not None:
            second += 2
            metre, radian = (metre - 1, radian) if self.acceleration < 2 else (metre, radian - 1)
        return _unit_text({"m": metre, "rad": radian, "s": second})


Row = tuple[int, int, float, int, list[int]]
DISTURBANCE_TERMS = 3  # terms and coefficients of the filter's own
MOST_TERMS = _core.MAX_TERMS - DISTURBANCE_TERMS
MOST_COEFFICIENTS = _core.MAX_COEFFICIENTS - DISTURBANCE_TERMS


@dataclass(frozen=True)
class Structure(ByFields):
    """The right-hand side of Eq. (12), or a generalisation of it.

    The terms as data; the core computes them (`core/include/seatrial/model/dynamics.hpp`).
    """

    name: str
    terms: tuple[Term, ...]
    forces: tuple[Force, ...]

    def __post_init__(self) -> None:
        for what, count, most in (
            ("terms", len(self.terms), MOST_TERMS),
            ("coefficients", len(self.coefficients), MOST_COEFFICIENTS),
            ("forces", len(self.forces), _core.MAX_FORCES),
        ):
            if count > most:
                raise StructureError(
                    f"structure {self.name}: {count} {what}; at most {most}: remove some"
                )
        known = {force.name for force in self.forces}
        for term in self.terms:
            for name in term.factors:
                if name not in VELOCITIES and name not in known:
                    raise StructureError(
                        f"structure {self.name}: term '{term.text()}' has factor '{name}'; "
                        f"known are {', '.join(VELOCITIES)} and the forces {', '.join(sorted(known))}"
                    )
            if term.acceleration == term.axis:
                raise StructureError(
                    f"structure {self.name}: term '{term.text()}' has its own axis' acceleration; "
                    "divide the equation by it instead"
                )
        if not self.coefficients:
            raise StructureError(f"structure {self.name}: no coefficient to identify")
        _ = self.flipped_coefficients

    @cached_property
    def coefficients(self) -> tuple[str, ...]:
        """Names of the coefficients in order of appearance."""
        return tuple(dict.fromkeys(t.coefficient for t in self.terms if t.coefficient))

    @cached_property
    def units(self) -> dict[str, str]:
        """SI unit of every coefficient."""
        return {t.coefficient: t.unit() for t in reversed(self.terms) if t.coefficient}

    @cached_property
    def odd_forces(self) -> frozenset[str]:
        """Forces that change sign between the axis systems."""
        return frozenset(force.name for force in self.forces if force.axis > 0)

    @cached_property
    def flipped_coefficients(self) -> frozenset[str]:
        """Coefficients that change sign between the axis systems."""
        seen: dict[str, bool] = {}
        for term in self.terms:
            if term.coefficient is None:
                continue
            flips = term.flips(self.odd_forces)
            if seen.setdefault(term.coefficient, flips) != flips:
                raise StructureError(
                    f"structure {self.name}: {term.coefficient} is in two terms of which only "
                    "one changes sign between axis systems; give them different names"
                )
        return frozenset(name for name, flips in seen.items() if flips)

    def flipped(self) -> "Structure":
        """The structure in the other axis system: known terms change sign where needed."""
        terms = tuple(
            Term(t.axis, t.coefficient, -t.number, t.factors, t.acceleration)
            if t.coefficient is None and t.flips(self.odd_forces)
            else t
            for t in self.terms
        )
        return Structure(self.name, terms, self.forces)

    @cached_property
    def rows(self) -> list[Row]:
        """Terms as the core takes them: axis, coefficient, number, acceleration, factors."""
        codes = {name: i for i, name in enumerate(VELOCITIES)}
        codes |= {f.name: _core.FIRST_FORCE + i for i, f in enumerate(self.forces)}
        return [
            (
                t.axis,
                self.coefficients.index(t.coefficient) if t.coefficient else -1,
                t.number,
                -1 if t.acceleration is None else t.acceleration,
                [codes[name] for name in t.factors],
            )
            for t in self.terms
        ]

    @cached_property
    def compiled(self) -> _core.Structure:
        """The core's flat form."""
        return _core.Structure(self.rows, len(self.coefficients), len(self.forces))

    def lines(self) -> dict[str, list[str]]:
        """For each axis its terms as text: what files hold."""
        return {axis: [t.text() for t in self.terms if t.axis == i] for i, axis in enumerate(AXES)}

    def equation(self, axis: int, values: Mapping[str, float] | None = None) -> str:
        """One axis' equation in plain text, with names or with numbers."""
        right = ""
        for term in (t for t in self.terms if t.axis == axis):
            number = term.number
            head = [term.coefficient] if term.coefficient else []
            if values is not None and term.coefficient:
                number, head = number * values[term.coefficient], []
            tail = [*head, *term.factors]
            tail += [ACCELERATIONS[term.acceleration]] if term.acceleration is not None else []
            size = [] if abs(number) == 1.0 and tail else [f"{abs(number):.4g}"]
            sign = " - " if number < 0 else " + "
            right += sign + " ".join([*size, *tail])
        return f"{SYMBOLS[axis]}_dot ={right or ' 0'}".replace("= + ", "= ").replace("= - ", "= -")

    def thrust_and_drag(self, axis: int) -> tuple[set[str], set[str]]:
        """Coefficients of an axis' terms with a force, and of its drag.

        Drag is all terms of velocities alone, without those of masses: a payload that acts on all axes alike
        changes no Coriolis term.
        """
        forces = {force.name for force in self.forces}
        thrust: set[str] = set()
        drag: set[str] = set()
        for term in self.terms:
            if term.axis == axis and term.coefficient is not None and not term.of_masses:
                (thrust if forces & set(term.factors) else drag).add(term.coefficient)
        return thrust, drag


def parse(name: str, lines: Mapping[str, Sequence[str]], forces: Sequence[Force]) -> Structure:
    """A structure from its lines for surge, sway and yaw."""
    unknown = set(lines) - set(AXES)
    if unknown:
        raise StructureError(
            f"structure {name}: unknown axis '{sorted(unknown)[0]}'; use {', '.join(AXES)}"
        )
    terms = tuple(
        _parse_term(name, axis, line)
        for axis, key in enumerate(AXES)
        for line in lines.get(key, ())
    )
    return Structure(name, terms, tuple(forces))


@lru_cache(maxsize=32)
def named(name: str, source: str) -> Mapping[str, Sequence[str]]:
    """The lines of a structure that comes with seatrial, for instance ``mallard``; `source` names it."""
    folder = resources.files("seatrial") / "data" / "structures"
    known = sorted(p.name.removesuffix(".yaml") for p in folder.iterdir())
    if name not in known:  # a name, never a path
        raise StructureError(
            f"{source}: no structure named '{name[:LONGEST_SHOWN]}'; there are {', '.join(known)}, "
            "or write the terms under surge, sway and yaw"
        )
    lines = read_yaml(folder / f"{name}.yaml")
    return {str(k): tuple(str(x) for x in v) for k, v in lines.items()}


@lru_cache(maxsize=256)  # a search for stages makes many vehicles with the same terms
def _parse_term(structure: str, axis: int, line: str) -> Term:
    number, coefficient, factors, acceleration = 1.0, None, [], None
    for i, raw in enumerate(re.split(r"[\s*·]+", line.strip())):
        token = _ALIASES.get(raw, raw)
        if i > 0 and token in ("+", "-"):
            raise StructureError(f"structure {structure}: '{line}' is a sum; write one term a line")
        if token in ACCELERATIONS:
            if acceleration is not None:
                raise StructureError(
                    f"structure {structure}: '{line}' has two accelerations; one is possible"
                )
            acceleration = ACCELERATIONS.index(token)
        elif _COEFFICIENT.fullmatch(token):
            if coefficient is not None:
                raise StructureError(
                    f"structure {structure}: '{line}' has two coefficients; one is possible"
                )
            coefficient = token
        elif re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", token):
            number *= float(token)
            if not math.isfinite(number):
                raise StructureError(f"structure {structure}: '{line}' has a number beyond 1.8e308")
        elif token in ("+", "-"):
            number *= -1.0 if token == "-" else 1.0
        else:
            factors.append(token)
    if len(factors) > _core.MAX_FACTORS:
        raise StructureError(
            f"structure {structure}: '{line}' has {len(factors)} factors; "
            f"at most {_core.MAX_FACTORS} are possible"
        )
    return Term(axis, coefficient, number, tuple(factors), acceleration)


def _unit_text(powers: Mapping[str, int]) -> str:
    def side(sign: int) -> str:
        chosen = [(name, sign * p) for name, p in powers.items() if sign * p > 0]
        return " ".join(name if p == 1 else f"{name}^{p}" for name, p in chosen)

    above, below = side(1), side(-1)
    if not below:
        return above or "-"
    return f"{above or '1'}/{below}" if " " not in below else f"{above or '1'}/({below})"
