# SPDX-License-Identifier: MIT
"""Advice on a recording: what was found, what it means, what to do."""

from collections.abc import Sequence, Set

import numpy as np

from seatrial.boat.physics import ABSURD_SPEED
from seatrial.boat.schema import Column, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.coverage import InputUse
from seatrial.recording.excitation import EXCITED, Excitation, beyond_full
from seatrial.recording.faults.course_heading import course_doubt
from seatrial.recording.pose_noise import known_pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.sampled_commands import sampling_doubt
from seatrial.recording.timing import Stream
from seatrial.recording.undriven import undriven_motion, without_undriven_ends
from seatrial.recording.velocity import SLOW, Motion, motion, stencil_deviation
from seatrial.util.format import percent
from seatrial.util.frames import AXES

SHORT_RECORDING = 30.0  # [s]: too few manoeuvres below it
USABLE_POSES = 0.9  # share below which a recording gets a warning
UNEVEN_STEPS = 0.05  # of the period, standard deviation of the steps between stamps
FOLLOWING = 1.5  # periods; a longer step between poses is a gap, not jitter
LOWEST_RATE, HIGHEST_RATE = 0.5, 2000.0  # [Hz] of poses; outside, the unit of the stamps is wrong
TURN_NOISE = 0.3  # [rad] by which a heading within one turn may exceed it
ABSURD_YAW_RATE = 6.0  # [rad/s]: about one turn a second, faster than a small boat turns
RESTING_SPEED = 0.002  # [m/s], [rad/s] 90th percentiles of a boat that rests
AT_REST_SPREAD = 5.0  # standard deviations of pose noise, 5th to 95th percentile (white noise: 3.3)
FEW_VALUES = 5  # of a command; one amplitude in both directions and rest are three
ON_OFF_VALUES = 3  # of a command; an on-off command is at its limit by design
COARSE_RESOLUTION = 0.1  # of the range of a command
SATURATED_SHARE = 0.5  # of the driven time at the limits
RAYLEIGH_90 = 2.15  # 90th percentile of a Rayleigh distribution, in standard deviations
NORMAL_90 = 1.65  # 90th percentile of the absolute value of a normal one


def recording_advice(
    recording: Recording,
    found: Excitation,
    inputs: Sequence[InputUse],
    moves: Set[str],
    vehicle: Vehicle,
) -> list[str]:
    """One message for each thing to do. `moves`: inputs that move in any of the recordings."""
    # 1. Values that a small boat does not have: wrong units, a boat at rest.
    doubts = [*recording.doubts, *course_doubt(recording), *sampling_doubt(recording)]
    advice = [*recording.remarks, *doubts, *implausible_values(recording, vehicle)]
    advice += [one.text(recording) for one in undriven_motion(recording)]
    # 2. Length, usable poses, pose rate, jitter.
    if recording.duration < SHORT_RECORDING:
        advice.append(f"{recording.duration:.0f} s is short: record a few minutes")
    if recording.usable < USABLE_POSES:
        advice.append(_unusable(recording, vehicle))
    if SLOW < recording.period <= 1.0 / LOWEST_RATE:
        advice.append(
            f"poses at {1.0 / recording.period:.2g} Hz: velocities and pose noise shown here are "
            "rough; record at 10 Hz or more"
        )
    off = jitter(recording)
    if off > UNEVEN_STEPS * recording.period:
        advice.append(
            f"stamps have {1e3 * off:.1f} ms of jitter: harmless if they are the times of measurement, "
            "harmful to velocities if they are rounded or arrival times; record the sensor's own stamps"
        )
    # 3. Excitation of the axes, values of the inputs.
    advice += _excitation(found, vehicle)
    advice += [sentence for use in inputs for sentence in _input(use, moves)]
    return advice


def of_velocity_commands(streams: Sequence[Stream]) -> list[str]:
    """Commands whose type is a velocity: set points of a controller make a model of boat and controller."""
    return [
        f"{stream.source} ({stream.kind}): are these velocities that a controller holds? The model is then of "
        "boat and controller together; record what it sends to the thrusters"
        for stream in streams
        if stream.role == "commands" and "Twist" in stream.kind
    ]


def _unusable(recording: Recording, vehicle: Vehicle) -> str:
    """Why poses are unusable: a command timeout below the command period, or faults."""
    timeout = vehicle.file.command_timeout
    steps = np.diff(recording.commands.stamps)
    period = float(np.median(steps)) * 1e-9 if len(steps) else 0.0
    share = f"{100 * (1 - recording.usable):.0f} % of the poses are unusable"
    if timeout is not None and period > timeout:
        why = "command_timeout is shorter than the period of the commands"
        return f"{share}: {why}, {period:.3g} s"
    return f"{share}: see the faults"


def jitter(recording: Recording) -> float:
    """Standard deviation of the steps between consecutive poses [s], gaps left out."""
    steps = np.diff(recording.t)
    return float(np.std(steps[steps < FOLLOWING * recording.period]))


def _excitation(found: Excitation, vehicle: Vehicle) -> list[str]:
    advice, forced = [], {force.axis for force in vehicle.forces}
    if found.dominant is not None:
        share, name = percent(float(found.share[found.dominant])), AXES[found.dominant]
        advice.append(f"{share} of the effort is in {name}: this recording identifies {name} best")
    for axis, label in enumerate(AXES):
        if axis not in forced:
            continue  # no actuator drives it
        if found.rms[axis] < EXCITED:
            advice.append(f"{label} is not excited: add a recording that excites it")
        elif not found.both_signs[axis] and found.dominant in (axis, None):
            advice.append(f"{label} is excited mostly in one direction: drive both")
    return advice


def _input(use: InputUse, moves: Set[str]) -> list[str]:
    if use.never_moves:
        if use.name in moves:
            return []
        return [f"{use.name} is constant at {use.least:g}: check its column or field"]
    advice = beyond_full(use.name, use.least, use.most)
    if use.levels <= FEW_VALUES:
        advice.append(
            f"{use.name} has only {use.levels} different values: drive with commands of several sizes"
        )
    elif use.resolution > COARSE_RESOLUTION * (use.most - use.least):
        advice.append(
            f"{use.name} has a coarse resolution of {use.resolution:.3g}: check whether it is rounded"
        )
    if use.at_limit > SATURATED_SHARE and use.levels > ON_OFF_VALUES:
        advice.append(
            f"{use.name} is at its limit for {100 * use.at_limit:.0f} % of the driven time: "
            "drive at partial command, too"
        )
    return advice


def _speeds_from_noise(recording: Recording) -> tuple[float, float]:
    """90th percentiles [m/s], [rad/s] of the speeds that pose noise alone gives by the stencil."""
    if (noise := known_pose_noise(recording)) is None:
        return 0.0, 0.0
    plane, _, turn = stencil_deviation(noise, recording).tolist()
    return RAYLEIGH_90 * plane, NORMAL_90 * turn


def implausible_values(recording: Recording, vehicle: Vehicle) -> list[str]:
    """Values that a small boat does not have: wrong units, a boat at rest. One message each."""
    advice = [f"{found} {mend}" for found, mend in implausible_units(recording, vehicle)]
    moving = motion(recording)
    if not moving.valid.any():
        return advice
    fast, turn = _usual_speeds(moving)
    if fast < RESTING_SPEED and turn < RESTING_SPEED:
        advice.append(f"the boat hardly moves: {fast:.2g} m/s, {turn:.2g} rad/s; drive it")
    elif _moves_only_by_noise(recording):
        advice.append(
            "the boat is commanded but moves no more than its pose noise: check that the thrusters are on"
        )
    return advice


def implausible_units(recording: Recording, vehicle: Vehicle) -> list[tuple[str, str]]:
    """Values of a likely other unit, where the vehicle file states none: each with what to state there."""
    pose, rate, found = vehicle.file.pose, 1.0 / recording.period, []
    if not (LOWEST_RATE <= rate <= HIGHEST_RATE or _has_unit(pose.stamp)):
        what = f"poses at {rate:.3g} Hz: check the unit of the stamps (s, ms, us, ns)"
        found.append((what, "and state it in the vehicle file"))
    moving = motion(without_undriven_ends(recording))  # a boat's, not a trailer's
    if not moving.valid.any():
        return found
    fast, turn = _usual_speeds(moving)
    by_noise = _speeds_from_noise(recording)
    if fast > np.hypot(ABSURD_SPEED, by_noise[0]) and not _has_unit(pose.x, pose.y):
        what = f"speeds of {fast:.3g} m/s: are x and y in mm or cm?"
        found.append((what, "State their unit in the vehicle file"))
    known = _has_unit(pose.psi) or _wraps_in_radians(recording)
    if turn > np.hypot(ABSURD_YAW_RATE, by_noise[1]) and not known:
        what = f"yaw rates of {turn:.3g} rad/s: is psi in degrees?"
        found.append((what, "State unit: deg, or unit: rad if the boat turns so fast"))
    return found


def _has_unit(*columns: str | Column) -> bool:
    """Whether the vehicle file states the unit of these columns."""
    return all(as_column(column).unit is not None for column in columns)


def _usual_speeds(moving: Motion) -> tuple[float, float]:
    """90th percentiles [m/s], [rad/s] of speed and yaw rate."""
    nu = moving.nu[moving.valid]
    speeds = np.hypot(nu[:, 0], nu[:, 1]), np.abs(nu[:, 2])
    fast, turn = (float(np.percentile(a, 90)) for a in speeds)
    return fast, turn


def _wraps_in_radians(recording: Recording) -> bool:
    """Whether the heading as logged stays within a turn of radians and jumps by one: it is no degrees."""
    raw, turned = recording.raw[recording.valid, 2], recording.eta[recording.valid, 2]
    within = float(np.ptp(raw)) < 2.0 * np.pi + TURN_NOISE
    return within and float(np.ptp(turned)) > float(np.ptp(raw)) + np.pi


def _moves_only_by_noise(recording: Recording) -> bool:
    """Whether the boat is commanded and its poses spread no more than their noise does."""
    noise = known_pose_noise(recording)
    if noise is None or not recording.commands.values.any():
        return False
    apart = np.ptp(np.percentile(recording.eta[recording.valid], (5, 95), axis=0), axis=0)
    by_noise = AT_REST_SPREAD * np.array([noise.position, noise.position, noise.heading])
    return bool(np.all(apart < by_noise))
