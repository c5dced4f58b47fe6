# SPDX-License-Identifier: MIT
"""Names in the C header: macros of coefficients and constants, variables of forces."""

import re

from seatrial.export.content import Content
from seatrial.export.spelling import identifiers
from seatrial.export.template import template


def spelled(content: Content, name: str) -> dict[str, str]:
    """The header's names of coefficients and constants (macros) and of forces (variables)."""
    own, macros = _own_names(name), {p: f"{name.upper()}_{p}" for p in content.values}
    found = identifiers(macros.values(), own)
    forces = identifiers(content.forces, {*own, *found.values()})
    return {p: found[macro] for p, macro in macros.items()} | forces


def _own_names(name: str) -> set[str]:
    """What the header itself names, in any boat."""
    text = "".join(map(template, ("boat.h", "queue.h", "at_once.h", "curves.h")))
    upper, lower = (set(re.findall(rf"\$\{{{n}\}}_(\w+)", text)) for n in ("NAME", "name"))
    return {f"{name.upper()}_{word}" for word in upper} | {f"{name}_{word}" for word in lower}


def macro(content: Content, name: str, parameter: str) -> str:
    """The header's name of a coefficient or constant."""
    return spelled(content, name)[parameter]
