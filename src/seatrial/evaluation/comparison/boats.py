# SPDX-License-Identifier: MIT
"""Physics of two models side by side, and reservations: what else differs between them."""

from dataclasses import replace

import msgspec

from seatrial.boat.finding_kinds import LACKING
from seatrial.boat.findings import finding_text, most_important
from seatrial.boat.model import Model
from seatrial.boat.physics import axis_physics, largest_forces
from seatrial.boat.schema import EQUATION_ERROR, DeadZone, EnvelopeEntry, RecordingEntry, as_column
from seatrial.evaluation.comparison.comparability import fixed_terms
from seatrial.evaluation.comparison.parameters import View
from seatrial.evaluation.comparison.thrust_curves import EDGES, stages_apart
from seatrial.util.errors import ModelError
from seatrial.util.frames import AXES, SYMBOLS, Axes

ENVELOPE_RATIO = 1.3  # of the largest speeds, above which envelopes differ


class AxisMeaning(msgspec.Struct, frozen=True):
    """Response of one axis to the same command, for A and B.

    axis: surge, sway or yaw
    command: of its first force: full, or the largest recorded with both if that is smaller
    top_speed: [m/s] or [rad/s]
    rise_time: [s] to 63 % of it
    coast: [m] or [rad] until 2 % of it is left
    """

    axis: str
    command: float
    top_speed: tuple[float, float]
    rise_time: tuple[float, float]
    coast: tuple[float, float]


def axis_meanings(a: Model, b: Model) -> list[AxisMeaning]:
    """Top speed, rise time and coasting distance. Raises ModelError where a model is unstable."""
    both = []
    common = _common_forces(a, b)
    for label, model in (("A", a), ("B", b)):
        try:
            both.append(
                axis_physics(replace(model, envelope=EnvelopeEntry(model.envelope.speeds, common)))
            )
        except ModelError as error:
            raise ModelError(f"{label}: {error}") from None
    return [
        AxisMeaning(
            AXES[x.axis], x.command,
            (x.top_speed, y.top_speed), (x.rise_time, y.rise_time), (x.coast, y.coast),
        )
        for x in both[0]
        for y in both[1]
        if x.axis == y.axis
    ]  # fmt: skip


def _common_forces(a: Model, b: Model) -> dict[str, tuple[float, float]]:
    """Ranges of forces that both reached."""
    both = largest_forces(a), largest_forces(b)
    sizes = {
        force: min(own[force] for own in both if force in own) for force in {*both[0], *both[1]}
    }
    return {force: (-size, size) for force, size in sizes.items()}


def shared(a: Model, b: Model) -> list[str]:
    """Names of recordings that both models were identified from, with overlapping parts."""
    return [x.name for x in a.recordings for y in b.recordings if _overlap(x, y)]


def same_data(a: Model, b: Model) -> bool:
    """Whether both were identified from the same recordings only."""

    def within(one: Model, other: Model) -> bool:
        return all(any(_overlap(x, y) for y in other.recordings) for x in one.recordings)

    return bool(a.recordings) and within(a, b) and within(b, a)


def _overlap(x: RecordingEntry, y: RecordingEntry) -> bool:
    own, other = ({f.sha256 for f in entry.files} for entry in (x, y))
    same = own == other if own and other else x.name == y.name
    return same and x.start < y.start + y.length and y.start < x.start + x.length


def notes(a: Model, b: Model, seen: tuple[View, View]) -> list[str]:
    """Reservations: other differences between the two models, one message each."""
    return [
        *_lacking(a, b), *_independence(a, b), *_methods(a, b), *_vehicles(a, b), *_dead_zones(a, b, seen),
        *_curves(a, b, seen), *_envelopes(a, b),
    ]  # fmt: skip


def _lacking(a: Model, b: Model) -> list[str]:
    """What the recordings of each show that its model lacks."""
    both = [(label, most_important(m.findings_of(*LACKING))) for label, m in (("A", a), ("B", b))]
    return [
        f"{label}'s coefficients may be off by more than their standard errors, which no cause allows for: "
        f"{finding_text(found[0])}"
        for label, found in both
        if found
    ]


def _independence(a: Model, b: Model) -> list[str]:
    names = shared(a, b)
    if not names:
        return []
    listed = ", ".join(dict.fromkeys(names))
    prior = [label for label, m in (("A", a), ("B", b)) if "prior" in m.estimator.settings]
    why = f" ({' and '.join(prior)} had an older model as prior)" if prior else ""
    message = f"errors are not independent: both models come from {listed}{why}. The errors of the differences "
    if same_data(a, b):
        return [
            f"{message}are upper bounds, and any difference comes from how they were identified, not from the "
            "boat"
        ]
    return [f"{message}are upper bounds: significant differences are real, others may be missed"]


def _methods(a: Model, b: Model) -> list[str]:
    found = []
    methods = a.estimator.method, b.estimator.method
    if methods[0] != methods[1]:
        found.append(
            f"A was identified by {methods[0]}, B by {methods[1]}: the difference of the methods appears"
            + ("" if same_data(a, b) else " as a difference of the boats")
        )
    if EQUATION_ERROR in methods:
        which = "both" if methods[0] == methods[1] else "AB"[methods.index(EQUATION_ERROR)]
        found.append(
            f"errors of {EQUATION_ERROR} ({which}) cover scatter only, not its bias from pose noise: small "
            "differences may be that bias"
        )
    if a.integration != b.integration:
        steps = [f"{m.integration.scheme} in steps of {m.integration.step:.3g} s" for m in (a, b)]
        euler = "forward-euler" in (a.integration.scheme, b.integration.scheme)
        why = ": forward Euler's coefficients compensate its discretisation" if euler else ""
        found.append(f"integration: A by {steps[0]}, B by {steps[1]}{why}")
    return found


def _vehicles(a: Model, b: Model) -> list[str]:
    found = []
    one, two = a.vehicle, b.vehicle
    if one.name != two.name:
        found.append(f"two vehicles: A is {one.name}, B is {two.name}")
    if one.axes is not two.axes:
        found.append(
            f"A's file is in {one.axes.value} axes, B's in {two.axes.value}: both are compared in "
            f"{Axes.FLU.value} axes"
        )
    if not a.same_origin(b):
        found.append(
            f"two origins: the measured point is {one.point} of A's, {two.point} of B's; coefficients depend "
            "on the origin"
        )
    if fixed_terms(a) != fixed_terms(b):
        found.append("the terms without a coefficient differ: coefficients may compensate for them")
    if one.file.allocation != two.file.allocation:
        schemes = [_allocation_text(m) for m in (a, b)]
        found.append(f"allocation: A {schemes[0]}, B {schemes[1]}")
    read = [{n: _scaling(c) for n, c in v.file.commands.inputs.items()} for v in (one, two)]
    odd = [n for n in read[0] if n in read[1] and read[0][n] != read[1][n]]
    if odd:
        found.append(
            f"{', '.join(odd)}: another sign, scale or offset: thrust gains are comparable only if the same "
            "stick gives the same command"
        )
    return found


def _scaling(column: object) -> tuple[object, ...]:
    c = as_column(column)  # type: ignore[arg-type]
    return c.unit, c.sign, c.scale, c.offset


def _allocation_text(model: Model) -> str:
    entry = model.vehicle.file.allocation
    more = f" with F_os {entry.F_os:g}" if entry.F_os else ""
    return f"{entry.scheme}{more}"


def _dead_zones(a: Model, b: Model, seen: tuple[View, View]) -> list[str]:
    has = [any(n.partition(".")[0] in EDGES for n in m.parameters) for m in (a, b)]
    if has[0] == has[1]:
        return _one_edge(a, b)
    whose, other = ("A", "B") if has[0] else ("B", "A")
    converted = seen[0].converted or seen[1].converted
    if converted:
        return [
            f"{other} has no dead zone: always-forward thrusters stay beyond its edge, so its gains are those of "
            f"the thrusters over (1 - edge); {whose}'s are shown as {converted}"
        ]
    return [
        f"{whose} has a dead zone, {other} has none: {other}'s thrust gains are an average over it, "
        f"{whose}'s apply beyond its edge"
    ]


def _curves(a: Model, b: Model, seen: tuple[View, View]) -> list[str]:
    """A message where a factor of the thrust curves is in all thrust gains of one model."""
    stages = stages_apart(a, b, any(view.converted for view in seen))
    if not stages:
        return []
    return [
        f"only one model has {', '.join(stages)} in its thrust curve: thrust gains differ by that curve, and an "
        "axis' factor is that of drag alone. Identify both with the same stages in `chain`"
    ]


def _one_edge(a: Model, b: Model) -> list[str]:
    """A message where one model has one edge for both directions and the other two."""
    single = [
        any(isinstance(z := g.dead_zone, DeadZone) and z.symmetric for g in m.vehicle.file.chain)
        for m in (a, b)
    ]
    if single[0] == single[1]:
        return []
    whose, other = ("A", "B") if single[0] else ("B", "A")
    return [
        f"{whose} has one dead-zone edge for both directions, as one of them was hardly driven; "
        f"{other}'s edge in that direction is not compared"
    ]


def _envelopes(a: Model, b: Model) -> list[str]:
    found = []
    for axis, symbol in enumerate(SYMBOLS):
        if symbol not in a.envelope.speeds or symbol not in b.envelope.speeds:
            continue
        tops = [max(abs(x) for x in m.envelope.speeds[symbol]) for m in (a, b)]
        if max(tops) > ENVELOPE_RATIO * min(tops):
            unit = "rad/s" if axis == 2 else "m/s"
            found.append(
                f"{AXES[axis]}: A was identified up to {tops[0]:.2f} {unit}, B up to {tops[1]:.2f} {unit}: "
                "coefficients depend on the range of speeds where the drag model is not exact"
            )
    return found
