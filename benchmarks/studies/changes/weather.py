# SPDX-License-Identifier: MIT
"""Drives of the unchanged boat in one weather, or with a hand."""

from collections.abc import Callable

import numpy as np

from benchmarks.studies.changes.boats import unseen
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import DisturbanceForce
from tests.boats.scenes import FORCE
from tests.boats.weather import GUSTS, SLOW_WIND, current, hand, waves

LONG, HAND_DRIVE = 200.0, 100.0  # [s] of a drive
HAND = "a hand for 2 s: 15 cm, 0.6 rad"


def _same(recording: Recording, rng: np.random.Generator) -> Recording:
    return recording


Motion = Callable[[Recording, np.random.Generator], Recording]
WEATHER: dict[str, tuple[DisturbanceForce, Motion]] = {
    "as at identification: force of 4 %, 2 s": (FORCE, _same),
    "gusts: earth-fixed force of 12 %, 2 s": (GUSTS, _same),
    "slow wind: earth-fixed force of 15 %, 20 s": (SLOW_WIND, _same),
    "waves: motion of 5 mm, 10 mrad RMS, 1.5 s": (FORCE, waves),
    "gusts and waves": (GUSTS, waves),
    "current of 0.05 to 0.15 m/s": (FORCE, current),
}


def in_weather(name: str, seed: int) -> Recording:
    """A drive of the unchanged boat."""
    force, motion = WEATHER[name]
    return motion(unseen(None, seed, force, LONG).recording, np.random.default_rng(seed))


def with_hand(seed: int) -> Recording:
    """A drive of the unchanged boat that a hand moves once."""
    recording = unseen(None, seed, FORCE, HAND_DRIVE).recording
    return hand(recording, np.random.default_rng(seed))
