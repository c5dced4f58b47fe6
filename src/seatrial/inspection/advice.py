# SPDX-License-Identifier: MIT
"""What to do about a recording, one sentence each."""

from collections.abc import Sequence, Set

import numpy as np

from seatrial.boat.physics import ABSURD_SPEED
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.coverage import InputUse
from seatrial.recording.excitation import EXCITED, Excitation, beyond_full
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import SLOW, motion, stencil_deviation
from seatrial.util.errors import RecordingError
from seatrial.util.frames import AXES

SHORT = 30.0  # [s] a recording below it says little
UNEVEN_STAMPS = 0.05  # share of the period that stamps may be off an even rhythm
SLOWEST_RATE, FASTEST_RATE = 0.5, 2000.0  # [Hz] of poses
ABSURD_TURN = 6.0  # [rad/s]
STILL = 0.002  # [m/s], [rad/s]
AT_REST = 5.0  # standard deviations of the pose noise that 90 % of the poses are within: white noise's are 3.3
FEW = 5  # different values; one size each way and rest are three
COARSE = 0.1  # resolution of a command, as a share of its range
AT_LIMIT = 0.5  # share of the driven time


def verdicts(
    recording: Recording,
    found: Excitation,
    inputs: Sequence[InputUse],
    moves: Set[str],
    vehicle: Vehicle,
) -> list[str]:
    """What to do about it, one sentence each. `moves`: inputs that move here or in a recording beside it."""
    timeout = vehicle.file.command_timeout
    said = list(recording.remarks) + implausible(recording)
    if recording.duration < SHORT:
        said.append(f"{recording.duration:.0f} s is short: drive a few minutes")
    steps = np.diff(recording.commands.stamps)
    rhythm = float(np.median(steps)) * 1e-9 if len(steps) else 0.0
    if recording.usable < 0.9:
        said.append(
            f"{100 * (1 - recording.usable):.0f} % of the poses are unusable: "
            + (
                f"command_timeout is shorter than the rhythm of the commands, {rhythm:.3g} s"
                if timeout is not None and rhythm > timeout
                else "see the faults"
            )
        )
    if SLOW < recording.period <= 1.0 / SLOWEST_RATE:
        said.append(
            f"poses at {1.0 / recording.period:.2g} Hz are few: velocities and pose noise shown here are "
            "rough; 10 Hz tell more"
        )
    off = jitter(recording)
    if off > UNEVEN_STAMPS * recording.period:
        said.append(
            f"stamps are off an even rhythm by {1e3 * off:.1f} ms; that does no harm if they are true, but if "
            "they are rounded, or arrival times, velocities suffer: record the sensor's own stamps"
        )
    said += _drive(found, vehicle) + [sentence for use in inputs for sentence in _input(use, moves)]
    return said


def jitter(recording: Recording) -> float:
    """Standard deviation of the steps between poses that follow each other [s]."""
    steps = np.diff(recording.t)
    return float(np.std(steps[steps < 1.5 * recording.period]))


def _drive(found: Excitation, vehicle: Vehicle) -> list[str]:
    said, forced = [], {force.axis for force in vehicle.forces}
    if found.dominant is not None:
        said.append(f"drives {AXES[found.dominant]} nearly alone: identifies that axis")
    for axis, label in enumerate(AXES):
        if axis not in forced:
            continue  # the boat has nothing to drive it with
        if found.rms[axis] < EXCITED:
            said.append(f"{label} is not excited: take it from another recording")
        elif not found.both_signs[axis] and found.dominant in (axis, None):
            said.append(f"{label} is driven mostly to one side: drive both")
    return said


def _input(use: InputUse, moves: Set[str]) -> list[str]:
    if use.never_moves:
        if use.name in moves:
            return []
        return [f"{use.name} is {use.least:g} all the time: is it the right column or field?"]
    said = beyond_full(use.name, use.least, use.most)
    if use.levels <= FEW:
        said.append(
            f"{use.name} has only {use.levels} different values: drive at more than one size of command"
        )
    elif use.resolution > COARSE * (use.most - use.least):
        said.append(f"{use.name} moves in coarse steps of {use.resolution:.3g}: is it rounded?")
    if use.at_limit > AT_LIMIT and use.levels > 3:
        said.append(
            f"{use.name} is at its limit for {100 * use.at_limit:.0f} % of the time that it is used: "
            "drive at part of the stick, too"
        )
    return said


def _speeds_of_noise(recording: Recording) -> tuple[float, float]:
    """What 90 % of a resting boat's speeds by the stencil are below [m/s], [rad/s]."""
    try:
        noise = pose_noise(recording)
    except RecordingError:
        return 0.0, 0.0
    plane, _, turn = stencil_deviation(noise, recording).tolist()
    return 2.15 * plane, 1.65 * turn  # of Rayleigh's distribution, of the normal one


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
    by_noise = _speeds_of_noise(recording)
    if fast > np.hypot(ABSURD_SPEED, by_noise[0]):
        said.append(f"speeds of {fast:.3g} m/s: are x and y in mm or cm? Name the unit")
    if turn > np.hypot(ABSURD_TURN, by_noise[1]):
        said.append(f"yaw rates of {turn:.3g} rad/s: is psi in degrees? Name the unit deg")
    if fast < STILL and turn < STILL:
        said.append(f"the boat hardly moves: {fast:.2g} m/s, {turn:.2g} rad/s; drive it about")
    elif _at_rest(recording):
        said.append(
            "the boat stays where it is, but for noise, whatever it is commanded: were the thrusters on?"
        )
    return said


def _at_rest(recording: Recording) -> bool:
    """Whether it is commanded, and its poses are no further apart than their noise makes them."""
    if not recording.commands.values.any():
        return False
    try:
        noise = pose_noise(recording)
    except RecordingError:
        return False
    apart = np.ptp(np.percentile(recording.eta[recording.valid], (5, 95), axis=0), axis=0)
    return bool(np.all(apart < AT_REST * np.array([noise.position, noise.position, noise.heading])))
