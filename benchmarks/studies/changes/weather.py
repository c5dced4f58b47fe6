# SPDX-License-Identifier: MIT
"""What moves a boat and is no change of it: gusts, slow wind, waves, a current, a hand."""

from collections.abc import Callable

import numpy as np

from benchmarks.studies.changes.boats import unseen
from seatrial.recording.recording import Recording, make_recording
from seatrial.simulation.plan import DisturbanceForce
from seatrial.util.frames import Array
from tests.boats.scenes import FORCE

LONG = 200.0  # [s] of a drive without a change
GUSTS = DisturbanceForce(share=0.12, correlation=2.0, earth_fixed=True)
WIND = DisturbanceForce(share=0.15, correlation=20.0, earth_fixed=True)
WAVE_PERIOD, WAVE_SPREAD, WAVE_LINES = 1.5, 0.2, 12  # [s], relative, of the spectrum
WAVE = np.array([0.005, 0.005, 0.01])  # [m, m, rad] RMS
CURRENT, CURRENT_CHANGE = 0.1, 0.05  # [m/s] its size, and amplitude of its slow change
CURRENT_PERIOD = 120.0  # [s]
HAND_MOVE, HAND_TURN = 0.15, 0.6  # [m, rad]
HAND_SECONDS, HAND_DRIVE = 2.0, 100.0  # [s]


def _moved(recording: Recording, motion: Array) -> Recording:
    """The recording with a motion (n, 3) [m, m, rad] added to its poses."""
    return make_recording(
        recording.name, recording.stamps, recording.raw + motion, recording.commands
    )


def waves(recording: Recording, rng: np.random.Generator) -> Recording:
    """With wave-frequency motion, added to that of the boat (Fossen, Handbook of Marine Craft, section 8.1)."""
    periods = WAVE_PERIOD * (1.0 + WAVE_SPREAD * rng.normal(size=(WAVE_LINES, 3)).clip(-2.0, 2.0))
    phases = rng.uniform(0.0, 2.0 * np.pi, (WAVE_LINES, 3))
    angle = 2.0 * np.pi * recording.t[:, None, None] / periods + phases
    return _moved(recording, WAVE * np.sqrt(2.0 / WAVE_LINES) * np.sin(angle).sum(axis=1))


def current(recording: Recording, rng: np.random.Generator) -> Recording:
    """In water that moves, slowly faster and slower."""
    direction, phase = rng.uniform(0.0, 2.0 * np.pi, 2)
    turn = 2.0 * np.pi / CURRENT_PERIOD
    swing = np.cos(phase) - np.cos(turn * recording.t + phase)
    way = CURRENT * recording.t + CURRENT_CHANGE / turn * swing
    zero = np.zeros_like(way)
    return _moved(recording, np.stack([way * np.cos(direction), way * np.sin(direction), zero], 1))


def hand(recording: Recording, rng: np.random.Generator) -> Recording:
    """Moved and turned by a hand, and back, once."""
    begin = rng.uniform(15.0, 60.0)
    phase = ((recording.t - begin) / HAND_SECONDS).clip(0.0, 1.0)
    direction = rng.uniform(0.0, 2.0 * np.pi)
    size = np.array([HAND_MOVE * np.cos(direction), HAND_MOVE * np.sin(direction), HAND_TURN])
    return _moved(recording, np.sin(np.pi * phase)[:, None] * size)


def _same(recording: Recording, rng: np.random.Generator) -> Recording:
    return recording


Motion = Callable[[Recording, np.random.Generator], Recording]
WEATHER: dict[str, tuple[DisturbanceForce, Motion]] = {
    "as at identification: force of 4 %, 2 s": (FORCE, _same),
    "gusts: earth-fixed force of 12 %, 2 s": (GUSTS, _same),
    "slow wind: earth-fixed force of 15 %, 20 s": (WIND, _same),
    "waves: motion of 5 mm, 10 mrad RMS, 1.5 s": (FORCE, waves),
    "gusts and waves": (GUSTS, waves),
    "current of 0.05 to 0.15 m/s": (FORCE, current),
}
HAND = "a hand for 2 s: 15 cm, 0.6 rad"


def in_weather(name: str, seed: int) -> Recording:
    """A drive of the unchanged boat."""
    force, motion = WEATHER[name]
    return motion(unseen(None, seed, force, LONG).recording, np.random.default_rng(seed))


def with_hand(seed: int) -> Recording:
    """A drive of the unchanged boat that a hand moves once."""
    recording = unseen(None, seed, FORCE, HAND_DRIVE).recording
    return hand(recording, np.random.default_rng(seed))
