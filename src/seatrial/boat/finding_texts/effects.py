# SPDX-License-Identifier: MIT
"""Findings of effects that the model does not have."""

from seatrial.boat.finding_texts.spec import NAMES, ONE_NAME, Spec

UNMODELLED = "would remove more than half of the process noise, or move a coefficient by half its standard error"
UNMODELLED_BESIDE_NOISE = UNMODELLED.replace("noise,", "noise or of the correlated pose noise,")
ASK_EFFECT = "If it is plausible, identify with --effect {effect} before further terms are selected"

UNMODELLED_LEVER_ARM = Spec(
    f"unmodelled effect: a lever arm, poses of a point about {{size:.2g}} m off the origin, {UNMODELLED}",
    ASK_EFFECT.format(effect="lever"),
    numbers={"size": "m"},
)
UNMODELLED_CURRENT = Spec(
    f"unmodelled effect: a current of up to {{size:.2g}} m/s {UNMODELLED}",
    ASK_EFFECT.format(effect="current"),
    numbers={"size": "m/s"},
)
UNEVEN_CURRENT = Spec(
    "unmodelled effect: poses fit far better with a current that differs by up to {size:.2g} m/s between places "
    "or parts of the recordings. Drag and coupled terms may be off by more than their intervals",
    "Drive in still water, in a smaller area or for a shorter time. --effect current does not help: it is one "
    "steady current",
    numbers={"size": "m/s"},
)
UNMODELLED_TRIM = Spec(
    f"unmodelled effect: a steady force, for example of thrusters that do not quite stop, {UNMODELLED}",
    ASK_EFFECT.format(effect="trim"),
)
UNMODELLED_WIND = Spec(f"unmodelled effect: wind {UNMODELLED}", ASK_EFFECT.format(effect="wind"))
UNMODELLED_DELAY = Spec(
    f"unmodelled effect: a delay of about {{size:.2g}} s between position and heading {UNMODELLED_BESIDE_NOISE}",
    ASK_EFFECT.format(effect="delay"),
    numbers={"size": "s"},
)
UNEQUAL_THRUSTER_GAINS = Spec(
    f"unequal thruster gains of {{actuators}} {UNMODELLED}. {{weak_means}}",
    "If that is so, add {{gains: {{{gains}}}}} to the vehicle file's chain and identify again",
    {"actuators": NAMES},
    {"gains": "-"},
    {
        "weak": {
            "one": "Is a propeller fouled or damaged, or a payload off the centreline?",
            "several": "Several are equally weak, and an offset payload looks the same: check with "
            "'seatrial select' whether a coupled force explains it",
        }
    },
    signed=("gains",),
    each=("gains",),
)
HEADING_OFFSET = Spec(
    "heading offset: poses fit far better with a heading that is {size:.2deg} degrees off",
    "If that is so, write offset: {psi_offset:.4g} at pose: psi in the vehicle file and identify again, "
    "before further terms are selected",
    numbers={"size": "rad", "psi_offset": "of psi in the vehicle file"},
    signed=("psi_offset",),
)
HEADING_DRIFT = Spec(
    "heading drift: the recorded heading drifts by {rate:.2deg} degrees a minute, like the integral of a gyro "
    "without a compass. Poses fit far better without it. Coefficients may be off by more than their intervals",
    "Measure the heading with a compass or with two antennas, or correct the headings in the log. Parts of a few "
    "minutes, each with an offset of its own at pose: psi, are nearly right",
    numbers={"rate": "rad/min"},
)
HEADING_JUMP = Spec(
    "heading jump: in {recording} the heading jumps by {size:.2deg} degrees at {at:.10g} s and the course does "
    "not, as where an estimator resets its yaw. The heading is off on one side: coefficients, most of all those "
    "of sway, may be off by more than their intervals",
    "Identify from the side with the right heading. If that is after the jump, with --without "
    "{recording_quoted}=0-{at:.10g}",
    {"recording": ONE_NAME},
    {"size": "rad", "at": "s"},
)
COMPASS_DEVIATION = Spec(
    "compass deviation: poses fit far better with a heading error of up to {size:.2deg} degrees that depends on "
    "the heading, {turns_means}. Coefficients may be off by more than their intervals",
    "Calibrate the compass on the boat, away from iron and motor currents, or measure the heading otherwise",
    numbers={"size": "rad"},
    words={
        "turns": {
            "once": "with one period a turn (hard iron)",
            "twice": "with two periods a turn (soft iron)",
        }
    },
)
