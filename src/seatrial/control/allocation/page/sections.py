# SPDX-License-Identifier: MIT
"""The page's sections: chosen scheme, authority, idle commands, recorded commands."""

from html import escape

import numpy as np

from seatrial.control.allocation import AllocationComparison
from seatrial.control.allocation.page import draw
from seatrial.control.allocation.schemes import Drive
from seatrial.report.figures.base import Figure
from seatrial.report.sections.base import ALL, Section, foldable, plot, store_of
from seatrial.report.text.cells import NOTHING, Cell, Interval, Number, Text
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES

PLANES = ((0, 1), (0, 2), (1, 2))


def verdict(found: AllocationComparison) -> Section:
    """The requested scheme, the one in use, and the boat's thrusters."""
    own = found.allocator
    kind = "identified coefficients" if found.boat.identified else "positions and directions"
    axes = list(found.boat.driven)
    head = ("thruster", *(AXES[i] for i in axes), "dead zone", "limit")
    rows: list[list[Cell]] = []
    for k, name in enumerate(own.thrusters):
        ahead, astern = own.edges[:, k].tolist()
        zone = Interval(-astern, ahead) if ahead or astern else NOTHING
        given = [Number(x, 3) for x in found.boat.T[axes, k].tolist()]
        rows.append([Text(name), *given, zone, Number(float(own.limits[k]), 3)])
    table = Table("thrusters", "Wrench of each thruster's unit thrust", head, rows)
    head_of_page = f"""<header><h1>{escape(found.boat.vehicle.name)}</h1>
<p class="subtitle">Thrust allocation</p></header>
"""
    why = escape(own.why[0].upper() + own.why[1:])
    body = f"""<div class="said"><p>Scheme: {escape(own.scheme.value)}. {why}.</p>
<p>At the limits: {escape(found.priority)}.</p></div>
{table.html()}
<p class="note">T from {kind}, rows divided by their norms; forward-left-up axes, command units.</p>"""
    return Section("verdict", "", body, tables=(table,), heading="Verdict", above=head_of_page)


def authority(found: AllocationComparison) -> Section:
    """Attainable wrenches: slices, and one axis at a time."""
    axes = list(found.boat.driven)
    head = ("scheme", *(AXES[i] for i in axes))
    rows: list[list[Cell]] = [
        [Text(row.name), *(Interval(-b, a) for a, b in np.asarray(row.authority)[axes].tolist())]
        for row in found.rows
        if row.authority is not None
    ]
    table = Table("authority", "Largest wrench of one axis", head, rows)
    figures: dict[str, Figure] = {}
    drawn = ""
    for first, second in PLANES:
        if not {first, second} <= set(axes):
            continue
        name = f"reach-{AXES[first]}-{AXES[second]}"
        figures[name] = draw.slices(found, first, second)
        label = f"attainable {AXES[first]} and {AXES[second]}, the other axis at rest"
        drawn += plot(ALL, name, label, "square", label)
    body = f"""<div class="three">{drawn}</div>
{table.html()}<p class="note">Every wrench within an outline is attained exactly. The unit of a thruster is
its thrust at command 1.</p>"""
    return Section("authority", "Authority", body, {ALL: figures}, (table,))


def idling(found: AllocationComparison) -> Section:
    """Commands and power at zero wrench; schemes that are not possible."""
    names = found.allocator.thrusters
    head = ("scheme", "power", *names, "outside the dead zones by")
    rows: list[list[Cell]] = []
    for row in found.rows:
        if row.allocator is not None:
            idle = [Number(c, 3) for c in row.allocator.idle.tolist()]
            rows.append([Text(row.name), Number(row.allocator.idle_power, 3), *idle, Text(row.why)])
        elif not row.drives:
            rows.append([Text(row.name), NOTHING, *(NOTHING for _ in names), Text(row.why)])
    table = Table("idle", "At zero wrench", head, rows)
    body = f"""{table.html()}<p class="note">Power: thrust to the power of 3/2 (momentum theory);
1 is one thruster at full command.</p>"""
    return Section("idle", "At zero wrench", body, tables=(table,))


def driven(found: AllocationComparison) -> Section | None:
    """Each recorded drive by every scheme."""
    recorded = [row for row in found.rows if row.drives]
    if not recorded:
        return None
    figures: dict[str, dict[str, Figure]] = {}
    tables = []
    parts = []
    for place, drive in enumerate(recorded[0].drives):
        table = _drive_table(found, place)
        tables.append(table)
        thruster = _most(drive)
        name = f"commands-{thruster}"
        store = store_of(place)
        figures[store] = {name: draw.commands(found, place, thruster)}
        label = (
            f"commands to {found.allocator.thrusters[thruster]}, half a minute, with its dead zone"
        )
        parts.append(
            foldable(
                drive.recording, f"{drive.minutes:.1f} min",
                table.html() + plot(store, name, label, "wide", label), opened=place == 0,
            )
        )  # fmt: skip
    body = f"""{"".join(parts)}<p class="note">A crossing: a command enters its thruster's dead zone,
or jumps over it. Wrench error: RMS of resulting minus requested wrench, over the RMS of the requested one; limits
count. Limited: share of the time in which limits reduce the wrench.</p>"""
    return Section(
        "drives", "Drives", body, figures, tuple(tables), heading="Along recorded commands"
    )


def _drive_table(found: AllocationComparison, place: int) -> Table:
    names = found.allocator.thrusters
    head = ("scheme", "crossings [1/min]", *names, "wrench error [%]", "limited [%]", "power")
    rows: list[list[Cell]] = []
    for row in found.rows:
        if not row.drives:
            continue
        d = row.drives[place]
        rows.append(
            [
                Text(row.name), Number(d.crossing, 3), *(Number(d.crossings[n], 3) for n in names),
                Number(d.error_share, 3, 100.0), Number(d.limited, 3, 100.0), Number(d.power, 3),
            ]
        )  # fmt: skip
    return Table(f"drive-{place}", found.rows[0].drives[place].recording, head, rows)


def _most(drive: Drive) -> int:
    return int(np.argmax(list(drive.crossings.values())))
