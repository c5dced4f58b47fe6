# SPDX-License-Identifier: MIT
"""A section: its text, its plots, its tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape

from seatrial.report.evidence.runs import Run
from seatrial.report.figures.base import Figure
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES, SYMBOLS

ROWS_HEAD, ROW_HEIGHT = 130, 21  # [px] of a plot with rows: around them, and each
PANELS_HEAD, PANEL_HEIGHT = 190, 20  # [px] of a picture on a phone: around its panels, and each
# sections that are folded there: long, and not the verdict
ON_A_PHONE = frozenset(("model", "horizons"))
ALL = "all"  # the store of plots of all recordings together


@dataclass(frozen=True)
class Section:
    """One section."""

    name: str  # its anchor
    title: str  # in the contents; empty: not in them
    body: str  # HTML below its heading
    figures: Mapping[str, Mapping[str, Figure]] = field(default_factory=dict)  # by store, by name
    tables: Sequence[Table] = ()
    heading: str = ""  # HTML; empty: the title
    above: str = ""  # HTML before it: the head of a page
    folded: bool = False  # its body; the heading is the handle
    folded_on_a_phone: bool = False

    @property
    def html(self) -> str:
        """The whole section; one without a heading is only what is above it."""
        heading = self.heading or escape(self.title)
        if not heading:
            return self.above
        shown = f"<h2>{heading}</h2>" if self.title else f'<h2 class="quiet">{heading}</h2>'
        inside = f"{shown}\n{self.body}"
        if self.folded or self.folded_on_a_phone:
            kind = '"fold"' if self.folded else '"fold narrow" open'
            inside = f"<details class={kind}><summary>{shown}</summary>\n{self.body}</details>"
        return f'{self.above}<section id="{self.name}">{inside}</section>'


def first_screen(
    title: str, verdict: str, picture: str, dials: str, following: str, *, estimated: str = ""
) -> str:
    """A picture and a verdict, effects that were estimated, what to do next; all but the title are HTML."""
    return f"""<header><h1>{escape(title)}</h1>
<p class="lead">{verdict}</p>{estimated}</header>
<div class="screen">{picture}
<div class="dials">{dials}</div></div>
<p class="next">{following}</p>
"""


def verdict_section(
    screen: str, lines: str, warnings: str, figures: Mapping[str, Mapping[str, Figure]]
) -> Section:
    """The first screen, and below it the verdict in numbers."""
    body = f'<div class="said">{lines}</div>\n{warnings}'
    return Section("verdict", "", body, figures, heading="Verdict in numbers", above=screen)


def recorded_plots() -> str:
    """The plots `tracks` and `timeline`."""
    timeline = plot(
        ALL, "timeline", "when poses and commands were usable", "square", "missing data over time"
    )
    return f"""<div class="pair">{plot(ALL, "tracks", "tracks of all recordings", "square", "tracks")}
{timeline}</div>"""


def velocity_plots(store: str, what: str) -> str:
    """The plot `velocity` of each axis below its heading; `what` it shows of the velocity."""
    return "".join(
        axis_heading(axis) + plot(store, f"velocity-{s}", f"{AXES[axis]} velocity, {what}", "wide")
        for axis, s in enumerate(SYMBOLS)
    )


def with_folds(sections: Sequence[Section], folded: frozenset[str]) -> list[Section]:
    """The sections, those that few readers look at folded, further ones on a phone."""
    return [
        replace(one, folded=one.name in folded, folded_on_a_phone=one.name in ON_A_PHONE)
        for one in sections
    ]


def store_of(place: int) -> str:
    """The store of a recording's plots."""
    return f"run-{place}"


def plot(
    store: str,
    figure: str,
    label: str,
    size: str,
    caption: str = "",
    *,
    rows: int = 0,
    low: int = 0,
) -> str:
    """Placeholder of a plot; `label` is its text alternative.

    `rows`: their number, where it determines the height. `low`: height of a picture on a phone [px].
    """
    above = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    high = f' style="height:{ROWS_HEAD + ROW_HEIGHT * rows}px"' if rows else ""
    high = f' style="--low:{low}px"' if low else high
    return (
        f'<figure>{above}<div class="plot {size}" data-run="{store}" data-figure="{figure}"{high} '
        f'role="group" aria-label="plot: {escape(label)}"></div></figure>'
    )


def axis_heading(axis: int, facts: str = "") -> str:
    """Heading of the plots of one axis; `facts` in small print."""
    more = f' <span class="told">{escape(facts)}</span>' if facts else ""
    return f'<h3 class="one">{AXES[axis].capitalize()} <i>{SYMBOLS[axis]}</i>{more}</h3>'


def three(
    store: str, figure: str, label: str, size: str = "small", *, axes: Sequence[int] = (0, 1, 2)
) -> str:
    """One plot for each axis, side by side."""
    drawn = "".join(
        plot(store, f"{figure}-{SYMBOLS[axis]}", f"{AXES[axis]}: {label}", size) for axis in axes
    )
    return f'<div class="{"pair" if len(axes) == 2 else "three"}">{drawn}</div>'


def foldable(name: str, facts: str, inside: str, *, opened: bool) -> str:
    """A recording's part of a section."""
    title = f"<summary><b>{escape(name)}</b> <span>{escape(facts)}</span></summary>"
    return f'<details class="run"{" open" if opened else ""}>{title}\n{inside}</details>'


def fine(title: str, inside: str, *, printed: bool = False) -> str:
    """Details, folded; on paper only where they are to be printed."""
    kind = "kept" if printed else "fine"
    return f'<details class="{kind}"><summary>{escape(title)}</summary>{inside}</details>'


def first_of(runs: Sequence[Run]) -> int:
    """The recording that is unfolded at first: the first that the model has not seen."""
    fresh = (i for i, run in enumerate(runs) if run.unseen and run.tested)
    return next(fresh, next((i for i, run in enumerate(runs) if run.tested), 0))
