# SPDX-License-Identifier: MIT
"""The report's tables. Numbers carry their full value in `<data value>`, in SI units."""

from collections.abc import Sequence
from html import escape

from seatrial.faults import FaultKind
from seatrial.frames import AXES, SYMBOLS, Axes
from seatrial.model import Model
from seatrial.report.markup import NOT_A_NUMBER, data, number, symbol, table, unit
from seatrial.report.runs import Run
from seatrial.report.words import UNITS, minutes, not_told_apart
from seatrial.schema import SourceEntry
from seatrial.statistics import NORMAL_95


def coefficients(model: Model) -> str:
    """Values, standard errors and 95 % intervals, forward-left-up and in the file's axes."""
    own_axes = model.vehicle.axes is Axes.FRD
    head = ["coefficient", "value", "standard error", "95 % interval", "unit", "remark"]
    head += [f"value in {model.vehicle.axes.value} axes"] if own_axes else []
    loose = set(not_told_apart(model))
    rows: list[list[str]] = []
    marked: list[int] = []
    for place, (name, value) in enumerate(model.values.items()):
        error = model.standard_errors[name]
        width = NORMAL_95 * error
        known = error > 0
        row = [
            symbol(name),
            data(value),
            data(error, 2) if known else NOT_A_NUMBER,
            f"{data(value - width, 3)} to {data(value + width, 3)}" if known else NOT_A_NUMBER,
            unit(model.structure.units[name]),
            "not told apart from 0" if name in loose else "",
        ]
        if own_axes:
            row.append(data(-value if name in model.structure.flipped_coefficients else value))
        rows.append(row)
        marked += [place] if name in loose else []
    return table(head, rows, kind="numbers coefficients", marked=marked)


def steps(model: Model) -> str:
    """The least-squares steps that found the coefficients."""
    head = ["step", "coefficients", "from", "rows", "condition", "R²"]
    rows = [
        [
            escape(step.equation),
            ", ".join(symbol(name) for name in step.coefficients),
            escape(", ".join(step.recordings)),
            f"{step.rows}",
            data(step.condition, 2),
            data(step.explained, 2),
        ]
        for step in model.estimator.steps
    ]
    return table(head, rows, kind="numbers steps")


def fault_kinds(run: Run) -> str:
    """Faults of a recording by kind."""
    rows = []
    for kind in FaultKind:
        found = [f for f in run.recording.faults if f.kind is kind]
        if found:
            seconds = sum(f.end - f.start for f in found)
            samples = sum(f.samples for f in found)
            rows.append([escape(kind.value), f"{len(found)}", f"{samples}", f"{seconds:.1f}"])
    return table(["fault", "times", "poses", "seconds"], rows, kind="numbers fault-kinds")


def faults(run: Run) -> str:
    """Every fault of a recording."""
    rows = [
        [escape(f.kind.value), f"{f.start:.2f}", f"{f.end:.2f}", f"{f.samples}"]
        for f in run.recording.faults
    ]
    return table(["fault", "from [s]", "to [s]", "poses"], rows, kind="numbers faults")


def excitations(run: Run) -> str:
    """What the commands excited, by axis."""
    found = run.excitation
    rows = [
        [
            f"{name} <i>{SYMBOLS[i]}</i>",
            data(float(found.rms[i]), 2),
            data(float(found.largest[i]), 2),
            f"{100 * found.share[i]:.0f} %",
            "yes" if found.both_signs[i] else "no",
        ]
        for i, name in enumerate(AXES)
    ]
    head = ["commands in", "RMS", "largest", "share", "to both sides"]
    return table(head, rows, kind="numbers excitation")


def scores(runs: Sequence[Run]) -> str:
    """All velocities of every recording; the axis that dominates one is marked (Table III)."""
    head = [
        "velocity", "RMS error", "unit", "stays constant", "ratio", "floor", "excess", "bias", "kurtosis",
    ]  # fmt: skip
    rows: list[list[str]] = []
    marked: list[int] = []
    for run in runs:
        rows.append([escape(run.recording.name) + ("" if run.unseen else " <small>(seen)</small>")])
        for axis, sign in enumerate(SYMBOLS):
            found, (name, scale) = run.score.scores[sign], UNITS[axis]
            if run.score.excited == AXES[axis]:
                marked.append(len(rows))
            rows.append(
                [
                    f"{AXES[axis]} <i>{sign}</i>",
                    data(found.rms, 3, scale),
                    name,
                    data(found.stays_constant, 3, scale),
                    data(found.ratio, 3),
                    data(found.floor, 3, scale),
                    data(found.excess, 3, scale),
                    data(found.bias, 2, scale),
                    data(found.kurtosis, 3),
                ]
            )
    return table(head, rows, kind="numbers scores", marked=marked)


def files(model: Model, runs: Sequence[Run]) -> str:
    """The files behind the model and behind the scores, with SHA-256."""
    uses: dict[tuple[str, str, str, str], list[str]] = {}
    none = SourceEntry(NOT_A_NUMBER, NOT_A_NUMBER)  # made in memory
    for entry in model.recordings:
        for file in entry.files or [none]:
            key = (entry.name, minutes(entry.length), file.name, file.sha256)
            uses.setdefault(key, []).append("identified from")
    for run in runs:
        for source in run.recording.sources or [none]:
            length = minutes(run.recording.duration)
            key = (run.recording.name, length, source.name, source.sha256)
            uses.setdefault(key, []).append("predicted")
    rows = [
        [escape(name), length, ", ".join(use), escape(file), f"<code>{escape(digest)}</code>"]
        for (name, length, file, digest), use in uses.items()
    ]
    return table(["recording", "length", "use", "file", "SHA-256"], rows, kind="files")


def constants(model: Model) -> str:
    """Constants of the actuator chain."""
    chain = model.vehicle.constants
    rows = [
        [escape(name), data(value), escape(chain.unit(name))]
        for name, value in zip(chain.names, model.constants.tolist(), strict=True)
    ]
    return table(["constant", "value", "unit"], rows, kind="numbers constants")


def envelope(model: Model) -> str:
    """Ranges of speeds and forces that the model was made from, forward-left-up."""
    units = ("m/s", "m/s", "rad/s")
    speeds = [
        [symbol(n), number(low, 3), number(high, 3), units[SYMBOLS.index(n)]]
        for n, (low, high) in model.envelope.speeds.items()
    ]
    forces = [
        [symbol(n), number(low, 3), number(high, 3), "command units"]
        for n, (low, high) in model.envelope.forces.items()
    ]
    return table(["", "from", "to", "unit"], speeds + forces, kind="numbers envelope")
