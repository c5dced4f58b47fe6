# SPDX-License-Identifier: MIT
"""What moves a boat and is no change of it: gusts, slow wind, waves, a current, a hand, a tow."""

import numpy as np

from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import DisturbanceForce
from seatrial.util.frames import Array

GUSTS = DisturbanceForce(share=0.12, correlation=2.0, earth_fixed=True)
SLOW_WIND = DisturbanceForce(share=0.15, correlation=20.0, earth_fixed=True)
WAVE_PERIOD, WAVE_SPREAD, WAVE_LINES = 1.5, 0.2, 12  # [s], relative, of the spectrum
WAVE = np.array([0.005, 0.005, 0.01])  # [m, m, rad] RMS
CURRENT, CURRENT_CHANGE = 0.1, 0.05  # [m/s] its size, and amplitude of its slow change
CURRENT_PERIOD = 120.0  # [s]
HAND_MOVE, HAND_TURN, HAND_SECONDS = 0.15, 0.6, 2.0  # [m, rad, s]
HAND_TIMES = 15.0, 60.0  # [s] between which it comes
TOW = np.array([1.0, 0.5, 0.0])  # [m/s, m/s, rad/s] that a tow adds: a turn would stay


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
    begin = rng.uniform(*HAND_TIMES)
    phase = ((recording.t - begin) / HAND_SECONDS).clip(0.0, 1.0)
    direction = rng.uniform(0.0, 2.0 * np.pi)
    size = np.array([HAND_MOVE * np.cos(direction), HAND_MOVE * np.sin(direction), HAND_TURN])
    return _moved(recording, np.sin(np.pi * phase)[:, None] * size)


def towed(recording: Recording, begin: float, end: float) -> Recording:
    """Towed from `begin` to `end` [s] of the recording."""
    return _moved(recording, TOW * (recording.t.clip(begin, end) - begin)[:, None])
