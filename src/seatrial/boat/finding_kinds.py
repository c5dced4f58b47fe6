# SPDX-License-Identifier: MIT
"""The kinds of findings: what each is about, its values with their units, its sentence and the advice.

Sentence and advice are filled in with subject and values. `{x:.0%}` shows a share in per cent, `{x:.2deg}` an
angle in degrees. Of a word that is one of several, `{x_means}` is what it stands for.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from seatrial.util.frames import AXES

QUANTITIES = {  # scale factors that recordings disagree in, or that drift, and their causes
    "thrust": "Possible causes: battery voltage, trim",
    "drag": "Possible causes: the water, a trailing rope or weeds, a missing drag term",
    "thrust and drag": "Possible cause: payload",
}
DEAD_ZONE = {  # of the thrusters: whether the model has one
    "modelled": "",
    "not modelled": "Small commands thrust less where there is a dead zone, and none was estimated. ",
}
ONE_NAME, NAMES = "one name", "names"  # that a part of a subject is


@dataclass(frozen=True)
class Spec:
    """What a finding of one kind has."""

    sentence: str  # what was found, what it means
    advice: str  # what to do
    subject: Mapping[str, str] = field(default_factory=dict)  # its parts; NAMES only as the last
    numbers: Mapping[str, str] = field(default_factory=dict)  # units by name; >= 0 unless `signed`
    words: Mapping[str, Mapping[str, str] | None] = field(
        default_factory=dict
    )  # choices; None: any
    signed: tuple[str, ...] = ()  # numbers that may be negative
    parameter: tuple[str, ...] = ()  # numbers that change sign with the parameter between axes
    each: tuple[str, ...] = ()  # numbers of which there is one for every name of the subject


UNMODELLED = "would remove more than half of the process noise, or move a coefficient by half its standard error"
ASK_EFFECT = "If it is plausible, identify with --effect {effect} before further terms are selected"
SAME_RUN = "Check with 'seatrial inspect' that poses and commands are of the same run and time base"
PRIOR_OFF = (
    "Either the boat changed more than --prior-spread, or the recording is bad: take a larger "
    "--prior-spread, or record as for a new model"
)


class FindingKind(Enum):
    """A kind by its name in files."""

    def __new__(cls, value: str, spec: Spec) -> "FindingKind":
        """The file has the name only."""
        member = object.__new__(cls)
        member._value_ = value
        member.spec = spec
        return member

    spec: Spec

    @property
    def sentence(self) -> str:
        """What was found and what it means, to be filled in."""
        return self.spec.sentence

    @property
    def advice(self) -> str:
        """What to do, to be filled in."""
        return self.spec.advice

    # the actuator chain
    DEAD_ZONE_NOT_SOUGHT = (
        "dead-zone-not-sought",
        Spec(
            "dead zone: not estimated, as the commands are {forces}, not thrusters'. If the thrusters have "
            "one, force and drag coefficients are biased",
            "Add thrusters: and allocation: to the vehicle file",
            {"forces": NAMES},
        ),
    )
    THRUSTER_LAYOUT_SELECTED = (
        "thruster-layout-selected",
        Spec(
            "thrusters: the vehicle file has none. Of the usual layouts '{layout}' explains the recordings best "
            "(-2 log L falls by {gain:.0f}), so the model has these thrusters. Only their directions matter, not "
            "their positions",
            "Compare thrusters: and allocation: in the model file with the boat, and write the boat's own into "
            "the vehicle file",
            numbers={"gain": "-"},
            words={"layout": None},
        ),
    )
    COMMANDS_SAMPLED = (
        "commands-sampled",
        Spec(
            "commands: their rows are a logger's samples: with each change halfway to the row before, -2 log L "
            "falls by {gain:.0f}. So the model takes them, and its vehicle file says 'sampled: true'",
            "Write 'sampled: true' below commands: in the vehicle file",
            numbers={"gain": "-"},
        ),
    )
    THRUSTER_LAYOUT_CONTRADICTED = (
        "thruster-layout-contradicted",
        Spec(
            "thrusters: the usual layout '{layout}' explains the recordings much better than the layout in the "
            "vehicle file (-2 log L falls by {gain:.0f}). A thruster, its direction or the allocation scheme is "
            "probably wrong there, and forces and drag are biased",
            "Compare thrusters: and allocation: in the vehicle file with the boat",
            numbers={"gain": "-"},
            words={"layout": None},
        ),
    )
    DEAD_ZONE_ONE_EDGE = (
        "dead-zone-one-edge",
        Spec(
            "dead zone of {actuators}: one edge for both sides, as they hardly push {side}",
            "If the two edges differ, record commands that push {side}",
            {"actuators": NAMES},
            words={"side": {"ahead": "", "astern": ""}},
        ),
    )
    DEAD_ZONE_NOT_IDENTIFIABLE = (
        "dead-zone-not-identifiable",
        Spec(
            "dead zone of {actuators}: not identifiable, as it takes the same share of each force under these "
            "commands. The force coefficients include it",
            "If the edge is needed, record thrusts of several sizes",
            {"actuators": NAMES},
        ),
    )
    SCALE_POWER_HELD = (
        "scale-power-held",
        Spec(
            "{parameter}: held at {power:g}, as the scale signal {signal} hardly changes while there is a "
            "command",
            "To estimate it, record with {signal} at several values",
            {"parameter": ONE_NAME, "signal": ONE_NAME},
            {"power": "-"},
            signed=("power",),
        ),
    )
    CURVE_STAGE_SELECTED = (
        "curve-stage-selected",
        Spec(
            "actuator-stage selection: {stage_means} of the thrust curve is estimated",
            "To estimate it always, state it as 'estimate' in the vehicle file's chain",
            words={"stage": {"reverse_ratio": "reverse over forward", "power": "the power"}},
        ),
    )
    GROUP_STAGES_SELECTED = (
        "group-stages-selected",
        Spec(
            "actuator-stage selection: {stage_means} is estimated for each of {groups}",
            "To estimate them always, state them as 'estimate' in the vehicle file's chain",
            {"groups": NAMES},
            words={
                "stage": {
                    "latency": "a latency",
                    "lag": "a lag",
                    "power": "a power",
                    "reverse_ratio": "a reverse over forward",
                }
            },
        ),
    )

    # the estimate
    SHORT_BLOCKS = (
        "short-blocks",
        Spec(
            "standard errors: scores are summed over blocks of {length:.1f} s only, as the recordings are short",
            "Record longer where errors are correlated for longer than that",
            numbers={"length": "s"},
        ),
    )
    AT_BOUND = (
        "at-bound",
        Spec(
            "{parameter}: the estimate is at the bound {bound:g} of its range and has no standard error",
            "A lag or a dead zone at its lower bound is none. A latency at its bound is a wrong clock",
            {"parameter": ONE_NAME},
            {"bound": "of the parameter"},
            signed=("bound",),
            parameter=("bound",),
        ),
    )
    MISSING_TERM = (
        "missing-term",
        Spec(
            "missing term: {term} in {axis} is {errors:.1f} standard errors from 0. With it {axis} is predicted "
            "{improvement:.0%} better 1 s ahead",
            "Identify with --structure auto, or run 'seatrial select'",
            {"axis": ONE_NAME, "term": ONE_NAME},
            {"errors": "-", "improvement": "-"},
        ),
    )
    MODEL_MISMATCH = (
        "model-mismatch",
        Spec(
            "model mismatch: innovations are correlated. Fitted to the 1 s prediction error instead of "
            "single-pose innovations (fit horizon {horizon:g} s)",
            "Run 'seatrial select' to look for missing terms",
            numbers={"horizon": "s"},
        ),
    )
    OUTLIERS = (
        "outliers",
        Spec(
            "outliers: {share:.1%} of the poses are outliers to the model and have less weight",
            "Look for false matches and for two clocks with 'seatrial inspect'",
            numbers={"share": "-"},
        ),
    )
    NO_SIGNIFICANT_COEFFICIENT = (
        "no-significant-coefficient",
        Spec("no coefficient differs from zero by more than two standard errors", SAME_RUN),
    )
    NOT_PREDICTABLE = (
        "not-predictable",
        Spec(
            "no 1 s prediction is possible: the model diverges at the recorded velocities, or nowhere are there "
            "poses in a row",
            "Look at the recordings with 'seatrial inspect'",
        ),
    )
    NO_BETTER_THAN_CONSTANT = (
        "no-better-than-constant",
        Spec(
            "{axes}: 1 s predictions are hardly better than constant or zero velocity",
            f"{SAME_RUN}, and check the vehicle file's signs",
            {"axes": NAMES},
        ),
    )
    SMOOTH_HEADING = (
        "smooth-heading",
        Spec(
            "heading: no white noise, but correlated errors of {lasting:.2g} mrad with a time constant of "
            "{memory:.2g} s. So it comes from a filter, such as an autopilot's. White noise is held at "
            "{white:.2g} mrad",
            "Log the heading of the compass or the GNSS as well. On board, give the predictor the same filtered "
            "heading",
            numbers={"white": "mrad", "lasting": "mrad", "memory": "s"},
        ),
    )
    LEVER_ARM_ERRORS = (
        "lever-arm-errors",
        Spec(
            "lever arm: standard errors are {ahead:.1e} m ahead and {aside:.1e} m aside",
            "If they are too large, measure the lever arm and state it",
            numbers={"ahead": "m", "aside": "m"},
        ),
    )

    DELAY_DIFFERENCE = (
        "delay-difference",
        Spec(
            "sensor delays: the {older} is {delay:.3f} ± {error:.1g} s older than the {newer}",
            "If you know what both are late by, state it: it is indistinguishable from the thrusters' latency",
            {"older": ONE_NAME, "newer": ONE_NAME},
            {"delay": "s", "error": "s"},
        ),
    )
    DELAY = (
        "delay",
        Spec(
            "sensor delays: the {part} is {delay:.3f} ± {error:.1g} s late, with the thrusters' latency as stated",
            "An error of the stated latency is one of the delay",
            {"part": ONE_NAME},
            {"delay": "s", "error": "s"},
            signed=("delay",),
        ),
    )

    # effects that the model does not have
    UNMODELLED_LEVER_ARM = (
        "unmodelled-lever-arm",
        Spec(
            f"unmodelled effect: a lever arm, poses of a point about {{size:.2g}} m off the origin, {UNMODELLED}",
            ASK_EFFECT.format(effect="lever"),
            numbers={"size": "m"},
        ),
    )
    UNMODELLED_CURRENT = (
        "unmodelled-current",
        Spec(
            f"unmodelled effect: a current of up to {{size:.2g}} m/s {UNMODELLED}",
            ASK_EFFECT.format(effect="current"),
            numbers={"size": "m/s"},
        ),
    )
    UNMODELLED_TRIM = (
        "unmodelled-trim",
        Spec(
            f"unmodelled effect: a steady force, as of thrusters that are not quite at rest, {UNMODELLED}",
            ASK_EFFECT.format(effect="trim"),
        ),
    )
    UNMODELLED_WIND = (
        "unmodelled-wind",
        Spec(f"unmodelled effect: wind {UNMODELLED}", ASK_EFFECT.format(effect="wind")),
    )
    UNMODELLED_DELAY = (
        "unmodelled-delay",
        Spec(
            "unmodelled effect: position and heading are of two times, about {size:.2g} s apart, which "
            f"{UNMODELLED} or of the correlated pose noise",
            ASK_EFFECT.format(effect="delay"),
            numbers={"size": "s"},
        ),
    )
    UNEQUAL_THRUSTER_GAINS = (
        "unequal-thruster-gains",
        Spec(
            f"unequal thruster gains of {{actuators}} {UNMODELLED}. {{weak_means}}",
            "If that is so, add {{gains: {{{gains}}}}} to the vehicle file's chain and identify again",
            {"actuators": NAMES},
            {"gains": "-"},
            {
                "weak": {
                    "one": "Is a propeller fouled or damaged?",
                    "several": "Several are equally weak, which an offset payload looks like, too: check with "
                    "'seatrial select' whether a coupled force explains it",
                }
            },
            signed=("gains",),
            each=("gains",),
        ),
    )
    HEADING_OFFSET = (
        "heading-offset",
        Spec(
            "heading offset: poses fit far better with a heading that is {size:.2deg} degrees off",
            "If that is so, write offset: {psi_offset:.4g} at pose: psi in the vehicle file and identify again, "
            "before further terms are selected",
            numbers={"size": "rad", "psi_offset": "of psi in the vehicle file"},
            signed=("psi_offset",),
        ),
    )
    HOMOGENEITY = (
        "homogeneity",
        Spec(
            "the recordings disagree: {quantity} in {axis} is {change:.0%} less in {lower} than in {higher}. "
            "{dead_zone_means}{quantity_means}",
            "To check, identify them separately and run 'seatrial compare'",
            {"axis": ONE_NAME, "lower": ONE_NAME, "higher": ONE_NAME},
            {"change": "-"},
            {"quantity": QUANTITIES, "dead_zone": DEAD_ZONE},
        ),
    )
    CLOCK_HOMOGENEITY = (
        "clock-homogeneity",
        Spec(
            "the recordings disagree: commands act {delay:.2f} s later in {later} than in {earlier}. Possible "
            "cause: clocks that were set in between",
            "Correct the stamps. To check, identify the recordings separately and run 'seatrial compare'",
            {"later": ONE_NAME, "earlier": ONE_NAME},
            {"delay": "s"},
        ),
    )
    PARAMETER_DRIFT = (
        "parameter-drift",
        Spec(
            "parameter drift: {quantity} in {axis} is {change:.0%} less at the {lower} than at the {higher} of "
            "{of_means}{recording}. {dead_zone_means}{quantity_means}. Coefficients hold for the middle",
            "For other parts, cut the recording with --without and run 'seatrial compare'",
            {"axis": ONE_NAME, "recording": ONE_NAME},
            {"change": "-"},
            {
                "quantity": QUANTITIES,
                "lower": {"beginning": "", "end": ""},
                "higher": {"beginning": "", "end": ""},
                "of": {"one recording": "", "all recordings": "a recording as long as "},
                "dead_zone": DEAD_ZONE,
            },
        ),
    )
    DISTURBED_INTERVAL = (
        "disturbed-interval",
        Spec(
            "external disturbance: innovations are {ratio:.1f} times larger than elsewhere in {recording} from "
            "{start:.10g} s to {end:.10g} s",
            "If the boat was held, carried or bumped there, or a thruster stopped, exclude it with "
            "--without {recording_quoted}={start:.10g}-{end:.10g}",
            {"recording": ONE_NAME},
            {"start": "s", "end": "s", "ratio": "-"},
            signed=("start", "end"),
        ),
    )
    DISTURBANCE_INFLUENCE = (
        "disturbance-influence",
        Spec(
            "without the disturbed intervals standard errors are {ratio:.2g} times these, and {parameter}, which "
            "changes most, is {value:.3g} ± {error:.2g}",
            "Exclude the intervals if their cause is known",
            {"parameter": ONE_NAME},
            {"ratio": "-", "value": "of the parameter", "error": "of the parameter"},
            signed=("value",),
            parameter=("value",),
        ),
    )

    # a prior
    PRIOR_USED = (
        "prior-used",
        Spec(
            "prior: an older model, widened by {spread:.2g%} of every parameter",
            "Choose the change that you expect with --prior-spread",
            numbers={"spread": "-"},
        ),
    )
    PRIOR_CONFLICT = (
        "prior-conflict",
        Spec(
            "prior and recording disagree: {parameter} changed from {prior:.3g} ± {prior_error:.2g} to "
            "{found:.3g} ± {found_error:.2g}",
            PRIOR_OFF,
            {"parameter": ONE_NAME},
            dict.fromkeys(("prior", "prior_error", "found", "found_error"), "of the parameter"),
            signed=("prior", "found"),
            parameter=("prior", "found"),
        ),
    )
    PRIOR_FACTOR = (
        "prior-factor",
        Spec(
            "prior and recording disagree: {quantity} in {axis} is {factor:.2f} of the prior's",
            PRIOR_OFF,
            {"axis": ONE_NAME},
            {"factor": "-"},
            {"quantity": QUANTITIES},
            signed=("factor",),
        ),
    )
    ADAPTED = (
        "adapted-on-board",
        Spec(
            "adapted on board to a change: {text}",
            "Identify again from a recording of the changed boat",
            words={"text": None},
        ),
    )
    PRIOR_DOMINATES = (
        "prior-dominates",
        Spec(
            "the recording has little information on {parameters}: they are mostly the prior's",
            "Record more, with more excitation, if they matter",
            {"parameters": NAMES},
        ),
    )
    PRIOR_COUNTED_TWICE = (
        "prior-counted-twice",
        Spec(
            "the prior was identified from {recordings}, too: their information counts twice",
            "Give recordings that the prior was not identified from",
            {"recordings": NAMES},
        ),
    )

    # scores
    NO_FILTER = (
        "no-filter",
        Spec(
            "no predictions from the filter's starts, no residuals: {reason}",
            "Use the predictions from measured velocities",
            words={"reason": None},
        ),
    )
    HORIZON_NOT_PREDICTED = (
        "horizon-not-predicted",
        Spec(
            "not every horizon is predicted: {reason}",
            "Use the model at the horizons that are",
            words={"reason": None},
        ),
    )
    EXCEEDS_EXPECTED_ERROR = (
        "exceeds-expected-error",
        Spec(
            "{axis}: the error {horizon:g} s ahead is {ratio:.1f} times the expected error. {cause_means}",
            "If it matters, identify again from recordings like this",
            {"axis": ONE_NAME},
            {"ratio": "-", "horizon": "s"},
            {
                "cause": {
                    "pose noise": "The excess vanishes at longer horizons: pose noise is not as in the model, the "
                    "boat has not changed",
                    "model mismatch": "The model was identified from this recording: model mismatch",
                    "change": "Payload, wind or water changed since it was identified, or the boat is driven "
                    "differently",
                }
            },
        ),
    )
    THROUGH_WATER = (
        "through-water",
        Spec(
            "velocities are relative to the water: poses are without the current of {current:.2g} m/s that the "
            "model was identified with in this recording",
            "For velocities over ground add the current",
            numbers={"current": "m/s"},
        ),
    )
    SLOW_POSES = (
        "slow-poses",
        Spec(
            "poses are {period:.2g} s apart: reference velocities, which errors are taken against, miss motion "
            "within four of them. The noise floor includes as much of it as the model shows",
            "Record poses at a higher rate",
            numbers={"period": "s"},
        ),
    )

    OTHER = ("other", Spec("{text}", "", words={"text": None}))  # a sentence of an older version


UNMODELLED_EFFECTS = {  # by value of `--effect`
    "lever": FindingKind.UNMODELLED_LEVER_ARM,
    "current": FindingKind.UNMODELLED_CURRENT,
    "trim": FindingKind.UNMODELLED_TRIM,
    "wind": FindingKind.UNMODELLED_WIND,
    "delay": FindingKind.UNMODELLED_DELAY,
}
ASK_FOR_ACTION = (  # the kinds that ask the user for something, in the order of their effect on a model
    # recordings and vehicle file do not belong together
    FindingKind.NO_SIGNIFICANT_COEFFICIENT,
    FindingKind.NOT_PREDICTABLE,
    FindingKind.HEADING_OFFSET,
    FindingKind.CLOCK_HOMOGENEITY,
    FindingKind.OUTLIERS,
    FindingKind.THRUSTER_LAYOUT_CONTRADICTED,
    # the model lacks something that biases its coefficients
    *UNMODELLED_EFFECTS.values(),
    FindingKind.UNEQUAL_THRUSTER_GAINS,
    FindingKind.MISSING_TERM,
    FindingKind.MODEL_MISMATCH,
    FindingKind.NO_BETTER_THAN_CONSTANT,
    # the boat changed
    FindingKind.PRIOR_CONFLICT,
    FindingKind.PRIOR_FACTOR,
    FindingKind.PRIOR_COUNTED_TWICE,
    FindingKind.HOMOGENEITY,
    FindingKind.PARAMETER_DRIFT,
    # something else moved it
    FindingKind.DISTURBED_INTERVAL,
    FindingKind.DISTURBANCE_INFLUENCE,
    # what the commands do not identify
    FindingKind.DEAD_ZONE_NOT_SOUGHT,
    FindingKind.COMMANDS_SAMPLED,
    FindingKind.THRUSTER_LAYOUT_SELECTED,
    FindingKind.PRIOR_DOMINATES,
)
PART_CHOICES = {"axis": AXES, "axes": AXES}  # parts of a subject that are one of few
