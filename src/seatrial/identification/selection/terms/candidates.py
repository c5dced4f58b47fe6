# SPDX-License-Identifier: MIT
"""Candidate terms: a default list, or the user's own."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from seatrial.boat.physical_library import library_tiers
from seatrial.boat.structure import Force, Structure, Term, parse
from seatrial.boat.vehicle import Vehicle
from seatrial.util.errors import StructureError
from seatrial.util.files import read_yaml
from seatrial.util.frames import AXES, SYMBOLS

COEFFICIENT_LETTERS = ("X", "Y", "N")
ASYMMETRY_TERMS = {  # further terms of a hull that is symmetric port to starboard, not fore to aft
    0: (("v2", ("v", "v")), ("r2", ("r", "r"))),
    1: (("uv", ("u", "v")),),
    2: (("ur", ("u", "r")), ("vr", ("v", "r"))),
}


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
