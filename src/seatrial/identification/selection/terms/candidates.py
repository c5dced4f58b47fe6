# SPDX-License-Identifier: MIT
"""Candidate terms: a default list, or the user's own; and exact aliases among terms.

An alias is a linear combination of other terms for any data. N_ud u_dot, with u_dot = v r + X_u u + X_uu |u| u +
X_F F_u put in, is a combination of v r, u, |u| u and F_u: with all of these in the yaw equation one of the five is
too many.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from seatrial import _core
from seatrial.boat.physical_library import library_tiers
from seatrial.boat.structure import Force, Structure, Term, parse
from seatrial.boat.vehicle import Vehicle
from seatrial.util.errors import StructureError
from seatrial.util.files import read_yaml
from seatrial.util.frames import AXES, SYMBOLS, Array

COEFFICIENT_LETTERS = ("X", "Y", "N")
ASYMMETRY_TERMS = {  # further terms of a hull that is symmetric port to starboard, not fore to aft
    0: (("v2", ("v", "v")), ("r2", ("r", "r"))),
    1: (("uv", ("u", "v")),),
    2: (("ur", ("u", "r")), ("vr", ("v", "r"))),
}
ALIAS_SAMPLES = 400  # random states and forces: ten times the columns of the largest structure
ALIAS_TOLERANCE = 1e-8  # relative remainder of a column that others reproduce


def default_candidates(vehicle: Vehicle) -> tuple[Term, ...]:
    """The terms that the paper tried and dropped, and those that real boats need, without those already there.

    Linear and quadratic drag, coupled or not, cubic drag, drag that grows with the speed of another axis,
    free added mass on v r, u r and u v, coupled force, a cubic of the axis' own force, and a constant trim.
    For a hull without fore-aft symmetry: v v and r r in surge, u v in sway, u r in yaw.
    In yaw v r as well: one of four that make N_ud.
    """
    terms = [
        Term(axis, f"{COEFFICIENT_LETTERS[axis]}_{name}", 1.0, factors, None)
        for axis in range(3)
        for name, factors in _listed(axis, vehicle.forces)
    ]
    return tuple(new_to(vehicle.structure, terms))


def new_to(structure: Structure, terms: Sequence[Term]) -> list[Term]:
    """Those terms that the structure lacks, with names of coefficients that it has not."""
    known = {_identity(term) for term in structure.terms if term.coefficient}
    names = set(structure.coefficients)
    found = []
    for one in terms:
        term = one
        if _identity(term) in known:
            continue
        while str(term.coefficient) in names:  # another term has this name
            term = replace(term, coefficient=f"{term.coefficient}x")
        names.add(str(term.coefficient))
        found.append(term)
    return found


def _listed(axis: int, forces: Sequence[Force]) -> Iterator[tuple[str, tuple[str, ...]]]:
    own = SYMBOLS[axis]
    others = [symbol for i, symbol in enumerate(SYMBOLS) if i != axis]
    yield from ((symbol, (symbol,)) for symbol in (own, *others))
    yield from ((2 * symbol, (f"|{symbol}|", symbol)) for symbol in (own, *others))
    yield "".join(others), tuple(others)
    yield 3 * own, (own,) * 3
    for force in forces:
        short = force.name.replace("_", "")
        if force.axis == axis:
            yield f"{short}3", (force.name,) * 3
        else:
            yield short, (force.name,)
    yield "0", ()
    yield from ((f"{symbol}{own}", (f"|{symbol}|", own)) for symbol in others)
    yield from ASYMMETRY_TERMS.get(axis, ())  # last: the names are those of drag


def given_candidates(vehicle: Vehicle, given: Sequence[str]) -> tuple[Term, ...]:
    """Candidates from term lines (the letter of the coefficient names the axis) or from YAML files.

    A file lists terms under surge, sway and yaw. Raises StructureError for terms that can't be
    read, have no coefficient, or are in the structure already.
    """
    lines: dict[str, list[str]] = {axis: [] for axis in AXES}
    for text in given:
        if text.endswith((".yaml", ".yml")) or Path(text).is_file():
            for axis, listed in read_yaml(Path(text)).items():
                if not isinstance(listed, list):
                    raise StructureError(f"{text}: {axis}: expected a list of terms")
                lines.setdefault(str(axis), []).extend(str(line) for line in listed)
        else:
            lines[_axis_of(text)].append(text)
    terms = parse("candidates", lines, vehicle.forces).terms
    _refuse(vehicle.structure, terms)
    return terms


def _axis_of(text: str) -> str:
    for letter, axis in zip(COEFFICIENT_LETTERS, AXES, strict=True):
        if f"{letter}_" in text:
            return axis
    raise StructureError(
        f"candidate '{text}': no coefficient X_..., Y_... or N_..., and no such file; "
        "write for instance 'Y_r * r'"
    )


def _refuse(structure: Structure, terms: Sequence[Term]) -> None:
    seen = {_identity(term): str(term.coefficient) for term in structure.terms if term.coefficient}
    names = set(structure.coefficients)
    for term in terms:
        if term.coefficient is None:
            raise StructureError(
                f"candidate '{term.text()}' has no coefficient to find; name one, X_..., Y_... or N_..."
            )
        if _identity(term) in seen:
            raise StructureError(
                f"candidate '{term.text()}' is there already: {seen[_identity(term)]} in {AXES[term.axis]}"
            )
        if term.coefficient in names:
            raise StructureError(
                f"candidate '{term.text()}': the name {term.coefficient} is taken; take another"
            )
        seen[_identity(term)] = term.coefficient
        names.add(term.coefficient)


def _identity(term: Term) -> tuple[int, tuple[str, ...], int | None]:
    """The product of a term, without its number and the name of its coefficient."""
    return term.axis, tuple(sorted(term.factors)), term.acceleration


def drag_of(terms: Sequence[Term], axis: int) -> list[str]:
    """Drag coefficients of an axis that depend on its own velocity only."""
    own = {SYMBOLS[axis], f"|{SYMBOLS[axis]}|"}
    return [
        t.coefficient
        for t in terms
        if t.axis == axis
        and t.coefficient
        and t.acceleration is None
        and {*t.factors} <= own
        and t.factors
    ]


def is_essential(term: Term, forces: Sequence[Force]) -> bool:
    """Whether a term is never removed: one without coefficient, or thrust along its own axis."""
    own = {force.name for force in forces if force.axis == term.axis}
    thrust = len(term.factors) == 1 and term.factors[0] in own and term.acceleration is None
    return term.coefficient is None or thrust


def with_usual_terms(vehicle: Vehicle) -> Vehicle:
    """A vehicle with `structure: auto` and the terms that every boat has: drag, thrust and free added mass."""
    return vehicle.with_terms((*vehicle.structure.terms, *candidate_tiers(vehicle)[0]))


def candidate_tiers(vehicle: Vehicle) -> tuple[tuple[Term, ...], ...]:
    """Candidates in the order in which they are tried: the physical library for `structure: auto`."""
    if vehicle.automatic:
        tiers = library_tiers(vehicle.forces, explicit=bool(vehicle.file.forces))
        return tuple(tuple(new_to(vehicle.structure, tier)) for tier in tiers)
    return (default_candidates(vehicle),)


@dataclass(frozen=True)
class Alias:
    """A coefficient that no data can separate from others."""

    coefficient: str
    made_by: tuple[str, ...]  # coefficients whose terms add up to its term


def aliases(
    own: Sequence[Term], candidates: Sequence[Term], forces: Sequence[Force]
) -> tuple[Alias, ...]:
    """Exact linear dependencies among the free terms of every axis, own terms first.

    Of terms that depend on each other the last one is the alias. Accelerations are those of the structure
    itself, with random coefficients.
    """
    rng = np.random.default_rng(0)
    base = Structure("own", tuple(own), tuple(forces))
    nu = rng.normal(size=(ALIAS_SAMPLES, 3))
    force = rng.normal(size=(ALIAS_SAMPLES, len(forces)))
    theta = rng.uniform(0.2, 0.8, len(base.coefficients))  # none near 0, none dominates
    nu_dot = _core.accelerations(base.compiled, theta, nu, force)
    found = []
    for axis in range(3):
        terms = [t for t in (*own, *candidates) if t.axis == axis and t.coefficient]
        if terms:
            names, columns = _columns(terms, forces, nu, nu_dot, force)
            found += _dependent(names, columns)
    return tuple(found)


def _columns(
    terms: Sequence[Term], forces: Sequence[Force], nu: Array, nu_dot: Array, force: Array
) -> tuple[list[str], Array]:
    """Coefficients of one axis and their columns (samples, coefficients), of length 1."""
    parts = Structure("axis", tuple(terms), tuple(forces))
    each = _core.regressors(parts.compiled, nu, nu_dot, force)
    names = list(dict.fromkeys(str(t.coefficient) for t in terms))
    columns = np.zeros((len(nu), len(names)))
    for term, column in zip(terms, each.T, strict=True):
        columns[:, names.index(str(term.coefficient))] += column
    return names, np.asarray(columns / np.linalg.norm(columns, axis=0))


def _dependent(names: list[str], columns: Array) -> list[Alias]:
    kept: list[int] = []
    found = []
    for j, name in enumerate(names):
        weights = np.linalg.lstsq(columns[:, kept], columns[:, j], rcond=None)[0]
        left = columns[:, j] - columns[:, kept] @ weights
        if kept and np.linalg.norm(left) < ALIAS_TOLERANCE:
            shares = [
                names[k] for k, w in zip(kept, weights, strict=True) if abs(w) > ALIAS_TOLERANCE
            ]
            found.append(Alias(name, tuple(shares)))
        else:
            kept.append(j)
    return found
