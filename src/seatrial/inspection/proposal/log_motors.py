# SPDX-License-Identifier: MIT
"""Motor outputs of an autopilot's log: by its parameters, else those that change."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from seatrial.inspection.proposal.servo_parameters import OFF, Motor, digits_of, motors
from seatrial.inspection.proposal.sources import Ask, Choices, Entries, choose, listed_topics
from seatrial.io.formats.known import BESIDE, OUTPUTS
from seatrial.io.log import Log, LogTopic, Wanted
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

PULSE = (800.0, 2200.0)  # [us]
NAMES = {"actuator_motors": "motor", "actuator_servos": "servo"}  # whose fields are control[0], …


def as_motors(log: Log, main: str, channels: Entries) -> Entries:
    """Channels that the user named, with trim and range where the parameters state them."""
    found = {}
    for name, column in channels.items():
        topic = log.topics[column.get("topic", main)]
        stated = {m.column["field"]: m.column for m in motors(log, topic)}
        found[name] = column | stated.get(column["field"], {})
    return found


def topics_of(log: Log) -> str:
    """Names of its topics for a message."""
    return listed_topics([t.name for t in log.topics.values()])


def find_motors(log: Log, choices: Choices, ask: Ask | None) -> list[tuple[LogTopic, Motor]]:
    """Motors, each with its topic."""
    if choices.commands is not None:
        topic = log.topics.get(choices.commands)
        if topic is None:
            raise RecordingError(
                f"{log.path}: no topic {choices.commands} (--commands); it has {topics_of(log)}"
            )
        given = motors(log, topic) or list(_changing(log, topic))
        if not given:
            raise RecordingError(f"{log.path}: no field of {choices.commands} changes (--commands)")
        return [(topic, m) for m in given]
    own = [t for t in log.topics.values() if "@" not in t.name]
    able = [t for name in OUTPUTS for t in own if t.type == name]
    stated = [(t, m) for t in able for m in motors(log, t)]
    if stated:
        # RCOU and RCO2 are one, the motors and their outputs are not
        first = stated[0][0].type[:3]
        return [(t, m) for t, m in stated if t.type[:3] == first or t.type == "actuator_servos"]
    changing = {t.name: list(_changing(log, t)) for t in able}
    able = [t for t in able if changing[t.name]]
    if not able:
        raise RecordingError(
            f"{log.path}: no message with motor outputs that change; name the topic of the commands with "
            f"--commands. The topics are {topics_of(log)}"
        )
    chosen = able[0].name
    if ask is not None and len(able) > 1:
        chosen = choose(log.path, "commands", [t.name for t in able], ask)
    beside = BESIDE.get(log.topics[chosen].type)
    together = [chosen, *(t.name for t in able if t.type == beside)]
    return [(log.topics[name], m) for name in together for m in changing[name]]


def _changing(log: Log, topic: LogTopic) -> Iterator[Motor]:
    """Fields of a topic that change; stamps and counters aside."""
    (samples,) = log.read([Wanted(topic.name, topic.fields)])
    outputs = topic.type in OUTPUTS and len(topic.fields) > 1
    for field, values in zip(topic.fields, samples.values.T, strict=True):
        held = values[np.isfinite(values)]
        driven = held[held != OFF]
        if len(np.unique(driven)) < 2 or _counts(held) or (outputs and not digits_of(field)):
            continue
        pulses = PULSE[0] <= driven.min() and driven.max() <= PULSE[1]
        column: dict[str, Any] = {"field": field}
        if pulses and len(driven) < len(held):
            column |= {"offset": 1500.0, "scale": 400.0, "off": OFF}
        name = f"{NAMES[topic.type]}_{int(digits_of(field)) + 1}" if topic.type in NAMES else field
        yield Motor(name, column, "changes; no parameter states what it drives")


def _counts(values: Array) -> bool:
    """Whether values only rise: a time or a counter."""
    return len(values) > 2 and bool((np.diff(values) > 0).mean() > 0.9)
