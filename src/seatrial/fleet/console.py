# SPDX-License-Identifier: MIT
"""A fleet in words: the headline, a line for each boat."""

from seatrial.fleet.results import FleetBoat, FleetResult
from seatrial.util.format import shortened, table
from seatrial.util.frames import SYMBOLS

MOST_NAMED = 3  # parameters in one line
LONGEST_REASON = 200  # [characters], unless all is shown
NOT_COMPARED, AS_ITS_KIND = "not compared", "as its kind"


def headline(found: FleetResult) -> str:
    """How many boats, and which ask for attention."""
    count = len(found.boats)
    parts = [f"{count - len(found.failed)} of {count} boats have a model."]
    for names, words in (
        (found.failed, "Without a model"),
        (found.differing, "Different from their kind"),
        (found.changed, "Changed since last time"),
        (found.bad_recordings, "Bad recordings"),
    ):
        if names:
            parts.append(f"{words} ({len(names)}): {shortened(names)}.")
    return " ".join(parts)


def asks(boat: FleetBoat) -> bool:
    """Whether it asks for attention."""
    return verdict_of(boat) not in (AS_ITS_KIND, NOT_COMPARED)


def verdict_of(boat: FleetBoat) -> str:
    """A few words."""
    if boat.result.error is not None:
        return "no model"
    words = [*["differs"] * bool(boat.differs), *["changed"] * boat.changed]
    bad = sum(r.bad for r in boat.result.recordings)
    words += [f"{bad} bad recording{'s' * (bad > 1)}"] * bool(bad)
    return ", ".join(words) or (NOT_COMPARED if boat.not_compared else AS_ITS_KIND)


def first_line(boat: FleetBoat) -> str:
    """The reason for the verdict."""
    if boat.result.error is not None:
        return boat.result.error
    reasons = []
    if boat.differs:
        named = [
            f"{d.parameter} {d.value:.3g}, kind {d.centre:.3g} (z {d.z:+.1f})"
            for d in boat.differs[:MOST_NAMED]
        ]
        reasons.append("; ".join(named))
    if boat.changed:
        reasons.append(change_words(boat))
    reasons += [
        f"{r.name}: {r.error or ' '.join(r.remarks)}" for r in boat.result.recordings if r.bad
    ]
    return " | ".join(reasons) or boat.not_compared or ""


def change_words(boat: FleetBoat) -> str:
    """What changed since last time."""
    change = boat.result.change
    if change is None:
        return ""
    return change.error or " ".join(change.text)


def fleet_text(found: FleetResult, *, verbose: bool = False) -> str:
    """The table of all boats for the terminal, reasons below it, and the headline. `verbose`: all, in full."""
    head = ["boat", "kind", "read", *SYMBOLS, "verdict"]
    rows = [_row(boat) for boat in found.boats]
    reasons = [
        f"{boat.result.name}: {_cut(why, verbose=verbose)}"
        for boat in found.boats if (why := first_line(boat)) and (verbose or asks(boat))
    ]  # fmt: skip
    return "\n".join([table(head, rows, spare=(1, 2)), *reasons, headline(found)])


def _row(boat: FleetBoat) -> list[str]:
    own = boat.result
    read = sum(r.error is None for r in own.recordings)
    ratios = [own.ratios.get(symbol) for symbol in SYMBOLS]
    return [
        own.name, own.kind, f"{read}/{len(own.recordings)}",
        *("-" if ratio is None else f"{ratio:.2g}" for ratio in ratios), verdict_of(boat),
    ]  # fmt: skip


def _cut(why: str, *, verbose: bool) -> str:
    """A reason, short unless `verbose`."""
    return why if verbose or len(why) <= LONGEST_REASON else f"{why[:LONGEST_REASON]}..."
