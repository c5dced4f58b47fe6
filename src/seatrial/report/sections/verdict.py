# SPDX-License-Identifier: MIT
"""The first screen: verdict, picture, dials, next step. Below it the verdict in numbers, and warnings."""

from collections.abc import Sequence
from html import escape

from seatrial.boat.physics import model_concerns
from seatrial.report.evidence.first_screen import floor_score, known_score
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.runs import Run
from seatrial.report.evidence.verdict import headline, verdict
from seatrial.report.figures import prediction as draw
from seatrial.report.figures.base import RED, driven_axes
from seatrial.report.figures.dials import Dial, Grade, part_dial, share_dial
from seatrial.report.sections.base import (
    ALL,
    PANEL_HEIGHT,
    PANELS_HEAD,
    Section,
    first_of,
    first_screen,
    plot,
    verdict_section,
)
from seatrial.report.sections.effects import in_short
from seatrial.report.text import prose
from seatrial.report.text.names import names_in, sentence
from seatrial.util.frames import AXES
from seatrial.workflow.fitness import Fitness, Level

# share of constant velocity's excess over the noise floor that is gone: 0.8 is `very well`, 0.5 is `well`,
# see `ratio_word`
FLOOR_LIMITS = (0.5, 0.2)
MUCH = 1e3  # times the floor, which is then as good as none
KNOWN_LIMITS = (0.8, 0.5)  # share of parameters
GRADES = {Level.FIT: Grade.GOOD, Level.LIMITED: Grade.FAIR, Level.NOT_FIT: Grade.POOR}
MARKS = {Level.FIT: "●", Level.LIMITED: "◐", Level.NOT_FIT: "○"}


def section(evidence: Evidence) -> Section:
    """The head of the page."""
    model, run = evidence.model, evidence.runs[first_of(evidence.runs)]
    names = names_in(model)
    *numbers, following = (sentence(line, names) for line in verdict(evidence))
    lines = "".join(f"<p>{line}</p>" for line in numbers)
    warnings = "".join(
        f'<p class="warning">{sentence(t, names)}</p>' for t in model_concerns(model)
    )
    screen = first_screen(
        model.name, sentence(headline(evidence), names), _picture(evidence, run),
        "".join(dial.html() for dial in dials(evidence)) + _uses(evidence), following,
        estimated=_effects(evidence),
    )  # fmt: skip
    predictions = [("predicted", run.predicted, RED)] if run.tested else []
    figures = {"picture": draw.picture(model, run, predictions)}
    return verdict_section(screen, lines, warnings, {ALL: figures})


def _effects(evidence: Evidence) -> str:
    """Effects that were estimated with the model, with a link to their table."""
    line = in_short(evidence.model)
    if not line:
        return ""
    return f'\n<p class="beside"><a href="#effects">Effects</a>: {sentence(line)} (95 %).</p>'


def _picture(evidence: Evidence, run: Run) -> str:
    kind = "not seen" if run.unseen else "seen"
    ahead = f" and predicted {evidence.horizon:g}\u00a0s ahead" if run.tested else "; no prediction"
    caption = f"{run.name} ({kind}): measured{ahead}"
    low = PANELS_HEAD + PANEL_HEIGHT * len(driven_axes(evidence.model))
    return plot(ALL, "picture", f"{caption}, the busiest minute", "picture", caption, low=low)


def dials(evidence: Evidence) -> list[Dial]:
    """Prediction against the floor, what is known, fit for use."""
    known = known_score(evidence.known)
    meaning = (
        f"of {known.estimated} parameters are sharp ({known.sharp}) or usable ({known.usable})"
        if known.estimated
        else "nothing was estimated"
    )
    grades = [GRADES[one.level] for one in evidence.fitness]
    fit = sum(one.level is Level.FIT for one in evidence.fitness)
    levels = ", ".join(f"{one.use.value} {one.level.value}" for one in evidence.fitness)
    return [
        _floor_dial(evidence),
        share_dial("known", "What is known", known.share, meaning, KNOWN_LIMITS),
        part_dial("fitness", "Fit for use", f"{fit} of {len(grades)}", levels, grades),
    ]


def _floor_dial(evidence: Evidence) -> Dial:
    title, found = "Prediction", floor_score(evidence.runs)
    if found is None:
        return Dial("floor", title, "none", "no recording could be predicted", ())
    worst = found.worst
    over, still = found.over_floor[worst], found.still_over_floor[worst]
    meaning = "less error beyond the noise floor than constant velocity; "
    meaning += f"worst: {AXES[worst]}, {_number(over)} against {_number(still)} × floor"
    return share_dial("floor", title, float(found.share[worst]), meaning, FLOOR_LIMITS)


def _number(value: float) -> str:
    """Two digits; how far beyond `MUCH` does not matter."""
    return f"{value:.2g}" if value < MUCH else f"> {MUCH:.0f}"


def _uses(evidence: Evidence) -> str:
    """Every use with its level and the reason."""
    rows: Sequence[str] = [
        f'<li><span class="mark {GRADES[one.level]}" aria-hidden="true">{MARKS[one.level]}</span> '
        f"<b>{one.use.value}: {one.level.value}.</b> {escape(one.reason.text())}{_action(one)}</li>"
        for one in evidence.fitness
    ]
    return f'<ul class="uses" aria-label="{prose.USES}">{"".join(rows)}</ul>'


def _action(one: Fitness) -> str:
    """What would make it fit; not on a phone, whose first screen has no room for it."""
    text = f"{one.action[:1].upper()}{one.action[1:]}"
    return f'<span class="do">. {escape(text)}.</span>' if text else ""
