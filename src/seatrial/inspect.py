# SPDX-License-Identifier: MIT
"""What is in a recording, in words: rates, gaps, faults, excitation."""

from collections import Counter

import numpy as np

from seatrial.errors import RecordingError
from seatrial.excitation import EXCITED, excitation
from seatrial.frames import AXES
from seatrial.noise import pose_noise
from seatrial.recording import Recording
from seatrial.sanity import ABSURD_SPEED
from seatrial.vehicle import Vehicle
from seatrial.velocity import motion

SHORT = 30.0  # [s] a recording below it says little
UNEVEN_STAMPS = 0.05  # share of the period that stamps may be off an even rhythm
SLOWEST_RATE, FASTEST_RATE = 0.5, 2000.0  # [Hz] of poses
ABSURD_TURN = 6.0  # [rad/s]
STILL = 0.002  # [m/s], [rad/s]


def inspect_text(recording: Recording, vehicle: Vehicle) -> str:
    """A few lines about one recording, verdicts last."""
    lines = [
        f"{recording.name}: {recording.duration:.1f} s, vehicle {vehicle.name} ({vehicle.axes.value})",
        f"  poses     {len(recording.t)} at {1 / recording.period:.2f} Hz, jitter "
        f"{1e3 * _jitter(recording):.2f} ms, "
        f"{100 * recording.usable:.1f} % usable{_noise(recording)}",
        f"  commands  {_commands(recording)}",
    ]
    counts = Counter(fault.kind for fault in recording.faults)
    for kind, count in counts.items():
        worst = max((f for f in recording.faults if f.kind is kind), key=lambda f: f.end - f.start)
        lines.append(
            f"  fault     {count} x {kind.value}; longest {worst.end - worst.start:.2f} s "
            f"at {worst.start:.1f} s"
        )
    found = excitation(vehicle, recording)
    for axis, label in enumerate(AXES):
        sides = "both directions" if found.both_signs[axis] else "mostly one direction"
        sides = sides if found.rms[axis] >= EXCITED else "not driven"
        lines.append(
            f"  {label:<9} rms {found.rms[axis]:.3f}, largest {found.largest[axis]:.2f}, "
            f"{100 * found.share[axis]:.0f} % of all effort, {sides}"
        )
    return "\n".join(lines + [f"  => {verdict}" for verdict in verdicts(recording, vehicle)])


def verdicts(recording: Recording, vehicle: Vehicle) -> list[str]:
    """What to do about it, one sentence each."""
    found = excitation(vehicle, recording)
    said = implausible(recording)
    if recording.duration < SHORT:
        said.append(f"{recording.duration:.0f} s is short: drive a few minutes")
    if recording.usable < 0.9:
        said.append(
            f"{100 * (1 - recording.usable):.0f} % of the poses are unusable: see the faults"
        )
    jitter = _jitter(recording)
    if jitter > UNEVEN_STAMPS * recording.period:
        said.append(
            f"stamps are off an even rhythm by {1e3 * jitter:.1f} ms; are they rounded, or arrival "
            "times? Velocities suffer: record the sensor's own stamps"
        )
    if found.dominant is not None:
        said.append(f"drives {AXES[found.dominant]} nearly alone: identifies that axis")
    for axis, label in enumerate(AXES):
        if found.rms[axis] < EXCITED:
            said.append(f"{label} is not excited: take it from another recording")
        elif not found.both_signs[axis] and found.dominant in (axis, None):
            said.append(f"{label} is driven mostly to one side: drive both")
    return said or ["good for identification"]


def implausible(recording: Recording) -> list[str]:
    """Units that can't be right for a small boat, one sentence each."""
    said = []
    rate = 1.0 / recording.period
    if not SLOWEST_RATE <= rate <= FASTEST_RATE:
        said.append(
            f"poses at {rate:.3g} Hz: is the stamp's unit right (s, ms, us, ns)? "
            "Name it in the vehicle file"
        )
    moving = motion(recording)
    if not moving.valid.any():
        return said
    speed = np.hypot(moving.nu[moving.valid, 0], moving.nu[moving.valid, 1])
    fast, turn = (float(np.percentile(a, 90)) for a in (speed, np.abs(moving.nu[moving.valid, 2])))
    if fast > ABSURD_SPEED:
        said.append(f"speeds of {fast:.3g} m/s: are x and y in mm or cm? Name the unit")
    if turn > ABSURD_TURN:
        said.append(f"yaw rates of {turn:.3g} rad/s: is psi in degrees? Name the unit deg")
    if fast < STILL and turn < STILL:
        said.append(f"the boat hardly moves: {fast:.2g} m/s, {turn:.2g} rad/s; drive it about")
    return said


def _jitter(recording: Recording) -> float:
    """Standard deviation of the steps between poses that follow each other [s]."""
    steps = np.diff(recording.t)
    return float(np.std(steps[steps < 1.5 * recording.period]))


def _commands(recording: Recording) -> str:
    signal = recording.commands
    n = len(signal.stamps)
    t = recording.seconds(signal.stamps)
    rate = f"{(n - 1) / (t[-1] - t[0]):.2f} Hz" if n > 1 else "one row"
    return f"{n} at {rate} ({', '.join(signal.names)}), from {t[0]:.2f} s to {t[-1]:.2f} s"


def _noise(recording: Recording) -> str:
    try:
        noise = pose_noise(recording)
    except RecordingError:
        return ""
    return f", noise {1e3 * noise.position:.2f} mm, {1e3 * noise.heading:.2f} mrad"
