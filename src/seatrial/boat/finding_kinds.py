# SPDX-License-Identifier: MIT
"""The kinds of findings, by their names in files; finding_texts/ has sentence, advice and values of each."""

from enum import Enum

from seatrial.boat.finding_texts import actuator_chain, changes, effects, estimate, prior, scores
from seatrial.boat.finding_texts.spec import Spec
from seatrial.util.frames import AXES


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
    DEAD_ZONE_NOT_SOUGHT = ("dead-zone-not-sought", actuator_chain.DEAD_ZONE_NOT_SOUGHT)
    COMMANDS_SAMPLED = ("commands-sampled", actuator_chain.COMMANDS_SAMPLED)
    COMMANDS_LOOK_SAMPLED = ("commands-look-sampled", actuator_chain.COMMANDS_LOOK_SAMPLED)
    LATE_COMMANDS = ("late-commands", actuator_chain.LATE_COMMANDS)
    FORCE_ADDED = ("force-added", actuator_chain.FORCE_ADDED)
    THRUSTER_LAYOUT_SELECTED = ("thruster-layout-selected", actuator_chain.THRUSTER_LAYOUT_SELECTED)
    THRUSTER_LAYOUT_CONTRADICTED = (
        "thruster-layout-contradicted",
        actuator_chain.THRUSTER_LAYOUT_CONTRADICTED,
    )
    DEAD_ZONE_ONE_EDGE = ("dead-zone-one-edge", actuator_chain.DEAD_ZONE_ONE_EDGE)
    DEAD_ZONE_NOT_IDENTIFIABLE = (
        "dead-zone-not-identifiable",
        actuator_chain.DEAD_ZONE_NOT_IDENTIFIABLE,
    )
    SCALE_POWER_HELD = ("scale-power-held", actuator_chain.SCALE_POWER_HELD)
    SLEW_RATE_SELECTED = ("slew-rate-selected", actuator_chain.SLEW_RATE_SELECTED)
    CURVE_STAGE_SELECTED = ("curve-stage-selected", actuator_chain.CURVE_STAGE_SELECTED)
    GROUP_STAGES_SELECTED = ("group-stages-selected", actuator_chain.GROUP_STAGES_SELECTED)

    # the estimate
    CONTRADICTED = ("contradicted", estimate.CONTRADICTED)
    SHORT_BLOCKS = ("short-blocks", estimate.SHORT_BLOCKS)
    AT_BOUND = ("at-bound", estimate.AT_BOUND)
    BEYOND_RANGE = ("beyond-range", estimate.BEYOND_RANGE)
    MISSING_TERM = ("missing-term", estimate.MISSING_TERM)
    MODEL_MISMATCH = ("model-mismatch", estimate.MODEL_MISMATCH)
    OUTLIERS = ("outliers", estimate.OUTLIERS)
    NO_SIGNIFICANT_COEFFICIENT = ("no-significant-coefficient", estimate.NO_SIGNIFICANT_COEFFICIENT)
    NOT_PREDICTABLE = ("not-predictable", estimate.NOT_PREDICTABLE)
    NO_BETTER_THAN_CONSTANT = ("no-better-than-constant", estimate.NO_BETTER_THAN_CONSTANT)
    SMOOTH_POSITION = ("smooth-position", estimate.SMOOTH_POSITION)
    SMOOTH_HEADING = ("smooth-heading", estimate.SMOOTH_HEADING)
    LEVER_ARM_ERRORS = ("lever-arm-errors", estimate.LEVER_ARM_ERRORS)
    DELAY_DIFFERENCE = ("delay-difference", estimate.DELAY_DIFFERENCE)
    DELAY = ("delay", estimate.DELAY)

    # effects that the model does not have
    UNMODELLED_LEVER_ARM = ("unmodelled-lever-arm", effects.UNMODELLED_LEVER_ARM)
    UNMODELLED_CURRENT = ("unmodelled-current", effects.UNMODELLED_CURRENT)
    UNEVEN_CURRENT = ("uneven-current", effects.UNEVEN_CURRENT)
    UNMODELLED_TRIM = ("unmodelled-trim", effects.UNMODELLED_TRIM)
    UNMODELLED_WIND = ("unmodelled-wind", effects.UNMODELLED_WIND)
    UNMODELLED_DELAY = ("unmodelled-delay", effects.UNMODELLED_DELAY)
    UNEQUAL_THRUSTER_GAINS = ("unequal-thruster-gains", effects.UNEQUAL_THRUSTER_GAINS)
    COMPASS_DEVIATION = ("compass-deviation", effects.COMPASS_DEVIATION)
    HEADING_DRIFT = ("heading-drift", effects.HEADING_DRIFT)
    HEADING_JUMP = ("heading-jump", effects.HEADING_JUMP)
    HEADING_OFFSET = ("heading-offset", effects.HEADING_OFFSET)

    # changes between and within recordings
    HOMOGENEITY = ("homogeneity", changes.HOMOGENEITY)
    CLOCK_HOMOGENEITY = ("clock-homogeneity", changes.CLOCK_HOMOGENEITY)
    CLOCK_DRIFT = ("clock-drift", changes.CLOCK_DRIFT)
    PARAMETER_DRIFT = ("parameter-drift", changes.PARAMETER_DRIFT)
    DISTURBED_INTERVAL = ("disturbed-interval", changes.DISTURBED_INTERVAL)
    DISTURBANCE_INFLUENCE = ("disturbance-influence", changes.DISTURBANCE_INFLUENCE)

    # a prior
    PRIOR_USED = ("prior-used", prior.PRIOR_USED)
    PRIOR_CONFLICT = ("prior-conflict", prior.PRIOR_CONFLICT)
    PRIOR_FACTOR = ("prior-factor", prior.PRIOR_FACTOR)
    ADAPTED = ("adapted-on-board", prior.ADAPTED)
    PRIOR_DOMINATES = ("prior-dominates", prior.PRIOR_DOMINATES)
    PRIOR_COUNTED_TWICE = ("prior-counted-twice", prior.PRIOR_COUNTED_TWICE)

    # scores
    NO_FILTER = ("no-filter", scores.NO_FILTER)
    HORIZON_NOT_PREDICTED = ("horizon-not-predicted", scores.HORIZON_NOT_PREDICTED)
    EXCEEDS_EXPECTED_ERROR = ("exceeds-expected-error", scores.EXCEEDS_EXPECTED_ERROR)
    THROUGH_WATER = ("through-water", scores.THROUGH_WATER)
    SLOW_POSES = ("slow-poses", scores.SLOW_POSES)
    OTHER = ("other", scores.OTHER)  # a sentence of an older version


UNMODELLED_EFFECTS = {  # by value of `--effect`
    "lever": FindingKind.UNMODELLED_LEVER_ARM,
    "current": FindingKind.UNMODELLED_CURRENT,
    "trim": FindingKind.UNMODELLED_TRIM,
    "wind": FindingKind.UNMODELLED_WIND,
    "delay": FindingKind.UNMODELLED_DELAY,
}
LACKING = (  # what poses show that the model lacks: its coefficients may be off by more than their errors
    FindingKind.HEADING_OFFSET,
    FindingKind.COMPASS_DEVIATION,
    FindingKind.HEADING_DRIFT,
    FindingKind.HEADING_JUMP,
    *UNMODELLED_EFFECTS.values(),
    FindingKind.UNEVEN_CURRENT,
    FindingKind.UNEQUAL_THRUSTER_GAINS,
)
ASK_FOR_ACTION = (  # the kinds that ask the user for something, in the order of their effect on a model
    # recordings and vehicle file do not belong together
    FindingKind.CONTRADICTED,
    FindingKind.NO_SIGNIFICANT_COEFFICIENT,
    FindingKind.NOT_PREDICTABLE,
    FindingKind.HEADING_OFFSET,
    FindingKind.COMPASS_DEVIATION,
    FindingKind.HEADING_DRIFT,
    FindingKind.HEADING_JUMP,
    FindingKind.CLOCK_HOMOGENEITY,
    FindingKind.CLOCK_DRIFT,
    FindingKind.OUTLIERS,
    FindingKind.THRUSTER_LAYOUT_CONTRADICTED,
    FindingKind.COMMANDS_LOOK_SAMPLED,
    FindingKind.LATE_COMMANDS,
    FindingKind.BEYOND_RANGE,
    # the model lacks something that biases its coefficients
    *UNMODELLED_EFFECTS.values(),
    FindingKind.UNEVEN_CURRENT,
    FindingKind.UNEQUAL_THRUSTER_GAINS,
    FindingKind.SMOOTH_POSITION,
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
    FindingKind.FORCE_ADDED,
    FindingKind.THRUSTER_LAYOUT_SELECTED,
    FindingKind.PRIOR_DOMINATES,
)
PART_CHOICES = {"axis": AXES, "axes": AXES}  # parts of a subject that are one of few
