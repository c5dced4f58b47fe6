# SPDX-License-Identifier: MIT
"""Findings on the estimate: standard errors, bounds, missing terms, poor fits, sensors."""

from seatrial.boat.finding_texts.spec import NAMES, ONE_NAME, Spec

SAME_RUN = "Check with 'seatrial inspect' that poses and commands are of the same run and time base"

SHORT_BLOCKS = Spec(
    "standard errors: they include correlation of errors over {length:.1f} s only, as the recordings are short",
    "Record longer if errors are correlated for longer than that",
    numbers={"length": "s"},
)
AT_BOUND = Spec(
    "{parameter}: the estimate is at the bound {bound:g} of its range and has no standard error",
    "Drag at 0, a lag or a dead zone at its least, a rate limit at its largest: the recordings show none of it",
    {"parameter": ONE_NAME},
    {"bound": "of the parameter"},
    signed=("bound",),
    parameter=("bound",),
)
_SLOW = (
    "Does a controller, a ramp or a filter act between command and thrust? Log what it gives out, or state the "
    "constant in the vehicle file (chain)"
)
_CURVE = "Check offset and scale of the inputs in the vehicle file. If they are right, state the constant (chain)"
_CLOCK = "Are poses and commands stamped by one clock? Correct the stamps, or state it in the vehicle file"
BEYOND_RANGE = Spec(
    "{parameter}: the estimate is at the bound {bound:g} of its range, and poses would fit better beyond it. So "
    "other parameters stand in for it, and are off by more than their intervals",
    "{stage_means}",
    {"parameter": ONE_NAME},
    {"bound": "of the parameter"},
    {
        "stage": {
            "latency": _CLOCK,
            "delay_position": _CLOCK,
            "delay_heading": _CLOCK,
            "lag": _SLOW,
            "slew_rate": _SLOW,
            "steer_rate": _SLOW,
            "edge_forward": _CURVE,
            "edge_reverse": _CURVE,
            "reverse_ratio": _CURVE,
            "power": _CURVE,
            "scale_power": _CURVE,
            "gain": _CURVE,
            "pair_offset_along": _CURVE,
            "pair_offset_across": _CURVE,
            "pair_dead_zone": _CURVE,
            "steer_offset": _CURVE,
            "steer_dead_zone": _CURVE,
            "steer_angle": "State angle_deg. If the rudder acts by the flow, not by the propeller's race, "
            "write its terms with |u| * u and a deflection (docs/vehicle.md, a rudder)",
        }
    },
    signed=("bound",),
)
MISSING_TERM = Spec(
    "missing term: {term} in {axis} is {errors:.1f} standard errors from 0. With it {axis} is predicted "
    "{improvement:.0%} better 1 s ahead",
    "Identify with --structure auto, or run 'seatrial select'",
    {"axis": ONE_NAME, "term": ONE_NAME},
    {"errors": "-", "improvement": "-"},
)
MODEL_MISMATCH = Spec(
    "model mismatch: innovations are correlated. Fitted to the 1 s prediction error instead of "
    "single-pose innovations (fit horizon {horizon:g} s)",
    "Run 'seatrial select' to look for missing terms",
    numbers={"horizon": "s"},
)
CONTRADICTED = Spec(
    "recordings and vehicle file contradict each other, so these are not the boat's coefficients: {text}",
    "Correct that, then identify again",
    words={"text": None},
)
OUTLIERS = Spec(
    "outliers: {share:.1%} of the poses do not fit the model and have less weight",
    "Look for false matches of the localisation and for two clocks with 'seatrial inspect'",
    numbers={"share": "-"},
)
NO_SIGNIFICANT_COEFFICIENT = Spec(
    "no coefficient differs from zero by more than two standard errors", SAME_RUN
)
NOT_PREDICTABLE = Spec(
    "no 1 s prediction is possible: the model diverges at the recorded velocities, or no second of a recording "
    "has poses without a gap",
    "Look at the recordings with 'seatrial inspect'",
)
NO_BETTER_THAN_CONSTANT = Spec(
    "{axes}: 1 s predictions are hardly better than constant or zero velocity",
    f"{SAME_RUN}, and check the vehicle file's signs",
    {"axes": NAMES},
)
SMOOTH_POSITION = Spec(
    "position: no white noise, but correlated errors of {lasting:.2g} mm with a time constant of {memory:.2g} s. "
    "So it comes from a filter, such as a GNSS receiver's. One without an IMU lags behind the boat: thrust, drag "
    "and lag are then off by more than their intervals. White noise is held at {white:.2g} mm",
    "Log positions that are not filtered, or filtered as little as the receiver allows",
    numbers={"white": "mm", "lasting": "mm", "memory": "s"},
)
SMOOTH_HEADING = Spec(
    "heading: no white noise, but correlated errors of {lasting:.2g} mrad with a time constant of "
    "{memory:.2g} s. So it comes from a filter, such as an autopilot's. If the filter has no gyro, "
    "the heading lags behind the boat, and thrust, drag and lag are off by more than their "
    "intervals. White noise is held at {white:.2g} mrad",
    "Log the heading of the compass or the GNSS as well. On board, give the predictor the same filtered "
    "heading",
    numbers={"white": "mrad", "lasting": "mrad", "memory": "s"},
)
LEVER_ARM_ERRORS = Spec(
    "lever arm: standard errors are {ahead:.1e} m ahead and {aside:.1e} m aside",
    "If they are too large, measure the lever arm and state it",
    numbers={"ahead": "m", "aside": "m"},
)
DELAY_DIFFERENCE = Spec(
    "sensor delays: the {older} is {delay:.3f} ± {error:.1g} s older than the {newer}",
    "A delay of both is indistinguishable from the thrusters' latency: if you know it, state it",
    {"older": ONE_NAME, "newer": ONE_NAME},
    {"delay": "s", "error": "s"},
)
DELAY = Spec(
    "sensor delays: the {part} is {delay:.3f} ± {error:.1g} s late if the thrusters' latency is as stated",
    "An error of the stated latency is an error of the delay, too: check it",
    {"part": ONE_NAME},
    {"delay": "s", "error": "s"},
    signed=("delay",),
)
