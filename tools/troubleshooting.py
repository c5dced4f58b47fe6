# SPDX-License-Identifier: MIT
# ruff: noqa: E501 (sentences)
"""Messages, what they mean, what to do: a page of the site (tools/generated.py).

python tools/troubleshooting.py dead zone      # entries with these words; none: all

Sentences and advice are the program's own: findings, faults, health. Only meanings are written here; a test
compares, and finds every error below in the source.
"""

import re
import sys
from collections.abc import Iterable, Mapping

from seatrial import _core
from seatrial.boat.finding_kinds import FindingKind
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.recording.faults.pose_faults import FaultKind

HEAD = """\
# Troubleshooting

Search this page for words of your message; *…* stands for names and numbers of your data. Each entry: the message,
what it means, what to do.
"""
K = FindingKind

MEANINGS: Mapping[str, Mapping[FindingKind, str]] = {
    "Thrusters": {
        K.THRUSTER_LAYOUT_CONTRADICTED: "The allocation computes other commands than the boat's software does, so that "
        "the dead zone acts elsewhere.",
        K.COMMANDS_SAMPLED: "No action is necessary. With this line in the vehicle file every command reads the logs so.",
        K.COMMANDS_LOOK_SAMPLED: "A change that counts at its row, but was up to a row earlier, shifts latency, lag and "
        "dead zone. With chosen terms the model has samples by itself.",
        K.LATE_COMMANDS: "No thruster acts before its command: a logger stamps on arrival, or two clocks differ.",
        K.FORCE_ADDED: "Actuators of one force were also commanded against each other. No action is necessary.",
        K.THRUSTER_LAYOUT_SELECTED: "Dead zones act thruster by thruster, so that combined commands show the layout.",
    K.DEAD_ZONE_NOT_SOUGHT: "The vehicle file has generalised forces as inputs, so that no thruster has a curve.",
        K.DEAD_ZONE_ONE_EDGE: "There are too few commands in one direction for an edge of its own.",
        K.DEAD_ZONE_NOT_IDENTIFIABLE: "All thrusts are of about one size, as with always-forward allocation. The "
        "model predicts well at such thrusts, not at others.",
        K.SCALE_POWER_HELD: "One value of a signal shows no exponent.",
        K.SLEW_RATE_SELECTED: "The thrusters follow their commands at a limited rate. No action is necessary.",
        K.CURVE_STAGE_SELECTED: "The data need this part of the curve. No action is necessary.",
        K.GROUP_STAGES_SELECTED: "The thrusters differ in this constant. No action is necessary.",
        K.UNEQUAL_THRUSTER_GAINS: "Different gains explain what the model counts as noise.",
    },
    "Estimate": {
        K.CONTRADICTED: "A wrong sign, unit or order makes a model of another boat, which is fit for nothing.",
        K.SHORT_BLOCKS: "Standard errors may be too small.",
        K.AT_BOUND: "The boat has no such stage, or the model lacks something.",
        K.BEYOND_RANGE: "No usual thruster, rudder or sensor has such a constant: the model lacks something, or a clock "
        "or a scale is wrong.",
        K.MISSING_TERM: "The model has no such term, and the data show it.",
        K.MODEL_MISMATCH: "The structure does not describe this boat fully. Standard errors account for it.",
        K.OUTLIERS: "More than a few false matches: the poses have errors of another kind.",
        K.NO_SIGNIFICANT_COEFFICIENT: "Commands and motion are unrelated: the model is not usable.",
        K.NOT_PREDICTABLE: "The model can't be tested with these recordings.",
        K.NO_BETTER_THAN_CONSTANT: "The model is of no use in these axes.",
        K.SMOOTH_POSITION: "White errors end at their lower bound, which no sensor has.",
        K.SMOOTH_HEADING: "White errors end at their lower bound, a quarter of the logged heading's step.",
        K.LEVER_ARM_ERRORS: "The lever arm was estimated, with these errors.",
        K.DELAY_DIFFERENCE: "Position and heading are measured at two times, which the model corrects.",
        K.DELAY: "The sensor is late, which the model corrects.",
    },
    "Effects that the model does not have": {
        K.UNMODELLED_LEVER_ARM: "The pose sensor is not above the boat's origin: turning moves it.",
        K.UNMODELLED_CURRENT: "The water moves, and the model takes the boat's velocity as that through the water.",
        K.UNEVEN_CURRENT: "The current is faster in one place than in another, or it turns with the tide.",
        K.UNMODELLED_TRIM: "The boat is pushed to one side at command zero.",
        K.UNMODELLED_WIND: "A force from one direction of the earth acts on the boat.",
        K.UNMODELLED_DELAY: "The position is older than the heading, as with GNSS and a gyro.",
        K.COMPASS_DEVIATION: "A magnetometer near iron, magnets or motor cables: the error depends on the heading.",
        K.HEADING_DRIFT: "The heading is the integral of a gyro alone: its bias turns it away.",
        K.HEADING_JUMP: "An estimator (an autopilot's EKF) that corrects its yaw at once: before, or after, the heading "
        "did not fit the way that the boat went. Sway and its damping are most wrong.",
        K.HEADING_OFFSET: "The sensor is mounted at an angle, or the heading has another zero. Until that is corrected "
        "all coefficients are of a misaligned boat.",
    },
    "Recordings that disagree": {
        K.HOMOGENEITY: "The boat changed between the recordings (battery, payload, trim, weeds), or its drag has another "
        "form at other speeds. The model is their mean.",
        K.CLOCK_HOMOGENEITY: "The computers of poses and commands have two clocks.",
        K.CLOCK_DRIFT: "The computers of poses and commands have two clocks, of which one is faster.",
        K.PARAMETER_DRIFT: "The boat changed during the recording, for example as its battery ran down.",
        K.DISTURBED_INTERVAL: "Something other than thrusters and water moved the boat there.",
        K.DISTURBANCE_INFLUENCE: "How much these intervals change the estimate.",
    },
    "Identification with a prior": {
        K.PRIOR_USED: "The older model counts as much as its own data did, less the change allowed.",
        K.PRIOR_CONFLICT: "A parameter moved by more than was allowed.",
        K.PRIOR_FACTOR: "All parameters of an axis moved by one factor.",
        K.PRIOR_DOMINATES: "The numbers are those of the old boat.",
        K.PRIOR_COUNTED_TWICE: "Standard errors are too small.",
        K.ADAPTED: "The model follows a change that `predict --live` confirmed. It rests on less than a minute.",
    },
    "Scores": {
        K.NO_FILTER: "The model states no noise, or diverges with it.",
        K.HORIZON_NOT_PREDICTED: "The recording is shorter than the horizon, or the model diverges within it.",
        K.EXCEEDS_EXPECTED_ERROR: "The model is worse on this recording than it says of itself.",
        K.THROUGH_WATER: "The current is the model's own, not the boat's motion.",
        K.SLOW_POSES: "Errors are partly those of the reference.",
    },
}  # fmt: skip

C = InconsistencyKind
CONTRADICTIONS: Mapping[C, tuple[str, str, str]] = {  # message, meaning, what to do
    C.CLOCK: ("poses and commands have different clocks", "Commands act seconds before or after their stamps.",
              "Stamp both by one clock, or state `offset` at `commands: stamp`."),
    C.DELAY: ("older than the", "Position and heading are measured seconds apart: a slow localisation, a filter.",
              "Set `delay` and `heading_delay` at `pose`, or `--effect delay`."),
    C.CHANGED: ("as in the rest: a thruster that stopped, a fouled propeller, a loose cable?",
                "From some time on an input moves the boat less.", "Leave that part out: `--without`."),
    C.LENGTH: ("in the unit that the vehicle file states the speed is", "The speed is not that of a small boat.",
               "Set `unit` at `pose: x` and `y`."),
    C.ANGLE: ("in this unit the heading agrees with the track", "Degrees are read as radians, or radians as degrees.",
              "Set `unit` at `pose: psi`."),
    C.MIRRORED: ("has the wrong sign: negated, the track agrees with the heading",
                 "A coordinate or the heading counts in the other direction.", "Set its `sign`."),
    C.EXCHANGED: ("x and y are exchanged: with their columns swapped the track agrees with the heading",
                  "Each is in the place of the other.", "Exchange their entries under `pose`."),
    C.HEADING: ("the heading …: with psi = … the track agrees with it",
                "The heading counts from another direction, as that of a compass.", "Set `sign` and `offset` at `pose: psi`."),
    C.HANDED: ("poses and commands have opposite axes", "One has y to port, the other to starboard.",
               "Negate one of them, as the message states."),
    C.NEGATED: ("opposite to the vehicle file; set sign: … at commands: inputs",
                "A positive command moves the boat in the other direction.", "Set the `sign` of that input."),
    C.PERMUTED: ("exchange their entries at commands: inputs", "Inputs are swapped: each moves the axis of another.",
                 "Exchange their columns."),
    C.STEERED: ("are swapped at chain: steered", "The angle moves the boat ahead, and the thrust does not.",
                "Exchange the two in `of`."),
}  # fmt: skip

FAULTS: Mapping[FaultKind, tuple[str, str]] = {  # what it is, what to do
    FaultKind.MARKED: ("The column of `pose: valid` is 0 there.", "Nothing, if it should be."),
    FaultKind.NOT_FINITE: ("A number is missing.", "Nothing, for a few poses; else record the sensor's own output."),
    FaultKind.STAMP: ("A clock was set, or rows are out of order.", "Stamp by one monotonic clock."),
    FaultKind.FROZEN: (
        "The pose repeats while the boat is driven: the SLAM is lost.", "Record more features, or drive slower."
    ),
    FaultKind.EXCURSION: ("A false match.", "Nothing, for a few."),
    FaultKind.JUMP: ("The SLAM closed a loop, or began anew.", "Nothing, for a few: velocities do not cross it."),
    FaultKind.GAP: ("The sensor was silent.", "Nothing, for a few; check the sensor's rate."),
    FaultKind.SILENT: (
        "No command for longer than `command_timeout`, or a hole in a periodic log.",
        "Record commands for the whole run; remove `command_timeout` where the boat has none.",
    ),
    FaultKind.NO_NUMBER: ("A command is NaN.", "Record the values that the thrusters get."),
    FaultKind.PAUSED: (
        "Between two files of a bag messages are lost, or the stamps start again: a command may be lost, too.",
        "Record into one file, or stop the thrusters before the recorder.",
    ),
    FaultKind.EXCLUDED: ("You excluded it.", "Nothing."),
}  # fmt: skip

ERRORS: Mapping[str, tuple[tuple[str, str, str], ...]] = {  # message, meaning, what to do
    "Logs and vehicle files": (
        ("no such file or folder", "The path is wrong.", "Check it; a ROS 2 bag is a folder."),
        ("expected a bag (.bag, .mcap, .db3, or a folder of ROS 2), a log of ArduPilot",
         "The file is of no known kind.", "See [what can be read](formats.md)."),
        ("is no recording but a folder with", "The folder has several recordings, one level down.",
         "Give those that the message lists, each as an argument of its own."),
        ("Is it a note? A .txt file is read as a table", "A .txt file may be a table, and this one is text.",
         "Give the log itself."),
        ("has a vehicle file that does not describe",
         "`auto -o DIR` found a vehicle file in the folder, and the log has other signals.",
         "Give another folder for another boat; else change the file, or remove it."),
        ("no column '…'", "The vehicle file names a column that the table does not have.",
         "Take a name that the message lists, or run `seatrial init`."),
        ("no topic …", "The vehicle file names a topic that the log does not have.",
         "`seatrial inspect LOG` lists the topics."),
        ("has no messages", "The topic was recorded, and nothing was published.", "Start its node before you record."),
        ("is empty or not finite; write a number, or remove the line", "A row of the table has no command.",
         "Fill it in your logger: a command holds until the next."),
        ("is its unit ms, us or ns? Name it in the vehicle file", "Stamps are too large for seconds.",
         "Write `stamp: {column: t, unit: ms}`."),
        ("stamps in column '…' jump back … times as seconds",
         "The digits after the point are nanoseconds without zeros.", "Write `unit: s.ns`."),
        ("write a decimal point, not a comma" , "The table has decimal commas between commas.",
         "Export it with semicolons or points."),
        ("Parquet needs pyarrow", "An extra is not installed.", "`pip install 'seatrial[parquet]'`."),
        ("data frames need pandas", "An extra is not installed.", "`pip install 'seatrial[pandas]'`."),
        ("MAVLink telemetry logs need pymavlink", "An extra is not installed.", "`pip install 'seatrial[ardupilot]'`."),
        ("PNG needs resvg-py", "An extra is not installed.", "`pip install 'seatrial[png]'`."),
        ("CasADi is not installed", "An extra is not installed.", "`pip install 'seatrial[mpc]'`."),
        ("plots need Matplotlib", "An extra is not installed.", "`pip install 'seatrial[plot]'`."),
        ("the compressed bag is not whole", "The file is cut off.", "Copy it again, or read the rest with `--salvage`."),
        ("carries transforms: name parent and child", "`/tf` holds many frames.",
         "Write `pose: {parent: map, child: base_link}`."),
        ("two robots, or two sources; select one with pose", "One topic has poses of two frames.",
         "Name the frame in the vehicle file."),
    ),
    "Recordings": (
        ("poses; record a few seconds at least", "The log has next to no poses.", "Check the pose topic or columns."),
        ("usable poses of", "Nearly all poses are faulty.", "Look at the faults with `seatrial inspect`."),
        ("no commands; record them for the whole run and name them", "No command is in the log.",
         "Record the joypad or the motor outputs, too."),
        ("poses and commands do not overlap", "They are by two clocks, or of two runs.",
         "Check the units of both stamps; record with one computer's clock."),
        ("ahead of the recorder's clock", "Two computers have two clocks.",
         "Run chrony on both; cut the recording where the clock jumps, with `--start` and `--end`."),
        ("of the steps between poses leap by about", "Poses of two sources alternate.", "Record one of them."),
        ("no five usable poses in a row", "There are gaps all over, or the stamps are very uneven.",
         "Record the sensor's own stamps at 10 Hz or more."),
    ),
    "Identification": (
        ("is too short; drive a minute or more in", "There is too little data.", "Record longer."),
        ("s in all is too short for", "There is too little time with usable poses for so many parameters.",
         "Record longer, or take terms out of the structure; where the message names gaps, mend the log: "
         "`seatrial inspect` names the faults."),
        ("can't be told apart: vary speed and command independently", "Two terms do the same in this recording.",
         "Drive pulses of several sizes with pauses, or take one term out."),
        ("excited (RMS command", "An axis is hardly driven.", "Drive a minute of pulses in it, or remove its terms."),
        ("of the poses are rejected as outliers", "The structure or a sign is wrong.",
         "Run `seatrial inspect` with the vehicle file."),
        ("the boat diverges from the start values",
         "A command moves another axis than its name, or a clock is off by seconds.",
         "Run `seatrial inspect` with the vehicle file."),
        ("no solution: the search does not converge", "A clock is off by seconds, the prior is another boat's, or there is too little driving.",
         "Check signals and clocks with `seatrial inspect`, or drive longer."),
        ("a delay that position and heading have in common is indistinguishable",
         "A common delay looks like the thrusters' latency.", "State `heading_delay`, or the latency of all thrusters."),
        ("nothing is commanded; drive, and record the commands", "All commands are constant.",
         "Check the columns of the inputs with `seatrial inspect`."),
        ("throughout; constant thrust and drag are not distinguishable", "A force never changes.",
         "Drive pulses in both directions."),
        ("no model of this structure explains them", "Motion and commands contradict each other.",
         "`seatrial inspect --vehicle` checks signs, units and order."),
        ("which would count it twice; give each once", "A recording is given twice.", "Give it once."),
        ("the prior model shares no estimated parameter with this vehicle's structure",
         "Old and new model have no parameter in common.", "Take the vehicle file of the old model."),
    ),
    "Models": (
        ("the model is unstable: driven in", "A drag coefficient has the wrong sign or is not known.",
         "Record this axis at several speeds, and identify again."),
        ("the model diverges from", "The recording is faster than those that the model is from.",
         "Identify from recordings at these speeds."),
        ("has other terms than the model", "Model and vehicle file do not belong together.",
         "Leave `--vehicle` out, or give the model's own."),
        ("the scores are of another model than", "The model changed after `validate --json`.", "Validate again."),
        ("no scores to plot", "No recording was scored.", "Validate the model with a recording."),
    ),
}  # fmt: skip


def told(text: str) -> str:
    """A sentence of a finding as it is printed, with … for values; markup of Markdown escaped."""
    plain = re.sub(r"(?<!\{)\{[a-z_]+(?:[:!][^{}]*)?\}", "…", text)
    plain = re.sub(r"\{\{|\}\}", lambda found: found[0][0], plain)
    return re.sub(r"… ?…", "…", plain).strip()


def entry(message: str, meaning: str, advice: str) -> str:
    """One message."""
    parts = [f"- `{message}`", meaning, f"**Do:** {advice}" if advice else ""]
    return "  \n  ".join(part for part in parts if part)


def findings() -> Iterable[str]:
    """A section for each group of findings."""
    for group, meanings in MEANINGS.items():
        yield f"### {group}\n"
        for kind, meaning in meanings.items():
            advice = told(kind.advice)
            yield entry(told(kind.sentence), meaning, f"{advice}." if advice else "")
        yield ""


def page() -> str:
    """The whole page."""
    lines = [HEAD]
    lines.append("## Errors\n\nOne line, exit code 1.\n")
    for group, errors in ERRORS.items():
        lines += [f"### {group}\n", *(entry(*one) for one in errors), ""]
    lines.append(
        "## Contradictions of the vehicle file\n\nOf `inspect`, `init`, `identify` and `validate`.\n"
    )
    lines += [entry(*CONTRADICTIONS[kind]) for kind in InconsistencyKind]
    lines.append("\n## Faults of poses and commands\n\nOf `inspect`, and of `recording.faults`.\n")
    lines += [entry(kind.value, *FAULTS[kind]) for kind in FaultKind]
    lines.append(
        "\n## Findings\n\nOf `identify`, `validate` and the report; in `model.estimator.findings`.\n"
    )
    lines += findings()
    lines.append(
        "## Health on board\n\nFlags of the predictor and the ROS nodes ([on board](onboard.md)).\n"
    )
    for _, name, words in _core.health_words():
        meaning, _, advice = words.partition(". ")
        lines.append(
            entry(name, f"{meaning[:1].upper()}{meaning[1:]}.", f"{advice}." if advice else "")
        )
    return "\n".join(lines).rstrip() + "\n"


def found(words: str) -> str:
    """Entries that contain these words, in any case."""
    entries = re.findall(r"^- .*(?:\n  .*)*", page(), re.MULTILINE)
    return "\n".join(one for one in entries if words.lower() in one.lower())


if __name__ == "__main__":
    print(found(" ".join(sys.argv[1:])))
