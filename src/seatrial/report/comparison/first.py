# SPDX-License-Identifier: MIT
"""The first screen of a comparison: picture, dials, cause, next step."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape

from seatrial.evaluation.comparison.cause_text import cause_text, inseparable, probability_text
from seatrial.evaluation.comparison.console import next_text
from seatrial.evaluation.comparison.parameters import SIGNIFICANCE, Pair
from seatrial.report.comparison import draw
from seatrial.report.comparison.two_models import LETTERS, MODEL_COLOURS, ModelPair
from seatrial.report.figures import prediction as draw_prediction
from seatrial.report.figures.base import Figure, driven_axes
from seatrial.report.figures.dials import Dial, Grade, part_dial, share_dial
from seatrial.report.sections.base import (
    ALL,
    PANEL_HEIGHT,
    PANELS_HEAD,
    first_of,
    first_screen,
    plot,
)
from seatrial.report.text import prose
from seatrial.report.text.numbers import names_of
from seatrial.util.format import joined
from seatrial.util.frames import AXES, SYMBOLS

MOST_CHANGES = 10  # in the picture
CHANGES_HEAD, CHANGE_HEIGHT = 76, 19  # [px] of the picture on a phone: around its rows, and each
CAUSE_LIMITS = (0.95, 0.5)  # of its probability


def screen(pair: ModelPair) -> tuple[str, dict[str, dict[str, Figure]]]:
    """HTML, and the picture by store."""
    drawn, figure = _picture(pair)
    dials = "".join(dial.html() for dial in (_cause(pair), _changed(pair), _better(pair)))
    dials += _bars(pair)
    following = escape(f"Next: {next_text(pair.found)}.")
    html = first_screen(_title(pair), escape(headline(pair)), drawn, dials, following)
    return html, {ALL: {"picture": figure}}


def _title(pair: ModelPair) -> str:
    """The models by name; of one name, A and B tell them apart."""
    a, b = (model.name for model in pair.models)
    return f"{a}: A and B" if a == b else f"A: {a}, B: {b}"


def headline(pair: ModelPair) -> str:
    """The verdict in plain words: the cause, and which model predicts better."""
    found = pair.found
    cause = (
        "Both models are from the same recordings: any difference is one of method"
        if found.same_data
        else cause_text(found.causes)
    )
    return f"{cause}. {_prediction(pair)}."


def _prediction(pair: ModelPair) -> str:
    if not pair.found.better or pair.evidence is None:
        return "No recording shows yet which of the two predicts better"
    better = _better_by_axis(pair)
    parts = [
        f"{letter} predicts {joined([a for a, own in better.items() if own == letter])} better"
        for letter in LETTERS
        if letter in better.values()
    ]
    runs = names_of(pair.evidence[0].runs)
    return f"{joined(parts)} on {runs}" if parts else f"Both predict {runs} equally well"


def _better_by_axis(pair: ModelPair) -> dict[str, str | None]:
    """At the horizon of the page."""
    name = f"{pair.horizon:g}"
    own = pair.found.better.get(name) or next(iter(pair.found.better.values()))
    return {axis: own[symbol] for axis, symbol in zip(AXES, SYMBOLS, strict=True)}


def _picture(pair: ModelPair) -> tuple[str, Figure]:
    """Measured and predicted by both; without recordings the changes of the parameters."""
    if pair.evidence is None:
        shown, what = _most_changed(pair.found.pairs)
        caption = f"change of {what} from A to B, 95 % intervals"
        low = CHANGES_HEAD + CHANGE_HEIGHT * len(shown)
        return plot(ALL, "picture", caption, "picture", caption, low=low), draw.changes(shown)
    first, second = pair.evidence
    place = first_of(first.runs)
    runs = first.runs[place], second.runs[place]
    predictions = [
        (letter, run.predicted, colour)
        for letter, run, colour in zip(LETTERS, runs, MODEL_COLOURS, strict=True)
        if run.tested
    ]
    caption = f"{runs[0].name}: measured, and predicted {pair.horizon:g} s ahead by both"
    figure = draw_prediction.picture(first.model, runs[0], predictions)
    label, panels = f"{caption}, the busiest minute", len(driven_axes(first.model))
    low = PANELS_HEAD + PANEL_HEIGHT * panels
    return plot(ALL, "picture", label, "picture", caption, low=low), figure


def _most_changed(pairs: Sequence[Pair]) -> tuple[list[Pair], str]:
    """The pairs that the first screen has room for, in their order, and what they are."""
    tested = [one for one in pairs if one.z is not None and one.a]
    if len(tested) <= MOST_CHANGES:
        return tested, "each parameter"
    most = sorted(tested, key=lambda one: -abs(one.z or 0.0))[:MOST_CHANGES]
    return [one for one in tested if one in most], (
        f"the {MOST_CHANGES} most significant of {len(tested)} parameters"
    )


def _cause(pair: ModelPair) -> Dial:
    found, title = pair.found.causes, "Cause"
    if not found:
        return Dial("cause", title, "none", "no cause can be computed", ())
    if inseparable(found):
        whole = found[0].probability + found[1].probability
        cause = f"{found[0].cause} or {found[1].cause}"
    else:
        whole, cause = found[0].probability, found[0].cause
    dial = share_dial("cause", title, whole, f"probability: {cause}", CAUSE_LIMITS)
    return replace(dial, figure=probability_text(whole))


def _bars(pair: ModelPair) -> str:
    """The probability of every cause as a bar."""
    rows = "".join(
        f'<li><span>{escape(one.cause)}</span><span class="bar-room"><span class="bar-filled" '
        f'style="width:{100.0 * one.probability:.1f}%"></span></span>'
        f"<span>{escape(probability_text(one.probability))}</span></li>"
        for one in pair.found.causes
    )
    return f'<ul class="bars" aria-label="{prose.CAUSES_SHORT}">{rows}</ul>' if rows else ""


def _changed(pair: ModelPair) -> Dial:
    tested = [one for one in pair.found.pairs if one.z is not None]
    if not tested:
        return Dial("changed", "Changed", "none", "no parameter can be tested", ())
    number = len([one for one in tested if one.differs])
    share = number / len(tested)
    meaning = f"of {len(tested)} parameters differ significantly ({100 * SIGNIFICANCE:g} %)"
    parts = [(0.0, share, Grade.PLAIN)] if number else []
    return Dial("changed", "Changed", f"{number}", meaning, parts)


def _better(pair: ModelPair) -> Dial:
    title = "Better prediction"
    if not pair.found.better:
        return Dial("better", title, "–", "no recording was given", ())
    better = _better_by_axis(pair)
    grades = [
        Grade.NONE if one is None else Grade.PLAIN if one == "A" else Grade.SECOND
        for one in better.values()
    ]
    meaning = ", ".join(f"{axis} {one or 'equal'}" for axis, one in better.items())
    letters = [one for one in better.values() if one]
    figure = max(LETTERS, key=letters.count) if letters else "="
    return part_dial("better", title, figure, meaning, grades)
