# SPDX-License-Identifier: MIT
"""The rooms of the core: which header may include which, and the include paths of release 0.1."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
HEADERS = ROOT / "core/include/seatrial"
OLD = ROOT / "core/compat/seatrial"
ROOMS = [  # from the bottom; a header includes only from its own room and the rooms named
    ("model", ()),
    ("actuators", ("model",)),
    ("integration", ("model", "actuators")),
    ("filter", ("model", "actuators", "integration")),
    ("onboard", ("model", "actuators", "integration", "filter")),
    ("control", ("model", "actuators")),
    ("simulation", ("model", "actuators", "integration", "onboard")),
]


def included(file: Path) -> list[str]:
    return re.findall(r'#include "seatrial/([\w/]+\.hpp)"', file.read_text())


def test_every_header_stands_in_a_room():
    assert {path.name for path in HEADERS.iterdir()} == {room for room, _ in ROOMS}


@pytest.mark.parametrize(("room", "below"), ROOMS)
def test_a_room_includes_only_the_rooms_below_it(room, below):
    for header in (HEADERS / room).iterdir():
        for path in included(header):
            assert (HEADERS / path).exists(), f"{header.name}: {path}"
            assert path.split("/")[0] in (room, *below), f"{header.name} includes {path}"


def test_every_old_path_forwards_to_one_header_and_is_compiled():
    compiled = set(included(ROOT / "core/tests/test_old_paths.cpp"))
    assert compiled == {path.name for path in OLD.iterdir()}
    assert len(compiled) == 44
    for path in OLD.iterdir():
        (new,) = included(path)
        assert (HEADERS / new).exists(), f"{path.name}: {new}"
