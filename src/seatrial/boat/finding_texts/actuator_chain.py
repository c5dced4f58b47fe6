# SPDX-License-Identifier: MIT
"""Findings on the actuator chain: dead zones, thruster layout, stages that are selected."""

from seatrial.boat.finding_texts.spec import NAMES, ONE_NAME, Spec

DEAD_ZONE_NOT_SOUGHT = Spec(
    "dead zone: not estimated, as the inputs {forces} are forces and not thruster commands. If the "
    "thrusters have a dead zone, force and drag coefficients are biased",
    "Add thrusters: and allocation: to the vehicle file",
    {"forces": NAMES},
)
COMMANDS_SAMPLED = Spec(
    "commands: their rows look like samples of a logger. With each change put halfway between its row and the row "
    "before, -2 log L falls by {gain:.0f}, so the model has 'sampled: true'",
    "For other models of these logs write 'sampled: true' under 'commands:' in the vehicle file; or 'sampled: "
    "false', if each row is a new command: thrust that a motor controller ramps looks much the same",
    numbers={"gain": "-"},
)
COMMANDS_LOOK_SAMPLED = Spec(
    "commands: their rows look like samples of a logger. With each change put halfway between its row and the row "
    "before, -2 log L falls by {gain:.0f}. This model has each change at its row: of samples, latency, lag and "
    "dead zone are off by more than their intervals",
    "State 'sampled: true' under 'commands:' in the vehicle file, and identify again; or 'sampled: false', if "
    "each row is a new command",
    numbers={"gain": "-"},
)
LATE_COMMANDS = Spec(
    "{parameter}: thrust changes {lead:.3f} ± {error:.1g} s before the stamps of its commands. The commands are "
    "stamped late, or the poses early. The model is right only for logs with this error",
    "Stamp commands where they are sent, by the poses' clock. Or shift their stamps by {lead:.2f} s or more (of a "
    "table in seconds: 'offset: {lead:.2f}' at commands: stamp)",
    {"parameter": ONE_NAME},
    {"lead": "s", "error": "s"},
)
FORCE_ADDED = Spec(
    "force {force}: the commands drive a combination of {actuators} for which the vehicle file has no force. "
    "The model has it as {force}, a force in {axis}, and its terms may use it",
    "To keep it, copy {force} from forces: in the model file to the vehicle file",
    {"force": ONE_NAME, "axis": ONE_NAME, "actuators": NAMES},
)
THRUSTER_LAYOUT_SELECTED = Spec(
    "thrusters: the vehicle file has none. Of the usual layouts '{layout}' explains the recordings best "
    "(-2 log L falls by {gain:.0f}), so the model has these thrusters. Only their directions matter, not "
    "their positions",
    "Compare thrusters: and allocation: in the model file with the boat, and write the boat's own into "
    "the vehicle file",
    numbers={"gain": "-"},
    words={"layout": None},
)
THRUSTER_LAYOUT_CONTRADICTED = Spec(
    "thrusters: the usual layout '{layout}' explains the recordings much better than the layout in the "
    "vehicle file (-2 log L falls by {gain:.0f}). Probably a thruster, its direction or the allocation scheme "
    "is wrong in the vehicle file; then force and drag coefficients are biased",
    "Compare thrusters: and allocation: in the vehicle file with the boat",
    numbers={"gain": "-"},
    words={"layout": None},
)
DEAD_ZONE_ONE_EDGE = Spec(
    "dead zone of {actuators}: both directions have the same edge, as there is hardly any thrust {side}",
    "If the two edges differ, record commands with thrust {side}",
    {"actuators": NAMES},
    words={"side": {"ahead": "", "astern": ""}},
)
DEAD_ZONE_NOT_IDENTIFIABLE = Spec(
    "dead zone of {actuators}: not identifiable, as under these commands it reduces every force by the same "
    "share. The force coefficients include it",
    "To estimate the edge, record thrusts of several sizes",
    {"actuators": NAMES},
)
SCALE_POWER_HELD = Spec(
    "{parameter}: held at {power:g}, as the scale signal {signal} hardly changes while thrusters are "
    "commanded",
    "To estimate it, record with {signal} at several values",
    {"parameter": ONE_NAME, "signal": ONE_NAME},
    {"power": "-"},
    signed=("power",),
)
SLEW_RATE_SELECTED = Spec(
    "actuator-stage selection: thrust changes by {rate:.2g} of full thrust a second at most, as where a motor "
    "controller or an autopilot ramps it (ArduPilot: MOT_SLEWRATE). With this rate -2 log L falls by {gain:.0f}",
    "To estimate it always, state 'slew_rate: estimate' in the vehicle file's chain",
    numbers={"rate": "1/s", "gain": "-"},
)
CURVE_STAGE_SELECTED = Spec(
    "actuator-stage selection: {stage_means} of the thrust curve is estimated",
    "To estimate it always, state it as 'estimate' in the vehicle file's chain",
    words={"stage": {"reverse_ratio": "the ratio of reverse to forward", "power": "the power"}},
)
GROUP_STAGES_SELECTED = Spec(
    "actuator-stage selection: {stage_means} is estimated for each of {groups}",
    "To estimate them always, state them as 'estimate' in the vehicle file's chain",
    {"groups": NAMES},
    words={
        "stage": {
            "latency": "a latency",
            "lag": "a lag",
            "power": "a power",
            "reverse_ratio": "a ratio of reverse to forward thrust",
        }
    },
)
