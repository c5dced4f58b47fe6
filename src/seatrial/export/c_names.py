# SPDX-License-Identifier: MIT
"""Names in the C header: macros of coefficients and constants, variables of forces."""

import re
from dataclasses import dataclass

from seatrial.export.content import Content
from seatrial.export.spelling import identifiers
from seatrial.export.template import template


@dataclass(frozen=True)
class Names:
    """The header's names; all but the variables start with `name`."""

    name: str
    macros: dict[str, str]  # of coefficients and constants
    forces: dict[str, str]  # variables

    @property
    def degree(self) -> str:
        """The macro of a degree [rad]."""
        return f"{self.name.upper()}_DEGREE"


def names_of(content: Content, name: str) -> Names:
    """The names of a boat's header."""
    own, macros = _own_names(name), {p: f"{name.upper()}_{p}" for p in content.values}
    found = identifiers(macros.values(), own)
    forces = identifiers(content.forces, {*own, *found.values()})
    return Names(name, {p: found[macro] for p, macro in macros.items()}, forces)


def _own_names(name: str) -> set[str]:
    """What the header itself names, in any boat."""
    text = "".join(map(template, ("boat.h", "queue.h", "at_once.h", "curves.h")))
    upper, lower = (set(re.findall(rf"\$\{{{n}\}}_(\w+)", text)) for n in ("NAME", "name"))
    return {f"{name.upper()}_{word}" for word in upper} | {f"{name}_{word}" for word in lower}
