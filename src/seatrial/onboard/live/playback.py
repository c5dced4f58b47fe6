# SPDX-License-Identifier: MIT
"""Replay of a recording through the predictor."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from seatrial.boat.model import Model, sampling_period
from seatrial.evaluation.through_water import known_current
from seatrial.onboard.live.line_loop import RATE
from seatrial.onboard.live.protocol import NANO
from seatrial.onboard.odometer import Odometer, Odometry
from seatrial.onboard.predictor import HEADING, POSITION
from seatrial.recording.recording import Recording

COMMANDS, SCALES, POSES, HEADINGS = range(4)  # kinds of samples; of equal stamps in this order


def replay(model: Model, recording: Recording, rate: float = RATE) -> Iterator[Odometry]:
    """Odometry at `rate` [Hz]: commands and usable poses in the order of their stamps.

    With the current of the recording, where the model was identified with it.
    """
    # the reader has removed the lever arm of a recording, and the heading's delay from its stamps
    heading = model.vehicle.delays[1]
    vehicle = model.vehicle.with_delays(heading + recording.position_delay, heading)
    known = known_current(model, recording)
    odometer = Odometer(replace(model, vehicle=vehicle), lever=(0.0, 0.0), current=known)
    period = round(NANO / rate)
    due = recording.origin
    sampling = sampling_period(vehicle, recording)
    for stamp, kind, i in sorted(_moments(recording, round(NANO * heading), sampling)):
        while due < stamp:
            out = odometer.at(due)
            if out.known:
                yield out
            due += period
        _use(odometer, recording, stamp, kind, i)


def _moments(recording: Recording, late: int, sampling: float) -> list[tuple[int, int, int]]:
    """Stamp [ns], kind and row of every sample.

    late: [ns] delay of the heading; sampling: [s] between samples of the commands, which changed halfway.
    """
    stamps = recording.stamps + late
    commands = recording.commands.stamps - round(0.5 * NANO * sampling)
    moments = [
        *((int(t), COMMANDS, i) for i, t in enumerate(commands)),
        *((int(stamps[i]), POSES, int(i)) for i in np.flatnonzero(recording.valid)),
    ]
    asynchronous = recording.asynchronous
    if asynchronous is not None:
        turned = np.flatnonzero(asynchronous.parts == HEADING)
        moments += [(int(asynchronous.stamps[i]) + late, HEADINGS, int(i)) for i in turned]
    if recording.scales is not None:
        moments += [(int(t), SCALES, i) for i, t in enumerate(recording.scales.stamps)]
    return moments


def _use(odometer: Odometer, recording: Recording, stamp: int, kind: int, i: int) -> None:
    """Hand over a sample: row i of its kind."""
    asynchronous, parts = recording.asynchronous, recording.parts
    if kind == COMMANDS:
        odometer.command(stamp, recording.commands.values[i])
    elif kind == SCALES and recording.scales is not None:
        odometer.scale(stamp, recording.scales.values[i])
    elif kind == HEADINGS and asynchronous is not None:
        odometer.heading(stamp, float(asynchronous.values[i]))
    elif parts is not None and parts[i] == POSITION:
        odometer.position(stamp, recording.eta[i, :2])
    else:
        odometer.pose(stamp, recording.eta[i])
