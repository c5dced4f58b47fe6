# SPDX-License-Identifier: MIT
"""The physical library: terms that `structure: auto` begins with, and those that it chooses from.

Fossen, Handbook of Marine Craft, 2nd ed., chapters 6 and 7. A hull that is symmetric port to starboard has terms
that are even in v and r in surge, and odd ones in sway and yaw. Curved thrust is a stage of the actuator chain.
"""

from collections.abc import Iterator, Sequence

from seatrial.boat.structure import ACCELERATIONS, Force, Term
from seatrial.util.frames import SYMBOLS

SURGE, SWAY, YAW = range(3)
LETTERS = ("X", "Y", "N")
RIGID_BODY = ((1.0, ("v", "r")), (-1.0, ("u", "r")), None)  # Coriolis and centripetal, by axis
# of a term: name of its coefficient after the letter, and factors
Named = tuple[str, tuple[str, ...]]
ADDED_MASS: tuple[tuple[Named, ...], ...] = (  # by axis; Munk moment in yaw
    (("vr", ("v", "r")),),
    (("ur", ("u", "r")),),
    (("uv", ("u", "v")),),
)
LINEAR: tuple[tuple[Named, ...], ...] = (  # coupled drag, and lift
    (),
    (("r", ("r",)),),
    (("v", ("v",)), ("ur", ("u", "r"))),
)
CURVED: tuple[tuple[Named, ...], ...] = (
    # drag ahead and astern; drag in a drift and in a turn; offset centre of mass
    (("u2", ("u", "u")), ("vu", ("|v|", "u")), ("ru", ("|r|", "u")), ("v2", ("v", "v")), ("r2", ("r", "r"))),
    # cross-flow drag, lift; asymmetry
    (
        ("uv", ("u", "v")), ("av", ("|u|", "v")), ("ar", ("|u|", "r")), ("rv", ("|r|", "v")),
        ("vr", ("|v|", "r")), ("rr", ("|r|", "r")), ("u", ("u",)), ("uu", ("|u|", "u")),
    ),
    (
        ("av", ("|u|", "v")), ("ar", ("|u|", "r")), ("rv", ("|r|", "v")), ("vr", ("|v|", "r")),
        ("vv", ("|v|", "v")), ("u", ("u",)), ("uu", ("|u|", "u")), ("ud", ("u_dot",)),
    ),
)  # fmt: skip


def base_terms(forces: Sequence[Force], *, explicit: bool) -> tuple[Term, ...]:
    """What every boat has: rigid-body Coriolis terms, linear and quadratic drag, and thrust.

    Thrust acts along its axis. `explicit`: the file states forces as sums of inputs. Sway forces turn the boat
    then, as their lever arms are unknown.
    """
    found = []
    for axis, own in enumerate(SYMBOLS):
        letter, coriolis = LETTERS[axis], RIGID_BODY[axis]
        if coriolis is not None:
            found.append(Term(axis, None, coriolis[0], coriolis[1], None))
        found.append(Term(axis, f"{letter}_{own}", 1.0, (own,), None))
        found.append(Term(axis, f"{letter}_{2 * own}", 1.0, (f"|{own}|", own), None))
        for force in forces:
            turns = axis == YAW and force.axis == SWAY and explicit
            if force.axis == axis or turns:
                only = force.axis == axis and sum(f.axis == axis for f in forces) == 1
                name = f"{letter}_F" if only else _of_force(axis, force)
                found.append(Term(axis, name, 1.0, (force.name,), None))
    return tuple(found)


def library_tiers(forces: Sequence[Force], *, explicit: bool) -> tuple[tuple[Term, ...], ...]:
    """What a boat may have besides, in the order in which it is tried: linear in velocities and forces first."""
    own = {(t.axis, t.factors) for t in base_terms(forces, explicit=explicit)}
    coupled: tuple[list[Term], list[Term]] = [], []
    advance: list[Term] = []
    for axis in range(3):
        for force in forces:
            term = Term(axis, _of_force(axis, force), 1.0, (force.name,), None)
            asymmetric = (axis == SURGE) != (force.axis == SURGE)
            if (axis, term.factors) in own:
                advance += _with_speed(term)
            else:
                coupled[asymmetric].append(term)
    return (
        tuple(_named(ADDED_MASS)),
        (*_named(LINEAR), *coupled[0]),
        (*_named(CURVED), *advance, *coupled[1]),
    )


def _with_speed(thrust: Term) -> Iterator[Term]:
    """Thrust that falls with the speed of advance: the speed ahead, or that along the thrust's own axis."""
    (force,) = thrust.factors
    short = force.replace("_", "")
    for speed in dict.fromkeys(("u", SYMBOLS[thrust.axis])):
        name = f"{LETTERS[thrust.axis]}_{'a' if speed == 'u' else speed}{short}"
        yield Term(thrust.axis, name, 1.0, (f"|{speed}|", force), None)


def _named(listed: Sequence[Sequence[Named]]) -> list[Term]:
    return [
        _term(axis, f"{LETTERS[axis]}_{name}", factors)
        for axis in range(3)
        for name, factors in listed[axis]
    ]


def _term(axis: int, name: str, factors: Sequence[str]) -> Term:
    velocities = tuple(factor for factor in factors if factor not in ACCELERATIONS)
    acceleration = next((ACCELERATIONS.index(f) for f in factors if f in ACCELERATIONS), None)
    return Term(axis, name, 1.0, velocities, acceleration)


def _of_force(axis: int, force: Force) -> str:
    return f"{LETTERS[axis]}_{force.name.replace('_', '')}"
