# SPDX-License-Identifier: MIT
"""Findings of changes between and within recordings, and of disturbed intervals."""

from seatrial.boat.finding_texts.spec import DEAD_ZONE, ONE_NAME, QUANTITIES, Spec

HOMOGENEITY = Spec(
    "the recordings disagree: {quantity} in {axis} is {change:.0%} less in {lower} than in {higher}. "
    "{dead_zone_means}{quantity_means}",
    "To check, identify them separately and run 'seatrial compare'",
    {"axis": ONE_NAME, "lower": ONE_NAME, "higher": ONE_NAME},
    {"change": "-"},
    {"quantity": QUANTITIES, "dead_zone": DEAD_ZONE},
)
CLOCK_HOMOGENEITY = Spec(
    "the recordings disagree: commands act {delay:.2f} s later in {later} than in {earlier}. Possible "
    "cause: clocks that were set in between",
    "Correct the stamps. To check, identify the recordings separately and run 'seatrial compare'",
    {"later": ONE_NAME, "earlier": ONE_NAME},
    {"delay": "s"},
)
CLOCK_DRIFT = Spec(
    "clock drift: commands act {delay:.2f} s later at the {later} than at the {earlier} of {recording}. The "
    "clocks of poses and commands do not run alike, so latency, lag and coefficients are off",
    "Stamp both by one clock. To correct this log, multiply the commands' times since its first pose by "
    "{factor:.6f}",
    {"recording": ONE_NAME},
    {"delay": "s", "factor": "-"},
    {"later": {"beginning": "", "end": ""}, "earlier": {"beginning": "", "end": ""}},
)
PARAMETER_DRIFT = Spec(
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
)
DISTURBED_INTERVAL = Spec(
    "external disturbance: innovations are {ratio:.1f} times larger than elsewhere in {recording} from "
    "{start:.10g} s to {end:.10g} s",
    "If the boat was held, carried or bumped there, or a thruster stopped, exclude it with "
    "--without {recording_quoted}={start:.10g}-{end:.10g}",
    {"recording": ONE_NAME},
    {"start": "s", "end": "s", "ratio": "-"},
    signed=("start", "end"),
)
DISTURBANCE_INFLUENCE = Spec(
    "external disturbance: without the disturbed intervals standard errors are {ratio:.2g} times the stated ones. "
    "{parameter} changes most, to {value:.3g} ± {error:.2g}",
    "Exclude the intervals if their cause is known",
    {"parameter": ONE_NAME},
    {"ratio": "-", "value": "of the parameter", "error": "of the parameter"},
    signed=("value",),
    parameter=("value",),
)
