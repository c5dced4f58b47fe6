# SPDX-License-Identifier: MIT
"""What is in a recording, in words: rates, gaps, faults, excitation."""

from collections import Counter

import numpy as np

from seatrial.errors import RecordingError
from seatrial.excitation import EXCITED, excitation
from seatrial.frames import AXES
from seatrial.noise import pose_noise
from seatrial.recording import Recording
from seatrial.vehicle import Vehicle

SHORT = 30.0  # [s] a recording below it says little


def inspect_text(recording: Recording, vehicle: Vehicle) -> str:
    """A few lines about one recording, verdicts last."""
    steps = np.diff(recording.t)
    lines = [
        f"{recording.name}: {recording.duration:.1f} s, vehicle {vehicle.name} ({vehicle.axes.value})",
        f"  poses     {len(recording.t)} at {1 / recording.period:.2f} Hz, jitter "
        f"{1e3 * float(np.std(steps[steps < 1.5 * recording.period])):.2f} ms, "
        f"{100 * float(recording.valid.mean()):.1f} % usable{_noise(recording)}",
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
        lines.append(
            f"  {label:<9} rms {found.rms[axis]:.3f}, largest {found.largest[axis]:.2f}, "
            f"{100 * found.share[axis]:.0f} % of all effort, {sides}"
        )
    return "\n".join(lines + [f"  => {verdict}" for verdict in verdicts(recording, vehicle)])


def verdicts(recording: Recording, vehicle: Vehicle) -> list[str]:
    """What to do about it, one sentence each."""
    found = excitation(vehicle, recording)
    said = []
    if recording.duration < SHORT:
        said.append(f"{recording.duration:.0f} s is short: drive a few minutes")
    if recording.valid.mean() < 0.9:
        said.append(
            f"{100 * (1 - recording.valid.mean()):.0f} % of the poses are unusable: see the faults"
        )
    if found.dominant is not None:
        said.append(
            f"drives {AXES[found.dominant]} nearly alone: identifies that axis (like S1-S3)"
        )
    for axis, label in enumerate(AXES):
        if found.rms[axis] < EXCITED:
            said.append(f"{label} is not excited: take it from another recording")
        elif not found.both_signs[axis] and found.dominant in (axis, None):
            said.append(f"{label} is driven mostly to one side: drive both")
    return said or ["good for identification"]


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
