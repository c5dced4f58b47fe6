# SPDX-License-Identifier: MIT
"""An inspection as text for the terminal."""

from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.coverage import AxisCoverage, InputUse
from seatrial.inspection.overview import FaultSummary, Inspection, RecordingView
from seatrial.recording.excitation import EXCITED, beyond_full
from seatrial.recording.timing import Clock, Stream, rate_text

DIRECTION_WORDS = {  # positive and negative direction of surge, sway and yaw
    "forward-left-up": (("forward", "back"), ("left", "right"), ("turning left", "turning right")),
    "forward-right-down": (
        ("forward", "back"),
        ("right", "left"),
        ("turning right", "turning left"),
    ),
}


def inspection_text(found: Inspection) -> str:
    """Some lines a recording, its advice last; then consistency with the vehicle file."""
    lines = [line for view in found.recordings for line in _recording_lines(view, found.vehicle)]
    signs = found.signs
    lines.append("consistency of signs and order, all recordings (t: gain over its standard error)")
    lines += [f"  {text}" for text in signs.text]
    lines += [f"  => {remark}" for remark in found.vehicle.remarks]
    lines += [f"  => {finding.text}" for finding in signs.findings]
    if not signs.table:
        lines.append("  => units, signs and order are not checked")
    elif not signs.findings:
        used = [use for view in found.recordings for use in view.inputs]
        beyond = any(beyond_full(use.name, use.least, use.most) for use in used)
        in_doubt = beyond or found.vehicle.remarks
        checked = "signs and order" if in_doubt else "units, signs and order"
        but = f", but for {', '.join(signs.unexcited)}: drive them to check" * bool(signs.unexcited)
        lines.append(f"  => consistent with the vehicle file's {checked}{but}")
    return "\n".join(lines)


def _recording_lines(view: RecordingView, vehicle: Vehicle) -> list[str]:
    noise = view.noise
    noise_text = "" if noise is None else (
        f", noise {1e3 * noise.position:.2f} mm, {1e3 * noise.heading:.2f} mrad"
    )  # fmt: skip
    cut = f" from {view.start:.1f} s on" if view.start else ""
    boat = f"vehicle {vehicle.name} ({vehicle.axes.value})"
    lines = [f"{view.name}: {view.duration:.1f} s{cut}, {boat}"]
    shown: set[str] = set()
    for stream in view.streams:
        if stream.role == "poses" or stream.source not in shown:
            lines.append(f"  {stream.role:<9} {_stream(stream)}")
        shown.add(stream.source)
    lines.append(
        f"  quality   {100 * view.usable:.1f} % of the poses usable, jitter {1e3 * view.jitter:.2f} ms{noise_text}"
    )
    lines += [f"  fault     {_fault(f)}" for f in view.faults]
    sides = DIRECTION_WORDS[vehicle.axes.value]
    lines += [_axis(a, *sides[i]) for i, a in enumerate(view.axes)]
    lines += [f"  input     {_input(use)}" for use in view.inputs]
    return lines + [f"  => {verdict}" for verdict in view.verdicts]


def _fault(fault: FaultSummary) -> str:
    many = f"{fault.count} x {fault.kind}"
    if fault.longest > 0:
        return f"{many}; longest {fault.longest:.2f} s, at {fault.longest_at:.1f} s"
    return f"{many}; {'first at' if fault.count > 1 else 'at'} {fault.longest_at:.1f} s"


def _stream(stream: Stream) -> str:
    text = f"{stream.source} ({stream.kind}): {stream.count} at {rate_text(stream)}, longest gap "
    text += f"{stream.longest:.3g} s, stamps: {stream.clock.value}"
    if stream.delay is not None:
        text += f", {stream.delay}"
    for count, word in (
        (stream.duplicated, "duplicate stamps"),
        (stream.backward, "stamps out of order"),
    ):
        text += f", {count} {word}" if count and stream.clock is not Clock.ZERO else ""
    return f"{text}; before cutting" if stream.cut else text


def _axis(axis: AxisCoverage, positive: str, negative: str) -> str:
    if axis.rms < EXCITED:
        return f"  {axis.axis:<9} rms {axis.rms:.3f}: not excited"
    return (
        f"  {axis.axis:<9} rms {axis.rms:.3f}, largest {axis.largest:.2f}, "
        f"{100 * axis.share:.0f} % of all effort; {positive} {axis.minutes_positive:.1f} min, "
        f"{negative} {axis.minutes_negative:.1f} min; small {axis.minutes_small:.1f}, medium "
        f"{axis.minutes_medium:.1f}, large {axis.minutes_large:.1f} min"
    )


def _input(use: InputUse) -> str:
    if use.never_moves:
        return f"{use.name} constant at {use.least:g}"
    steps = f"in steps of {use.resolution:.3g}" if use.resolution else "continuous"
    return (
        f"{use.name} {use.least:.3g} to {use.most:.3g}, {steps}, at these limits "
        f"{100 * use.at_limit:.0f} % of the driven time"
    )
