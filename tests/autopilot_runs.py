# SPDX-License-Identifier: MIT
"""One run as the log of each autopilot."""

from autopilot_logs import ardupilot, trial
from mavlink_logs import telemetry
from px4_logs import px4

from seatrial.io.log import Wanted

RUN = trial(seconds=20.0)
WRITERS = {
    "run.BIN": ardupilot,
    "run.log": lambda path, run: ardupilot(path, run, text=True),
    "run.ulg": px4,
    "run.tlog": telemetry,
}


def samples(log, topic, *fields):
    (found,) = log.read([Wanted(topic, fields)])
    return found
