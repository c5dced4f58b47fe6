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


def replay(model: Model, recording: Recording, rate: float = RATE) -> Iterator[Odometry]:
    """Odometry at `rate` [Hz]: commands and usable poses in the order of their stamps.

    With the current of the recording, where the model was identified with it.
    """
    # the reader has removed the lever arm of a recording, and the heading's delay from its stamps
    heading = model.vehicle.delays[1]
    vehicle = model.vehicle.with_delays(heading + recording.position_delay, heading)
    known = known_current(model, recording)
    odometer = Odometer(replace(model, vehicle=vehicle), lever=(0.0, 0.0), current=known)
    stamps = recording.stamps + round(NANO * heading)
    late = round(0.5 * NANO * sampling_period(model.vehicle, recording))
    moments = [
        *((int(t), 0, i) for i, t in enumerate(recording.commands.stamps - late)),
        *((int(stamps[i]), 2, int(i)) for i in np.flatnonzero(recording.valid)),
    ]
    asynchronous, parts = recording.asynchronous, recording.parts
    if asynchronous is not None:
        turned = np.flatnonzero(asynchronous.parts == HEADING)
        moments += [
            (int(asynchronous.stamps[i]) + round(NANO * heading), 3, int(i)) for i in turned
        ]
    if recording.scales is not None:
        moments += [(int(t), 1, i) for i, t in enumerate(recording.scales.stamps)]
    period = round(NANO / rate)
    due = recording.origin
    for stamp, kind, i in sorted(moments):
        while due < stamp:
            out = odometer.at(due)
            if out.known:
                yield out
            due += period
        if kind == 0:
            odometer.command(stamp, recording.commands.values[i])
        elif kind == 1 and recording.scales is not None:
            odometer.scale(stamp, recording.scales.values[i])
        elif kind == 3 and asynchronous is not None:
            odometer.heading(stamp, float(asynchronous.values[i]))
        elif parts is not None and parts[i] == POSITION:
            odometer.position(stamp, recording.eta[i, :2])
        else:
            odometer.pose(stamp, recording.eta[i])
